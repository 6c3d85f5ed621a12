//! Sampling density that meets the deadline.

use crate::local::Sampling;

/// This many misses lower the sampling density
const MISSES_TO_LOWER: u32 = 2;
/// within this many decisions: a second at 10 Hz. A single miss may be the system's fault.
const MISSES_REMEMBERED: u32 = 10;
/// A decision within this share of its deadline has slack: the next level has at most four times the samples.
const SLACK: f64 = 0.25;
/// This many decisions in a row with slack raise the sampling density: five seconds at 10 Hz.
const SLACK_TO_RAISE: u32 = 50;

/// No level has fewer forward speeds or turn rates, unless the settings have: the closed loop was measured with 64 samples and
/// more.
const FEWEST: u32 = 8;

/// Levels of sampling density: that of the settings first, and half as many speeds and turn rates at each further one.
#[derive(Clone, Debug)]
pub(super) struct AdaptiveSampling {
    levels: Vec<Sampling>,
    level: usize,
    lowest: usize,
    /// One bit for each of the last decisions, the newest in the lowest bit: whether it was late.
    late: u32,
    with_slack: u32,
}

impl AdaptiveSampling {
    /// Levels from that of the settings downwards.
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

    /// Updates the level with a decision that took this share of its deadline; above 1 it was late.
    pub fn update(&mut self, share: f64) {
        let is_late = share > 1.0 || share.is_nan();
        self.late = (self.late << 1 | u32::from(is_late)) & ((1 << MISSES_REMEMBERED) - 1);
        self.with_slack = if share <= SLACK { self.with_slack + 1 } else { 0 };
        if self.late.count_ones() >= MISSES_TO_LOWER {
            self.go_to((self.level + 1).min(self.levels.len() - 1));
        } else if self.with_slack >= SLACK_TO_RAISE {
            self.go_to(self.level.saturating_sub(1));
        }
    }

    /// Forgets the decisions so far: those at one level say nothing about the next.
    fn go_to(&mut self, level: usize) {
        self.level = level;
        self.lowest = self.lowest.max(level);
        self.late = 0;
        self.with_slack = 0;
    }

    /// The present sampling density.
    pub fn sampling(&self) -> Sampling {
        self.levels[self.level]
    }

    /// The lowest sampling density so far.
    pub fn lowest(&self) -> Sampling {
        self.levels[self.lowest]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FULL: Sampling = Sampling { vx_samples: 20, vtheta_samples: 40 };

    fn counts(sampling: &AdaptiveSampling) -> (u32, u32) {
        let Sampling { vx_samples, vtheta_samples } = sampling.sampling();
        (vx_samples, vtheta_samples)
    }

    fn after(sampling: &mut AdaptiveSampling, shares: impl IntoIterator<Item = f64>) -> (u32, u32) {
        shares.into_iter().for_each(|share| sampling.update(share));
        counts(sampling)
    }

    #[test]
    fn levels_halve_down_to_eight_by_eight() {
        let mut sampling = AdaptiveSampling::new(FULL);
        let mut seen = vec![counts(&sampling)];
        for _ in 0..5 {
            seen.push(after(&mut sampling, [1.5, 1.5]));
        }
        assert_eq!(seen, [(20, 40), (10, 20), (8, 10), (8, 8), (8, 8), (8, 8)]);
        assert_eq!(sampling.lowest(), sampling.sampling());
        let few = Sampling { vx_samples: 3, vtheta_samples: 5 };
        assert_eq!(after(&mut AdaptiveSampling::new(few), [2.0; 9]), (3, 5));
    }

    #[test]
    fn two_misses_within_ten_decisions_lower_the_level_and_one_does_not() {
        let on_time = |count| core::iter::repeat_n(1.0, count);
        let mut sampling = AdaptiveSampling::new(FULL);
        after(&mut sampling, [1.01]);
        after(&mut sampling, on_time(9));
        assert_eq!(after(&mut sampling, [1.01]), (20, 40));
        after(&mut sampling, on_time(8));
        assert_eq!(after(&mut sampling, [1.01]), (10, 20));
        // The two misses that lowered the level no longer count.
        assert_eq!(after(&mut sampling, [1.01]), (10, 20));
        assert_eq!(after(&mut sampling, [f64::NAN]), (8, 10));
    }

    #[test]
    fn long_slack_raises_the_level_by_one() {
        let mut sampling = AdaptiveSampling::new(FULL);
        after(&mut sampling, [2.0; 4]);
        assert_eq!(after(&mut sampling, [SLACK; 49]), (8, 10));
        assert_eq!(after(&mut sampling, [SLACK.next_up()]), (8, 10));
        assert_eq!(after(&mut sampling, [SLACK; 49]), (8, 10));
        assert_eq!(after(&mut sampling, [0.0]), (10, 20));
        assert_eq!(after(&mut sampling, [0.1; 49]), (10, 20));
        assert_eq!(after(&mut sampling, [0.1]), (20, 40));
        assert_eq!(after(&mut sampling, [0.1; 200]), (20, 40));
        assert_eq!(sampling.lowest().vtheta_samples, 10);
    }
}
