//! Where something was a moment ago: the robot by its odometry, say.

use std::collections::VecDeque;

use crate::geometry::Pose;

/// So long is remembered, seconds: a few revolutions of any lidar.
const REMEMBERED_S: f64 = 1.0;

/// Most poses remembered, whatever their times.
const MOST: usize = 1024;

/// The last second of a motion.
#[derive(Clone, Debug, Default)]
pub struct PoseHistory {
    rows: VecDeque<(f64, Pose)>,
}

impl PoseHistory {
    /// Nothing remembered, and room for all that will be.
    #[must_use]
    pub fn new() -> Self {
        Self {
            rows: VecDeque::with_capacity(MOST),
        }
    }

    /// Takes in where it is at a time, seconds. Of poses at the same time the later counts. A time before the last
    /// one, or numbers that are not finite, begin anew or are passed over.
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
        // One older than what is asked for is kept: what lies between is blended.
        while self.rows.len() >= MOST
            || self
                .rows
                .get(1)
                .is_some_and(|(next_s, _)| time_s - next_s > REMEMBERED_S)
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

    /// Where it was at a time, seconds: on the arc between the poses before and after; at the first or the last of
    /// them where the time lies before or after all. None before the first pose.
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
    fn a_pose_between_two_is_on_the_way() {
        let mut track = PoseHistory::new();
        assert_eq!(track.at(0.0), None);
        track.record(1.0, &Pose::new(0.0, 0.0, 0.0));
        track.record(1.1, &Pose::new(0.1, 0.0, 0.0));
        let at = |time_s: f64| track.at(time_s).expect("two poses").x;
        assert_eq!([at(0.5), at(1.0), at(1.1), at(9.0)], [0.0, 0.0, 0.1, 0.1]);
        assert!((at(1.025) - 0.025).abs() < 1e-12);
    }

    #[test]
    fn old_poses_go_and_a_clock_that_runs_back_begins_anew() {
        let mut track = PoseHistory::new();
        for tick in 0..100_000 {
            track.record(
                0.01 * f64::from(tick),
                &Pose::new(f64::from(tick), 0.0, 0.0),
            );
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
