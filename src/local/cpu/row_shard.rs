//! A shard of the rows and the results of its samples.

use core::ops::Range;

use super::displacement_table::DisplacementTable;
use super::instruction_set::Kernel;
use super::lanes::{LaneTask, Lanes};
use super::min_pyramid::MinPyramid;
use super::row::{COLUMNS, EndPositions, STATUS_SHIFT, evaluate_row};
use super::row_argmax::{RowArgmax, TermScale, score};
use super::sample_stats::{LaneStats, SampleStats};
use super::scalar;
use super::soa_inputs::{MAX_ROWS, SoaInputs};
use super::step_pruning::{SampleTile, StepPruning};
use crate::local::engine::{SampleRecord, SampleStatus, Terms};
use crate::local::select::{Candidate, NO_CANDIDATE, better};
use crate::local::{QuantizedProblem, Totals};

/// Working memory of the lanes.
#[derive(Debug, Default)]
pub struct Scratch {
    /// Tables of a tile's rows.
    tables: [DisplacementTable; MAX_ROWS],
    pub pruning: StepPruning,
    ends: EndPositions,
}

/// Inputs of the selection.
pub struct ArgmaxInputs<'a> {
    pub kernel: Kernel,
    pub problem: &'a QuantizedProblem,
    pub inputs: &'a SoaInputs,
    pub scales: [TermScale; 4],
}

/// A shard of the rows. The next decision reuses its memory.
#[derive(Debug, Default)]
pub struct RowShard {
    pub rows: Range<usize>,
    /// The result columns of each row.
    samples: Vec<i32>,
    /// The best value of each term for each row that has an admissible sample.
    best_terms: Vec<Option<[i32; 4]>>,
    /// Statistics of all rows.
    pub total: SampleStats,
    /// Bounds of the rows that have admissible samples.
    bounds: Vec<Candidate>,
    /// The result of `select_best`.
    pub best: Candidate,
    /// Working memory of the scalar kernel.
    table: Vec<i32>,
    /// Working memory of the other kernels.
    pub scratch: Scratch,
}

impl RowShard {
    /// Evaluates the samples of these rows.
    pub fn evaluate(
        &mut self,
        kernel: Kernel,
        problem: &QuantizedProblem,
        inputs: &SoaInputs,
        pyramid: &MinPyramid,
        rows: Range<usize>,
    ) {
        let words = COLUMNS * inputs.stride;
        self.samples.resize(words * rows.len(), 0);
        self.best_terms.clear();
        self.total = SampleStats::default();
        self.rows = rows;
        if matches!(kernel, Kernel::Scalar) {
            self.evaluate_scalar(problem, inputs);
        } else {
            kernel.run(EvaluateRows { shard: self, problem, inputs, pyramid });
        }
    }

    fn evaluate_scalar(&mut self, problem: &QuantizedProblem, inputs: &SoaInputs) {
        let rows = self.samples.chunks_exact_mut(COLUMNS * inputs.stride);
        for (row, samples) in self.rows.clone().zip(rows) {
            let stats = scalar::evaluate_row(problem, inputs, row, &mut self.table, samples);
            let has_admissible = stats.counts.admissible > 0;
            self.best_terms.push(has_admissible.then(|| best_terms(&stats.totals)));
            self.total.merge(&stats);
        }
    }

    /// Computes an upper bound of the scores of each row that has an admissible sample, with the index of the row's
    /// first sample. Returns the best bound.
    ///
    /// A sample with the best value of each term in its row scores at least as much as every sample of the row.
    pub fn compute_bounds(&mut self, argmax: &ArgmaxInputs<'_>) -> Candidate {
        let vx_count = argmax.problem.vx_samples.len();
        let mut best = NO_CANDIDATE;
        self.bounds.clear();
        // Reserves for all rows, because the number of rows with an admissible sample changes from one decision to the
        // next.
        self.bounds.reserve(self.rows.len());
        for (row, terms) in self.rows.clone().zip(&self.best_terms) {
            if let Some(terms) = *terms {
                let max_score = score(&argmax.scales, terms);
                let bound = (max_score, (row * vx_count) as u32);
                self.bounds.push(bound);
                best = better(best, bound);
            }
        }
        best
    }

    /// Searches the rows whose bound beats the candidate for a better sample.
    pub fn select_best(&mut self, argmax: &ArgmaxInputs<'_>, candidate: Candidate) {
        let vx_count = argmax.problem.vx_samples.len();
        self.best = candidate;
        for &bound in &self.bounds {
            if better(self.best, bound) == bound {
                self.best = self.best_of_row(argmax, bound.1 as usize / vx_count, self.best);
            }
        }
    }

    /// The better of a candidate and the best sample of one row.
    pub fn best_of_row(
        &self,
        argmax: &ArgmaxInputs<'_>,
        row: usize,
        candidate: Candidate,
    ) -> Candidate {
        let vx_count = argmax.problem.vx_samples.len();
        let best = argmax.kernel.run(RowArgmax {
            inputs: argmax.inputs,
            row: self.row(argmax.inputs, row),
            samples: vx_count,
            scales: &argmax.scales,
            min_score: candidate.0,
        });
        best.map_or(candidate, |(score, index)| {
            better(candidate, (score, (row * vx_count + index) as u32))
        })
    }

    fn row(&self, inputs: &SoaInputs, row: usize) -> &[i32] {
        let words = COLUMNS * inputs.stride;
        &self.samples[(row - self.rows.start) * words..][..words]
    }

    /// A sample of one of its rows.
    pub fn sample(
        &self,
        problem: &QuantizedProblem,
        inputs: &SoaInputs,
        row: usize,
        index: usize,
    ) -> SampleRecord {
        let row = self.row(inputs, row);
        let word = row[index] as u32;
        let status = SampleStatus::from_u32(word >> STATUS_SHIFT);
        if status != SampleStatus::Ok {
            return SampleRecord { status, terms: Terms::default() };
        }
        let terms = Terms {
            heading: word,
            clearance: row[inputs.stride + index] as u32,
            velocity: problem.vx_samples[index].velocity_term,
            path: row[2 * inputs.stride + index] as u32,
        };
        SampleRecord { status, terms }
    }
}

/// Evaluates a shard in lanes.
struct EvaluateRows<'a> {
    shard: &'a mut RowShard,
    problem: &'a QuantizedProblem,
    inputs: &'a SoaInputs,
    pyramid: &'a MinPyramid,
}

impl LaneTask for EvaluateRows<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, token: L::FeatureToken) {
        let Self { shard, problem, inputs, pyramid } = self;
        let profiles = &problem.profiles[shard.rows.clone()];
        let words = COLUMNS * inputs.stride;
        let Scratch { tables, pruning, ends } = &mut shard.scratch;
        let tiles = shard.samples.chunks_mut(inputs.tile_rows * words);
        // Sized for the largest tile: the next decision may have more rows per tile.
        for table in tables.iter_mut().take(profiles.len()) {
            table.resize::<L>(inputs, problem.discs.len());
        }
        for table in tables.iter_mut().take(inputs.tile_rows.min(profiles.len())) {
            table.fill_discs::<L>(token, problem, inputs, true);
        }
        let mut first_row = shard.rows.start;
        for (profiles, rows) in profiles.chunks(inputs.tile_rows).zip(tiles) {
            let tables = &mut tables[..profiles.len()];
            for (table, row) in tables.iter_mut().zip(first_row..) {
                table.fill::<L>(token, problem, inputs, row);
            }
            first_row += profiles.len();
            if inputs.order_free {
                let tile = SampleTile { problem, inputs, profiles, tables };
                pruning.prune::<L>(token, &tile, pyramid);
            }
            let mut stats = LaneStats::<L>::new(token);
            let rows = rows.chunks_exact_mut(words).enumerate();
            for ((profile, table), (number, row)) in profiles.iter().zip(&*tables).zip(rows) {
                let table = (number, table);
                let outputs = (&mut *ends, row, &mut stats);
                let best =
                    evaluate_row::<L>(token, problem, inputs, profile, table, pruning, outputs);
                shard.best_terms.push(best);
            }
            shard.total.merge(&stats.finish());
        }
    }
}

/// The best value of each term.
const fn best_terms(totals: &Totals) -> [i32; 4] {
    let [heading, clearance, velocity, _] = totals.max;
    [heading as i32, clearance as i32, velocity as i32, totals.min[3] as i32]
}
