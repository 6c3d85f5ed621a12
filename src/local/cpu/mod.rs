//! The CPU engine: threads evaluate rows of samples, one row per turn rate, with the best instruction set of the
//! processor. Of a batch, each thread evaluates whole problems.

pub mod arithmetic;
mod clearance_bounds;
mod disc_lookup;
mod displacement_bounds;
mod displacement_table;
mod evaluator;
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

use std::sync::{Mutex, PoisonError};

use evaluator::Evaluator;
use instruction_set::Kernel;
use thread_pool::{Counter, ThreadPool};

pub use instruction_set::InstructionSet;

use super::engine::{Detail, Engine, Evaluation};
use super::{EngineError, QuantizedProblem};

/// Work of a thread for which it pays to start it, in the units of [`work`]: about 15 us with AVX-512. Measured with 1 to 16
/// threads: with more of them a decision of 256 to 4,096 arcs takes longer.
const WORK_PER_THREAD: u64 = 1 << 15;

/// Work of a turn profile's step in its table, in that of a sample's step.
const TABLE_WORK: u64 = 32;

/// Evaluates on the cores of this machine.
pub struct CpuEngine {
    instructions: InstructionSet,
    /// `None` when the caller's thread does all work.
    pool: Option<ThreadPool>,
    threads: usize,
    work_per_thread: u64,
    /// Evaluates with all threads.
    together: Evaluator,
    /// Of each thread, for batches.
    alone: Vec<Mutex<Evaluator>>,
}

crate::settings::opaque_debug!(CpuEngine);

impl CpuEngine {
    /// An engine that works in the caller's thread.
    #[must_use]
    pub fn single_threaded() -> Self {
        let instructions = InstructionSet::best();
        Self::new(instructions, Kernel::of(instructions).unwrap_or(Kernel::Portable), None, 1)
    }

    /// Most threads.
    pub const MAX_THREADS: usize = 1024;

    /// An engine that works in the caller's thread and up to `threads - 1` others, fewer for small problems; with 0 or 1 in the
    /// caller's alone.
    ///
    /// # Errors
    /// When there are more than [`Self::MAX_THREADS`], or the system refuses one.
    pub fn with_threads(threads: usize) -> Result<Self, EngineError> {
        Self::with_instruction_set(InstructionSet::best(), threads)
    }

    /// An engine with a given instruction set, for comparisons.
    ///
    /// # Errors
    /// When the processor lacks the instructions, there are more than [`Self::MAX_THREADS`], or the system refuses one.
    pub fn with_instruction_set(
        instructions: InstructionSet,
        threads: usize,
    ) -> Result<Self, EngineError> {
        if threads > Self::MAX_THREADS {
            return Err(EngineError::TooManyThreads { threads, most: Self::MAX_THREADS });
        }
        let kernel = Kernel::of(instructions)
            .ok_or(EngineError::UnsupportedInstructionSet { name: instructions.name() })?;
        let pool = if threads > 1 { Some(ThreadPool::new(threads - 1)?) } else { None };
        Ok(Self::new(instructions, kernel, pool, threads.max(1)))
    }

    fn new(
        instructions: InstructionSet,
        kernel: Kernel,
        pool: Option<ThreadPool>,
        threads: usize,
    ) -> Self {
        let lone = if threads > 1 { threads } else { 0 };
        Self {
            instructions,
            pool,
            threads,
            work_per_thread: WORK_PER_THREAD,
            together: Evaluator::new(kernel, threads),
            alone: (0..lone).map(|_| Mutex::new(Evaluator::new(kernel, 1))).collect(),
        }
    }

    /// The instruction set that it uses.
    #[must_use]
    pub const fn instructions(&self) -> InstructionSet {
        self.instructions
    }

    /// Uses all threads for every problem, however small, so that a test of threads needs no large problems.
    #[doc(hidden)]
    pub const fn use_all_threads(&mut self) {
        self.work_per_thread = 1;
    }

    /// Threads that evaluate a problem together.
    fn threads_for(&self, problem: &QuantizedProblem) -> usize {
        let most = work(problem) / self.work_per_thread;
        usize::try_from(most).map_or(self.threads, |most| most.clamp(1, self.threads))
    }

    /// Whether a batch is evaluated sooner with a problem per thread than with all threads for one problem after the other.
    fn divides(&self, problems: &[QuantizedProblem]) -> bool {
        let total: u64 = problems.iter().map(work).sum();
        let one_by_one =
            problems.iter().map(|problem| work(problem) / self.threads_for(problem) as u64);
        let largest = problems.iter().map(work).max().unwrap_or_default();
        // The last problem may begin when all other threads are done.
        let divided = largest.max(total.div_ceil(self.threads as u64));
        problems.len() > 1 && divided <= one_by_one.sum()
    }

    /// Each thread evaluates the next problem until none is left.
    fn evaluate_divided(
        pool: &mut ThreadPool,
        evaluators: &[Mutex<Evaluator>],
        problems: &[QuantizedProblem],
        detail: Detail,
    ) -> Vec<Evaluation> {
        let answers: Vec<Mutex<Evaluation>> = problems.iter().map(|_| Mutex::default()).collect();
        let (workers, next) = (Counter::default(), Counter::default());
        let most = evaluators.len().min(problems.len());
        pool.run(most - 1, &|| {
            let Some(evaluator) = evaluators.get(workers.take()) else { return };
            let mut evaluator = evaluator.lock().unwrap_or_else(PoisonError::into_inner);
            while let Some((problem, answer)) = {
                let number = next.take();
                problems.get(number).zip(answers.get(number))
            } {
                let evaluation = evaluator.evaluate(None, 1, problem, detail);
                *answer.lock().unwrap_or_else(PoisonError::into_inner) = evaluation;
            }
        });
        let answers = answers.into_iter();
        answers.map(|answer| answer.into_inner().unwrap_or_else(PoisonError::into_inner)).collect()
    }
}

/// Work of a problem: steps of samples, and of the tables.
fn work(problem: &QuantizedProblem) -> u64 {
    let tables = TABLE_WORK * problem.profiles.len() as u64;
    u64::from(problem.header.steps) * (problem.len() as u64 + tables)
}

impl Engine for CpuEngine {
    fn name(&self) -> String {
        let plural = if self.threads == 1 { "" } else { "s" };
        let instructions = self.instructions.name();
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
        let threads = self.threads_for(problem);
        Ok(self.together.evaluate(self.pool.as_mut(), threads, problem, detail))
    }

    fn evaluate_batch(
        &mut self,
        problems: &[QuantizedProblem],
        detail: Detail,
    ) -> Result<Vec<Evaluation>, EngineError> {
        let divides = self.divides(problems);
        match &mut self.pool {
            Some(pool) if divides => {
                Ok(Self::evaluate_divided(pool, &self.alone, problems, detail))
            }
            _ => problems.iter().map(|problem| self.evaluate(problem, detail)).collect(),
        }
    }
}
