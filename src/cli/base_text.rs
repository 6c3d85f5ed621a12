//! A kept base as people and scripts read it.

use inbye::base::{DriveStatus, Feedback, SupervisorStatus};
use serde_json::{Value, json};

/// What a base reports, for scripts.
pub fn feedback(feedback: &Feedback) -> Value {
    json!({
        "linear": feedback.twist.linear,
        "angular": feedback.twist.angular,
        "ticks": feedback.encoder_counts,
        "yaw_rate": feedback.yaw_rate,
        "battery_v": feedback.battery_v,
        "emergency_stop": feedback.emergency_stop,
        "faults": feedback.faults.to_string(),
        "command_delay_s": feedback.command_delay_s,
    })
}

/// How a base is kept, for scripts.
pub fn status(status: &SupervisorStatus) -> Value {
    json!({
        "condition": condition(status),
        "stopped": stopped(status),
        "feedback": status.feedback.as_ref().map(feedback),
        "pose": status.pose,
        "travelled_m": status.travelled_m,
        "counters": status.counters,
        "line_failure": status.last_failure.as_ref().map(ToString::to_string),
    })
}

/// Why the base does not do what was planned, if so: a stop that is latched, a line that is lost, or silence.
pub fn stopped(status: &SupervisorStatus) -> Option<String> {
    match (&status.stop_cause, &status.drive_status) {
        (Some(reason), _) => Some(reason.to_string()),
        (None, DriveStatus::Disconnected(why)) => Some(why.to_string()),
        (None, DriveStatus::AwaitingFeedback) if status.feedback.is_none() => {
            Some("the base does not answer".to_owned())
        }
        _ => None,
    }
}

/// What the base is told, and why.
pub fn condition(status: &SupervisorStatus) -> String {
    // What was told last may be older than the stop.
    if let Some(reason) = &status.stop_cause {
        return format!("stopped: {reason}");
    }
    match &status.drive_status {
        DriveStatus::NoTarget => "told to stand".to_owned(),
        DriveStatus::Driving => format!(
            "told {:.2} m/s, {:.2} rad/s",
            status.sent.linear, status.sent.angular
        ),
        DriveStatus::TargetExpired { age_s } => {
            format!("told to stand: the plan is {age_s:.2} s old")
        }
        DriveStatus::AwaitingFeedback => "told to stand: it has not answered yet".to_owned(),
        DriveStatus::Disconnected(why) => why.to_string(),
        DriveStatus::Stopped(reason) => format!("stopped: {reason}"),
    }
}

/// What a base reports, in a line.
pub fn line(feedback: &Feedback) -> String {
    let mut parts = vec![format!(
        "{:6.3} m/s  {:6.3} rad/s",
        feedback.twist.linear, feedback.twist.angular
    )];
    if let Some(ticks) = feedback.encoder_counts {
        parts.push(format!("ticks {} {}", ticks.left, ticks.right));
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
