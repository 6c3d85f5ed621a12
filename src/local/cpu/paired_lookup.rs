//! Looks up one disc of two rows in a register tile: indices have 16 bits, so one vector holds two rows.

use super::displacement_table::DisplacementTable;
use super::lanes::Lanes;
use super::soa_inputs::SoaInputs;

/// The positions of one disc in two rows, in the scale of the products, modulo 2^32. This keeps columns and rows modulo
/// the side of a register tile.
pub struct PairedLookup<'a> {
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
