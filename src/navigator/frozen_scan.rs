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
