//! `inbye_msgs/Tick`: observation and decision to the bit, which a replay needs.

use crate::geometry::{Point, Pose, Twist};
use crate::local::Counts;
use crate::localization::LostReason;
use crate::map::Scan;
use crate::navigator::{Decision, Mode, Observation};
use crate::recording::cdr::{Decoder, Encoder};
use crate::recording::parts;

/// A tick as recorded.
#[derive(Clone, Debug)]
pub struct Tick {
    /// Ticks before this one.
    pub tick: u64,
    /// What the robot observed.
    pub observation: Observation,
    /// What it decided.
    pub decision: Decision,
    /// Global plans after it.
    pub plans: u64,
    /// Answers taken from the planning thread after it.
    pub plans_received: u64,
    /// What the decision took, seconds.
    pub took_s: f64,
}

/// In the order of the message's numbers.
const MODES: [Mode; 10] = [
    Mode::Driving,
    Mode::Rotating,
    Mode::Blocked,
    Mode::Escaping,
    Mode::Arrived,
    Mode::Failed,
    Mode::Parking,
    Mode::AtWaypoint,
    Mode::Evading,
    Mode::SensorFault,
];

/// In the order of the message's numbers, from one; zero is a pose that is believed.
const LOST: [LostReason; 5] = [
    LostReason::NoReturns,
    LostReason::BeamsThroughWalls,
    LostReason::PoorMatch,
    LostReason::PoseJump,
    LostReason::HighUncertainty,
];

/// The message of a tick.
pub fn tick(
    tick: u64,
    observation: &Observation,
    decision: &Decision,
    (plans, plans_received): (u64, u64),
    took_s: f64,
) -> Vec<u8> {
    let Observation {
        time_s,
        pose,
        lost,
        twist,
        scan,
        scan_s,
    } = observation;
    let mut message = Encoder::new();
    parts::time(&mut message, *time_s);
    message.u64(tick);
    message.all_f64([*time_s, *scan_s]);
    message.all_f64([pose.x, pose.y, pose.yaw]);
    message.all_f64([twist.linear, twist.angular]);
    message.all_f64([scan.angle_min, scan.angle_increment, scan.range_max]);
    message.count(scan.ranges.len());
    message.all_f64(scan.ranges.iter().copied());
    message.all_f64([decision.command.linear, decision.command.angular]);
    message.u8(decision.mode as u8);
    message.all_f64([decision.local_target.x, decision.local_target.y]);
    message.bool(decision.counts.is_some());
    let counts = decision.counts.unwrap_or_default().to_array();
    counts.into_iter().for_each(|count| message.u32(count));
    message.u64(plans);
    message.u64(plans_received);
    message.f64(took_s);
    message.u8(lost.map_or(0, |why| why as u8 + 1));
    message.finish()
}

impl Tick {
    /// Reads the message; none of one that is damaged.
    #[must_use]
    pub fn read(message: &[u8]) -> Option<Self> {
        let mut read = Decoder::new(message)?;
        let _ = (read.i32()?, read.u32()?);
        let tick = read.u64()?;
        let (time_s, scan_s) = (read.f64()?, read.f64()?);
        let observation = Observation {
            time_s,
            pose: Pose::new(read.f64()?, read.f64()?, read.f64()?),
            lost: None,
            twist: Twist::new(read.f64()?, read.f64()?),
            scan: Scan {
                angle_min: read.f64()?,
                angle_increment: read.f64()?,
                range_max: read.f64()?,
                ranges: read.all_f64()?,
            },
            scan_s,
        };
        let command = Twist::new(read.f64()?, read.f64()?);
        let mode = *MODES.get(usize::from(read.u8()?))?;
        let local_target = Point::new(read.f64()?, read.f64()?);
        let is_sampled = read.bool()?;
        let counts = Counts {
            admissible: read.u32()?,
            collision: read.u32()?,
            cannot_stop: read.u32()?,
            outside: read.u32()?,
        };
        let decision = Decision {
            command,
            mode,
            local_target,
            counts: is_sampled.then_some(counts),
        };
        let mut tick = Self {
            tick,
            observation,
            decision,
            plans: read.u64()?,
            plans_received: read.u64()?,
            took_s: read.f64()?,
        };
        tick.observation.lost = match read.u8()? {
            0 => None,
            number => Some(*LOST.get(usize::from(number) - 1)?),
        };
        read.is_done().then_some(tick)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modes_are_numbered_as_the_definition_has_them() {
        for (number, mode) in MODES.iter().enumerate() {
            assert_eq!(*mode as usize, number);
            let line = format!("uint8 {}={number}\n", mode.as_str().to_uppercase());
            assert!(crate::recording::definitions::schema("inbye_msgs/Tick").contains(&line));
        }
    }

    #[test]
    fn reasons_are_numbered_as_the_definition_has_them() {
        for (number, why) in LOST.iter().enumerate() {
            assert_eq!(*why as usize, number);
            let word = serde_json::to_value(why).expect("a word");
            let word = word.as_str().unwrap_or_default().to_uppercase();
            let line = format!("uint8 {word}={}\n", number + 1);
            assert!(crate::recording::definitions::schema("inbye_msgs/Tick").contains(&line));
        }
    }

    #[test]
    fn a_tick_is_read_as_it_was_written() {
        let observation = Observation {
            time_s: 12.3,
            pose: Pose::new(0.1, -0.2, 0.3),
            lost: Some(LostReason::HighUncertainty),
            twist: Twist::new(0.4, -0.5),
            scan: Scan {
                angle_min: -1.0,
                angle_increment: 0.1,
                range_max: 10.0,
                ranges: vec![1.0 / 3.0, f64::INFINITY, 7.0],
            },
            scan_s: 12.25,
        };
        let mut decision = Decision {
            command: Twist::new(0.6, 0.7),
            mode: Mode::Evading,
            local_target: Point::new(8.0, 9.0),
            counts: None,
        };
        for counts in [
            None,
            Some(Counts {
                admissible: 1,
                collision: 2,
                cannot_stop: 3,
                outside: 4,
            }),
        ] {
            decision.counts = counts;
            let message = tick(5, &observation, &decision, (6, 7), 0.001);
            let read = Tick::read(&message).expect("it is whole");
            assert_eq!((read.tick, read.plans, read.plans_received), (5, 6, 7));
            assert_eq!((&read.decision, read.took_s), (&decision, 0.001));
            assert_eq!(read.observation.scan, observation.scan);
            assert_eq!(read.observation.pose, observation.pose);
            assert_eq!(read.observation.lost, observation.lost);
            assert_eq!(read.observation.twist, observation.twist);
            assert_eq!(
                (read.observation.time_s, read.observation.scan_s),
                (12.3, 12.25)
            );
            for end in 0..message.len() {
                assert!(Tick::read(&message[..end]).is_none(), "{end}");
            }
        }
    }
}
