//! All samples of one turn rate: the table that they share, and how each is judged. Lanes are samples here, and steps
//! while the table is made; the arithmetic is that of `rollout.rs` and `score.rs`, to the bit.

use super::arithmetic::{atan2_turn, cos_q20, shift_round, sin_q20, turn_size};
use super::course::Course;
use super::lanes::{Lanes, MOST_LANES};
use super::march;
use super::sieve::{Sieve, stay_inside};
use super::tally::{LaneTally, Tally};
use crate::local::inputs::Turn;
use crate::local::rollout::end_heading;
use crate::local::{Prepared, Reason};
use crate::numeric::HALF_TURN;

/// Words that the row of a course needs for its samples: heading term and reason, clearance, path term.
pub const COLUMNS: usize = 3;

/// The reason's place in the first word of a sample, above the heading term.
pub const REASON_BITS: u32 = 24;

/// A disc at a step.
///
/// Its position along x is `disc_x + round(coarse x / 2^coarse_bits)`, and its column that divided by `2^cell_bits`. The
/// divisions are one: with the part of `disc_x` below a cell, and the half that rounds, in the product's scale as `across`,
/// the column is that of `disc_x` plus `(coarse x + across) >> (coarse_bits + cell_bits)`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Step {
    pub x: i32,
    pub y: i32,
    pub x_halves: i32,
    pub y_halves: i32,
    pub across: i32,
    pub along: i32,
    pub cell: i32,
    pub disc_x: i32,
    pub disc_y: i32,
}

/// The table of one turn rate, by step.
#[derive(Debug, Default)]
pub struct Table {
    cosines: Vec<i32>,
    sines: Vec<i32>,
    /// Coarse displacement along x.
    pub x: Vec<i32>,
    /// Coarse displacement along y.
    pub y: Vec<i32>,
    /// `x` as two numbers of 16 bits, which add up to it.
    pub x_halves: Vec<i32>,
    /// `y` as two numbers of 16 bits, which add up to it.
    pub y_halves: Vec<i32>,
    /// For each disc and step its centre for a robot that did not move, along x.
    pub disc_x: Vec<i32>,
    /// And along y.
    pub disc_y: Vec<i32>,
    /// For each disc and step what leads from a product to its cell.
    pub across: Vec<i32>,
    /// The same along y.
    pub along: Vec<i32>,
    /// The cell of that disc for a robot that did not move.
    pub cell: Vec<i32>,
    /// All of these, disc by disc and step by step, in one place each.
    pub entries: Vec<Step>,
    /// Sum of cosines in Q20.
    end_x: i32,
    /// Sum of sines in Q20.
    end_y: i32,
}

impl Table {
    /// The table of a turn rate; entries beyond the last step repeat it.
    #[inline(always)]
    fn fill<L: Lanes>(
        &mut self,
        proof: L::Proof,
        problem: &Prepared,
        course: &Course,
        turn: &Turn,
    ) {
        let header = &problem.header;
        let steps = header.steps as usize;
        // A step's discs stand turned already: one angle more than steps.
        let angles = (steps + 1).next_multiple_of(L::COUNT);
        self.cosines.resize(course.steps + MOST_LANES, 0);
        self.sines.resize(course.steps + MOST_LANES, 0);
        let mut first = [0; MOST_LANES];
        for (lane, angle) in first.iter_mut().enumerate() {
            *angle = header
                .heading
                .wrapping_add(turn.per_step.wrapping_mul(lane as u32)) as i32;
        }
        let mut angle = L::load(proof, &first);
        let further = L::splat(proof, turn.per_step.wrapping_mul(L::COUNT as u32) as i32);
        for at in (0..angles).step_by(L::COUNT) {
            cos_q20(proof, angle).store(&mut self.cosines[at..]);
            sin_q20(proof, angle).store(&mut self.sines[at..]);
            angle = angle.add(further);
        }
        self.x.resize(course.steps, 0);
        self.y.resize(course.steps, 0);
        self.end_x = sums(&self.cosines[..steps], &mut self.x);
        self.end_y = sums(&self.sines[..steps], &mut self.y);
        repeat_last(&mut self.x, steps);
        repeat_last(&mut self.y, steps);
        for at in (0..course.steps).step_by(L::COUNT) {
            for list in [&mut self.x, &mut self.y] {
                let sum = L::load(proof, &list[at..]);
                shift_round(proof, sum, header.table_bits).store(&mut list[at..]);
            }
        }
        self.disc_x.resize(course.steps * problem.discs.len(), 0);
        self.disc_y.resize(course.steps * problem.discs.len(), 0);
        for (number, disc) in problem.discs.iter().enumerate() {
            let list_x = &mut self.disc_x[number * course.steps..][..course.steps];
            let list_y = &mut self.disc_y[number * course.steps..][..course.steps];
            let (disc_x, disc_y) = (L::splat(proof, disc.x), L::splat(proof, disc.y));
            let start_x = L::splat(proof, header.start_x);
            let start_y = L::splat(proof, header.start_y);
            for at in (0..course.steps).step_by(L::COUNT) {
                let cosine = shift_round(proof, L::load(proof, &self.cosines[at + 1..]), 6);
                let sine = shift_round(proof, L::load(proof, &self.sines[at + 1..]), 6);
                let x = disc_x.mul(cosine).sub(disc_y.mul(sine));
                let y = disc_x.mul(sine).add(disc_y.mul(cosine));
                start_x
                    .add(shift_round(proof, x, 14))
                    .store(&mut list_x[at..]);
                start_y
                    .add(shift_round(proof, y, 14))
                    .store(&mut list_y[at..]);
            }
            repeat_last(list_x, steps);
            repeat_last(list_y, steps);
        }
        if course.short {
            self.find_cells::<L>(proof, problem, course);
        }
    }

    #[inline(always)]
    fn find_cells<L: Lanes>(&mut self, proof: L::Proof, problem: &Prepared, course: &Course) {
        let header = &problem.header;
        let words = self.disc_x.len();
        for list in [&mut self.across, &mut self.along, &mut self.cell] {
            list.resize(words, 0);
        }
        let within_cell = L::splat(proof, (1 << header.cell_bits) - 1);
        let half = L::splat(proof, (1 << header.coarse_bits) >> 1);
        let width = L::splat(proof, header.width as i32);
        for at in (0..words).step_by(L::COUNT) {
            let x = L::load(proof, &self.disc_x[at..]);
            let y = L::load(proof, &self.disc_y[at..]);
            let across = x.and(within_cell).shl(header.coarse_bits).add(half);
            let along = y.and(within_cell).shl(header.coarse_bits).add(half);
            let row = y.sar(header.cell_bits).mul(width);
            across.store(&mut self.across[at..]);
            along.store(&mut self.along[at..]);
            row.add(x.sar(header.cell_bits)).store(&mut self.cell[at..]);
        }
        for (sums, halves) in [(&self.x, &mut self.x_halves), (&self.y, &mut self.y_halves)] {
            halves.resize(course.steps, 0);
            let low = L::splat(proof, 0xFFFF);
            for at in (0..course.steps).step_by(L::COUNT) {
                let sum = L::load(proof, &sums[at..]);
                let half = sum.sar(1);
                let packed = sum.sub(half).shl(16).add(half.and(low));
                packed.store(&mut halves[at..]);
            }
        }
        self.entries.clear();
        for disc in 0..problem.discs.len() {
            let places = disc * course.steps..(disc + 1) * course.steps;
            let across = self.across[places.clone()].iter();
            let along = self.along[places.clone()].iter();
            let cell = self.cell[places.clone()].iter();
            let disc_x = self.disc_x[places.clone()].iter();
            let disc_y = self.disc_y[places].iter();
            let halves = self.x_halves.iter().zip(&self.y_halves);
            let coarse = self.x.iter().zip(&self.y).zip(halves);
            let cells = across.zip(along).zip(cell);
            let entries = coarse.zip(cells).zip(disc_x.zip(disc_y));
            self.entries.extend(entries.map(
                |((((x, y), (x_halves, y_halves)), ((across, along), cell)), (disc_x, disc_y))| {
                    Step {
                        x_halves: *x_halves,
                        y_halves: *y_halves,
                        x: *x,
                        y: *y,
                        across: *across,
                        along: *along,
                        cell: *cell,
                        disc_x: *disc_x,
                        disc_y: *disc_y,
                    }
                },
            ));
        }
    }
}

/// Writes the sums of the values so far; the last of them.
fn sums(values: &[i32], sums: &mut [i32]) -> i32 {
    let mut sum = 0_i32;
    for (value, place) in values.iter().zip(sums) {
        // At most 2^20 for each of 1023 steps.
        sum = sum.wrapping_add(*value);
        *place = sum;
    }
    sum
}

fn repeat_last(list: &mut [i32], len: usize) {
    let last = list[len - 1];
    list[len..].fill(last);
}

/// What judging a row needs besides the problem, kept from one row to the next.
#[derive(Debug, Default)]
pub struct Scratch {
    pub table: Table,
    sieve: Sieve,
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

/// Judges every sample of a turn rate; `samples` has [`COLUMNS`] columns of the course's stride.
#[inline(always)]
pub fn judge_row<L: Lanes>(
    proof: L::Proof,
    problem: &Prepared,
    course: &Course,
    turn: &Turn,
    scratch: &mut Scratch,
    samples: &mut [i32],
) -> Tally {
    let Scratch { table, sieve } = scratch;
    table.fill::<L>(proof, problem, course, turn);
    let mut row = Row::<L> {
        proof,
        problem,
        course,
        turn,
        heading: end_heading(&problem.header, turn),
        ends: [table.end_x, table.end_y],
        tally: LaneTally::new(proof),
    };
    let whole_vectors = problem.speeds.len().next_multiple_of(L::COUNT);
    let in_any_order = course.short && problem.header.stop_by_arc == 0;
    let all_inside =
        in_any_order && stay_inside::<L>(proof, problem, course, table, 0..whole_vectors);
    let vectors = (0..whole_vectors).step_by(L::COUNT);
    if all_inside {
        let least = sieve.clearances::<L>(proof, problem, course, table);
        for first in vectors {
            let least = L::load(proof, &least[first..]);
            row.finish(first, Fate::of_clearance(proof, least), samples);
        }
    } else {
        for first in vectors {
            let fate = march::meet::<L>(proof, problem, course, table, first);
            row.finish(first, fate, samples);
        }
    }
    row.tally.finish()
}

struct Row<'a, L: Lanes> {
    proof: L::Proof,
    problem: &'a Prepared,
    course: &'a Course,
    turn: &'a Turn,
    heading: u32,
    ends: [i32; 2],
    tally: LaneTally<L>,
}

impl<L: Lanes> Row<'_, L> {
    /// Writes and counts the samples of one vector.
    #[inline(always)]
    fn finish(&mut self, first: usize, fate: Fate<L>, samples: &mut [i32]) {
        let Self { proof, course, .. } = *self;
        let zero = L::splat(proof, 0);
        let needs =
            L::load(proof, &course.needs[first..]).max(L::splat(proof, self.turn.needs as i32));
        let short = fate.has.less(needs);
        let ended = L::either(fate.collision, fate.outside);
        let not_ok = L::either(ended, short);
        let word = L::select(short, word_of(proof, Reason::CannotStop), zero);
        let word = L::select(fate.outside, word_of(proof, Reason::Outside), word);
        let word = L::select(fate.collision, word_of(proof, Reason::Collision), word);
        let left = self.problem.speeds.len() - first;
        let valid = if left >= L::COUNT {
            u32::MAX >> (32 - L::COUNT)
        } else {
            (1 << left) - 1
        };
        let bad = L::bits(not_ok) & valid;
        let collision = L::bits(fate.collision) & valid;
        let outside = L::bits(fate.outside) & valid & !collision;
        self.tally.count(valid, bad, collision, outside);
        let (mut heading, mut clearance, mut path) = (word, zero, zero);
        if bad != valid {
            let (found_heading, found_path) = self.terms(first);
            heading = L::select(not_ok, word, found_heading);
            clearance = L::select(not_ok, zero, fate.clearance);
            path = L::select(not_ok, zero, found_path);
            let velocity = L::load(proof, &course.term[first..]);
            let out = if left >= L::COUNT {
                not_ok
            } else {
                L::either(
                    not_ok,
                    L::splat(proof, left as i32 - 1).less(lane_numbers(proof)),
                )
            };
            self.tally
                .gather(proof, out, [heading, clearance, velocity, path]);
        }
        heading.store(&mut samples[first..]);
        clearance.store(&mut samples[course.stride + first..]);
        path.store(&mut samples[2 * course.stride + first..]);
    }

    /// Heading and path terms.
    #[inline(always)]
    fn terms(&self, first: usize) -> (L, L) {
        let Self { proof, course, .. } = *self;
        let header = &self.problem.header;
        let fine = L::load(proof, &course.fine[first..]);
        let x = fine.mul_hi(L::splat(proof, self.ends[0]));
        let y = fine.mul_hi(L::splat(proof, self.ends[1]));
        let x = shift_round(proof, x, header.fine_bits);
        let y = shift_round(proof, y, header.fine_bits);
        let path = L::splat(proof, header.key_x)
            .sub(x)
            .hypot(L::splat(proof, header.key_y).sub(y));
        let to_x = L::splat(proof, header.target_x).sub(x);
        let to_y = L::splat(proof, header.target_y).sub(y);
        let zero = L::splat(proof, 0);
        let there = L::both(to_x.equal(zero), to_y.equal(zero));
        let direction = atan2_turn(proof, to_y, to_x);
        let off = turn_size(direction.sub(L::splat(proof, self.heading as i32)));
        let heading = L::splat(proof, HALF_TURN as i32).sub(off).shr(8);
        let best = L::splat(proof, (HALF_TURN >> 8) as i32);
        (L::select(there, best, heading), path)
    }
}

/// The first word of a sample that is not admissible.
#[inline(always)]
fn word_of<L: Lanes>(proof: L::Proof, reason: Reason) -> L {
    L::splat(proof, (reason as i32) << REASON_BITS)
}

/// Zero in the first lane, one in the second, and so on.
#[inline(always)]
pub fn lane_numbers<L: Lanes>(proof: L::Proof) -> L {
    const NUMBERS: [i32; MOST_LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];
    L::load(proof, &NUMBERS)
}
