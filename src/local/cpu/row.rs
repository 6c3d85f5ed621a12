//! Evaluates all samples of one turn profile. Lanes are samples here; the arithmetic equals that of `score.rs`, to the
//! bit.

use super::arithmetic::{atan2_turn, shift_round, turn_size};
use super::displacement_table::{DisplacementTable, lane_indices, stays_on_field};
use super::lanes::{Lanes, MAX_LANES};
use super::ordered_steps::{self, LaneOutcome};
use super::sample_stats::LaneStats;
use super::soa_inputs::SoaInputs;
use super::step_pruning::StepPruning;
use crate::local::kernel_inputs::TurnProfile;
use crate::local::rollout::end_heading;
use crate::local::{QuantizedProblem, SampleStatus};
use crate::numeric::HALF_TURN;

/// Words per sample in the result columns of a row: heading term and status, clearance, path term.
pub const COLUMNS: usize = 3;

/// Position of the status in the first word of a sample, above the heading term.
pub const STATUS_SHIFT: u32 = 24;

/// Final positions of a row's samples.
#[derive(Debug, Default)]
pub struct EndPositions {
    x: Vec<i32>,
    y: Vec<i32>,
}

/// Evaluates every sample of a turn profile with its table and adds it to the statistics. Returns the best value of each
/// term, or `None` when no sample is admissible. `samples` has [`COLUMNS`] columns of `inputs.stride` words.
#[inline(always)]
pub fn evaluate_row<L: Lanes>(
    token: L::FeatureToken,
    problem: &QuantizedProblem,
    inputs: &SoaInputs,
    profile: &TurnProfile,
    (number, table): (usize, &DisplacementTable),
    pruning: &StepPruning,
    (ends, samples, stats): (&mut EndPositions, &mut [i32], &mut LaneStats<L>),
) -> Option<[i32; 4]> {
    ends.x.resize(inputs.stride, 0);
    ends.y.resize(inputs.stride, 0);
    let mut row = Row::<L> {
        token,
        problem,
        inputs,
        profile,
        heading: end_heading(&problem.header, profile),
        displaced: [table.end_x, table.end_y],
        base_end: table.base_end,
        ends,
        stats,
    };
    let vectors = (0..problem.vx_samples.len()).step_by(L::COUNT);
    if inputs.order_free && stays_on_field::<L>(token, problem, inputs, table) {
        let least = pruning.clearances(inputs, number);
        for first in vectors.clone() {
            let least = L::load(token, &least[first..]);
            row.store_status(first, LaneOutcome::of_clearance(token, least), samples);
        }
    } else {
        for first in vectors.clone() {
            let outcome = ordered_steps::evaluate::<L>(token, problem, inputs, table, first);
            row.store_status(first, outcome, samples);
        }
    }
    if row.stats.has_admissible() {
        for first in vectors.clone() {
            row.compute_ends(first);
        }
        // Each term has its own loop: its vectors are independent, and more of them execute in parallel than in one
        // loop.
        for first in vectors.clone() {
            row.compute_headings(first, samples);
        }
        for first in vectors.clone() {
            row.compute_paths(first, samples);
        }
        // In a local copy; otherwise the compiler keeps the sums in memory.
        let mut sums = *row.stats;
        for first in vectors {
            row.accumulate(first, samples, &mut sums);
        }
        *row.stats = sums;
    }
    row.stats.end_row()
}

struct Row<'a, L: Lanes> {
    token: L::FeatureToken,
    problem: &'a QuantizedProblem,
    inputs: &'a SoaInputs,
    profile: &'a TurnProfile,
    heading: u32,
    /// Sums of cosines and sines times their shares.
    displaced: [i32; 2],
    /// Final position of a sample of speed zero, fine units.
    base_end: [i32; 2],
    ends: &'a mut EndPositions,
    stats: &'a mut LaneStats<L>,
}

impl<L: Lanes> Row<'_, L> {
    /// Counts the samples of one vector. Stores their clearances and the first words: zero for an admissible sample,
    /// otherwise its status. The later steps read only the admissible ones.
    #[inline(always)]
    fn store_status(&mut self, first: usize, outcome: LaneOutcome<L>, samples: &mut [i32]) {
        let Self { token, inputs, .. } = *self;
        let zero = L::splat(token, 0);
        let stopping_need = L::load(token, &inputs.stopping_need[first..])
            .max(L::splat(token, self.profile.stopping_need as i32));
        let short = outcome.available.less(stopping_need);
        let left = self.problem.vx_samples.len() - first;
        let missing = L::splat(token, left.min(MAX_LANES) as i32 - 1).less(lane_indices(token));
        let ended = L::mask_or(outcome.collision, outcome.outside);
        let rejected = L::mask_or(L::mask_or(ended, short), missing);
        let word = L::select(rejected, status_word(token, SampleStatus::CannotStop), zero);
        let word = L::select(outcome.outside, status_word(token, SampleStatus::Outside), word);
        let word = L::select(outcome.collision, status_word(token, SampleStatus::Collision), word);
        let valid = !L::bitmask(missing) & (u32::MAX >> (32 - L::COUNT));
        let bad = L::bitmask(rejected) & valid;
        let collision = L::bitmask(outcome.collision) & valid;
        let outside = L::bitmask(outcome.outside) & valid & !collision;
        self.stats.count(valid, bad, collision, outside);
        word.store(&mut samples[first..]);
        outcome.clearance.store(&mut samples[inputs.stride + first..]);
    }

    /// Computes the final positions of one vector relative to the start, fine units.
    #[inline(always)]
    fn compute_ends(&mut self, first: usize) {
        let Self { token, inputs, .. } = *self;
        let header = &self.problem.header;
        let fine = L::load(token, &inputs.fine[first..]);
        let [to_x, to_y] = self.displaced;
        let [base_x, base_y] = self.base_end.map(|base| L::splat(token, base));
        let x = fine.mul_hi(L::splat(token, to_x));
        let y = fine.mul_hi(L::splat(token, to_y));
        shift_round(token, x, header.fine_bits).add(base_x).store(&mut self.ends.x[first..]);
        shift_round(token, y, header.fine_bits).add(base_y).store(&mut self.ends.y[first..]);
    }

    /// The final positions.
    #[inline(always)]
    fn end(&self, first: usize) -> (L, L) {
        (L::load(self.token, &self.ends.x[first..]), L::load(self.token, &self.ends.y[first..]))
    }

    /// Stores the heading terms of the admissible samples of one vector.
    #[inline(always)]
    fn compute_headings(&self, first: usize, samples: &mut [i32]) {
        let Self { token, .. } = *self;
        let header = &self.problem.header;
        let words = L::load(token, &samples[first..]);
        let zero = L::splat(token, 0);
        let ok = words.equal(zero);
        if L::bitmask(ok) == 0 {
            return;
        }
        let (x, y) = self.end(first);
        let to_x = L::splat(token, header.target_x).sub(x);
        let to_y = L::splat(token, header.target_y).sub(y);
        let there = L::mask_and(to_x.equal(zero), to_y.equal(zero));
        let direction = atan2_turn(token, to_y, to_x);
        let off = turn_size(direction.sub(L::splat(token, self.heading as i32)));
        let heading = L::splat(token, HALF_TURN as i32).sub(off).shr(8);
        let best = L::splat(token, (HALF_TURN >> 8) as i32);
        let heading = L::select(there, best, heading);
        L::select(ok, heading, words).store(&mut samples[first..]);
    }

    /// Stores the path terms of one vector if a sample is admissible.
    #[inline(always)]
    fn compute_paths(&self, first: usize, samples: &mut [i32]) {
        let Self { token, inputs, .. } = *self;
        let header = &self.problem.header;
        let ok = admissible(token, L::load(token, &samples[first..]));
        if L::bitmask(ok) == 0 {
            return;
        }
        let (x, y) = self.end(first);
        let path = L::splat(token, header.key_x).sub(x).hypot(L::splat(token, header.key_y).sub(y));
        path.store(&mut samples[2 * inputs.stride + first..]);
    }

    /// Adds the terms of the admissible samples of one vector to the sums.
    #[inline(always)]
    fn accumulate(&self, first: usize, samples: &[i32], sums: &mut LaneStats<L>) {
        let Self { token, inputs, .. } = *self;
        let heading = L::load(token, &samples[first..]);
        let clearance = L::load(token, &samples[inputs.stride + first..]);
        let velocity = L::load(token, &inputs.velocity_term[first..]);
        let path = L::load(token, &samples[2 * inputs.stride + first..]);
        let ok = admissible(token, heading);
        sums.accumulate(ok, [heading, clearance, velocity, path]);
    }
}

/// The admissible samples, by their first words.
#[inline(always)]
fn admissible<L: Lanes>(token: L::FeatureToken, words: L) -> L::Mask {
    words.less_unsigned(L::splat(token, 1 << STATUS_SHIFT))
}

/// The first word of a sample that is not admissible.
#[inline(always)]
fn status_word<L: Lanes>(token: L::FeatureToken, status: SampleStatus) -> L {
    L::splat(token, (status as i32) << STATUS_SHIFT)
}
