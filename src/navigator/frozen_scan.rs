//! Frozen lidars: the same revolution again and again, while the robot moves.

use super::Observation;

/// Scans in a row that repeat the one before.
const MIN_REPEATS: u32 = 3;
/// Motion since the first of them, metres and radians. A standing robot may see the same twice, by a simulated lidar without
/// noise.
const MOVED_M: f64 = 0.1;
const TURNED_RAD: f64 = 0.1;
/// Two times of a change that differ by at most this are the same, seconds: a source may correct its clock a little.
const SAME_S: f64 = 0.05;

/// Finds a frozen lidar. Once found, it stays frozen until a scan differs.
#[derive(Clone, Debug, Default)]
pub(super) struct FrozenScan {
    changed_s: Option<f64>,
    time_s: f64,
    repeats: u32,
    moved_m: f64,
    turned_rad: f64,
}

impl FrozenScan {
    /// Takes an observation with finite numbers, and whether its scan is a new one; returns whether the lidar is frozen.
    pub fn update(&mut self, seen: &Observation, is_new: bool) -> bool {
        let has_changed =
            self.changed_s.is_none_or(|changed_s| (seen.scan_changed_s - changed_s).abs() > SAME_S);
        if has_changed {
            *self = Self {
                changed_s: Some(seen.scan_changed_s),
                time_s: seen.time_s,
                ..Self::default()
            };
            return false;
        }
        let elapsed_s = (seen.time_s - self.time_s).max(0.0);
        self.time_s = seen.time_s;
        self.repeats += u32::from(is_new);
        self.moved_m += seen.twist.linear.abs() * elapsed_s;
        self.turned_rad += seen.twist.angular.abs() * elapsed_s;
        self.repeats >= MIN_REPEATS && (self.moved_m >= MOVED_M || self.turned_rad >= TURNED_RAD)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Pose, Twist};
    use crate::map::Scan;

    /// The first of the ticks, which are 0.1 s apart, at which the lidar counts as frozen. Each tick has the time of the latest
    /// change of a scan, and whether its scan is new.
    fn frozen_at(twist: Twist, tick: impl Fn(u32) -> (f64, bool)) -> Option<u32> {
        let mut check = FrozenScan::default();
        (0..100).find(|&number| {
            let time_s = f64::from(number) * 0.1;
            let (scan_changed_s, is_new) = tick(number);
            let seen = Observation {
                time_s,
                pose: Pose::default(),
                pose_s: time_s,
                lost: None,
                twist,
                odometry_s: time_s,
                scan: Scan {
                    angle_min: 0.0,
                    angle_increment: 0.1,
                    range_max: 9.0,
                    ranges: vec![1.0; 60],
                    ..Scan::default()
                },
                scan_s: time_s,
                scan_changed_s,
                sent: None,
            };
            check.update(&seen, is_new)
        })
    }

    #[test]
    fn lidar_is_frozen_after_three_repeats_and_a_tenth_of_a_metre_or_radian() {
        let same = |_| (0.0, true);
        for fast in [1.0, -1.0] {
            assert_eq!(frozen_at(Twist::new(fast, 0.0), same), Some(3));
            assert_eq!(frozen_at(Twist::new(0.0, fast), same), Some(3));
        }
        // 0.1 m and 0.1 rad after 0.5 s.
        assert_eq!(frozen_at(Twist::new(0.2001, 0.0), same), Some(5));
        assert_eq!(frozen_at(Twist::new(0.0, -0.2001), same), Some(5));
        assert_eq!(frozen_at(Twist::STOP, same), None);
        // A tick without a new scan is no repeat.
        assert_eq!(frozen_at(Twist::new(1.0, 0.0), |tick| (0.0, tick % 2 == 0)), Some(6));
    }

    #[test]
    fn change_of_a_scan_restarts_the_count() {
        let fast = Twist::new(1.0, 0.0);
        // A source corrects its clock by 0.04 s; a change by more is a new scan, also to an earlier time.
        assert_eq!(frozen_at(fast, |tick| (0.04 * f64::from(tick % 2), true)), Some(3));
        for change_s in [0.06, -0.06] {
            assert_eq!(frozen_at(fast, |tick| (change_s * f64::from(tick), true)), None);
        }
    }
}
