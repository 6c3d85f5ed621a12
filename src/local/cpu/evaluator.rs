//! The evaluation of one problem, by one thread or several.

use std::sync::{Mutex, PoisonError};

use super::instruction_set::Kernel;
use super::min_pyramid::{BuildMinPyramid, MinPyramid};
use super::row_argmax::TermScale;
use super::row_shard::{ArgmaxInputs, RowShard};
use super::sample_stats::SampleStats;
use super::soa_inputs::SoaInputs;
use super::thread_pool::{Counter, ThreadPool};
use crate::local::engine::{Detail, Evaluation, SampleRecord, Winner};
use crate::local::select::{Candidate, NO_CANDIDATE, better};
use crate::local::{QuantizedProblem, score};

/// Shards per thread when there are several threads: enough that a late thread leaves little work to the others.
const SHARDS_PER_THREAD: usize = 4;

/// Number of samples from which the selection uses all threads. Below it one thread is faster.
const PARALLEL_ARGMAX_SAMPLES: usize = 1 << 15;

/// Evaluates problems, one after the other; the next one reuses the memory.
pub struct Evaluator {
    kernel: Kernel,
    pub inputs: SoaInputs,
    pub pyramid: MinPyramid,
    pub shards: Vec<Mutex<RowShard>>,
    /// Number of shards of the problem; the others are left from earlier problems.
    used: usize,
}

impl Evaluator {
    /// An evaluator for up to `threads` threads.
    pub fn new(kernel: Kernel, threads: usize) -> Self {
        Self {
            kernel,
            inputs: SoaInputs::default(),
            pyramid: MinPyramid::default(),
            shards: (0..shards_of(threads)).map(|_| Mutex::default()).collect(),
            used: 0,
        }
    }

    /// Evaluates a problem with the caller's thread and up to `threads - 1` of the pool.
    pub fn evaluate(
        &mut self,
        pool: Option<&mut ThreadPool>,
        threads: usize,
        problem: &QuantizedProblem,
        detail: Detail,
    ) -> Evaluation {
        let mut team = Team { pool, threads };
        self.used = shards_of(threads).min(self.shards.len());
        self.inputs.fill(problem, self.kernel.lanes());
        self.pyramid.clear();
        let is_scalar = matches!(self.kernel, Kernel::Scalar);
        if !is_scalar && self.inputs.order_free && self.inputs.allows_pruning {
            self.kernel.run(BuildMinPyramid { pyramid: &mut self.pyramid, problem });
        }
        self.evaluate_rows(problem, &mut team);
        let (stats, best) = self.select(problem, team);
        let winner = self.winner(problem, best);
        let samples = (detail == Detail::Samples).then(|| self.samples(problem));
        Evaluation { counts: stats.counts, totals: stats.totals, winner, samples }
    }

    /// Evaluates every shard.
    pub fn evaluate_rows(&mut self, problem: &QuantizedProblem, team: &mut Team<'_>) {
        let (kernel, shards) = (self.kernel, &self.shards[..self.used]);
        let (inputs, pyramid) = (&self.inputs, &self.pyramid);
        let rows = problem.profiles.len();
        let share = |number: usize| rows * number / shards.len();
        team.for_each(shards, |number, shard| {
            let rows = share(number)..share(number + 1);
            shard.evaluate(kernel, problem, inputs, pyramid, rows);
        });
    }

    /// Statistics of all samples, and the best sample.
    pub fn select(
        &mut self,
        problem: &QuantizedProblem,
        mut team: Team<'_>,
    ) -> (SampleStats, Candidate) {
        let mut stats = SampleStats::default();
        for shard in &mut self.shards[..self.used] {
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
        for (number, shard) in self.shards[..self.used].iter_mut().enumerate() {
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
        let shards = &self.shards[..self.used];
        if problem.len() < PARALLEL_ARGMAX_SAMPLES {
            team.threads = 1;
        }
        team.for_each(shards, |_, shard| {
            shard.select_best(&argmax, candidate);
        });
        let best = self.shards[..self.used].iter_mut().map(|shard| unlocked(shard).best);
        (stats, best.fold(NO_CANDIDATE, better))
    }

    /// The winner; `None` when no sample is admissible.
    fn winner(&mut self, problem: &QuantizedProblem, (score, index): Candidate) -> Option<Winner> {
        let vx_count = problem.vx_samples.len();
        let (row, column) = (index as usize / vx_count, index as usize % vx_count);
        let inputs = &self.inputs;
        let mut shards = self.shards[..self.used].iter_mut().map(unlocked);
        let shard = shards.find(|shard| shard.rows.contains(&row))?;
        Some(Winner { index, score, terms: shard.sample(problem, inputs, row, column).terms })
    }

    /// All samples in order of index: shards and their rows are in that order.
    pub fn samples(&mut self, problem: &QuantizedProblem) -> Vec<SampleRecord> {
        let inputs = &self.inputs;
        let mut samples = Vec::with_capacity(problem.len());
        for shard in &mut self.shards[..self.used] {
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

/// Number of shards for some threads.
const fn shards_of(threads: usize) -> usize {
    if threads > 1 { threads * SHARDS_PER_THREAD } else { 1 }
}

/// The threads that evaluate a problem; by default the caller's alone.
#[derive(Default)]
pub struct Team<'a> {
    pool: Option<&'a mut ThreadPool>,
    threads: usize,
}

impl Team<'_> {
    /// Calls `each` with every shard; each idle thread takes the next one.
    fn for_each(&mut self, shards: &[Mutex<RowShard>], each: impl Fn(usize, &mut RowShard) + Sync) {
        let next = Counter::default();
        let work = || {
            loop {
                let number = next.take();
                let Some(shard) = shards.get(number) else {
                    break;
                };
                each(number, &mut shard.lock().unwrap_or_else(PoisonError::into_inner));
            }
        };
        match &mut self.pool {
            Some(pool) if self.threads > 1 => pool.run(self.threads - 1, &work),
            _ => work(),
        }
    }
}

fn unlocked(shard: &mut Mutex<RowShard>) -> &mut RowShard {
    shard.get_mut().unwrap_or_else(PoisonError::into_inner)
}
