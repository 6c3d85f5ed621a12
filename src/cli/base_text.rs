//! Text and JSON of a base's state.

use inbye::base::{DriveStatus, Feedback, SupervisorStatus};
use inbye::runtime::hardware::stop_cause;
use serde_json::{Value, json};

/// A report of a base as JSON.
pub fn feedback(feedback: &Feedback) -> Value {
    json!({
        "linear": feedback.twist.linear,
        "angular": feedback.twist.angular,
        "encoder_counts": feedback.encoder_counts,
        "yaw_rate": feedback.yaw_rate,
        "battery_v": feedback.battery_v,
        "emergency_stop": feedback.emergency_stop,
        "faults": feedback.faults.to_string(),
        "command_delay_s": feedback.command_delay_s,
    })
}

/// The supervisor's status as JSON.
pub fn status(status: &SupervisorStatus) -> Value {
    json!({
        "drive_status": drive_status(status),
        "stop_cause": stop_cause(status),
        "feedback": status.feedback.as_ref().map(feedback),
        "pose": status.pose,
        "travelled_m": status.travelled_m,
        "counters": status.counters,
        "last_failure": status.last_failure.as_ref().map(ToString::to_string),
    })
}

/// What the base is commanded to do, and why.
pub fn drive_status(status: &SupervisorStatus) -> String {
    // The status may be older than the stop.
    if let Some(reason) = &status.stop_cause {
        return format!("stopped: {reason}");
    }
    match &status.drive_status {
        DriveStatus::NoTarget => "stands".to_owned(),
        DriveStatus::Driving => {
            format!("drives {:.2} m/s, {:.2} rad/s", status.sent.linear, status.sent.angular)
        }
        DriveStatus::TargetExpired { age_s } => {
            format!("stands: the target is {age_s:.2} s old")
        }
        DriveStatus::AwaitingFeedback => "stands: it has not answered yet".to_owned(),
        DriveStatus::Disconnected(why) => why.to_string(),
        DriveStatus::Stopped(reason) => format!("stopped: {reason}"),
    }
}

/// A report of a base as a line of text.
pub fn line(feedback: &Feedback) -> String {
    let mut parts =
        vec![format!("{:6.3} m/s  {:6.3} rad/s", feedback.twist.linear, feedback.twist.angular)];
    if let Some(counts) = feedback.encoder_counts {
        parts.push(format!("encoders {} {}", counts.left, counts.right));
    }
    if let Some(rate) = feedback.yaw_rate {
        parts.push(format!("gyro {rate:6.3} rad/s"));
    }
    if let Some(volts) = feedback.battery_v {
        parts.push(format!("{volts:.1} V"));
    }
    if feedback.emergency_stop {
        parts.push("EMERGENCY STOP".to_owned());
    }
    if !feedback.faults.is_empty() {
        parts.push(format!("faults: {}", feedback.faults));
    }
    parts.join("  ")
}
