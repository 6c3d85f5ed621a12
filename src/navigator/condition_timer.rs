//! How long a condition has held.

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
