//! Looking one disc of two rows' samples up in a patch: places are words of 16 bits, so a vector of them is two rows.

use super::course::Course;
use super::lanes::Lanes;
use super::table::Table;

/// The positions of one disc in two rows, in the scale of products: what is beyond 32 bits is cut off, which leaves
/// columns and rows modulo the side of a patch as they are.
pub struct TwoRows<'a> {
    one: Positions<'a>,
    other: Positions<'a>,
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
    fn at<L: Lanes>(&self, proof: L::Proof, step: usize, speed: L) -> (L, L) {
        let x = L::splat(proof, self.moved[0][step]);
        let y = L::splat(proof, self.moved[1][step]);
        let across = L::splat(proof, self.standing[0][step]);
        let along = L::splat(proof, self.standing[1][step]);
        (
            speed.mul_halves(x).add(across),
            speed.mul_halves(y).add(along),
        )
    }
}

impl<'a> TwoRows<'a> {
    /// Of two tables.
    #[inline(always)]
    pub fn new(course: &Course, one: &'a Table, other: &'a Table, disc: usize) -> Self {
        Self {
            one: Positions::new(course, one, disc),
            other: Positions::new(course, other, disc),
        }
    }

    /// The smallest entries at the steps of some groups, of the first row in the lower halves of the lanes.
    #[inline(always)]
    pub fn nearest<L: Lanes, const SIDE: usize>(
        &self,
        proof: L::Proof,
        patch: &L::Patch,
        (groups, course): (&[i32], &Course),
        speed: L,
        bits: u32,
    ) -> L {
        let mut nearest = L::splat(proof, -1);
        for &group in groups {
            for step in course.steps_of(group) {
                let one = self.one.at(proof, step, speed);
                let other = self.other.at(proof, step, speed);
                let entries = L::look_up::<SIDE>(proof, patch, one, other, bits);
                nearest = nearest.min_halves(entries);
            }
        }
        nearest
    }
}
