//! The CPU engine: for each turn rate a table, for each sample a judgement. No mathematics of its own.

use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use super::contract::{
    Counts, Detail, Engine, Evaluation, Reason, SampleRecord, Terms, Totals, Winner,
};
use super::inputs::Turn;
use super::score::Normalizer;
use super::select::{Candidate, NOBODY};
use super::{EngineError, Prepared, rollout, score, select};

/// Evaluates on the machine's own cores.
pub struct CpuEngine {
    /// None runs in the caller's thread.
    pool: Option<ThreadPool>,
    threads: usize,
    records: Vec<SampleRecord>,
}

impl CpuEngine {
    /// An engine that works in the thread that calls it.
    #[must_use]
    pub const fn single_threaded() -> Self {
        Self {
            pool: None,
            threads: 1,
            records: Vec::new(),
        }
    }

    /// An engine with its own worker threads; one thread, or fewer, works in the thread that calls it.
    ///
    /// # Errors
    /// When the system does not give the threads.
    pub fn with_threads(threads: usize) -> Result<Self, EngineError> {
        if threads <= 1 {
            return Ok(Self::single_threaded());
        }
        let pool = ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|error| EngineError::Threads {
                threads,
                what: error.to_string(),
            })?;
        Ok(Self {
            pool: Some(pool),
            threads,
            records: Vec::new(),
        })
    }
}

impl Engine for CpuEngine {
    fn name(&self) -> String {
        let plural = if self.threads == 1 { "" } else { "s" };
        format!("CPU, {} thread{plural}", self.threads)
    }

    fn kind(&self) -> &'static str {
        "cpu"
    }

    fn threads(&self) -> usize {
        self.threads
    }

    fn evaluate(&mut self, problem: &Prepared, detail: Detail) -> Result<Evaluation, EngineError> {
        let blank = SampleRecord {
            reason: Reason::Ok,
            terms: Terms::default(),
        };
        self.records.clear();
        self.records.resize(problem.len(), blank);
        let records = self.records.as_mut_slice();
        let (tally, best) = match &self.pool {
            None => evaluate_in_order(problem, records),
            Some(pool) => pool.install(|| evaluate_in_parallel(problem, records)),
        };
        let winner = (best.1 != NOBODY.1).then(|| Winner {
            index: best.1,
            score: best.0,
            terms: self.records[best.1 as usize].terms,
        });
        let samples = (detail == Detail::Samples).then(|| self.records.clone());
        Ok(Evaluation {
            counts: tally.counts,
            totals: tally.totals,
            winner,
            samples,
        })
    }
}

#[derive(Clone, Copy, Default)]
struct Tally {
    counts: Counts,
    totals: Totals,
}

impl Tally {
    fn merge(self, other: Self) -> Self {
        Self {
            counts: Counts {
                admissible: self.counts.admissible + other.counts.admissible,
                collision: self.counts.collision + other.counts.collision,
                cannot_stop: self.counts.cannot_stop + other.counts.cannot_stop,
                outside: self.counts.outside + other.counts.outside,
            },
            totals: select::merge(self.totals, other.totals),
        }
    }
}

fn evaluate_in_order(problem: &Prepared, records: &mut [SampleRecord]) -> (Tally, Candidate) {
    let speeds = problem.speeds.len();
    let mut table = vec![0; rollout::table_words(&problem.header)];
    let mut tally = Tally::default();
    for (turn, row) in problem.turns.iter().zip(records.chunks_exact_mut(speeds)) {
        tally = tally.merge(judge_row(problem, turn, &mut table, row));
    }
    let normalizers = score::normalizers(&problem.header, &tally.totals);
    let rows = records.chunks_exact(speeds).enumerate();
    let best = rows.map(|(index, row)| best_of_row(index * speeds, row, &normalizers));
    (tally, best.fold(NOBODY, select::better))
}

fn evaluate_in_parallel(problem: &Prepared, records: &mut [SampleRecord]) -> (Tally, Candidate) {
    let speeds = problem.speeds.len();
    let table = || vec![0; rollout::table_words(&problem.header)];
    let tally = problem
        .turns
        .par_iter()
        .zip(records.par_chunks_exact_mut(speeds))
        .map_init(table, |table, (turn, row)| {
            judge_row(problem, turn, table, row)
        })
        .reduce(Tally::default, Tally::merge);
    let normalizers = score::normalizers(&problem.header, &tally.totals);
    let best = records
        .par_chunks_exact(speeds)
        .enumerate()
        .map(|(index, row)| best_of_row(index * speeds, row, &normalizers))
        .reduce(|| NOBODY, select::better);
    (tally, best)
}

/// Judges all speeds of one turn rate.
fn judge_row(
    problem: &Prepared,
    turn: &Turn,
    table: &mut [i32],
    row: &mut [SampleRecord],
) -> Tally {
    let header = &problem.header;
    rollout::tabulate(header, turn, &problem.discs, table);
    let end_heading = rollout::end_heading(header, turn);
    let mut tally = Tally::default();
    for (speed, record) in problem.speeds.iter().zip(row) {
        let (reason, clearance) = rollout::judge(problem, speed, turn, table);
        select::count(&mut tally.counts, reason);
        record.reason = reason;
        if reason == Reason::Ok {
            let end = rollout::end_position(header, speed, table);
            record.terms = score::terms(header, speed, end_heading, end, clearance);
            select::gather(&mut tally.totals, record.terms.to_array());
        }
    }
    tally
}

/// The best of one row of samples whose first has this index.
fn best_of_row(first: usize, row: &[SampleRecord], normalizers: &[Normalizer; 4]) -> Candidate {
    row.iter()
        .enumerate()
        .filter(|(_, record)| record.reason == Reason::Ok)
        .map(|(offset, record)| {
            (
                score::score(&record.terms, normalizers),
                (first + offset) as u32,
            )
        })
        .fold(NOBODY, select::better)
}
