//! Which steps can matter to a tile of neighbouring samples, a few speeds of a few turn rates; the others change no bit
//! and are left out.
//!
//! The distance field is 1-Lipschitz between cell centres. So the clearance of one sample of a tile, the middle one,
//! bounds that of all others at the same step: they differ by no more than the samples are apart, and a cell's diagonal. The
//! smallest upper bound of any step is above every sample's smallest clearance or equal to it, and a step whose lower
//! bound is not below that cannot lower it.
//!
//! This is for trajectories that cannot leave the field and that are judged by their smallest clearance: there the
//! order of the steps does not matter.

use super::course::Course;
use super::lanes::{Lanes, MOST_LANES};
use super::moving::Moving;
use super::table::{Table, lane_numbers, stays_inside};
use crate::local::Prepared;

/// With more slack than this at the last step, cells, sifting costs more than it saves: with one disc and cheap gathers, and
/// otherwise.
const MOST_SLACK_CELLS: (f64, f64) = (4.0, 12.0);

/// Steps that are looked at together.
pub const GROUP: usize = 2;

/// What one row needs, and room for it.
#[derive(Debug, Default)]
pub struct Sieve {
    /// Whether the last tile was sifted.
    is_sifted: bool,
    /// For each chunk and disc the steps that can matter, in whole groups; each has room for all.
    picks: Vec<i32>,
    /// How many picks there are.
    counts: Vec<usize>,
    /// For each chunk the smallest upper bound of the clearance.
    bounds: Vec<i32>,
    /// Room for the picks of one chunk and disc.
    room: usize,
    /// Of one chunk: for each disc and step the lower bound of the clearance.
    lower: Vec<i32>,
    moving: Moving,
    /// Smallest clearances of the row's samples.
    least: Vec<i32>,
}

impl Sieve {
    /// Smallest clearance of each sample of a row that stays on the field, not above zero where it collides. The row's tile
    /// has been sifted.
    #[inline(always)]
    pub fn clearances<L: Lanes>(
        &mut self,
        proof: L::Proof,
        problem: &Prepared,
        course: &Course,
        table: &Table,
    ) -> &[i32] {
        self.least.resize(course.stride, 0);
        let chunks = course.stride.div_ceil(course.chunk);
        if self.is_sifted {
            for chunk in 0..chunks {
                self.meet_picks::<L>(proof, problem, course, table, chunk);
            }
        } else {
            self.meet_all::<L>(proof, problem, course, table);
        }
        if !problem.obstacles.is_empty() {
            let chunks = course.coarse.chunks(course.chunk);
            for (coarse, least) in chunks.zip(self.least.chunks_mut(course.chunk)) {
                self.moving
                    .lower::<L>(proof, problem, course, table, coarse, least);
            }
        }
        &self.least
    }

    /// Finds the steps that can matter to each chunk of a tile's rows, from the table of the middle row. All chunks at
    /// once: they do not depend on one another, so the processor need not wait for the gathers of one before it begins the
    /// next.
    #[inline(always)]
    pub fn sift<L: Lanes>(
        &mut self,
        proof: L::Proof,
        problem: &Prepared,
        course: &Course,
        table: &Table,
    ) {
        let most_slack = if L::GATHERS_ARE_CHEAP && problem.discs.len() == 1 {
            MOST_SLACK_CELLS.0
        } else {
            MOST_SLACK_CELLS.1
        };
        self.is_sifted = course.in_any_order
            && course.most_slack_cells <= most_slack
            && stays_inside::<L>(proof, problem, course, table);
        if !self.is_sifted {
            return;
        }
        let discs = problem.discs.len();
        let chunks = course.stride.div_ceil(course.chunk);
        self.room = course.steps + MOST_LANES + GROUP;
        self.bounds.resize(chunks, 0);
        self.counts.resize(chunks * discs, 0);
        self.picks.resize(chunks * discs * self.room, 0);
        self.lower.resize(course.steps * discs, 0);
        let cap = L::splat(proof, problem.header.max_clearance as i32);
        let numbers = lane_numbers::<L>(proof);
        let mut rooms = self.picks.chunks_exact_mut(self.room).zip(&mut self.counts);
        let chunks = course.coarse_twice.chunks(course.chunk);
        for (samples, bound) in chunks.zip(&mut self.bounds) {
            let middle = L::splat(proof, samples[samples.len() / 2]);
            let mut upper = cap;
            for at in (0..course.steps).step_by(L::COUNT) {
                let slack = L::load(proof, &course.slack[at..]);
                let x = middle.mul_halves(L::load(proof, &table.x_halves[at..]));
                let y = middle.mul_halves(L::load(proof, &table.y_halves[at..]));
                for (number, disc) in problem.discs.iter().enumerate() {
                    let place = number * course.steps + at;
                    let entry = entry(
                        proof,
                        problem,
                        x.add(L::load(proof, &table.across[place..])),
                        y.add(L::load(proof, &table.along[place..])),
                        L::load(proof, &table.cell[place..]),
                    );
                    let clearance = entry.tighten().sub(L::splat(proof, disc.radius));
                    upper = upper.min(clearance.add(slack));
                    clearance.sub(slack).store(&mut self.lower[place..]);
                }
            }
            *bound = upper.least();
            let bound = L::splat(proof, *bound);
            for lower in self.lower.chunks_exact(course.steps) {
                let Some((picks, whole)) = rooms.next() else {
                    break;
                };
                let mut count = 0;
                for at in (0..course.steps).step_by(L::COUNT) {
                    let below = L::load(proof, &lower[at..]).less(bound);
                    let numbers = numbers.add(L::splat(proof, at as i32));
                    count += L::compress(below, numbers, &mut picks[count..]);
                }
                // Whole groups, so that loops over them have few lengths, which the processor can foresee. The last pick
                // again, or any step, changes nothing.
                let last = picks[count.saturating_sub(1)].min(course.steps as i32 - 1);
                picks[count..][..GROUP].copy_from_slice(&[last; GROUP]);
                *whole = count.next_multiple_of(GROUP);
            }
        }
    }

    /// Looks at a chunk's picks.
    #[inline(always)]
    fn meet_picks<L: Lanes>(
        &mut self,
        proof: L::Proof,
        problem: &Prepared,
        course: &Course,
        table: &Table,
        chunk: usize,
    ) {
        let first = chunk * course.chunk;
        let end = (first + course.chunk).min(course.stride);
        let least = &mut self.least[first..end];
        if self.bounds[chunk] <= 0 {
            // All of them collide.
            least.fill(0);
            return;
        }
        let discs = problem.discs.len();
        let picks = &self.picks[chunk * discs * self.room..][..discs * self.room];
        let picks = picks.chunks_exact(self.room);
        let counts = &self.counts[chunk * discs..][..discs];
        least.fill(problem.header.max_clearance as i32);
        for (number, (picks, &count)) in picks.zip(counts).enumerate() {
            let looked = Looked::new(problem, course, table, number, &picks[..count]);
            looked.lower_all::<L>(proof, problem, &course.coarse_twice[first..end], least);
        }
    }

    /// Looks at every step of a row.
    #[inline(always)]
    fn meet_all<L: Lanes>(
        &mut self,
        proof: L::Proof,
        problem: &Prepared,
        course: &Course,
        table: &Table,
    ) {
        self.least.fill(problem.header.max_clearance as i32);
        for number in 0..problem.discs.len() {
            let looked = Looked::new(problem, course, table, number, &course.every_step);
            looked.lower_all::<L>(proof, problem, &course.coarse_twice, &mut self.least);
        }
    }
}

/// One disc at some of its steps.
struct Looked<'a> {
    /// Of the table; all of one length.
    x: &'a [i32],
    y: &'a [i32],
    across: &'a [i32],
    along: &'a [i32],
    cell: &'a [i32],
    picks: &'a [i32],
    radius: i32,
}

impl<'a> Looked<'a> {
    #[inline(always)]
    fn new(
        problem: &Prepared,
        course: &Course,
        table: &'a Table,
        disc: usize,
        picks: &'a [i32],
    ) -> Self {
        let steps = course.steps;
        let first = disc * steps;
        Self {
            x: &table.x_halves[..steps],
            y: &table.y_halves[..steps],
            across: &table.across[first..][..steps],
            along: &table.along[first..][..steps],
            cell: &table.cell[first..][..steps],
            picks,
            radius: problem.discs[disc].radius,
        }
    }

    /// Lowers the clearances of samples to what this disc meets.
    #[inline(always)]
    fn lower_all<L: Lanes>(
        &self,
        proof: L::Proof,
        problem: &Prepared,
        coarse: &[i32],
        least: &mut [i32],
    ) {
        let pairs = coarse.len() / (2 * L::COUNT) * (2 * L::COUNT);
        for at in (0..pairs).step_by(2 * L::COUNT) {
            self.lower::<L, 2>(proof, problem, &coarse[at..], &mut least[at..]);
        }
        for at in (pairs..coarse.len()).step_by(L::COUNT) {
            self.lower::<L, 1>(proof, problem, &coarse[at..], &mut least[at..]);
        }
    }

    /// The same for some vectors, which share what is read for each step.
    #[inline(always)]
    fn lower<L: Lanes, const N: usize>(
        &self,
        proof: L::Proof,
        problem: &Prepared,
        coarse: &[i32],
        least: &mut [i32],
    ) {
        let mut speeds = [L::splat(proof, 0); N];
        for (vector, speed) in speeds.iter_mut().enumerate() {
            *speed = L::load(proof, &coarse[vector * L::COUNT..]);
        }
        let mut nearest = [L::splat(proof, i32::from(u16::MAX)); N];
        for picks in self.picks.chunks_exact(GROUP) {
            for &pick in picks {
                let step = pick as usize;
                let x = L::splat(proof, self.x[step]);
                let y = L::splat(proof, self.y[step]);
                let across = L::splat(proof, self.across[step]);
                let along = L::splat(proof, self.along[step]);
                let cell = L::splat(proof, self.cell[step]);
                for (speed, nearest) in speeds.iter().zip(&mut nearest) {
                    let x = speed.mul_halves(x).add(across);
                    let y = speed.mul_halves(y).add(along);
                    *nearest = nearest.min_loose(entry(proof, problem, x, y, cell));
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

/// The field's entry, in the lower half, for products with what leads from them to a cell ([`Table`]).
#[inline(always)]
fn entry<L: Lanes>(proof: L::Proof, problem: &Prepared, x: L, y: L, cell: L) -> L {
    let header = &problem.header;
    let bits = header.coarse_bits + header.cell_bits;
    L::row_major(proof, x, y, bits, header.width as i32)
        .add(cell)
        .gather_loose(problem.field.padded_units())
}
