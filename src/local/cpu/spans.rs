//! Between what bounds the entries of some tables lie, group of steps by group of steps.

use super::arithmetic::shift_round;
use super::course::Course;
use super::lanes::{Lanes, MOST_LANES};
use super::pooled::Boxes;
use super::table::Table;
use crate::local::inputs::{BodyDisc, Header};

/// At most so many groups of steps, whole vectors.
pub const GROUPS: usize = 2 * MOST_LANES;

/// Groups, and a vector written behind them.
const ROOM: usize = GROUPS + MOST_LANES;

/// The least and the greatest entries of a tile's tables. Groups beyond the last are as the last.
#[derive(Debug, Default)]
pub struct Spans {
    /// For x, y and each disc's x and y.
    columns: Vec<Span>,
    /// Of one column by step, and room behind.
    least: Vec<i32>,
    most: Vec<i32>,
}

/// Of one column of the tables.
#[derive(Clone, Copy, Debug)]
struct Span {
    least: [i32; ROOM],
    most: [i32; ROOM],
}

impl Default for Span {
    fn default() -> Self {
        Self {
            least: [0; ROOM],
            most: [0; ROOM],
        }
    }
}

impl Spans {
    /// Looks through the tables.
    #[inline(always)]
    pub fn fill<L: Lanes>(
        &mut self,
        proof: L::Proof,
        course: &Course,
        discs: &[BodyDisc],
        tables: &[Table],
    ) {
        for list in [&mut self.least, &mut self.most] {
            list.resize(course.steps + course.group as usize, 0);
        }
        self.columns.resize(2 + 2 * discs.len(), Span::default());
        for number in 0..self.columns.len() {
            if number >= 2 && discs[number / 2 - 1].is_central() {
                let place = column(&tables[0], course, number)[0];
                self.columns[number].least.fill(place);
                self.columns[number].most.fill(place);
                continue;
            }
            self.merge::<L>(proof, course, number, tables);
            self.group::<L>(proof, course, number);
        }
    }

    /// The boxes of cells that a disc is in with speeds between these two, for the groups from `at`.
    #[inline(always)]
    pub fn boxes<L: Lanes>(
        &self,
        proof: L::Proof,
        header: &Header,
        speeds: [i32; 2],
        disc: usize,
        at: usize,
    ) -> Boxes<L> {
        let [x, y] = [&self.columns[0], &self.columns[1]];
        let [disc_x, disc_y] = [&self.columns[2 + 2 * disc], &self.columns[3 + 2 * disc]];
        Boxes {
            columns: cells::<L>(proof, header, speeds, (x, disc_x), at),
            rows: cells::<L>(proof, header, speeds, (y, disc_y), at),
        }
    }

    /// The least and the greatest of all tables, step by step.
    #[inline(always)]
    fn merge<L: Lanes>(
        &mut self,
        proof: L::Proof,
        course: &Course,
        number: usize,
        tables: &[Table],
    ) {
        for at in (0..course.steps).step_by(L::COUNT) {
            let mut least = L::splat(proof, i32::MAX);
            let mut most = L::splat(proof, i32::MIN);
            for table in tables {
                let entries = L::load(proof, &column(table, course, number)[at..]);
                least = least.min(entries);
                most = most.max(entries);
            }
            least.store(&mut self.least[at..]);
            most.store(&mut self.most[at..]);
        }
        // The last group may be longer than what is left.
        for list in [&mut self.least, &mut self.most] {
            let last = list[course.steps - 1];
            list[course.steps..].fill(last);
        }
    }

    /// The least and the greatest of all steps of each group.
    #[inline(always)]
    fn group<L: Lanes>(&mut self, proof: L::Proof, course: &Course, number: usize) {
        let span = &mut self.columns[number];
        let mut groups = 0;
        for at in (0..course.steps).step_by(L::COUNT) {
            let mut least = L::load(proof, &self.least[at..]);
            let mut most = L::load(proof, &self.most[at..]);
            for later in 1..course.group as usize {
                least = least.min(L::load(proof, &self.least[at + later..]));
                most = most.max(L::load(proof, &self.most[at + later..]));
            }
            let begins = L::load(proof, &course.begins[at..]).equal(L::splat(proof, 1));
            L::compress(begins, least, &mut span.least[groups..]);
            groups += L::compress(begins, most, &mut span.most[groups..]);
        }
        for group in groups..GROUPS {
            span.least[group] = span.least[groups - 1];
            span.most[group] = span.most[groups - 1];
        }
    }
}

/// Column `number` of a table.
#[inline(always)]
fn column<'a>(table: &'a Table, course: &Course, number: usize) -> &'a [i32] {
    let disc = (number / 2).saturating_sub(1) * course.steps;
    match number {
        0 => &table.x,
        1 => &table.y,
        even if even % 2 == 0 => &table.disc_x[disc..],
        _ => &table.disc_y[disc..],
    }
}

/// The first and the last columns, or rows, for displacements in the first span from places in the second.
#[inline(always)]
fn cells<L: Lanes>(
    proof: L::Proof,
    header: &Header,
    speeds: [i32; 2],
    (moved, standing): (&Span, &Span),
    at: usize,
) -> (L, L) {
    let (slowest, fastest) = (L::splat(proof, speeds[0]), L::splat(proof, speeds[1]));
    let least = L::load(proof, &moved.least[at..]);
    let most = L::load(proof, &moved.most[at..]);
    let [one, two] = [slowest.mul(least), fastest.mul(least)];
    let [three, four] = [slowest.mul(most), fastest.mul(most)];
    let first = one.min(two).min(three.min(four));
    let last = one.max(two).max(three.max(four));
    (
        cell::<L>(proof, header, first, &standing.least[at..]),
        cell::<L>(proof, header, last, &standing.most[at..]),
    )
}

/// The column or row for a product of a coarse speed and a displacement.
#[inline(always)]
fn cell<L: Lanes>(proof: L::Proof, header: &Header, product: L, standing: &[i32]) -> L {
    shift_round(proof, product, header.coarse_bits)
        .add(L::load(proof, standing))
        .sar(header.cell_bits)
}
