//! When a process that ended is started again.

/// First pause before a restart, seconds; it doubles at each further one.
const FIRST_PAUSE_S: f64 = 0.1;
/// Longest pause, seconds.
const LONGEST_PAUSE_S: f64 = 5.0;
/// A process that ran for this long, seconds, ends a series of failures.
const STABLE_S: f64 = 30.0;

/// Exponential backoff between restarts.
#[derive(Clone, Copy, Debug)]
pub struct RestartBackoff {
    pause_s: f64,
    due_s: f64,
}

impl Default for RestartBackoff {
    fn default() -> Self {
        Self { pause_s: FIRST_PAUSE_S, due_s: f64::NEG_INFINITY }
    }
}

impl RestartBackoff {
    /// The process ended at a time after it had run for a while, both in seconds.
    pub fn ended(&mut self, now_s: f64, ran_s: f64) {
        if ran_s >= STABLE_S {
            self.pause_s = FIRST_PAUSE_S;
        }
        self.due_s = now_s + self.pause_s;
        self.pause_s = (2.0 * self.pause_s).min(LONGEST_PAUSE_S);
    }

    /// Whether the process may start at a time, seconds.
    pub fn is_due(&self, now_s: f64) -> bool {
        now_s >= self.due_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pause_doubles_up_to_its_limit_and_falls_back_after_a_stable_run() {
        let mut backoff = RestartBackoff::default();
        assert!(backoff.is_due(0.0));
        for pause_s in [0.1, 0.2, 0.4, 0.8, 1.6, 3.2, 5.0, 5.0] {
            backoff.ended(100.0, 1.0);
            assert!(!backoff.is_due(99.99 + pause_s) && backoff.is_due(100.01 + pause_s));
        }
        backoff.ended(200.0, 60.0);
        assert!(!backoff.is_due(200.05) && backoff.is_due(200.11));
    }
}
