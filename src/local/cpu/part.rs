//! A share of the turn rates, and what became of their samples.

use core::ops::Range;

use super::choice::{BestOfRow, Share, score};
use super::course::{Course, MOST_ROWS};
#[cfg(test)]
use super::groups::Groups;
use super::instructions::{Kernel, Work};
use super::lanes::Lanes;
use super::pooled::Pooled;
use super::row::{COLUMNS, Ends, REASON_BITS, judge_row};
use super::scalar;
use super::sieve::{Sieve, Tile};
use super::table::Table;
use super::tally::{LaneTally, Tally};
use crate::local::contract::{Reason, SampleRecord, Terms};
use crate::local::select::{Candidate, NOBODY, better};
use crate::local::{Prepared, Totals};

/// Room for the lanes' work.
#[derive(Debug, Default)]
struct Scratch {
    /// Tables of a tile's rows.
    tables: [Table; MOST_ROWS],
    sieve: Sieve,
    ends: Ends,
}

/// What choosing a sample takes.
pub struct Choice<'a> {
    pub kernel: Kernel,
    pub problem: &'a Prepared,
    pub course: &'a Course,
    pub shares: [Share; 4],
}

/// A share of the rows. Its memory is kept from one decision to the next.
#[derive(Debug, Default)]
pub struct Part {
    rows: Range<usize>,
    /// For each row its columns.
    samples: Vec<i32>,
    /// For each row the best value of each term, where it has an admissible sample.
    best_terms: Vec<Option<[i32; 4]>>,
    /// Of all rows.
    total: Tally,
    /// Of rows that have admissible samples.
    bounds: Vec<Candidate>,
    best: Candidate,
    /// Of the scalar kernel.
    table: Vec<i32>,
    /// Of the others.
    scratch: Scratch,
}

impl Part {
    /// Judges the samples of these rows.
    pub fn judge(
        &mut self,
        kernel: Kernel,
        problem: &Prepared,
        course: &Course,
        pooled: &Pooled,
        rows: Range<usize>,
    ) {
        let words = COLUMNS * course.stride;
        self.samples.resize(words * rows.len(), 0);
        self.best_terms.clear();
        self.total = Tally::default();
        self.rows = rows;
        if matches!(kernel, Kernel::Scalar) {
            self.judge_scalar(problem, course);
        } else {
            kernel.run(Judging {
                part: self,
                problem,
                course,
                pooled,
            });
        }
    }

    fn judge_scalar(&mut self, problem: &Prepared, course: &Course) {
        let turns = &problem.turns[self.rows.clone()];
        let rows = self.samples.chunks_exact_mut(COLUMNS * course.stride);
        for (turn, row) in turns.iter().zip(rows) {
            let tally = scalar::judge_row(problem, course, turn, &mut self.table, row);
            let has_admissible = tally.counts.admissible > 0;
            self.best_terms
                .push(has_admissible.then(|| best_terms(&tally.totals)));
            self.total.merge(&tally);
        }
    }

    #[inline(always)]
    fn judge_lanes<L: Lanes>(
        &mut self,
        proof: L::Proof,
        problem: &Prepared,
        course: &Course,
        pooled: &Pooled,
    ) {
        let turns = &problem.turns[self.rows.clone()];
        let words = COLUMNS * course.stride;
        let Scratch {
            tables,
            sieve,
            ends,
        } = &mut self.scratch;
        let tiles = self.samples.chunks_mut(course.tile_rows * words);
        // For the largest tile: the next decision's may have more rows than this one's.
        for table in tables.iter_mut().take(turns.len()) {
            table.make_room::<L>(course, problem.discs.len());
        }
        for table in tables.iter_mut().take(course.tile_rows.min(turns.len())) {
            table.begin::<L>(proof, problem, course);
        }
        for (turns, rows) in turns.chunks(course.tile_rows).zip(tiles) {
            let tables = &mut tables[..turns.len()];
            for (table, turn) in tables.iter_mut().zip(turns) {
                table.fill::<L>(proof, problem, course, turn);
            }
            if course.in_any_order {
                let tile = Tile {
                    problem,
                    course,
                    turns,
                    tables,
                };
                sieve.sift::<L>(proof, &tile, pooled);
            }
            let mut tally = LaneTally::<L>::new(proof);
            let rows = rows.chunks_exact_mut(words).enumerate();
            for ((turn, table), (number, row)) in turns.iter().zip(&*tables).zip(rows) {
                let table = (number, table);
                let room = (&mut *ends, row, &mut tally);
                let best = judge_row::<L>(proof, problem, course, turn, table, sieve, room);
                self.best_terms.push(best);
            }
            self.total.merge(&tally.finish());
        }
    }

    /// The groups of steps that its last tile was looked at, list by list.
    #[cfg(test)]
    pub fn picked(&self) -> &[Groups] {
        self.scratch.sieve.picked()
    }

    /// How many patches were looked up so far.
    #[cfg(test)]
    pub const fn looked_up(&self) -> usize {
        self.scratch.sieve.looked_up()
    }

    /// What all its samples add up to.
    pub const fn total(&self) -> &Tally {
        &self.total
    }

    /// Finds the most that a sample of each row could score, with the index of the row's first; rows without an admissible
    /// sample left out. The best of them.
    ///
    /// No sample of a row scores more than one with the row's best value of each term would.
    pub fn find_bounds(&mut self, choice: &Choice<'_>) -> Candidate {
        let speeds = choice.problem.speeds.len();
        let mut best = NOBODY;
        self.bounds.clear();
        // Room for all rows: how many have an admissible sample changes from one decision to the next.
        self.bounds.reserve(self.rows.len());
        for (row, terms) in self.rows.clone().zip(&self.best_terms) {
            if let Some(terms) = *terms {
                let most = score(&choice.shares, terms);
                let bound = (most, (row * speeds) as u32);
                self.bounds.push(bound);
                best = better(best, bound);
            }
        }
        best
    }

    /// Looks for its best sample among the rows that could beat a candidate, by the bounds that were found.
    pub fn choose(&mut self, choice: &Choice<'_>, candidate: Candidate) {
        let speeds = choice.problem.speeds.len();
        self.best = candidate;
        for &bound in &self.bounds {
            if better(self.best, bound) == bound {
                self.best = self.best_of_row(choice, bound.1 as usize / speeds, self.best);
            }
        }
    }

    /// What `choose` found, or the candidate that it was given.
    pub const fn best(&self) -> Candidate {
        self.best
    }

    /// The better of a candidate and the best sample of one of its rows.
    pub fn best_of_row(&self, choice: &Choice<'_>, row: usize, candidate: Candidate) -> Candidate {
        let speeds = choice.problem.speeds.len();
        let best = choice.kernel.run(BestOfRow {
            course: choice.course,
            row: self.row(choice.course, row),
            samples: speeds,
            shares: &choice.shares,
            least: candidate.0,
        });
        best.map_or(candidate, |(score, index)| {
            better(candidate, (score, (row * speeds + index) as u32))
        })
    }

    fn row(&self, course: &Course, row: usize) -> &[i32] {
        let words = COLUMNS * course.stride;
        &self.samples[(row - self.rows.start) * words..][..words]
    }

    /// The rows it has.
    pub const fn rows(&self) -> &Range<usize> {
        &self.rows
    }

    /// A sample of one of its rows.
    pub fn sample(
        &self,
        problem: &Prepared,
        course: &Course,
        row: usize,
        index: usize,
    ) -> SampleRecord {
        let row = self.row(course, row);
        record(problem, course, row, index)
    }
}

/// Judging a part in lanes.
struct Judging<'a> {
    part: &'a mut Part,
    problem: &'a Prepared,
    course: &'a Course,
    pooled: &'a Pooled,
}

impl Work for Judging<'_> {
    type Outcome = ();

    #[inline(always)]
    fn run<L: Lanes>(self, proof: L::Proof) {
        self.part
            .judge_lanes::<L>(proof, self.problem, self.course, self.pooled);
    }
}

/// The best value of each term.
const fn best_terms(totals: &Totals) -> [i32; 4] {
    let [heading, clearance, velocity, _] = totals.greatest;
    [
        heading as i32,
        clearance as i32,
        velocity as i32,
        totals.least[3] as i32,
    ]
}

fn record(problem: &Prepared, course: &Course, row: &[i32], index: usize) -> SampleRecord {
    let word = row[index] as u32;
    let reason = Reason::from_number(word >> REASON_BITS);
    if reason != Reason::Ok {
        return SampleRecord {
            reason,
            terms: Terms::default(),
        };
    }
    let terms = Terms {
        heading: word,
        clearance: row[course.stride + index] as u32,
        velocity: problem.speeds[index].term,
        path: row[2 * course.stride + index] as u32,
    };
    SampleRecord { reason, terms }
}
