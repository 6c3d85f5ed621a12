//! Exponential backoff between attempts to reconnect.

/// Pauses that double with each failure, up to a maximum.
#[derive(Clone, Copy, Debug)]
pub(in crate::base) struct Backoff {
    min_s: f64,
    max_s: f64,
    failures: i32,
    due_s: f64,
}

impl Backoff {
    /// Creates a backoff without failures; times in seconds.
    pub(in crate::base) const fn new(min_s: f64, max_s: f64) -> Self {
        Self { min_s, max_s, failures: 0, due_s: f64::NEG_INFINITY }
    }

    /// Whether the next attempt is due.
    pub(in crate::base) fn is_due(&self, now_s: f64) -> bool {
        now_s >= self.due_s
    }

    /// Records a failed attempt and schedules the next one.
    pub(in crate::base) fn failed(&mut self, now_s: f64) {
        let pause_s = self.min_s * libm::ldexp(1.0, self.failures);
        self.due_s = now_s + pause_s.min(self.max_s);
        // The pause has long reached its maximum, and the count must not overflow.
        self.failures = (self.failures + 1).min(64);
    }

    /// Records a success: the next pause is the shortest again.
    pub(in crate::base) const fn succeeded(&mut self) {
        self.failures = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn backoff_doubles_to_its_maximum_and_resets_on_success() {
        let mut backoff = Backoff::new(0.125, 0.5);
        let (mut now_s, mut attempts) = (0.0, Vec::new());
        // Sixteenths of a second add up without rounding.
        for _ in 0..64 {
            if backoff.is_due(now_s) {
                attempts.push(now_s);
                backoff.failed(now_s);
            }
            now_s += 0.0625;
        }
        let pauses: Vec<f64> = attempts.windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert_eq!(pauses[..4], [0.125, 0.25, 0.5, 0.5]);
        backoff.succeeded();
        backoff.failed(now_s);
        assert!(!backoff.is_due(now_s + 0.12) && backoff.is_due(now_s + 0.125));
    }
}
