//! Poses in the order of their times.

use super::TimedPose;

/// Poses in the order of their times; of the same time, in the order given.
pub(super) struct ByTime(Vec<TimedPose>);

impl ByTime {
    /// Sorts poses. Their times become later by an offset, seconds.
    pub fn new(poses: &[TimedPose], offset_s: f64) -> Self {
        let later = |it: &TimedPose| TimedPose { time_s: it.time_s + offset_s, pose: it.pose };
        let mut ordered: Vec<TimedPose> = poses.iter().map(later).collect();
        ordered.sort_by(|one, other| one.time_s.total_cmp(&other.time_s));
        Self(ordered)
    }

    /// The pose with the nearest time, and the difference of the times; of two as near, the earlier one, and of several of one
    /// time, the last.
    pub fn nearest(&self, time_s: f64) -> Option<(&TimedPose, f64)> {
        let after = self.0.partition_point(|it| it.time_s <= time_s);
        let before = after.checked_sub(1).and_then(|index| self.0.get(index));
        let candidates = before.into_iter().chain(self.0.get(after));
        let with_gap = candidates.map(|it| (it, (it.time_s - time_s).abs()));
        with_gap.min_by(|one, other| one.1.total_cmp(&other.1))
    }

    /// The poses whose times differ by at most this, seconds.
    pub fn within(&self, time_s: f64, reach_s: f64) -> impl Iterator<Item = &TimedPose> {
        let first = self.0.partition_point(|it| it.time_s < time_s - reach_s);
        self.0[first..].iter().take_while(move |it| it.time_s <= time_s + reach_s)
    }
}
