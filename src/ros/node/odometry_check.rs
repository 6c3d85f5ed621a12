//! Detects odometry whose pose moves while its speed is zero: its driver does not measure the speed, or does not send it.

use super::incoming::OdometryInput;
use crate::geometry::{Pose, Twist, wrap_angle};

/// Motion with a speed of zero that proves that the speed is missing, metres and radians.
const MOVED_M: f64 = 0.1;
const TURNED_RAD: f64 = 0.2;
/// Time within which the pose must move that far, seconds: a pose may drift slowly.
const WINDOW_S: f64 = 1.0;
/// Largest share of one message in that motion: a pose that jumps was reset.
const MAX_SHARE: f64 = 0.5;

/// Compares poses and speeds of odometry.
#[derive(Clone, Debug, Default)]
pub struct SpeedCheck {
    /// Time and pose at the start of the window.
    from: Option<(f64, Pose)>,
    newest: Pose,
    /// The longest step between two messages, metres and radians.
    largest: (f64, f64),
    is_missing: bool,
}

impl SpeedCheck {
    /// Whether the speed of a message is missing. Once it is, all speeds of zero count as missing until another one comes.
    pub fn lacks_speed(&mut self, odometry: &OdometryInput) -> bool {
        let (time_s, pose) = (odometry.stamp.seconds(), odometry.pose);
        if odometry.twist != Twist::STOP {
            *self = Self::default();
            return false;
        }
        let from = self.from.filter(|(from_s, _)| (0.0..=WINDOW_S).contains(&(time_s - from_s)));
        let Some((_, from)) = from else {
            self.from = Some((time_s, pose));
            (self.newest, self.largest) = (pose, (0.0, 0.0));
            return self.is_missing;
        };
        let step = motion(&self.newest, &pose);
        self.largest = (self.largest.0.max(step.0), self.largest.1.max(step.1));
        self.newest = pose;
        let moved = motion(&from, &pose);
        let proves =
            |moved: f64, largest: f64, least: f64| moved >= least && largest <= MAX_SHARE * moved;
        self.is_missing |=
            proves(moved.0, self.largest.0, MOVED_M) || proves(moved.1, self.largest.1, TURNED_RAD);
        self.is_missing
    }
}

/// Distance and turn between two poses, metres and radians.
fn motion(from: &Pose, to: &Pose) -> (f64, f64) {
    ((to.position() - from.position()).norm(), wrap_angle(to.yaw - from.yaw).abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ros::msg::Time;

    /// The first of the messages, which are 0.05 s apart, at which the speed counts as missing.
    fn missing_at(twist: Twist, pose: impl Fn(f64) -> Pose) -> Option<u32> {
        let mut check = SpeedCheck::default();
        (0..100).find(|&number| {
            let time_s = 0.05 * f64::from(number);
            check.lacks_speed(&OdometryInput {
                stamp: Time::from_seconds(100.0 + time_s),
                frame: "odom".to_owned(),
                base_frame: "base_link".to_owned(),
                pose: pose(time_s),
                twist,
            })
        })
    }

    #[test]
    fn speed_of_zero_is_missing_while_the_pose_moves() {
        assert_eq!(missing_at(Twist::STOP, |time_s| Pose::new(0.5001 * time_s, 0.0, 3.0)), Some(4));
        assert_eq!(
            missing_at(Twist::STOP, |time_s| Pose::new(0.0, 0.0, 3.0 - 0.5001 * time_s)),
            Some(8)
        );
        assert_eq!(
            missing_at(Twist::new(0.5, 0.0), |time_s| Pose::new(0.5 * time_s, 0.0, 0.0)),
            None
        );
    }

    #[test]
    fn drift_and_jumps_of_the_pose_are_no_missing_speed() {
        assert_eq!(
            missing_at(Twist::STOP, |time_s| Pose::new(0.09 * time_s, 0.0, 0.1 * time_s)),
            None
        );
        let jump = |time_s: f64| Pose::new(if time_s < 2.0 { 0.0 } else { 3.0 }, 0.0, 0.0);
        assert_eq!(missing_at(Twist::STOP, jump), None);
    }
}
