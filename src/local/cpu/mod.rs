//! The CPU engine: threads evaluate rows of samples, one row per turn rate, with the best instruction set of the
//! processor.

pub mod arithmetic;
mod clearance_bounds;
mod disc_lookup;
mod displacement_bounds;
mod displacement_table;
mod instruction_set;
pub mod lanes;
mod min_pyramid;
mod moving_obstacles;
mod ordered_steps;
mod reachable_region;
mod register_tiles;
mod row;
mod row_argmax;
mod row_shard;
mod sample_stats;
pub mod scalar;
mod soa_inputs;
mod step_pruning;
mod thread_pool;

#[cfg(test)]
mod tests;

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use instruction_set::Kernel;
use min_pyramid::{BuildMinPyramid, MinPyramid};
use row_argmax::TermScale;
use row_shard::{ArgmaxInputs, RowShard};
use sample_stats::SampleStats;
use soa_inputs::SoaInputs;
use thread_pool::ThreadPool;

pub use instruction_set::InstructionSet;

use super::engine::{Detail, Engine, Evaluation, SampleRecord, Winner};
use super::select::{Candidate, NO_CANDIDATE, better};
use super::{EngineError, QuantizedProblem, score};

/// Shards per thread when there are several threads: enough that a late thread leaves little work to the others.
const SHARDS_PER_THREAD: usize = 4;

/// Number of samples from which the selection uses all threads. Below it one thread is faster.
const PARALLEL_ARGMAX_SAMPLES: usize = 1 << 15;

/// Evaluates on the cores of this machine.
pub struct CpuEngine {
    instructions: InstructionSet,
    kernel: Kernel,
    /// `None` when the caller's thread does all work.
    pool: Option<ThreadPool>,
    threads: usize,
    inputs: SoaInputs,
    pyramid: MinPyramid,
    shards: Vec<Mutex<RowShard>>,
}

impl CpuEngine {
    /// An engine that works in the caller's thread.
    #[must_use]
    pub fn single_threaded() -> Self {
        let instructions = InstructionSet::best();
        Self::new(instructions, Kernel::of(instructions).unwrap_or(Kernel::Portable), None, 1)
    }

    /// An engine that works in the caller's thread and `threads - 1` others; with 0 or 1 in the caller's alone.
    ///
    /// # Errors
    /// When the system refuses a thread.
    pub fn with_threads(threads: usize) -> Result<Self, EngineError> {
        Self::with_instruction_set(InstructionSet::best(), threads)
    }

    /// An engine with a given instruction set, for comparisons.
    ///
    /// # Errors
    /// When the processor lacks the instructions, or the system refuses a thread.
    pub fn with_instruction_set(
        instructions: InstructionSet,
        threads: usize,
    ) -> Result<Self, EngineError> {
        let kernel = Kernel::of(instructions)
            .ok_or(EngineError::UnsupportedInstructionSet { name: instructions.as_str() })?;
        let pool = if threads > 1 { Some(ThreadPool::new(threads - 1)?) } else { None };
        Ok(Self::new(instructions, kernel, pool, threads.max(1)))
    }

    fn new(
        instructions: InstructionSet,
        kernel: Kernel,
        pool: Option<ThreadPool>,
        threads: usize,
    ) -> Self {
        let shards = if threads > 1 { threads * SHARDS_PER_THREAD } else { 1 };
        Self {
            instructions,
            kernel,
            pool,
            threads,
            inputs: SoaInputs::default(),
            pyramid: MinPyramid::default(),
            shards: (0..shards).map(|_| Mutex::default()).collect(),
        }
    }

    /// The instruction set that it uses.
    #[must_use]
    pub const fn instructions(&self) -> InstructionSet {
        self.instructions
    }

    /// Evaluates every shard.
    fn evaluate_rows(&mut self, problem: &QuantizedProblem) {
        let (kernel, shards) = (self.kernel, &self.shards);
        let (inputs, pyramid) = (&self.inputs, &self.pyramid);
        let rows = problem.profiles.len();
        let share = |number: usize| rows * number / shards.len();
        for_each_shard(self.pool.as_mut(), shards, |number, shard| {
            let rows = share(number)..share(number + 1);
            shard.evaluate(kernel, problem, inputs, pyramid, rows);
        });
    }

    /// Statistics of all samples, and the best sample.
    fn select(&mut self, problem: &QuantizedProblem) -> (SampleStats, Candidate) {
        let mut stats = SampleStats::default();
        for shard in &mut self.shards {
            stats.merge(&unlocked(shard).total);
        }
        let normalizers = score::normalizers(&problem.header, &stats.totals);
        let argmax = ArgmaxInputs {
            kernel: self.kernel,
            problem,
            inputs: &self.inputs,
            scales: normalizers.map(|normalizer| TermScale::new(&normalizer)),
        };
        // The row with the largest bound comes first: few other rows can beat its best sample.
        let mut first = (NO_CANDIDATE, 0);
        for (number, shard) in self.shards.iter_mut().enumerate() {
            let bound = unlocked(shard).compute_bounds(&argmax);
            if better(first.0, bound) == bound {
                first = (bound, number);
            }
        }
        let (bound, number) = first;
        if bound == NO_CANDIDATE {
            return (stats, NO_CANDIDATE);
        }
        let row = bound.1 as usize / problem.vx_samples.len();
        let candidate = unlocked(&mut self.shards[number]).best_of_row(&argmax, row, NO_CANDIDATE);
        let shards = &self.shards;
        let pool = self.pool.as_mut().filter(|_| problem.len() >= PARALLEL_ARGMAX_SAMPLES);
        for_each_shard(pool, shards, |_, shard| {
            shard.select_best(&argmax, candidate);
        });
        let best = self.shards.iter_mut().map(|shard| unlocked(shard).best);
        (stats, best.fold(NO_CANDIDATE, better))
    }

    /// The winner; `None` when no sample is admissible.
    fn winner(&mut self, problem: &QuantizedProblem, (score, index): Candidate) -> Option<Winner> {
        let vx_count = problem.vx_samples.len();
        let (row, column) = (index as usize / vx_count, index as usize % vx_count);
        let inputs = &self.inputs;
        let mut shards = self.shards.iter_mut().map(unlocked);
        let shard = shards.find(|shard| shard.rows.contains(&row))?;
        Some(Winner { index, score, terms: shard.sample(problem, inputs, row, column).terms })
    }

    /// All samples in order of index: shards and their rows are in that order.
    fn samples(&mut self, problem: &QuantizedProblem) -> Vec<SampleRecord> {
        let inputs = &self.inputs;
        let mut samples = Vec::with_capacity(problem.len());
        for shard in &mut self.shards {
            let shard = unlocked(shard);
            for row in shard.rows.clone() {
                let row = (0..problem.vx_samples.len())
                    .map(|index| shard.sample(problem, inputs, row, index));
                samples.extend(row);
            }
        }
        samples
    }
}

/// Calls `each` with every shard; each idle thread takes the next one.
fn for_each_shard(
    pool: Option<&mut ThreadPool>,
    shards: &[Mutex<RowShard>],
    each: impl Fn(usize, &mut RowShard) + Sync,
) {
    let next = AtomicUsize::new(0);
    let work = || {
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            let Some(shard) = shards.get(number) else {
                break;
            };
            each(number, &mut shard.lock().unwrap_or_else(PoisonError::into_inner));
        }
    };
    match pool {
        None => work(),
        Some(pool) => pool.run(&work),
    }
}

fn unlocked(shard: &mut Mutex<RowShard>) -> &mut RowShard {
    shard.get_mut().unwrap_or_else(PoisonError::into_inner)
}

impl Engine for CpuEngine {
    fn name(&self) -> String {
        let plural = if self.threads == 1 { "" } else { "s" };
        let instructions = self.instructions.as_str();
        format!("CPU, {} thread{plural}, {instructions}", self.threads)
    }

    fn threads(&self) -> usize {
        self.threads
    }

    fn evaluate(
        &mut self,
        problem: &QuantizedProblem,
        detail: Detail,
    ) -> Result<Evaluation, EngineError> {
        self.inputs.fill(problem);
        self.pyramid.clear();
        let is_scalar = matches!(self.kernel, Kernel::Scalar);
        if !is_scalar && self.inputs.order_free && self.inputs.allows_pruning {
            self.kernel.run(BuildMinPyramid { pyramid: &mut self.pyramid, problem });
        }
        self.evaluate_rows(problem);
        let (stats, best) = self.select(problem);
        let winner = self.winner(problem, best);
        let samples = (detail == Detail::Samples).then(|| self.samples(problem));
        Ok(Evaluation { counts: stats.counts, totals: stats.totals, winner, samples })
    }
}
