//! Is the mission getting on?

/// Watches progress along the path.
#[derive(Clone, Debug, Default)]
pub struct ProgressChecker {
    least_left_m: Option<f64>,
    since_s: f64,
}

impl ProgressChecker {
    /// Measures from now on along a new path, so much of which is left. A new path alone is no progress.
    pub fn rebase(&mut self, left_m: f64) {
        self.least_left_m = Some(left_m);
    }

    /// Notes the path left and returns for how long, in seconds, it has not shrunk by `radius_m`.
    pub fn stuck_s(&mut self, now_s: f64, left_m: f64, radius_m: f64) -> f64 {
        if self
            .least_left_m
            .is_none_or(|least| left_m <= least - radius_m)
        {
            self.least_left_m = Some(left_m);
            self.since_s = now_s;
        }
        now_s - self.since_s
    }
}

/// Measures how long something has gone on without a break.
#[derive(Clone, Debug, Default)]
pub struct Since(Option<f64>);

impl Since {
    /// Seconds since `holds` became true; zero while it is false.
    pub fn update(&mut self, now_s: f64, holds: bool) -> f64 {
        if !holds {
            self.0 = None;
            return 0.0;
        }
        now_s - *self.0.get_or_insert(now_s)
    }
}
