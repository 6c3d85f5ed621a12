//! Odometry from encoder ticks (paper, eqs. 3-8).

use super::{PerTrack, TrackedDrive};
use crate::geometry::{Pose, Twist};

/// Signed difference of two readings of a 32-bit counter, across its wrap-around.
///
/// Correct for less than 2^31 ticks: half a day at 50,000 ticks per second.
const fn tick_difference(before: u32, now: u32) -> i32 {
    now.wrapping_sub(before) as i32
}

impl TrackedDrive {
    /// The pose after uniform travel of each track, metres: the exact arc of eqs. 6 to 8. Its yaw is in (-pi, pi].
    #[must_use]
    pub fn after(&self, pose: &Pose, travel_m: &PerTrack<f64>) -> Pose {
        pose.after(&self.twist(travel_m), 1.0)
    }
}

/// Dead reckoning from encoder readings.
#[derive(Clone, Debug)]
pub struct TrackOdometry {
    drive: TrackedDrive,
    ticks_per_m: PerTrack<f64>,
    last: Option<PerTrack<u32>>,
    pose: Pose,
}

impl TrackOdometry {
    /// Creates odometry that starts at a pose. The drive's width is the effective one.
    #[must_use]
    pub fn new(drive: TrackedDrive, ticks_per_m: PerTrack<f64>, pose: Pose) -> Self {
        Self { drive, ticks_per_m, last: None, pose }
    }

    /// Adds a reading and returns the motion since the last one, metres and radians; zero for the first.
    pub fn update(&mut self, ticks: PerTrack<u32>) -> Twist {
        let last = self.last.replace(ticks).unwrap_or(ticks);
        let travel_m = travel_m(&last, &ticks, &self.ticks_per_m);
        self.pose = self.drive.after(&self.pose, &travel_m);
        self.drive.twist(&travel_m)
    }

    /// The estimated pose.
    #[must_use]
    pub const fn pose(&self) -> &Pose {
        &self.pose
    }

    /// Discards the last reading and keeps the pose, for counters that may have been reset.
    pub fn reset_counters(&mut self) {
        self.last = None;
    }
}

/// Travel of each track between two readings, metres.
#[must_use]
pub fn travel_m(
    before: &PerTrack<u32>,
    now: &PerTrack<u32>,
    ticks_per_m: &PerTrack<f64>,
) -> PerTrack<f64> {
    before
        .zip(*now, |before, now| f64::from(tick_difference(before, now)))
        .zip(*ticks_per_m, |ticks, per_m| ticks / per_m)
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use super::*;

    const DRIVE: TrackedDrive = TrackedDrive { track_width_m: 0.5 };

    #[test]
    fn tick_difference_wraps_in_both_directions() {
        assert_eq!(tick_difference(u32::MAX - 1, 3), 5);
        assert_eq!(tick_difference(3, u32::MAX - 1), -5);
        assert_eq!(tick_difference(0x7FFF_FFFE, 0x8000_0003), 5);
        assert_eq!(tick_difference(7, 7), 0);
    }

    #[test]
    fn odometry_measures_a_half_turn_in_place() {
        let mut odometry =
            TrackOdometry::new(DRIVE, PerTrack::new(1000.0, 2000.0), Pose::default());
        odometry.update(PerTrack::new(100, u32::MAX - 99));
        // Each track travels pi / 2 times 0.5 m = 0.7854 m: 785 and 1571 ticks, across both wraps.
        let moved = odometry.update(PerTrack::new(100_u32.wrapping_sub(785), 1471));
        assert!(moved.linear.abs() < 3e-4 && (moved.angular - PI).abs() < 2e-3, "{moved:?}");
        assert!(odometry.pose().x.abs() < 1e-3 && odometry.pose().yaw.abs() > PI - 2e-3);
    }

    #[test]
    fn odometry_ignores_a_counter_reset() {
        let mut odometry = TrackOdometry::new(DRIVE, PerTrack::both(1000.0), Pose::default());
        odometry.update(PerTrack::both(500));
        odometry.update(PerTrack::both(1500));
        odometry.reset_counters();
        assert_eq!(odometry.update(PerTrack::both(0)), Twist::STOP);
        assert!((odometry.pose().x - 1.0).abs() < 1e-12);
    }
}
