//! Checks progress along the path, as Nav2's progress checker.

/// Measures the time since the last progress along the path.
#[derive(Clone, Debug, Default)]
pub(super) struct ProgressChecker {
    least_left_m: Option<f64>,
    since_s: f64,
}

impl ProgressChecker {
    /// Measures along a new path with this length left, metres. A new path alone is no progress.
    pub const fn rebase(&mut self, left_m: f64) {
        self.least_left_m = Some(left_m);
    }

    /// Updates with the length of path left and returns the time since it last shrank by `radius_m`, seconds.
    pub fn stuck_s(&mut self, now_s: f64, left_m: f64, radius_m: f64) -> f64 {
        if self.least_left_m.is_none_or(|least| left_m <= least - radius_m) {
            self.least_left_m = Some(left_m);
            self.since_s = now_s;
        }
        now_s - self.since_s
    }
}

/// Measures how long a condition has held without a break.
#[derive(Clone, Debug, Default)]
pub(super) struct ConditionTimer(Option<f64>);

impl ConditionTimer {
    /// Seconds since `holds` became true; zero while it is false.
    pub fn update(&mut self, now_s: f64, holds: bool) -> f64 {
        if !holds {
            self.0 = None;
            return 0.0;
        }
        now_s - *self.0.get_or_insert(now_s)
    }
}
