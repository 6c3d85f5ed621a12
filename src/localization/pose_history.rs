//! Short history of poses for interpolation.

use std::collections::VecDeque;

use crate::geometry::Pose;

/// Length of the history, seconds: a few lidar revolutions.
const HISTORY_S: f64 = 1.0;

/// Largest number of poses, whatever their times.
const MAX_POSES: usize = 1024;

/// The poses of the last second.
#[derive(Clone, Debug, Default)]
pub struct PoseHistory {
    rows: VecDeque<(f64, Pose)>,
}

impl PoseHistory {
    /// Creates an empty history with preallocated memory.
    #[must_use]
    pub fn new() -> Self {
        Self { rows: VecDeque::with_capacity(MAX_POSES) }
    }

    /// Records a pose at a time, seconds. A pose at the same time as the last replaces it; an earlier time clears the
    /// history; values that are not finite are ignored.
    pub fn record(&mut self, time_s: f64, pose: &Pose) {
        if !(time_s.is_finite() && pose.is_finite()) {
            return;
        }
        match self.rows.back().map(|(last_s, _)| *last_s) {
            Some(last_s) if time_s < last_s => self.rows.clear(),
            Some(last_s) if time_s == last_s => {
                self.rows.pop_back();
            }
            _ => {}
        }
        // One pose older than the limit is kept for interpolation.
        while self.rows.len() >= MAX_POSES
            || self.rows.get(1).is_some_and(|(next_s, _)| time_s - next_s > HISTORY_S)
        {
            self.rows.pop_front();
        }
        self.rows.push_back((time_s, *pose));
    }

    /// The newest time and pose.
    #[must_use]
    pub fn newest(&self) -> Option<(f64, Pose)> {
        self.rows.back().copied()
    }

    /// The pose at a time, seconds, interpolated along an arc between the adjacent poses. Times outside the history give its
    /// first or last pose. None if it is empty.
    #[must_use]
    pub fn at(&self, time_s: f64) -> Option<Pose> {
        let after = self.rows.partition_point(|(row_s, _)| *row_s <= time_s);
        let Some(&(before_s, before)) = after.checked_sub(1).and_then(|row| self.rows.get(row))
        else {
            return self.rows.front().map(|(_, pose)| *pose);
        };
        let Some(&(after_s, after)) = self.rows.get(after) else {
            return Some(before);
        };
        Some(before.interpolate(&after, (time_s - before_s) / (after_s - before_s)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pose_history_interpolates_between_poses() {
        let mut track = PoseHistory::new();
        assert_eq!(track.at(0.0), None);
        track.record(1.0, &Pose::new(0.0, 0.0, 0.0));
        track.record(1.1, &Pose::new(0.1, 0.0, 0.0));
        let at = |time_s: f64| track.at(time_s).expect("two poses").x;
        assert_eq!([at(0.5), at(1.0), at(1.1), at(9.0)], [0.0, 0.0, 0.1, 0.1]);
        assert!((at(1.025) - 0.025).abs() < 1e-12);
    }

    #[test]
    fn pose_history_drops_old_poses_and_restarts_when_time_decreases() {
        let mut track = PoseHistory::new();
        for tick in 0..100_000 {
            track.record(0.01 * f64::from(tick), &Pose::new(f64::from(tick), 0.0, 0.0));
        }
        assert!(track.rows.len() < 110, "{}", track.rows.len());
        track.record(f64::NAN, &Pose::default());
        track.record(5.0, &Pose::new(f64::NAN, 0.0, 0.0));
        assert_eq!(track.newest().map(|(_, pose)| pose.x), Some(99_999.0));
        track.record(5.0, &Pose::default());
        track.record(5.0, &Pose::new(7.0, 0.0, 0.0));
        assert_eq!(track.rows.len(), 1);
        assert_eq!(track.at(5.0).map(|pose| pose.x), Some(7.0));
    }
}
