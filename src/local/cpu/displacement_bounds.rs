//! Bounds of the entries of some displacement tables, for each group of steps.

use super::arithmetic::shift_round;
use super::displacement_table::DisplacementTable;
use super::lanes::{Lanes, MAX_LANES};
use super::min_pyramid::Boxes;
use super::soa_inputs::{GROUPS, SoaInputs};
use crate::local::kernel_inputs::{Header, QuantizedDisc};

/// The groups, and space for one more vector store.
const ROOM: usize = GROUPS + MAX_LANES;

/// Minima and maxima of the entries of a tile's tables. Groups beyond the last repeat it.
#[derive(Debug, Default)]
pub struct DisplacementBounds {
    /// For x, y and each disc's x and y.
    columns: Vec<ColumnBounds>,
    /// Minima and maxima of one column by step, padded.
    min: Vec<i32>,
    max: Vec<i32>,
}

/// Bounds of one column of the tables.
#[derive(Clone, Copy, Debug)]
struct ColumnBounds {
    min: [i32; ROOM],
    max: [i32; ROOM],
}

impl Default for ColumnBounds {
    fn default() -> Self {
        Self { min: [0; ROOM], max: [0; ROOM] }
    }
}

impl DisplacementBounds {
    /// Computes the bounds of these tables.
    #[inline(always)]
    pub fn fill<L: Lanes>(
        &mut self,
        token: L::FeatureToken,
        inputs: &SoaInputs,
        discs: &[QuantizedDisc],
        tables: &[DisplacementTable],
    ) {
        for list in [&mut self.min, &mut self.max] {
            list.resize(inputs.steps + inputs.group as usize, 0);
        }
        self.columns.resize(2 + 2 * discs.len(), ColumnBounds::default());
        for number in 0..self.columns.len() {
            if number >= 2 && inputs.is_fixed(&discs[number / 2 - 1]) {
                let place = column(&tables[0], inputs, number)[0];
                self.columns[number].min.fill(place);
                self.columns[number].max.fill(place);
                continue;
            }
            self.merge_tables::<L>(token, inputs, number, tables);
            self.reduce_groups::<L>(token, inputs, number);
        }
    }

    /// The boxes of cells of a disc's centre for speeds between these two, for the groups from `at`.
    #[inline(always)]
    pub fn boxes<L: Lanes>(
        &self,
        token: L::FeatureToken,
        header: &Header,
        vx_samples: [i32; 2],
        disc: usize,
        at: usize,
    ) -> Boxes<L> {
        let [x, y] = [&self.columns[0], &self.columns[1]];
        let [disc_x, disc_y] = [&self.columns[2 + 2 * disc], &self.columns[3 + 2 * disc]];
        Boxes {
            columns: cells::<L>(token, header, vx_samples, (x, disc_x), at),
            rows: cells::<L>(token, header, vx_samples, (y, disc_y), at),
        }
    }

    /// Minima and maxima over all tables, step by step.
    #[inline(always)]
    fn merge_tables<L: Lanes>(
        &mut self,
        token: L::FeatureToken,
        inputs: &SoaInputs,
        number: usize,
        tables: &[DisplacementTable],
    ) {
        for at in (0..inputs.steps).step_by(L::COUNT) {
            let mut min = L::splat(token, i32::MAX);
            let mut max = L::splat(token, i32::MIN);
            for table in tables {
                let entries = L::load(token, &column(table, inputs, number)[at..]);
                min = min.min(entries);
                max = max.max(entries);
            }
            min.store(&mut self.min[at..]);
            max.store(&mut self.max[at..]);
        }
        // The last group may extend beyond the last step.
        for list in [&mut self.min, &mut self.max] {
            let last = list[inputs.steps - 1];
            list[inputs.steps..].fill(last);
        }
    }

    /// Minima and maxima over the steps of each group.
    #[inline(always)]
    fn reduce_groups<L: Lanes>(
        &mut self,
        token: L::FeatureToken,
        inputs: &SoaInputs,
        number: usize,
    ) {
        let bounds = &mut self.columns[number];
        let mut groups = 0;
        for at in (0..inputs.steps).step_by(L::COUNT) {
            let mut min = L::load(token, &self.min[at..]);
            let mut max = L::load(token, &self.max[at..]);
            for later in 1..inputs.group as usize {
                min = min.min(L::load(token, &self.min[at + later..]));
                max = max.max(L::load(token, &self.max[at + later..]));
            }
            let group_starts = L::load(token, &inputs.group_starts[at..]).equal(L::splat(token, 1));
            L::compress(group_starts, min, &mut bounds.min[groups..]);
            groups += L::compress(group_starts, max, &mut bounds.max[groups..]);
        }
        for list in [&mut bounds.min, &mut bounds.max] {
            let last = list[groups - 1];
            list[groups..GROUPS].fill(last);
        }
    }
}

/// Column `number` of a table.
#[inline(always)]
fn column<'a>(table: &'a DisplacementTable, inputs: &SoaInputs, number: usize) -> &'a [i32] {
    let disc = (number / 2).saturating_sub(1) * inputs.steps;
    match number {
        0 => &table.x,
        1 => &table.y,
        even if even % 2 == 0 => &table.disc_x[disc..],
        _ => &table.disc_y[disc..],
    }
}

/// The first and last columns, or rows, for displacements in the first bounds from positions in the second.
#[inline(always)]
fn cells<L: Lanes>(
    token: L::FeatureToken,
    header: &Header,
    vx_samples: [i32; 2],
    (displacement, disc_bounds): (&ColumnBounds, &ColumnBounds),
    at: usize,
) -> (L, L) {
    let (slowest, fastest) = (L::splat(token, vx_samples[0]), L::splat(token, vx_samples[1]));
    let min = L::load(token, &displacement.min[at..]);
    let max = L::load(token, &displacement.max[at..]);
    let [one, two] = [slowest.mul(min), fastest.mul(min)];
    let [three, four] = [slowest.mul(max), fastest.mul(max)];
    let first = one.min(two).min(three.min(four));
    let last = one.max(two).max(three.max(four));
    (
        cell::<L>(token, header, first, &disc_bounds.min[at..]),
        cell::<L>(token, header, last, &disc_bounds.max[at..]),
    )
}

/// The column or row for a product of a coarse speed and a displacement.
#[inline(always)]
fn cell<L: Lanes>(token: L::FeatureToken, header: &Header, product: L, disc_bounds: &[i32]) -> L {
    shift_round(token, product, header.coarse_bits)
        .add(L::load(token, disc_bounds))
        .sar(header.cell_bits)
}
