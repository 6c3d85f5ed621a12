//! What one disc of a row's samples meets at some of the steps.

use super::course::Course;
use super::lanes::Lanes;
use super::table::Table;
use crate::local::Prepared;

/// Steps that are looked at together: lists of them are filled up to whole pairs.
pub const PAIR: usize = 2;

/// A disc and where it is looked up. All that a lookup takes is here by value or as a slice of its own, or compilers
/// read it again for each step.
pub struct Looked<'a> {
    /// Of the table; all of one length.
    x: &'a [i32],
    y: &'a [i32],
    across: &'a [i32],
    along: &'a [i32],
    cell: &'a [i32],
    radius: i32,
    /// From a product to a cell.
    bits: u32,
    width: i32,
    units: &'a [u16],
}

impl<'a> Looked<'a> {
    /// A disc of the samples with this table.
    #[inline(always)]
    pub fn new(problem: &'a Prepared, course: &Course, table: &'a Table, disc: usize) -> Self {
        let steps = course.steps;
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

    /// Lowers the clearances of samples, whose coarse speeds are in both halves of these words, to what the disc meets
    /// at these steps, whole pairs of them.
    #[inline(always)]
    pub fn lower_all<L: Lanes>(
        &self,
        proof: L::Proof,
        steps: &[i32],
        coarse: &[i32],
        least: &mut [i32],
    ) {
        let pairs = coarse.len() / (2 * L::COUNT) * (2 * L::COUNT);
        for at in (0..pairs).step_by(2 * L::COUNT) {
            self.lower::<L, 2>(proof, steps, &coarse[at..], &mut least[at..]);
        }
        for at in (pairs..coarse.len()).step_by(L::COUNT) {
            self.lower::<L, 1>(proof, steps, &coarse[at..], &mut least[at..]);
        }
    }

    /// The same for some vectors, which share what is read for each step.
    #[inline(always)]
    fn lower<L: Lanes, const N: usize>(
        &self,
        proof: L::Proof,
        steps: &[i32],
        coarse: &[i32],
        least: &mut [i32],
    ) {
        let mut speeds = [L::splat(proof, 0); N];
        for (vector, speed) in speeds.iter_mut().enumerate() {
            *speed = L::load(proof, &coarse[vector * L::COUNT..]);
        }
        let mut nearest = [L::splat(proof, i32::from(u16::MAX)); N];
        for pair in steps.chunks_exact(PAIR) {
            for &step in pair {
                let step = step as usize;
                let x = L::splat(proof, self.x[step]);
                let y = L::splat(proof, self.y[step]);
                let across = L::splat(proof, self.across[step]);
                let along = L::splat(proof, self.along[step]);
                let cell = L::splat(proof, self.cell[step]);
                for (speed, nearest) in speeds.iter().zip(&mut nearest) {
                    let x = speed.mul_halves(x).add(across);
                    let y = speed.mul_halves(y).add(along);
                    let cell = L::row_major(proof, x, y, self.bits, self.width).add(cell);
                    *nearest = nearest.min_loose(cell.gather_loose(self.units));
                }
            }
        }
        let radius = L::splat(proof, self.radius);
        for (vector, nearest) in nearest.iter().enumerate() {
            let least = &mut least[vector * L::COUNT..];
            let clearance = nearest.tighten().sub(radius);
            clearance.min(L::load(proof, least)).store(least);
        }
    }
}
