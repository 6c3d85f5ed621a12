//! All samples of one turn rate, judged. Lanes are samples here; the arithmetic is that of `score.rs`, to the bit.

use super::arithmetic::{atan2_turn, shift_round, turn_size};
use super::course::Course;
use super::lanes::{Lanes, MOST_LANES};
use super::march;
use super::sieve::Sieve;
use super::table::{Table, lane_numbers, stays_inside};
use super::tally::LaneTally;
use crate::local::inputs::Turn;
use crate::local::rollout::end_heading;
use crate::local::{Prepared, Reason};
use crate::numeric::HALF_TURN;

/// Words that the row of a course needs for its samples: heading term and reason, clearance, path term.
pub const COLUMNS: usize = 3;

/// The reason's place in the first word of a sample, above the heading term.
pub const REASON_BITS: u32 = 24;

/// Room for the final positions of a row's samples.
#[derive(Debug, Default)]
pub struct Ends {
    x: Vec<i32>,
    y: Vec<i32>,
}

/// How the samples of one vector fared.
#[derive(Clone, Copy)]
pub struct Fate<L: Lanes> {
    /// They touch an obstacle.
    pub collision: L::Mask,
    /// They leave the field.
    pub outside: L::Mask,
    /// Smallest clearance, units.
    pub clearance: L,
    /// What stopping has: that clearance, or free steps.
    pub has: L,
}

impl<L: Lanes> Fate<L> {
    /// Of samples that stay on the field and are judged by their smallest clearance.
    #[inline(always)]
    fn of_clearance(proof: L::Proof, least: L) -> Self {
        let zero = L::splat(proof, 0);
        Self {
            collision: L::but_not(zero.equal(zero), zero.less(least)),
            outside: L::none(proof),
            clearance: least,
            has: least,
        }
    }
}

/// Judges every sample of a turn rate with its table and adds it to a tally; the best value of each term, unless no sample
/// is admissible. `samples` has [`COLUMNS`] columns of the course's stride.
#[inline(always)]
pub fn judge_row<L: Lanes>(
    proof: L::Proof,
    problem: &Prepared,
    course: &Course,
    turn: &Turn,
    (number, table): (usize, &Table),
    sieve: &Sieve,
    (ends, samples, tally): (&mut Ends, &mut [i32], &mut LaneTally<L>),
) -> Option<[i32; 4]> {
    ends.x.resize(course.stride, 0);
    ends.y.resize(course.stride, 0);
    let mut row = Row::<L> {
        proof,
        problem,
        course,
        turn,
        heading: end_heading(&problem.header, turn),
        displaced: [table.end_x, table.end_y],
        ends,
        tally,
    };
    let vectors = (0..problem.speeds.len()).step_by(L::COUNT);
    if course.in_any_order && stays_inside::<L>(proof, problem, course, table) {
        let least = sieve.clearances(course, number);
        for first in vectors.clone() {
            let least = L::load(proof, &least[first..]);
            row.note(first, Fate::of_clearance(proof, least), samples);
        }
    } else {
        for first in vectors.clone() {
            let fate = march::meet::<L>(proof, problem, course, table, first);
            row.note(first, fate, samples);
        }
    }
    if row.tally.has_admissible() {
        for first in vectors.clone() {
            row.find_ends(first);
        }
        // Each term in a loop of its own: the vectors in it do not wait for one another, and more of them are under way
        // at once than of the whole.
        for first in vectors.clone() {
            row.find_headings(first, samples);
        }
        for first in vectors.clone() {
            row.find_paths(first, samples);
        }
        // By itself, or compilers add up in memory.
        let mut sums = *row.tally;
        for first in vectors {
            row.add_up(first, samples, &mut sums);
        }
        *row.tally = sums;
    }
    row.tally.end_row()
}

struct Row<'a, L: Lanes> {
    proof: L::Proof,
    problem: &'a Prepared,
    course: &'a Course,
    turn: &'a Turn,
    heading: u32,
    /// Sums of cosines and sines.
    displaced: [i32; 2],
    ends: &'a mut Ends,
    tally: &'a mut LaneTally<L>,
}

impl<L: Lanes> Row<'_, L> {
    /// Counts the samples of one vector; writes their clearances, and zeros as their first words where they are
    /// admissible. Only those are looked at later: the other terms of the others mean nothing.
    #[inline(always)]
    fn note(&mut self, first: usize, fate: Fate<L>, samples: &mut [i32]) {
        let Self { proof, course, .. } = *self;
        let zero = L::splat(proof, 0);
        let needs =
            L::load(proof, &course.needs[first..]).max(L::splat(proof, self.turn.needs as i32));
        let short = fate.has.less(needs);
        let left = self.problem.speeds.len() - first;
        let missing = L::splat(proof, left.min(MOST_LANES) as i32 - 1).less(lane_numbers(proof));
        let ended = L::either(fate.collision, fate.outside);
        let not_ok = L::either(L::either(ended, short), missing);
        let word = L::select(not_ok, word_of(proof, Reason::CannotStop), zero);
        let word = L::select(fate.outside, word_of(proof, Reason::Outside), word);
        let word = L::select(fate.collision, word_of(proof, Reason::Collision), word);
        let valid = !L::bits(missing) & (u32::MAX >> (32 - L::COUNT));
        let bad = L::bits(not_ok) & valid;
        let collision = L::bits(fate.collision) & valid;
        let outside = L::bits(fate.outside) & valid & !collision;
        self.tally.count(valid, bad, collision, outside);
        word.store(&mut samples[first..]);
        fate.clearance.store(&mut samples[course.stride + first..]);
    }

    /// Finds the final positions of one vector from the start, fine units.
    #[inline(always)]
    fn find_ends(&mut self, first: usize) {
        let Self { proof, course, .. } = *self;
        let header = &self.problem.header;
        let fine = L::load(proof, &course.fine[first..]);
        let [to_x, to_y] = self.displaced;
        let x = fine.mul_hi(L::splat(proof, to_x));
        let y = fine.mul_hi(L::splat(proof, to_y));
        shift_round(proof, x, header.fine_bits).store(&mut self.ends.x[first..]);
        shift_round(proof, y, header.fine_bits).store(&mut self.ends.y[first..]);
    }

    /// What was found.
    #[inline(always)]
    fn end(&self, first: usize) -> (L, L) {
        (
            L::load(self.proof, &self.ends.x[first..]),
            L::load(self.proof, &self.ends.y[first..]),
        )
    }

    /// Writes the heading terms of the admissible samples of one vector.
    #[inline(always)]
    fn find_headings(&self, first: usize, samples: &mut [i32]) {
        let Self { proof, .. } = *self;
        let header = &self.problem.header;
        let words = L::load(proof, &samples[first..]);
        let zero = L::splat(proof, 0);
        let ok = words.equal(zero);
        if L::bits(ok) == 0 {
            return;
        }
        let (x, y) = self.end(first);
        let to_x = L::splat(proof, header.target_x).sub(x);
        let to_y = L::splat(proof, header.target_y).sub(y);
        let there = L::both(to_x.equal(zero), to_y.equal(zero));
        let direction = atan2_turn(proof, to_y, to_x);
        let off = turn_size(direction.sub(L::splat(proof, self.heading as i32)));
        let heading = L::splat(proof, HALF_TURN as i32).sub(off).shr(8);
        let best = L::splat(proof, (HALF_TURN >> 8) as i32);
        let heading = L::select(there, best, heading);
        L::select(ok, heading, words).store(&mut samples[first..]);
    }

    /// Writes the path terms of one vector where a sample is admissible.
    #[inline(always)]
    fn find_paths(&self, first: usize, samples: &mut [i32]) {
        let Self { proof, course, .. } = *self;
        let header = &self.problem.header;
        let ok = is_ok(proof, L::load(proof, &samples[first..]));
        if L::bits(ok) == 0 {
            return;
        }
        let (x, y) = self.end(first);
        let path = L::splat(proof, header.key_x)
            .sub(x)
            .hypot(L::splat(proof, header.key_y).sub(y));
        path.store(&mut samples[2 * course.stride + first..]);
    }

    /// Adds up the terms of the admissible samples of one vector.
    #[inline(always)]
    fn add_up(&self, first: usize, samples: &[i32], sums: &mut LaneTally<L>) {
        let Self { proof, course, .. } = *self;
        let heading = L::load(proof, &samples[first..]);
        let clearance = L::load(proof, &samples[course.stride + first..]);
        let velocity = L::load(proof, &course.term[first..]);
        let path = L::load(proof, &samples[2 * course.stride + first..]);
        let ok = is_ok(proof, heading);
        sums.gather(ok, [heading, clearance, velocity, path]);
    }
}

/// Which samples are admissible, by their first words.
#[inline(always)]
fn is_ok<L: Lanes>(proof: L::Proof, words: L) -> L::Mask {
    words.less_unsigned(L::splat(proof, 1 << REASON_BITS))
}

/// The first word of a sample that is not admissible.
#[inline(always)]
fn word_of<L: Lanes>(proof: L::Proof, reason: Reason) -> L {
    L::splat(proof, (reason as i32) << REASON_BITS)
}
