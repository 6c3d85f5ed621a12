//! Where all samples of a chunk, in all rows of a tile and for some steps, are within one small square of the field, a copy
//! of it is looked up instead: two registers hold 64 cells, and are much nearer than memory.

use core::ops::Range;

use super::course::Course;
use super::lanes::{Lanes, Patch};
use super::pooled::Boxes;
use super::sieve::{Tile, steps_of};
use super::spans::GROUPS;
use super::table::Table;
use crate::local::Prepared;
use crate::local::inputs::Header;

/// The bits from a product to a cell with which places in a patch are found ([`Lanes::look_up`]).
const BITS: core::ops::RangeInclusive<u32> = 20..=28;

/// Whether there can be patches at all.
pub fn can_be(problem: &Prepared) -> bool {
    let header = &problem.header;
    let [_, side] = Patch::SIDES;
    BITS.contains(&product_bits(header)) && header.width.min(header.height) >= side as u32
}

/// From a product to a cell.
const fn product_bits(header: &Header) -> u32 {
    header.coarse_bits + header.cell_bits
}

/// The samples that a list of groups of steps is for.
#[derive(Clone, Debug)]
pub struct Listed {
    /// Which list.
    pub number: usize,
    /// Of which disc.
    pub disc: usize,
    /// Of a row.
    pub samples: Range<usize>,
}

/// Where chunks are, and room for the work.
#[derive(Debug, Default)]
pub struct Patches {
    /// For each list and group of steps: first columns, last columns, first rows, last rows.
    visited: Vec<[[i32; GROUPS]; 4]>,
    patch: Patch,
    /// Groups that share a patch.
    run: Vec<i32>,
    steps: Vec<i32>,
    /// How many patches were looked up so far.
    #[cfg(test)]
    pub looked_up: usize,
}

/// A rectangle of cells: first and last column, first and last row.
#[derive(Clone, Copy)]
struct Cells {
    columns: [i32; 2],
    rows: [i32; 2],
}

impl Cells {
    #[inline(always)]
    fn with(self, other: Self) -> Self {
        Self {
            columns: around(self.columns, other.columns),
            rows: around(self.rows, other.rows),
        }
    }

    #[inline(always)]
    const fn fit(self, side: usize) -> bool {
        let side = side as i32;
        self.columns[1] - self.columns[0] < side && self.rows[1] - self.rows[0] < side
    }
}

#[inline(always)]
fn around(one: [i32; 2], other: [i32; 2]) -> [i32; 2] {
    [one[0].min(other[0]), one[1].max(other[1])]
}

impl Patches {
    /// Makes room.
    pub fn resize(&mut self, lists: usize) {
        self.visited.resize(lists, [[0; GROUPS]; 4]);
        self.run.reserve(GROUPS);
    }

    /// Takes note of the cells that a list's samples visit, for the groups from `at`.
    #[inline(always)]
    pub fn note<L: Lanes>(&mut self, list: usize, at: usize, visited: Boxes<L>) {
        let [first_columns, last_columns, first_rows, last_rows] = &mut self.visited[list];
        visited.columns.0.store(&mut first_columns[at..]);
        visited.columns.1.store(&mut last_columns[at..]);
        visited.rows.0.store(&mut first_rows[at..]);
        visited.rows.1.store(&mut last_rows[at..]);
    }

    /// Lowers the clearances of a list's samples to what its disc meets in these groups of steps, but for those in which
    /// the samples are too far apart: they become the rest.
    #[inline(always)]
    pub fn lower<L: Lanes>(
        &mut self,
        proof: L::Proof,
        tile: &Tile<'_>,
        list: &Listed,
        groups: &[i32],
        least: &mut [i32],
        rest: &mut Vec<i32>,
    ) {
        let [_, side] = Patch::SIDES;
        rest.clear();
        self.run.clear();
        let mut all = Cells {
            columns: [0; 2],
            rows: [0; 2],
        };
        for &group in groups {
            let here = self.visited(list.number, group);
            if !here.fit(side) {
                rest.push(group);
                continue;
            }
            let both = if self.run.is_empty() {
                here
            } else {
                all.with(here)
            };
            if both.fit(side) {
                all = both;
            } else {
                self.finish_run::<L>(proof, tile, list, all, least);
                all = here;
            }
            self.run.push(group);
        }
        self.finish_run::<L>(proof, tile, list, all, least);
    }

    #[inline(always)]
    fn visited(&self, list: usize, group: i32) -> Cells {
        let [first_columns, last_columns, first_rows, last_rows] = &self.visited[list];
        let group = group as usize % GROUPS;
        Cells {
            columns: [first_columns[group], last_columns[group]],
            rows: [first_rows[group], last_rows[group]],
        }
    }

    /// Looks at the groups that share a patch.
    #[inline(always)]
    fn finish_run<L: Lanes>(
        &mut self,
        proof: L::Proof,
        tile: &Tile<'_>,
        list: &Listed,
        cells: Cells,
        least: &mut [i32],
    ) {
        if self.run.is_empty() {
            return;
        }
        #[cfg(test)]
        {
            self.looked_up += 1;
        }
        steps_of(tile.course, &self.run, &mut self.steps);
        self.run.clear();
        if cells.fit(8) {
            self.look::<L, 8>(proof, tile, list, cells, least);
        } else {
            self.look::<L, 16>(proof, tile, list, cells, least);
        }
    }

    /// Looks the steps up, for two rows at a time.
    #[inline(always)]
    fn look<L: Lanes, const SIDE: usize>(
        &mut self,
        proof: L::Proof,
        tile: &Tile<'_>,
        list: &Listed,
        cells: Cells,
        least: &mut [i32],
    ) {
        let Tile {
            problem, course, ..
        } = *tile;
        let header = &problem.header;
        // At the field's ends a patch begins before the cells.
        let column = cells.columns[0].min(header.width as i32 - SIDE as i32);
        let row = cells.rows[0].min(header.height as i32 - SIDE as i32);
        let width = header.width as usize;
        let corner = row as usize * width + column as usize;
        self.patch
            .copy::<SIDE>(problem.field.padded_units(), corner, width);
        let bits = product_bits(header);
        let corner = [column.wrapping_shl(bits), row.wrapping_shl(bits)];
        let radius = L::splat(proof, problem.discs[list.disc].radius);
        let coarse = &course.coarse_twice[list.samples.clone()];
        let rows = least.chunks_mut(2 * course.stride);
        for (tables, least) in tile.tables.chunks(2).zip(rows) {
            let two = TwoRows::new(course, tables, list.disc, corner);
            let (one, other) = least.split_at_mut(course.stride);
            let one = &mut one[list.samples.clone()];
            let mut other = other.get_mut(list.samples.clone());
            for at in (0..coarse.len()).step_by(L::COUNT) {
                let speed = L::load(proof, &coarse[at..]);
                let both = two.nearest::<L, SIDE>(proof, &self.patch, &self.steps, speed, bits);
                lower(proof, both.tighten().sub(radius), &mut one[at..]);
                if let Some(other) = &mut other {
                    lower(proof, both.shr(16).sub(radius), &mut other[at..]);
                }
            }
        }
    }
}

/// The positions of one disc in two rows, from a patch's corner and in the product's scale: what is beyond 32 bits is
/// cut off, for no sum is.
struct TwoRows<'a> {
    one: Positions<'a>,
    other: Positions<'a>,
    corner: [i32; 2],
}

/// By step, all of one length.
struct Positions<'a> {
    /// Coarse displacements as two numbers of 16 bits.
    moved: [&'a [i32]; 2],
    /// For a robot that did not move.
    standing: [&'a [i32]; 2],
}

impl<'a> Positions<'a> {
    #[inline(always)]
    fn new(course: &Course, table: &'a Table, disc: usize) -> Self {
        let steps = course.steps;
        let first = disc * steps;
        Self {
            moved: [&table.x_halves[..steps], &table.y_halves[..steps]],
            standing: [
                &table.x_scaled[first..][..steps],
                &table.y_scaled[first..][..steps],
            ],
        }
    }

    /// At a step, for samples with these coarse speeds.
    #[inline(always)]
    fn at<L: Lanes>(&self, proof: L::Proof, step: usize, corner: [i32; 2], speed: L) -> (L, L) {
        let x = L::splat(proof, self.moved[0][step]);
        let y = L::splat(proof, self.moved[1][step]);
        let across = self.standing[0][step].wrapping_sub(corner[0]);
        let along = self.standing[1][step].wrapping_sub(corner[1]);
        (
            speed.mul_halves(x).add(L::splat(proof, across)),
            speed.mul_halves(y).add(L::splat(proof, along)),
        )
    }
}

impl<'a> TwoRows<'a> {
    /// Of two tables, or of one, which is then looked up twice.
    #[inline(always)]
    fn new(course: &Course, tables: &'a [Table], disc: usize, corner: [i32; 2]) -> Self {
        Self {
            one: Positions::new(course, &tables[0], disc),
            other: Positions::new(course, &tables[tables.len() - 1], disc),
            corner,
        }
    }

    /// The smallest entries at some steps, of the first row in the lower halves of the lanes.
    #[inline(always)]
    fn nearest<L: Lanes, const SIDE: usize>(
        &self,
        proof: L::Proof,
        patch: &Patch,
        steps: &[i32],
        speed: L,
        bits: u32,
    ) -> L {
        let mut nearest = L::splat(proof, -1);
        for &step in steps {
            let step = step as usize;
            let one = self.one.at(proof, step, self.corner, speed);
            let other = self.other.at(proof, step, self.corner, speed);
            let entries = L::look_up::<SIDE>(proof, patch, one, other, bits);
            nearest = nearest.min_halves(entries);
        }
        nearest
    }
}

#[inline(always)]
fn lower<L: Lanes>(proof: L::Proof, clearance: L, least: &mut [i32]) {
    clearance.min(L::load(proof, least)).store(least);
}
