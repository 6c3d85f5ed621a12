//! When to try again what has failed.

/// Pauses that double from one failure to the next, up to a longest one.
#[derive(Clone, Copy, Debug)]
pub(in crate::base) struct BackOff {
    first_s: f64,
    longest_s: f64,
    failures: i32,
    due_s: f64,
}

impl BackOff {
    /// Nothing has failed yet.
    pub(in crate::base) const fn new(first_s: f64, longest_s: f64) -> Self {
        Self {
            first_s,
            longest_s,
            failures: 0,
            due_s: f64::NEG_INFINITY,
        }
    }

    /// Whether it may be tried now.
    pub(in crate::base) fn is_due(&self, now_s: f64) -> bool {
        now_s >= self.due_s
    }

    /// It has failed.
    pub(in crate::base) fn failed(&mut self, now_s: f64) {
        let pause_s = self.first_s * libm::ldexp(1.0, self.failures);
        self.due_s = now_s + pause_s.min(self.longest_s);
        // Beyond that it is the longest in any case, and the count must not overflow.
        self.failures = (self.failures + 1).min(64);
    }

    /// It has worked: the next pause is the first again.
    pub(in crate::base) const fn worked(&mut self) {
        self.failures = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_double_to_a_bound_and_begin_anew() {
        let mut back_off = BackOff::new(0.125, 0.5);
        let (mut now_s, mut tries) = (0.0, Vec::new());
        // Sixteenths of a second, which add up without rounding.
        for _ in 0..64 {
            if back_off.is_due(now_s) {
                tries.push(now_s);
                back_off.failed(now_s);
            }
            now_s += 0.0625;
        }
        let pauses: Vec<f64> = tries.windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert_eq!(pauses[..4], [0.125, 0.25, 0.5, 0.5]);
        back_off.worked();
        back_off.failed(now_s);
        assert!(!back_off.is_due(now_s + 0.12) && back_off.is_due(now_s + 0.125));
    }
}
