//! Decisions that miss the period of a control loop.

/// Rates of common control loops, Hz.
pub const RATES_HZ: [f64; 3] = [20.0, 50.0, 100.0];

/// Number of late decisions for each of [`RATES_HZ`], counted from the exact times, not from percentiles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Misses([usize; RATES_HZ.len()]);

impl Misses {
    /// Adds a decision with its time in seconds. A decision that takes the whole period is in time.
    pub fn record(&mut self, seconds: f64) {
        for (count, rate) in self.0.iter_mut().zip(RATES_HZ) {
            *count += usize::from(seconds > 1.0 / rate);
        }
    }

    /// The counts, in the order of [`RATES_HZ`].
    #[must_use]
    pub const fn counts(self) -> [usize; RATES_HZ.len()] {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::Misses;

    #[test]
    fn decision_is_late_when_longer_than_the_period() {
        let mut misses = Misses::default();
        for seconds in [0.0, 0.009, 0.010, 0.011, 0.02, 0.021, 0.05, 0.051, 3.0] {
            misses.record(seconds);
        }
        assert_eq!(misses.counts(), [2, 4, 6]);
    }
}
