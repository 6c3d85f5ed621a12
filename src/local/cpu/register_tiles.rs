//! Looks up clearances in register tiles: copies of small squares of the field.
//!
//! A register tile applies if the cells of all samples of a chunk, in all rows of a tile and for some steps, lie in one
//! small square. Two registers hold 64 cells and are much faster than memory.

use core::ops::{Range, RangeInclusive};

use super::clearance_bounds::StepGroups;
use super::displacement_table::DisplacementTable;
use super::lanes::{LARGE_TILE, Lanes, SMALL_TILE};
use super::min_pyramid::{Boxes, MinPyramid};
use super::soa_inputs::{GROUPS, SoaInputs};
use super::step_pruning::SampleTile;
use crate::local::kernel_inputs::Header;

/// Shifts from a product to a cell for which [`Lanes::look_up`] works.
const BITS: RangeInclusive<u32> = 20..=28;

/// Shift from a product to a cell.
const fn product_bits(header: &Header) -> u32 {
    header.coarse_bits + header.cell_bits
}

/// The samples that share a list of groups of steps.
#[derive(Clone, Debug)]
pub struct SampleList {
    /// Number of the list.
    pub number: usize,
    /// Number of the disc.
    pub disc: usize,
    /// Range of samples in a row.
    pub samples: Range<usize>,
}

/// The cells visited by each list, and working memory.
#[derive(Debug, Default)]
pub struct RegisterTiles {
    /// Whether register tiles apply to the problem.
    pub applies: bool,
    /// For each list and group of steps: first columns, last columns, first rows, last rows.
    visited: Vec<[[i32; GROUPS]; 4]>,
    /// Groups that share a register tile.
    batch: StepGroups,
    /// Number of register tiles looked up so far.
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
    fn union(self, other: Self) -> Self {
        Self { columns: union(self.columns, other.columns), rows: union(self.rows, other.rows) }
    }

    #[inline(always)]
    const fn fit(self, side: usize) -> bool {
        let side = side as i32;
        self.columns[1] - self.columns[0] < side && self.rows[1] - self.rows[0] < side
    }
}

#[inline(always)]
fn union(one: [i32; 2], other: [i32; 2]) -> [i32; 2] {
    [one[0].min(other[0]), one[1].max(other[1])]
}

impl RegisterTiles {
    /// Prepares for a tile of samples.
    pub fn begin(&mut self, tile: &SampleTile<'_>) {
        let header = &tile.problem.header;
        // One row alone would be looked up twice.
        self.applies = BITS.contains(&product_bits(header)) && tile.tables.len() > 1;
        self.visited.resize(tile.lists(), [[0; GROUPS]; 4]);
    }

    /// Stores the cells that a list's samples visit, for the groups from `at`.
    #[inline(always)]
    pub fn store_visited<L: Lanes>(&mut self, list: usize, at: usize, visited: Boxes<L>) {
        let [first_columns, last_columns, first_rows, last_rows] = &mut self.visited[list];
        visited.columns.0.store(&mut first_columns[at..]);
        visited.columns.1.store(&mut last_columns[at..]);
        visited.rows.0.store(&mut first_rows[at..]);
        visited.rows.1.store(&mut last_rows[at..]);
    }

    /// Lowers the clearances of a list's samples with its disc's lookups in these groups of steps. Groups whose cells
    /// exceed a register tile go to `remaining`.
    #[inline(always)]
    pub fn lower<L: Lanes>(
        &mut self,
        token: L::FeatureToken,
        (tile, pyramid): (&SampleTile<'_>, &MinPyramid),
        list: &SampleList,
        groups: &[i32],
        clearances: &mut [i32],
        remaining: &mut StepGroups,
    ) {
        remaining.clear();
        self.batch.clear();
        let mut all = Cells { columns: [0; 2], rows: [0; 2] };
        let mut groups = groups.iter();
        loop {
            let group = groups.next().copied();
            let here = group.map(|group| (group, self.visited(list.number, group)));
            if let Some((group, here)) = here {
                if !here.fit(L::LARGEST_REGISTER_TILE) {
                    remaining.push(group);
                    continue;
                }
                let both = if self.batch.as_slice().is_empty() { here } else { all.union(here) };
                if both.fit(L::LARGEST_REGISTER_TILE) {
                    all = both;
                    self.batch.push(group);
                    continue;
                }
            }
            // The next group does not fit, or there is none. This call stays the only one, because the inlined code is
            // large.
            self.look_up_batch::<L>(token, (tile, pyramid), list, all, clearances);
            let Some((group, here)) = here else {
                return;
            };
            all = here;
            self.batch.push(group);
        }
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

    /// Looks up the groups that share a register tile.
    #[inline(always)]
    fn look_up_batch<L: Lanes>(
        &mut self,
        token: L::FeatureToken,
        (tile, pyramid): (&SampleTile<'_>, &MinPyramid),
        list: &SampleList,
        cells: Cells,
        clearances: &mut [i32],
    ) {
        if self.batch.as_slice().is_empty() {
            return;
        }
        #[cfg(test)]
        {
            self.looked_up += 1;
        }
        if L::LARGEST_REGISTER_TILE == SMALL_TILE || cells.fit(SMALL_TILE) {
            self.look_up_rows::<L, { SMALL_TILE }>(token, (tile, pyramid), list, cells, clearances);
        } else {
            self.look_up_rows::<L, { LARGE_TILE }>(token, (tile, pyramid), list, cells, clearances);
        }
        self.batch.clear();
    }

    /// Looks up the steps, for two rows at a time.
    #[inline(always)]
    fn look_up_rows<L: Lanes, const SIDE: usize>(
        &mut self,
        token: L::FeatureToken,
        (tile, pyramid): (&SampleTile<'_>, &MinPyramid),
        list: &SampleList,
        cells: Cells,
        clearances: &mut [i32],
    ) {
        let SampleTile { problem, inputs, .. } = *tile;
        let header = &problem.header;
        let square = pyramid.square(cells.columns[0], cells.rows[0]);
        let register_tile = L::register_tile::<SIDE>(token, &square);
        let bits = product_bits(header);
        let radius = L::splat(token, problem.discs[list.disc].radius);
        let Range { start, end } = list.samples;
        for row in (0..tile.tables.len()).step_by(2) {
            let last = (row + 1).min(tile.tables.len() - 1);
            let two = PairedLookup::new(inputs, &tile.tables[row], &tile.tables[last], list.disc);
            let (row, last) = (row * inputs.stride, last * inputs.stride);
            for at in (start..end).step_by(L::COUNT) {
                let vx = L::load(token, &inputs.coarse_twice[at..]);
                let groups = (self.batch.as_slice(), inputs);
                let both = two.nearest::<L, SIDE>(token, &register_tile, groups, vx, bits);
                lower(token, both.mask_high().sub(radius), &mut clearances[row + at..]);
                lower(token, both.shr(16).sub(radius), &mut clearances[last + at..]);
            }
        }
    }
}

#[inline(always)]
fn lower<L: Lanes>(token: L::FeatureToken, clearance: L, clearances: &mut [i32]) {
    clearance.min(L::load(token, clearances)).store(clearances);
}

/// The positions of one disc in two rows, in the scale of the products, modulo 2^32. This keeps columns and rows modulo
/// the side of a register tile.
struct PairedLookup<'a> {
    one: Positions<'a>,
    other: Positions<'a>,
}

/// Columns by step; all have the same length.
struct Positions<'a> {
    /// Coarse displacements as two 16-bit numbers.
    moved: [&'a [i32]; 2],
    /// Positions for a robot that does not translate.
    standing: [&'a [i32]; 2],
}

impl<'a> Positions<'a> {
    #[inline(always)]
    fn new(inputs: &SoaInputs, table: &'a DisplacementTable, disc: usize) -> Self {
        let steps = inputs.steps;
        let first = disc * steps;
        Self {
            moved: [&table.x_halves[..steps], &table.y_halves[..steps]],
            standing: [&table.x_scaled[first..][..steps], &table.y_scaled[first..][..steps]],
        }
    }

    /// Positions at a step for samples with these coarse speeds.
    #[inline(always)]
    fn at<L: Lanes>(&self, token: L::FeatureToken, step: usize, vx: L) -> (L, L) {
        let x = L::splat(token, self.moved[0][step]);
        let y = L::splat(token, self.moved[1][step]);
        let across = L::splat(token, self.standing[0][step]);
        let along = L::splat(token, self.standing[1][step]);
        (vx.mul_halves(x).add(across), vx.mul_halves(y).add(along))
    }
}

impl<'a> PairedLookup<'a> {
    /// Combines two tables.
    #[inline(always)]
    pub fn new(
        inputs: &SoaInputs,
        one: &'a DisplacementTable,
        other: &'a DisplacementTable,
        disc: usize,
    ) -> Self {
        Self { one: Positions::new(inputs, one, disc), other: Positions::new(inputs, other, disc) }
    }

    /// The smallest entries at the steps of some groups, the first row in the lower halves of the lanes.
    #[inline(always)]
    pub fn nearest<L: Lanes, const SIDE: usize>(
        &self,
        token: L::FeatureToken,
        register_tile: &L::RegisterTile,
        (groups, inputs): (&[i32], &SoaInputs),
        vx: L,
        bits: u32,
    ) -> L {
        let mut nearest = L::splat(token, -1);
        for &group in groups {
            for step in inputs.steps_of(group) {
                let one = self.one.at(token, step, vx);
                let other = self.other.at(token, step, vx);
                let entries = L::look_up::<SIDE>(token, register_tile, one, other, bits);
                nearest = nearest.min_halves(entries);
            }
        }
        nearest
    }
}
