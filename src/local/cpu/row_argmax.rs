//! Finds the best sample of a row in loops that compile to vector instructions.

use super::lanes::{LaneTask, Lanes};
use super::row::STATUS_SHIFT;
use super::soa_inputs::SoaInputs;
use crate::local::score::Normalizer;

/// A normaliser without branches: `(term - offset) * mantissa`, shifted right, then left.
#[derive(Clone, Copy, Debug)]
pub struct TermScale {
    offset: u32,
    mantissa: u32,
    right: u32,
    left: u32,
}

impl TermScale {
    /// Equals [`crate::local::score::share`] with this normaliser.
    pub const fn new(normalizer: &Normalizer) -> Self {
        let bits = normalizer.bits;
        Self {
            offset: normalizer.offset,
            mantissa: if bits >= 64 { 0 } else { normalizer.mantissa },
            right: if bits > 0 && bits < 64 { bits as u32 } else { 0 },
            left: if bits < 0 { -bits as u32 } else { 0 },
        }
    }

    #[inline(always)]
    fn of(&self, term: i32) -> i64 {
        let product = u64::from((term as u32).wrapping_sub(self.offset)) * u64::from(self.mantissa);
        ((product >> self.right) << self.left) as i64
    }
}

/// The score of these terms, equal to [`crate::local::score::score`].
#[inline(always)]
pub fn score(scales: &[TermScale; 4], [heading, clearance, velocity, path]: [i32; 4]) -> i64 {
    scales[0]
        .of(heading)
        .wrapping_add(scales[1].of(clearance))
        .wrapping_add(scales[2].of(velocity))
        .wrapping_sub(scales[3].of(path))
}

/// Finds the best of a row's admissible samples: its score and position; of equal scores the first.
pub struct RowArgmax<'a> {
    /// Holds the velocity terms.
    pub inputs: &'a SoaInputs,
    /// The result columns of the row.
    pub row: &'a [i32],
    /// Number of samples.
    pub samples: usize,
    /// The scales of the terms.
    pub scales: &'a [TermScale; 4],
    /// Samples with a lower score are ignored.
    pub min_score: i64,
}

impl LaneTask for RowArgmax<'_> {
    type Output = Option<(i64, usize)>;

    #[inline(always)]
    fn run<L: Lanes>(self, _: L::FeatureToken) -> Self::Output {
        let Self { inputs, row, samples, scales, min_score } = self;
        let columns = Columns {
            heading: &row[..samples],
            clearance: &row[inputs.stride..][..samples],
            velocity: &inputs.velocity_term[..samples],
            path: &row[2 * inputs.stride..][..samples],
        };
        let mut largest = i64::MIN;
        for index in 0..samples {
            largest = largest.max(columns.score(index, scales));
        }
        if largest < min_score || largest == i64::MIN {
            return None;
        }
        let is_largest = |index: &usize| columns.score(*index, scales) == largest;
        (0..samples).find(is_largest).map(|index| (largest, index))
    }
}

/// The terms of a row's samples; all columns have the same length.
struct Columns<'a> {
    heading: &'a [i32],
    clearance: &'a [i32],
    velocity: &'a [i32],
    path: &'a [i32],
}

impl Columns<'_> {
    /// The score of a sample; `i64::MIN` unless admissible.
    #[inline(always)]
    fn score(&self, index: usize, scales: &[TermScale; 4]) -> i64 {
        let (heading, clearance) = (self.heading[index], self.clearance[index]);
        let (velocity, path) = (self.velocity[index], self.path[index]);
        let score = score(scales, [heading, clearance, velocity, path]);
        let admissible = (heading as u32) >> STATUS_SHIFT == 0;
        if admissible { score } else { i64::MIN }
    }
}
