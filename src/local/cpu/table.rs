//! The table of one turn rate: where the discs of the footprint are at each step. Lanes are steps here.

use super::arithmetic::{cos_q20, shift_round, sin_q20};
use super::course::Course;
use super::lanes::{Lanes, MOST_LANES};
use crate::local::Prepared;
use crate::local::inputs::{Header, Turn};

/// The table of one turn rate, by step.
///
/// A disc's position along x is `disc_x + round(coarse x / 2^coarse_bits)`, and its column that divided by `2^cell_bits`. The
/// divisions are one: with the part of `disc_x` below a cell, and the half that rounds, in the product's scale as `across`,
/// the column is that of `disc_x` plus `(coarse x + across) >> (coarse_bits + cell_bits)`.
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
    /// `disc_x` with the half that rounds, in the product's scale; what is beyond 32 bits is cut off. Only for lanes that
    /// look up in registers, as the next.
    pub x_scaled: Vec<i32>,
    /// The same along y.
    pub y_scaled: Vec<i32>,
    /// Sum of cosines in Q20.
    pub end_x: i32,
    /// Sum of sines in Q20.
    pub end_y: i32,
}

impl Table {
    /// The table of a turn rate, for which there is room; entries beyond the last step repeat it.
    #[inline(always)]
    pub fn fill<L: Lanes>(
        &mut self,
        proof: L::Proof,
        problem: &Prepared,
        course: &Course,
        turn: &Turn,
    ) {
        self.turn_on::<L>(proof, &problem.header, turn);
        self.add_up::<L>(proof, &problem.header, course);
        self.place_discs::<L>(proof, problem, course, false);
    }

    /// Enters what is the same for all turn rates of a decision: central discs do not move as the robot turns.
    #[inline(always)]
    pub fn begin<L: Lanes>(&mut self, proof: L::Proof, problem: &Prepared, course: &Course) {
        self.place_discs::<L>(proof, problem, course, true);
    }

    /// Finds where the central discs are, or the others.
    #[inline(always)]
    fn place_discs<L: Lanes>(
        &mut self,
        proof: L::Proof,
        problem: &Prepared,
        course: &Course,
        central: bool,
    ) {
        for (number, disc) in problem.discs.iter().enumerate() {
            if disc.is_central() == central {
                self.place_disc::<L>(proof, problem, course, number);
            }
        }
    }

    /// Makes room for the tables of this decision.
    #[inline(always)]
    pub fn make_room<L: Lanes>(&mut self, course: &Course, discs: usize) {
        // A step's discs stand turned already: one angle more than steps.
        let angles = course.steps + MOST_LANES;
        let cells = course.steps * discs;
        if self.cosines.len() == angles && self.disc_x.len() == cells {
            return;
        }
        self.cosines.resize(angles, 0);
        self.sines.resize(angles, 0);
        for list in [
            &mut self.x,
            &mut self.y,
            &mut self.x_halves,
            &mut self.y_halves,
        ] {
            list.resize(course.steps, 0);
        }
        for list in [
            &mut self.disc_x,
            &mut self.disc_y,
            &mut self.across,
            &mut self.along,
            &mut self.cell,
        ] {
            list.resize(cells, 0);
        }
        if L::LOOKS_UP {
            self.x_scaled.resize(cells, 0);
            self.y_scaled.resize(cells, 0);
        }
    }

    /// Finds the cosines and sines of all headings; those beyond the last repeat it.
    #[inline(always)]
    fn turn_on<L: Lanes>(&mut self, proof: L::Proof, header: &Header, turn: &Turn) {
        let heading = L::splat(proof, header.heading as i32);
        let per_step = L::splat(proof, turn.per_step as i32);
        let last = L::splat(proof, header.steps as i32);
        let (mut cosines, mut sines) = (heading, heading);
        for at in (0..self.cosines.len()).step_by(L::COUNT) {
            if at <= header.steps as usize {
                let steps = lane_numbers::<L>(proof).add(L::splat(proof, at as i32));
                let angle = heading.add(steps.min(last).mul(per_step));
                (cosines, sines) = (cos_q20(proof, angle), sin_q20(proof, angle));
            } else {
                cosines = L::splat(proof, cosines.last());
                sines = L::splat(proof, sines.last());
            }
            cosines.store(&mut self.cosines[at..]);
            sines.store(&mut self.sines[at..]);
        }
    }

    /// Finds the displacements, which are sums of cosines and sines.
    #[inline(always)]
    fn add_up<L: Lanes>(&mut self, proof: L::Proof, header: &Header, course: &Course) {
        let (zero, low) = (L::splat(proof, 0), L::splat(proof, 0xFFFF));
        let steps = L::splat(proof, header.steps as i32);
        let lists = [
            (
                &self.cosines,
                &mut self.x,
                &mut self.x_halves,
                &mut self.end_x,
            ),
            (
                &self.sines,
                &mut self.y,
                &mut self.y_halves,
                &mut self.end_y,
            ),
        ];
        for (values, sums, halves, end) in lists {
            *end = 0;
            for at in (0..course.steps).step_by(L::COUNT) {
                let number = lane_numbers::<L>(proof).add(L::splat(proof, at as i32));
                let values = L::load(proof, &values[at..]);
                // At most 2^20 for each of 1023 steps; none beyond the last.
                let values = L::select(number.less(steps), values, zero);
                let sum = values.running_sums().add(L::splat(proof, *end));
                *end = sum.last();
                let sum = shift_round(proof, sum, header.table_bits);
                sum.store(&mut sums[at..]);
                let half = sum.sar(1);
                let packed = sum.sub(half).shl(16).add(half.and(low));
                packed.store(&mut halves[at..]);
            }
        }
    }

    /// Finds where one disc is.
    #[inline(always)]
    fn place_disc<L: Lanes>(
        &mut self,
        proof: L::Proof,
        problem: &Prepared,
        course: &Course,
        number: usize,
    ) {
        let Prepared { header, discs, .. } = problem;
        let disc = &discs[number];
        let (disc_x, disc_y) = (L::splat(proof, disc.x), L::splat(proof, disc.y));
        let start_x = L::splat(proof, header.start_x);
        let start_y = L::splat(proof, header.start_y);
        let within_cell = L::splat(proof, (1 << header.cell_bits) - 1);
        let half = L::splat(proof, (1 << header.coarse_bits) >> 1);
        let width = L::splat(proof, header.width as i32);
        for step in (0..course.steps).step_by(L::COUNT) {
            let at = number * course.steps + step;
            let cosine = shift_round(proof, L::load(proof, &self.cosines[step + 1..]), 6);
            let sine = shift_round(proof, L::load(proof, &self.sines[step + 1..]), 6);
            let x = disc_x.mul(cosine).sub(disc_y.mul(sine));
            let y = disc_x.mul(sine).add(disc_y.mul(cosine));
            let x = start_x.add(shift_round(proof, x, 14));
            let y = start_y.add(shift_round(proof, y, 14));
            x.store(&mut self.disc_x[at..]);
            y.store(&mut self.disc_y[at..]);
            if !course.in_any_order {
                continue;
            }
            let across = x.and(within_cell).shl(header.coarse_bits).add(half);
            let along = y.and(within_cell).shl(header.coarse_bits).add(half);
            let row = y.sar(header.cell_bits).mul(width);
            across.store(&mut self.across[at..]);
            along.store(&mut self.along[at..]);
            row.add(x.sar(header.cell_bits)).store(&mut self.cell[at..]);
            if L::LOOKS_UP {
                let (x_scaled, y_scaled) = (x.shl(header.coarse_bits), y.shl(header.coarse_bits));
                x_scaled.add(half).store(&mut self.x_scaled[at..]);
                y_scaled.add(half).store(&mut self.y_scaled[at..]);
            }
        }
    }
}

/// Whether every disc of a row's samples stays on the field. Positions are monotonic in the speed, rounded as they are, so
/// the first and the last sample bound the others.
#[inline(always)]
pub fn stays_inside<L: Lanes>(
    proof: L::Proof,
    problem: &Prepared,
    course: &Course,
    table: &Table,
) -> bool {
    if course.inside {
        return true;
    }
    let header = &problem.header;
    let width = L::splat(proof, header.width as i32);
    let height = L::splat(proof, header.height as i32);
    for coarse in [course.coarse[0], course.coarse[course.stride - 1]] {
        let coarse = L::splat(proof, coarse);
        for at in (0..course.steps).step_by(L::COUNT) {
            let moved = moved_steps(proof, problem, table, coarse, at);
            for disc in 0..problem.discs.len() {
                let (x, y) = disc_steps(proof, table, moved, disc * course.steps + at);
                let on = L::both(
                    x.sar(header.cell_bits).less_unsigned(width),
                    y.sar(header.cell_bits).less_unsigned(height),
                );
                if L::bits(on) != u32::MAX >> (32 - L::COUNT) {
                    return false;
                }
            }
        }
    }
    true
}

/// How far one sample has moved at the steps from `at`.
#[inline(always)]
pub fn moved_steps<L: Lanes>(
    proof: L::Proof,
    problem: &Prepared,
    table: &Table,
    coarse: L,
    at: usize,
) -> (L, L) {
    let bits = problem.header.coarse_bits;
    let x = coarse.mul(L::load(proof, &table.x[at..]));
    let y = coarse.mul(L::load(proof, &table.y[at..]));
    (shift_round(proof, x, bits), shift_round(proof, y, bits))
}

/// Where a disc is then.
#[inline(always)]
pub fn disc_steps<L: Lanes>(
    proof: L::Proof,
    table: &Table,
    (moved_x, moved_y): (L, L),
    place: usize,
) -> (L, L) {
    (
        moved_x.add(L::load(proof, &table.disc_x[place..])),
        moved_y.add(L::load(proof, &table.disc_y[place..])),
    )
}

/// Zero in the first lane, one in the second, and so on.
#[inline(always)]
pub fn lane_numbers<L: Lanes>(proof: L::Proof) -> L {
    const NUMBERS: [i32; MOST_LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];
    L::load(proof, &NUMBERS)
}
