//! `inbye_msgs/Tick`: an observation and its decision to the bit, for the replay.

use core::fmt::Write;

use super::controller_reply::{KINDS, ReplyFields};
use crate::geometry::{Point, Pose, Twist};
use crate::local::Counts;
use crate::localization::LostReason;
use crate::map::Scan;
use crate::navigator::{ControllerReply, Decision, Mode, Observation};
use crate::ros::msg::{Message, Time};

/// A tick of a recorded drive.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct RecordedTick {
    /// Number of earlier ticks.
    pub tick: u64,
    /// The observation.
    pub observation: Observation,
    /// The decision.
    pub decision: Decision,
    /// The answer of the controller; none where inbye's behaviours decided, or the controller was not asked.
    pub reply: Option<ControllerReply>,
    /// Number of global plans after the tick.
    pub plans: u64,
    /// Number of plans received from the planning thread after the tick.
    pub plans_received: u64,
    /// Duration of the decision by the wall clock, seconds.
    pub took_s: f64,
    /// Whether the robot stood until an operator armed it.
    pub awaits_operator: bool,
}

#[expect(
    clippy::struct_field_names,
    reason = "the number of a tick has its name in the message definition"
)]
mod message {
    use crate::ros::msg::Time;
    use crate::ros::msg::declaration::messages;

    messages! {
        /// A tick of inbye to the bit: observation and decision. Metres, seconds, radians; the map frame.
        inbye_msgs / Tick {
            /// Time of the tick.
            stamp: Time,
            /// Number of earlier ticks.
            tick: u64,
            /// Time of the observation.
            time_s: f64,
            /// Time of the scan.
            scan_s: f64,
            /// Time of the odometry.
            odometry_s: f64,
            /// Time of the last correction of the pose.
            pose_s: f64,
            /// Time of the latest scan that differed from the one before.
            scan_changed_s: f64,
            /// The command that was sent last; NaN where that is unknown.
            sent_linear: f64,
            /// The command that was sent last; NaN where that is unknown.
            sent_angular: f64,
            /// Estimated pose.
            x: f64,
            /// Estimated pose.
            y: f64,
            /// Estimated pose.
            yaw: f64,
            /// Measured velocity.
            linear: f64,
            /// Measured velocity.
            angular: f64,
            /// Place of the lidar in the robot's frame.
            lidar_x: f64,
            /// Place of the lidar in the robot's frame.
            lidar_y: f64,
            /// Angle of the first beam.
            angle_min: f64,
            /// Angle between two beams.
            angle_increment: f64,
            /// Longest measurable range.
            range_max: f64,
            /// Range of each beam; infinite for no return, NaN for no measurement.
            ranges: Vec<f64>,
            /// Commanded velocity.
            command_linear: f64,
            /// Commanded velocity.
            command_angular: f64,
            /// Mode of the navigator: a constant before LOCALIZED.
            mode: u8,
            /// Local target.
            target_x: f64,
            /// Local target.
            target_y: f64,
            /// Whether the dynamic window was sampled.
            sampled: bool,
            /// Number of admissible samples.
            admissible: u32,
            /// Number of samples with a collision.
            collision: u32,
            /// Number of samples from which the robot cannot stop.
            cannot_stop: u32,
            /// Number of samples that leave the map.
            outside: u32,
            /// Number of global plans.
            plans: u64,
            /// Number of plans received from the planning thread.
            plans_received: u64,
            /// Duration of the decision by the wall clock.
            took_s: f64,
            /// Why the pose is unreliable: LOCALIZED or a constant after it.
            lost: u8,
            /// The answer of the user's own controller: `NOT_ASKED` or a constant after it.
            reply: u8,
            /// Velocity of the answer; the time waited for `TIMED_OUT`.
            reply_linear: f64,
            /// Velocity of the answer.
            reply_angular: f64,
            /// Reason of an answer without velocity.
            reply_reason: String,
            /// Whether the robot stood until an operator armed it.
            awaits_operator: bool,
        }
    }
}

/// The schema of the message: the numbers of modes and reasons, then its fields.
pub fn schema() -> String {
    let mut text = String::new();
    for mode in Mode::ALL {
        let _ = writeln!(text, "uint8 {}={}", mode.name().to_uppercase(), mode as u8);
    }
    text += "uint8 LOCALIZED=0\n";
    for reason in LostReason::ALL {
        let _ = writeln!(text, "uint8 {}={}", reason.name().to_uppercase(), reason as u8 + 1);
    }
    for (number, kind) in KINDS.into_iter().enumerate() {
        let _ = writeln!(text, "uint8 {kind}={number}");
    }
    text + &message::Tick::schema()
}

impl RecordedTick {
    /// The tick as a message in CDR.
    pub(super) fn to_cdr(&self) -> Vec<u8> {
        let Observation { time_s, pose, pose_s, lost, twist, odometry_s, scan, .. } =
            &self.observation;
        let Observation { scan_s, scan_changed_s, sent, .. } = &self.observation;
        let sent = sent.unwrap_or(Twist::new(f64::NAN, f64::NAN));
        let decision = &self.decision;
        let counts = decision.counts.unwrap_or_default();
        let reply = ReplyFields::of(self.reply.as_ref());
        let message = message::Tick {
            stamp: Time::from_seconds(*time_s),
            tick: self.tick,
            time_s: *time_s,
            scan_s: *scan_s,
            odometry_s: *odometry_s,
            pose_s: *pose_s,
            scan_changed_s: *scan_changed_s,
            sent_linear: sent.linear,
            sent_angular: sent.angular,
            x: pose.x,
            y: pose.y,
            yaw: pose.yaw,
            linear: twist.linear,
            angular: twist.angular,
            lidar_x: scan.origin.x,
            lidar_y: scan.origin.y,
            angle_min: scan.angle_min,
            angle_increment: scan.angle_increment,
            range_max: scan.range_max,
            ranges: scan.ranges.clone(),
            command_linear: decision.command.linear,
            command_angular: decision.command.angular,
            mode: decision.mode as u8,
            target_x: decision.local_target.x,
            target_y: decision.local_target.y,
            sampled: decision.counts.is_some(),
            admissible: counts.admissible,
            collision: counts.collision,
            cannot_stop: counts.cannot_stop,
            outside: counts.outside,
            plans: self.plans,
            plans_received: self.plans_received,
            took_s: self.took_s,
            lost: lost.map_or(0, |reason| reason as u8 + 1),
            reply: reply.kind,
            reply_linear: reply.numbers[0],
            reply_angular: reply.numbers[1],
            reply_reason: reply.reason,
            awaits_operator: self.awaits_operator,
        };
        message.to_cdr()
    }

    /// Reads a message in CDR. Returns nothing if it is invalid.
    pub(super) fn from_cdr(bytes: &[u8]) -> Option<Self> {
        let message = message::Tick::from_cdr(bytes)?;
        let mode = *Mode::ALL.get(usize::from(message.mode))?;
        let lost = match message.lost {
            0 => None,
            number => Some(*LostReason::ALL.get(usize::from(number) - 1)?),
        };
        let counts = Counts {
            admissible: message.admissible,
            collision: message.collision,
            cannot_stop: message.cannot_stop,
            outside: message.outside,
        };
        let sent = Twist::new(message.sent_linear, message.sent_angular);
        let reply = ReplyFields {
            kind: message.reply,
            numbers: [message.reply_linear, message.reply_angular],
            reason: message.reply_reason,
        };
        Some(Self {
            reply: reply.reply().ok()?,
            tick: message.tick,
            observation: Observation {
                time_s: message.time_s,
                pose: Pose::new(message.x, message.y, message.yaw),
                pose_s: message.pose_s,
                lost,
                twist: Twist::new(message.linear, message.angular),
                odometry_s: message.odometry_s,
                scan: Scan {
                    origin: Point::new(message.lidar_x, message.lidar_y),
                    angle_min: message.angle_min,
                    angle_increment: message.angle_increment,
                    range_max: message.range_max,
                    ranges: message.ranges,
                },
                scan_s: message.scan_s,
                scan_changed_s: message.scan_changed_s,
                sent: sent.is_finite().then_some(sent),
            },
            decision: Decision {
                command: Twist::new(message.command_linear, message.command_angular),
                mode,
                local_target: Point::new(message.target_x, message.target_y),
                counts: message.sampled.then_some(counts),
            },
            plans: message.plans,
            plans_received: message.plans_received,
            took_s: message.took_s,
            awaits_operator: message.awaits_operator,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_indices_of_the_lists() {
        for (index, mode) in Mode::ALL.into_iter().enumerate() {
            assert_eq!(mode as usize, index);
        }
        for (index, reason) in LostReason::ALL.into_iter().enumerate() {
            assert_eq!(reason as usize, index);
        }
        let schema = schema();
        assert!(schema.starts_with("uint8 DRIVING=0\n") && schema.contains("\nuint8 lost\n"));
        assert!(schema.contains("\nuint8 BEAMS_THROUGH_WALLS=2\n"), "{schema}");
    }

    #[test]
    fn decoding_returns_the_encoded_tick() {
        let mut tick = RecordedTick {
            tick: 5,
            observation: Observation {
                time_s: 12.3,
                pose: Pose::new(0.1, -0.2, 0.3),
                pose_s: 12.2,
                lost: Some(LostReason::HighUncertainty),
                twist: Twist::new(0.4, -0.5),
                odometry_s: 12.28,
                scan: Scan {
                    angle_min: -1.0,
                    angle_increment: 0.1,
                    range_max: 10.0,
                    ranges: vec![1.0 / 3.0, f64::INFINITY, 7.0],
                    ..Scan::default()
                },
                scan_s: 12.25,
                scan_changed_s: 12.15,
                sent: Some(Twist::new(0.35, -0.45)),
            },
            decision: Decision {
                command: Twist::new(0.6, 0.7),
                mode: Mode::Evading,
                local_target: Point::new(8.0, 9.0),
                counts: None,
            },
            reply: Some(Ok(Twist::new(0.5, 0.25))),
            plans: 6,
            plans_received: 7,
            took_s: 0.001,
            awaits_operator: true,
        };
        for counts in
            [None, Some(Counts { admissible: 1, collision: 2, cannot_stop: 3, outside: 4 })]
        {
            tick.decision.counts = counts;
            let message = tick.to_cdr();
            let decoded = RecordedTick::from_cdr(&message).expect("a whole message");
            assert_eq!(format!("{decoded:?}"), format!("{tick:?}"));
            for end in 0..message.len() {
                assert!(RecordedTick::from_cdr(&message[..end]).is_none(), "{end}");
            }
        }
    }
}
