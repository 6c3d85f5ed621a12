//! When to try again what has failed.

/// Pauses that double from one failure to the next, up to a longest one.
#[derive(Clone, Copy, Debug)]
pub(super) struct BackOff {
    first_s: f64,
    longest_s: f64,
    failures: i32,
    due_s: f64,
}

impl BackOff {
    /// Nothing has failed yet.
    pub(super) const fn new(first_s: f64, longest_s: f64) -> Self {
        Self {
            first_s,
            longest_s,
            failures: 0,
            due_s: f64::NEG_INFINITY,
        }
    }

    /// Whether it may be tried now.
    pub(super) fn is_due(&self, now_s: f64) -> bool {
        now_s >= self.due_s
    }

    /// It has failed.
    pub(super) fn failed(&mut self, now_s: f64) {
        let pause_s = self.first_s * libm::ldexp(1.0, self.failures);
        self.due_s = now_s + pause_s.min(self.longest_s);
        // Beyond that it is the longest in any case, and the count must not overflow.
        self.failures = (self.failures + 1).min(64);
    }

    /// It has worked: the next pause is the first again.
    pub(super) const fn worked(&mut self) {
        self.failures = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_double_to_a_bound_and_begin_anew() {
        let mut back_off = BackOff::new(0.1, 0.5);
        let mut now_s = 0.0;
        let mut tries = Vec::new();
        for _ in 0..200 {
            if back_off.is_due(now_s) {
                tries.push((now_s * 100.0_f64).round() as i32);
                back_off.failed(now_s);
            }
            now_s += 0.01;
        }
        let pauses: Vec<i32> = tries.windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert_eq!(pauses[..2], [10, 20]);
        assert!(pauses[2] >= 40 && pauses[3..].iter().all(|pause| (50..=51).contains(pause)));
        back_off.worked();
        back_off.failed(now_s);
        assert!(!back_off.is_due(now_s + 0.09) && back_off.is_due(now_s + 0.1));
    }
}
