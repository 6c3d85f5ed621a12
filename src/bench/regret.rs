//! What a command chosen from few samples is worth beside the one chosen from the densest sampling.

use crate::local::internals::Header;
use crate::local::internals::score::{Normalizer, normalizers};
use crate::local::{Evaluation, Terms};

/// What the densest sampling makes of a command.
///
/// A score by itself says little: where terms are divided by their sums it shrinks as samples are added. So commands
/// are all judged with the normalisers of the densest sampling, and a loss is told as a share of what choosing gains
/// there over picking any admissible sample blindly.
#[derive(Clone, Copy, Debug)]
pub struct Yardstick {
    normalizers: [Normalizer; 4],
    best: f64,
    mean: f64,
}

impl Yardstick {
    /// The yardstick of a problem with the densest sampling; none where no sample of it is admissible.
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

    /// What is lost with a sample of these terms: 0 for one as good as the best of the densest sampling, 1 for one no
    /// better than the mean of its admissible samples, above 1 for a worse one. A sample between those of the densest
    /// sampling may be better than all of them; nothing is lost then.
    #[must_use]
    pub fn regret(&self, terms: &Terms) -> f64 {
        let gain = self.best - self.mean;
        let lost = self.best - score(&self.normalizers, terms.to_array().map(f64::from));
        if lost > 0.0 && gain > 0.0 {
            lost / gain
        } else {
            0.0
        }
    }
}

/// The score of eq. 35, as the engines have it but in floating point: another sampling's terms may lie below the least
/// or far above the sums that these normalisers are made for.
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

    /// Terms 0, 1, 2 and 5 of velocity, and 3, 3, 3 and 1 of the way to the key node, by hand.
    fn densest() -> Evaluation {
        Evaluation {
            counts: Counts {
                admissible: 4,
                collision: 9,
                ..Counts::default()
            },
            totals: Totals {
                sums: [0, 0, 8, 10],
                min: [0, 0, 0, 1],
                max: [0, 0, 5, 3],
            },
            winner: Some(Winner {
                index: 3,
                score: 0,
                terms: terms(5, 1),
            }),
            samples: None,
        }
    }

    fn terms(velocity: u32, path: u32) -> Terms {
        Terms {
            velocity,
            path,
            ..Terms::default()
        }
    }

    fn yardstick(min_max: u32) -> Yardstick {
        let header = Header {
            weights: [0, 0, 3 << 28, 1 << 28],
            min_max,
            ..Header::default()
        };
        Yardstick::new(&header, &densest()).expect("it has a winner")
    }

    #[track_caller]
    fn assert_near(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-7, "{found}, not {expected}");
    }

    #[test]
    fn the_best_loses_nothing_and_the_mean_all() {
        for min_max in [0, 1] {
            assert_near(yardstick(min_max).regret(&terms(5, 1)), 0.0);
        }
        // Three quarters of 5/8 less a quarter of 1/10 is the best; of the means, 1/4 each, 1/2 / 4.
        let best = 0.75 * 5.0 / 8.0 - 0.25 / 10.0;
        let gain = best - 0.5 / 4.0;
        let of_two = 0.75 * 2.0 / 8.0 - 0.25 * 3.0 / 10.0;
        assert_near(yardstick(0).regret(&terms(2, 3)), (best - of_two) / gain);
        // 3/4 of 5/5 less a quarter of 0; the means are 2 of 5 and 1.5 above 1, of 2.
        let gain = 0.75 - (0.75 * 2.0 / 5.0 - 0.25 * 1.5 / 2.0);
        let of_two = 0.75 * 2.0 / 5.0 - 0.25;
        assert_near(yardstick(1).regret(&terms(2, 3)), (0.75 - of_two) / gain);
    }

    #[test]
    fn a_worse_one_than_the_mean_loses_more_than_all() {
        assert!(yardstick(0).regret(&terms(0, 3)) > 1.0);
    }

    #[test]
    fn one_that_the_densest_sampling_misses_may_be_better() {
        // Below the least of the densest sampling, above its greatest: no arithmetic may overflow either.
        for min_max in [0, 1] {
            assert_near(yardstick(min_max).regret(&terms(6, 0)), 0.0);
            assert_near(yardstick(min_max).regret(&terms((1 << 24) - 1, 0)), 0.0);
        }
    }

    #[test]
    fn where_all_are_equal_nothing_is_lost() {
        let mut same = densest();
        (same.totals.sums, same.counts.admissible) = ([0, 0, 5, 1], 1);
        let header = Header {
            weights: [0, 0, 3 << 28, 1 << 28],
            ..Header::default()
        };
        let yardstick = Yardstick::new(&header, &same).expect("it has a winner");
        assert_near(yardstick.regret(&terms(1, 9)), 0.0);
    }

    #[test]
    fn without_an_admissible_sample_there_is_no_yardstick() {
        assert!(Yardstick::new(&Header::default(), &Evaluation::default()).is_none());
    }
}
