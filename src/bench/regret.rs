//! Regret of a command chosen from few samples against the one chosen from the densest sampling.

use crate::local::internals::Header;
use crate::local::internals::score::{Normalizer, normalizers};
use crate::local::{Evaluation, Terms};

/// Evaluates commands with the normalisers of the densest sampling.
///
/// Scores of different samplings do not compare: where terms are divided by their sums, scores shrink as samples are added.
/// Regret is a loss relative to the gain of the best sample over the mean admissible one in the densest sampling.
#[derive(Clone, Copy, Debug)]
pub struct RegretBaseline {
    normalizers: [Normalizer; 4],
    best: f64,
    mean: f64,
}

impl RegretBaseline {
    /// The baseline of a problem with the densest sampling; none without an admissible sample.
    #[must_use]
    pub fn new(header: &Header, densest: &Evaluation) -> Option<Self> {
        let winner = densest.winner.as_ref()?;
        let normalizers = normalizers(header, &densest.totals);
        let admissible = f64::from(densest.counts.admissible);
        // The score is linear in the terms, so the mean score is the score of the mean terms.
        let mean_terms = densest.totals.sums.map(|sum| sum as f64 / admissible);
        Some(Self {
            normalizers,
            best: score(&normalizers, winner.terms.to_array().map(f64::from)),
            mean: score(&normalizers, mean_terms),
        })
    }

    /// The regret of a sample with these terms: 0 for the best of the densest sampling, 1 for the mean of its admissible
    /// samples, above 1 for a worse sample. A sample between those of the densest sampling may be better than all of them;
    /// its regret is 0.
    #[must_use]
    pub fn regret(&self, terms: &Terms) -> f64 {
        let gain = self.best - self.mean;
        let lost = self.best - score(&self.normalizers, terms.to_array().map(f64::from));
        if lost > 0.0 && gain > 0.0 { lost / gain } else { 0.0 }
    }
}

/// The score of eq. 35 as in the engines but in floating point: the terms of another sampling may be outside the range of
/// these normalisers.
fn score(normalizers: &[Normalizer; 4], terms: [f64; 4]) -> f64 {
    let mut shares = normalizers.iter().zip(terms).map(|(normalizer, term)| {
        let scale = f64::from(normalizer.mantissa) * libm::exp2(-f64::from(normalizer.bits));
        (term - f64::from(normalizer.offset)) * scale
    });
    let mut next = || shares.next().unwrap_or(0.0);
    let gained = next() + next() + next();
    gained - next()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::local::{Counts, Totals, Winner};

    /// Terms 0, 1, 2 and 5 of velocity, and 3, 3, 3 and 1 of the distance to the key node, by hand.
    fn densest() -> Evaluation {
        Evaluation {
            counts: Counts { admissible: 4, collision: 9, ..Counts::default() },
            totals: Totals { sums: [0, 0, 8, 10], min: [0, 0, 0, 1], max: [0, 0, 5, 3] },
            winner: Some(Winner { index: 3, score: 0, terms: terms(5, 1) }),
            samples: None,
        }
    }

    fn terms(velocity: u32, path: u32) -> Terms {
        Terms { velocity, path, ..Terms::default() }
    }

    fn baseline(min_max: u32) -> RegretBaseline {
        let header = Header { weights: [0, 0, 3 << 28, 1 << 28], min_max, ..Header::default() };
        RegretBaseline::new(&header, &densest()).expect("it has a winner")
    }

    #[track_caller]
    fn assert_near(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-7, "{found}, not {expected}");
    }

    #[test]
    fn regret_of_the_best_is_zero_and_of_the_mean_one() {
        for min_max in [0, 1] {
            assert_near(baseline(min_max).regret(&terms(5, 1)), 0.0);
        }
        // The best score is 3/4 of 5/8 minus 1/4 of 1/10; the score of the means, 1/4 each, is 1/2 / 4.
        let best = 0.75 * 5.0 / 8.0 - 0.25 / 10.0;
        let gain = best - 0.5 / 4.0;
        let of_two = 0.75 * 2.0 / 8.0 - 0.25 * 3.0 / 10.0;
        assert_near(baseline(0).regret(&terms(2, 3)), (best - of_two) / gain);
        // 3/4 of 5/5 less a quarter of 0; the means are 2 of 5 and 1.5 above 1, of 2.
        let gain = 0.75 - (0.75 * 2.0 / 5.0 - 0.25 * 1.5 / 2.0);
        let of_two = 0.75 * 2.0 / 5.0 - 0.25;
        assert_near(baseline(1).regret(&terms(2, 3)), (0.75 - of_two) / gain);
    }

    #[test]
    fn regret_of_a_sample_below_the_mean_exceeds_one() {
        assert!(baseline(0).regret(&terms(0, 3)) > 1.0);
    }

    #[test]
    fn regret_of_a_better_sample_is_zero() {
        // Terms below the least and above the greatest of the densest sampling: the arithmetic must not overflow.
        for min_max in [0, 1] {
            assert_near(baseline(min_max).regret(&terms(6, 0)), 0.0);
            assert_near(baseline(min_max).regret(&terms((1 << 24) - 1, 0)), 0.0);
        }
    }

    #[test]
    fn regret_is_zero_where_all_samples_are_equal() {
        let mut same = densest();
        (same.totals.sums, same.counts.admissible) = ([0, 0, 5, 1], 1);
        let header = Header { weights: [0, 0, 3 << 28, 1 << 28], ..Header::default() };
        let baseline = RegretBaseline::new(&header, &same).expect("it has a winner");
        assert_near(baseline.regret(&terms(1, 9)), 0.0);
    }

    #[test]
    fn baseline_is_none_without_an_admissible_sample() {
        assert!(RegretBaseline::new(&Header::default(), &Evaluation::default()).is_none());
    }
}
