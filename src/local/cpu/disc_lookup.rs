//! Looks up the clearance of one disc for a row's samples at some steps.

use super::displacement_table::DisplacementTable;
use super::lanes::Lanes;
use super::soa_inputs::{PAIR, SoaInputs};
use crate::local::QuantizedProblem;

/// A disc and its table. All values of a lookup are copies or separate slices; otherwise the compiler reloads them at
/// each step.
pub struct DiscLookup<'a> {
    /// Columns of the table; all have the same length.
    x: &'a [i32],
    y: &'a [i32],
    across: &'a [i32],
    along: &'a [i32],
    cell: &'a [i32],
    radius: i32,
    /// Shift from a product to a cell.
    bits: u32,
    width: i32,
    units: &'a [u16],
}

impl<'a> DiscLookup<'a> {
    /// A disc of the samples of this table.
    #[inline(always)]
    pub fn new(
        problem: &'a QuantizedProblem,
        inputs: &SoaInputs,
        table: &'a DisplacementTable,
        disc: usize,
    ) -> Self {
        let steps = inputs.steps;
        let first = disc * steps;
        Self {
            x: &table.x_halves[..steps],
            y: &table.y_halves[..steps],
            across: &table.across[first..][..steps],
            along: &table.along[first..][..steps],
            cell: &table.cell[first..][..steps],
            radius: problem.discs[disc].radius,
            bits: problem.header.coarse_bits + problem.header.cell_bits,
            width: problem.header.width as i32,
            units: problem.field.padded_units(),
        }
    }

    /// Lowers the clearances of samples to those of the disc at these steps, which are whole pairs. `coarse` holds the
    /// coarse speeds in both halves of each word.
    #[inline(always)]
    pub fn lower_all<L: Lanes>(
        &self,
        token: L::FeatureToken,
        steps: &[i32],
        coarse: &[i32],
        least: &mut [i32],
    ) {
        let pairs = coarse.len() / (2 * L::COUNT) * (2 * L::COUNT);
        for at in (0..pairs).step_by(2 * L::COUNT) {
            self.lower::<L, 2>(token, steps, &coarse[at..], &mut least[at..]);
        }
        for at in (pairs..coarse.len()).step_by(L::COUNT) {
            self.lower::<L, 1>(token, steps, &coarse[at..], &mut least[at..]);
        }
    }

    /// Lowers the clearances of `N` vectors, which share the loads of each step.
    #[inline(always)]
    fn lower<L: Lanes, const N: usize>(
        &self,
        token: L::FeatureToken,
        steps: &[i32],
        coarse: &[i32],
        least: &mut [i32],
    ) {
        let mut vx_samples = [L::splat(token, 0); N];
        for (vector, vx) in vx_samples.iter_mut().enumerate() {
            *vx = L::load(token, &coarse[vector * L::COUNT..]);
        }
        let mut nearest = [L::splat(token, i32::from(u16::MAX)); N];
        for pair in steps.chunks_exact(PAIR) {
            for &step in pair {
                let step = step as usize;
                let x = L::splat(token, self.x[step]);
                let y = L::splat(token, self.y[step]);
                let across = L::splat(token, self.across[step]);
                let along = L::splat(token, self.along[step]);
                let cell = L::splat(token, self.cell[step]);
                for (vx, nearest) in vx_samples.iter().zip(&mut nearest) {
                    let x = vx.mul_halves(x).add(across);
                    let y = vx.mul_halves(y).add(along);
                    let cell = L::row_major(token, x, y, self.bits, self.width).add(cell);
                    *nearest = nearest.min_dirty_high(cell.gather_dirty_high(self.units));
                }
            }
        }
        let radius = L::splat(token, self.radius);
        for (vector, nearest) in nearest.iter().enumerate() {
            let least = &mut least[vector * L::COUNT..];
            let clearance = nearest.mask_high().sub(radius);
            clearance.min(L::load(token, least)).store(least);
        }
    }
}
