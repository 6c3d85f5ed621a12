//! When the statuses of the node go to `diagnostics`.

/// Interval of statuses that do not change, seconds.
const INTERVAL_S: f64 = 1.0;

/// What was published last, and when.
#[derive(Debug, Default)]
pub struct Diagnostics {
    /// The names of the states.
    states: Vec<&'static str>,
    published_s: Option<f64>,
}

impl Diagnostics {
    /// Whether the statuses are published at a time, seconds: when a state changes, and once a second.
    pub fn is_due(
        &mut self,
        now_s: f64,
        states: impl Iterator<Item = &'static str> + Clone,
    ) -> bool {
        let is_recent = |published_s: f64| (0.0..INTERVAL_S).contains(&(now_s - published_s));
        if self.published_s.is_some_and(is_recent) && states.clone().eq(self.states.iter().copied())
        {
            return false;
        }
        self.published_s = Some(now_s);
        self.states.clear();
        self.states.extend(states);
        true
    }
}
