//! How densely to sample so that decisions come in time.

use crate::local::Sampling;

/// Sampling is lowered at so many misses
pub const MISSES_TO_LOWER: u32 = 2;
/// within so many decisions: a second at 10 Hz. One alone may be the system's fault, and passes.
pub const MISSES_REMEMBERED: u32 = 10;
/// A decision within this share of its deadline has slack: the next level has at most four times the samples.
pub const SLACK: f64 = 0.25;
/// Sampling is raised after so many decisions with slack in a row: five seconds at 10 Hz.
pub const SLACK_TO_RAISE: u32 = 50;

/// No level has fewer forward speeds or turn rates, unless the settings have: 64 samples are the fewest that the closed
/// loop was measured with.
const FEWEST: u32 = 8;

/// Levels of sampling: that of the settings first, and half as many speeds and turn rates at each further one.
#[derive(Clone, Debug)]
pub struct AdaptiveSampling {
    levels: Vec<Sampling>,
    level: usize,
    lowest: usize,
    /// One bit for each of the last decisions, the newest lowest: whether it came too late.
    late: u32,
    with_slack: u32,
}

impl AdaptiveSampling {
    /// Levels below that of the settings.
    #[must_use]
    pub fn new(full: Sampling) -> Self {
        let half = |count: u32| count.min(FEWEST).max(count.div_ceil(2));
        let below = |above: &Sampling| {
            let next = Sampling {
                vx_samples: half(above.vx_samples),
                vtheta_samples: half(above.vtheta_samples),
            };
            (next != *above).then_some(next)
        };
        Self {
            levels: core::iter::successors(Some(full), below).collect(),
            level: 0,
            lowest: 0,
            late: 0,
            with_slack: 0,
        }
    }

    /// Notes a decision that took this share of its deadline; above 1 it came too late.
    pub fn note(&mut self, share: f64) {
        let is_late = share > 1.0 || share.is_nan();
        self.late = (self.late << 1 | u32::from(is_late)) & ((1 << MISSES_REMEMBERED) - 1);
        self.with_slack = if share <= SLACK {
            self.with_slack + 1
        } else {
            0
        };
        if self.late.count_ones() >= MISSES_TO_LOWER {
            self.go_to((self.level + 1).min(self.levels.len() - 1));
        } else if self.with_slack >= SLACK_TO_RAISE {
            self.go_to(self.level.saturating_sub(1));
        }
    }

    /// What was measured of one level says nothing of the next.
    fn go_to(&mut self, level: usize) {
        self.level = level;
        self.lowest = self.lowest.max(level);
        self.late = 0;
        self.with_slack = 0;
    }

    /// How to sample now.
    #[must_use]
    pub fn sampling(&self) -> Sampling {
        self.levels[self.level]
    }

    /// The lowest density so far.
    #[must_use]
    pub fn lowest(&self) -> Sampling {
        self.levels[self.lowest]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FULL: Sampling = Sampling {
        vx_samples: 20,
        vtheta_samples: 40,
    };

    fn counts(density: &AdaptiveSampling) -> (u32, u32) {
        let Sampling {
            vx_samples,
            vtheta_samples,
        } = density.sampling();
        (vx_samples, vtheta_samples)
    }

    fn after(density: &mut AdaptiveSampling, shares: impl IntoIterator<Item = f64>) -> (u32, u32) {
        shares.into_iter().for_each(|share| density.note(share));
        counts(density)
    }

    #[test]
    fn levels_halve_down_to_eight_by_eight_and_no_further() {
        let mut density = AdaptiveSampling::new(FULL);
        let mut seen = vec![counts(&density)];
        for _ in 0..5 {
            seen.push(after(&mut density, [1.5, 1.5]));
        }
        assert_eq!(seen, [(20, 40), (10, 20), (8, 10), (8, 8), (8, 8), (8, 8)]);
        assert_eq!(density.lowest(), density.sampling());
        let few = Sampling {
            vx_samples: 3,
            vtheta_samples: 5,
        };
        assert_eq!(after(&mut AdaptiveSampling::new(few), [2.0; 9]), (3, 5));
    }

    #[test]
    fn one_miss_passes_and_two_within_ten_decisions_do_not() {
        let on_time = |count| core::iter::repeat_n(1.0, count);
        let mut density = AdaptiveSampling::new(FULL);
        after(&mut density, [1.01]);
        after(&mut density, on_time(9));
        assert_eq!(after(&mut density, [1.01]), (20, 40));
        after(&mut density, on_time(8));
        assert_eq!(after(&mut density, [1.01]), (10, 20));
        // The two that lowered it are spent.
        assert_eq!(after(&mut density, [1.01]), (10, 20));
        assert_eq!(after(&mut density, [f64::NAN]), (8, 10));
    }

    #[test]
    fn only_long_slack_raises_it_one_level_at_a_time() {
        let mut density = AdaptiveSampling::new(FULL);
        after(&mut density, [2.0; 4]);
        assert_eq!(after(&mut density, [SLACK; 49]), (8, 10));
        assert_eq!(after(&mut density, [SLACK.next_up()]), (8, 10));
        assert_eq!(after(&mut density, [SLACK; 49]), (8, 10));
        assert_eq!(after(&mut density, [0.0]), (10, 20));
        assert_eq!(after(&mut density, [0.1; 49]), (10, 20));
        assert_eq!(after(&mut density, [0.1]), (20, 40));
        assert_eq!(after(&mut density, [0.1; 200]), (20, 40));
        assert_eq!(density.lowest().vtheta_samples, 10);
    }
}
