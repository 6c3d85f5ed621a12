//! Which steps can matter to a chunk of neighbouring samples; the others change no bit and are left out.
//!
//! The distance field is 1-Lipschitz between cell centres. So the clearance of one sample of a chunk, the middle one,
//! bounds that of all others at the same step: they differ by no more than the samples are apart, and a cell's diagonal. The
//! smallest upper bound of any step is above every sample's smallest clearance or equal to it, and a step whose lower
//! bound is not below that cannot lower it. The same holds for moving obstacles, with the distance to their centres.
//!
//! This is for trajectories that cannot leave the field and that are judged by their smallest clearance: there the
//! order of the steps does not matter.

use core::ops::Range;

use super::arithmetic::shift_round;
use super::course::{Course, MOST_SAMPLES, ROUNDING};
use super::lanes::Lanes;
use super::march::{MOST_ACROSS, bounded, moved, nearer, squared_distance};
use super::row::Table;
use crate::local::Prepared;

/// What one row needs, and room for it.
#[derive(Debug, Default)]
pub struct Sieve {
    /// For each chunk, disc and vector of steps, the steps that can matter.
    steps: Vec<u32>,
    /// For each chunk the smallest upper bound of the clearance.
    bounds: Vec<i32>,
    /// Of one chunk: for each disc and step the lower bound of the clearance.
    lower: Vec<i32>,
    /// Of one chunk: where moving obstacles can matter.
    near: Vec<Near>,
    /// Smallest clearances of the chunk's samples.
    least: Vec<i32>,
}

/// A disc at a step at which a moving obstacle can be nearest.
#[derive(Clone, Copy, Debug)]
struct Near {
    step: usize,
    /// Of the disc at that step in the table.
    place: usize,
    body_x: i32,
    body_y: i32,
    radii: i32,
}

impl Sieve {
    /// Finds the steps that can matter to each chunk of a row. All chunks at once: they do not depend on one another, so
    /// the processor need not wait for the gathers of one before it begins the next.
    #[inline(always)]
    pub fn sift<L: Lanes>(
        &mut self,
        proof: L::Proof,
        problem: &Prepared,
        course: &Course,
        table: &Table,
    ) {
        let header = &problem.header;
        self.steps.clear();
        self.bounds.clear();
        self.lower.resize(course.steps * problem.discs.len(), 0);
        for samples in course.coarse.chunks(course.chunk) {
            let middle = L::splat(proof, samples[samples.len() / 2]);
            let mut upper = L::splat(proof, header.max_clearance as i32);
            for at in (0..course.steps).step_by(L::COUNT) {
                let slack = L::load(proof, &course.slack[at..]);
                let moved = moved_steps(proof, problem, table, middle, at);
                for (number, disc) in problem.discs.iter().enumerate() {
                    let place = number * course.steps + at;
                    let (x, y) = disc_steps(proof, table, moved, place);
                    let distance = distance(proof, problem, x, y).sub(L::splat(proof, disc.radius));
                    upper = upper.min(distance.add(slack));
                    distance.sub(slack).store(&mut self.lower[place..]);
                }
            }
            let bound = upper.least();
            self.bounds.push(bound);
            let bound = L::splat(proof, bound);
            for lower in self.lower.chunks_exact(course.steps) {
                for at in (0..course.steps).step_by(L::COUNT) {
                    let below = L::load(proof, &lower[at..]).less(bound);
                    self.steps
                        .push(L::bits(below) & steps_left(header.steps, at, L::COUNT));
                }
            }
        }
    }

    /// Smallest clearance of each sample of a chunk that `sift` has seen; zero where all collide.
    #[inline(always)]
    pub fn meet<L: Lanes>(
        &mut self,
        proof: L::Proof,
        problem: &Prepared,
        course: &Course,
        table: &Table,
        samples: Range<usize>,
    ) -> &[i32] {
        let chunk = samples.start / course.chunk;
        self.least.resize(MOST_SAMPLES, 0);
        if self.bounds[chunk] <= 0 {
            self.least.fill(0);
            return &self.least;
        }
        let vectors = course.steps / L::COUNT;
        let words = vectors * problem.discs.len();
        let steps = &self.steps[chunk * words..][..words];
        let cap = L::splat(proof, problem.header.max_clearance as i32);
        let mut greatest = L::splat(proof, 0);
        for (at, first) in samples.clone().step_by(L::COUNT).enumerate() {
            let coarse = L::load(proof, &course.coarse[first..]);
            let mut least = cap;
            let discs = problem.discs.iter().zip(steps.chunks_exact(vectors));
            for (number, (disc, steps)) in discs.enumerate() {
                let mut nearest = L::splat(proof, i32::MAX);
                for (vector, &steps) in steps.iter().enumerate() {
                    let mut steps = steps;
                    while steps != 0 {
                        let step = vector * L::COUNT + steps.trailing_zeros() as usize;
                        steps &= steps - 1;
                        let (x, y) = position(
                            proof,
                            problem,
                            table,
                            coarse,
                            step,
                            number * course.steps + step,
                        );
                        nearest = nearest.min(distance(proof, problem, x, y));
                    }
                }
                least = least.min(nearest.sub(L::splat(proof, disc.radius)));
            }
            greatest = greatest.max(least);
            least.store(&mut self.least[at * L::COUNT..]);
        }
        if !problem.obstacles.is_empty() {
            let bound = greatest.greatest();
            self.sift_bodies::<L>(proof, problem, course, table, &samples, bound);
            self.meet_bodies::<L>(proof, problem, course, table, samples);
        }
        &self.least
    }

    /// Finds where moving obstacles can come nearer than `bound`, the greatest of the chunk's clearances so far.
    #[inline(always)]
    fn sift_bodies<L: Lanes>(
        &mut self,
        proof: L::Proof,
        problem: &Prepared,
        course: &Course,
        table: &Table,
        samples: &Range<usize>,
        bound: i32,
    ) {
        self.near.clear();
        if bound <= 0 {
            return;
        }
        let samples = &course.coarse[samples.clone()];
        let middle = L::splat(proof, samples[samples.len() / 2]);
        let most = L::splat(proof, MOST_ACROSS);
        for at in (0..course.steps).step_by(L::COUNT) {
            let moved = moved_steps(proof, problem, table, middle, at);
            let apart = L::load(proof, &course.apart[at..]);
            for (number, disc) in problem.discs.iter().enumerate() {
                let first = number * course.steps;
                let (x, y) = disc_steps(proof, table, moved, first + at);
                for (number, body) in problem.obstacles.iter().enumerate() {
                    let (track_x, track_y) = course.track(number);
                    let radii = disc.radius + body.radius;
                    let across = bounded(proof, x.sub(L::load(proof, &track_x[at..])));
                    let along = bounded(proof, y.sub(L::load(proof, &track_y[at..])));
                    let squared = across.mul(across).add(along.mul(along));
                    let within = apart.add(L::splat(proof, bound + radii + ROUNDING as i32));
                    let near =
                        L::either(squared.less_unsigned(within.mul(within)), most.less(within));
                    let mut steps = L::bits(near) & steps_left(problem.header.steps, at, L::COUNT);
                    while steps != 0 {
                        let step = at + steps.trailing_zeros() as usize;
                        steps &= steps - 1;
                        self.near.push(Near {
                            step,
                            place: first + step,
                            body_x: track_x[step],
                            body_y: track_y[step],
                            radii,
                        });
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn meet_bodies<L: Lanes>(
        &mut self,
        proof: L::Proof,
        problem: &Prepared,
        course: &Course,
        table: &Table,
        samples: Range<usize>,
    ) {
        if self.near.is_empty() {
            return;
        }
        for (at, first) in samples.step_by(L::COUNT).enumerate() {
            let coarse = L::load(proof, &course.coarse[first..]);
            let least = &mut self.least[at * L::COUNT..];
            let mut nearest = L::load(proof, least);
            for near in &self.near {
                let (x, y) = position(proof, problem, table, coarse, near.step, near.place);
                let squared = squared_distance(proof, x, y, near.body_x, near.body_y);
                nearest = nearer(proof, nearest, squared, near.radii);
            }
            nearest.store(least);
        }
    }
}

/// Whether every disc of these samples stays on the field. Positions are monotonic in the speed, rounded as they are, so
/// the first and the last sample bound the others.
#[inline(always)]
pub fn stay_inside<L: Lanes>(
    proof: L::Proof,
    problem: &Prepared,
    course: &Course,
    table: &Table,
    samples: Range<usize>,
) -> bool {
    let header = &problem.header;
    let width = L::splat(proof, header.width as i32);
    let height = L::splat(proof, header.height as i32);
    for coarse in [course.coarse[samples.start], course.coarse[samples.end - 1]] {
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

/// The lanes that stand for steps of the horizon.
fn steps_left(steps: u32, at: usize, lanes: usize) -> u32 {
    let left = (steps as usize).saturating_sub(at);
    if left >= lanes {
        u32::MAX
    } else {
        (1 << left) - 1
    }
}

/// How far one sample has moved at the steps from `at`.
#[inline(always)]
fn moved_steps<L: Lanes>(
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
fn disc_steps<L: Lanes>(
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

/// Where a disc of many samples is at one step.
#[inline(always)]
fn position<L: Lanes>(
    proof: L::Proof,
    problem: &Prepared,
    table: &Table,
    coarse: L,
    step: usize,
    place: usize,
) -> (L, L) {
    let bits = problem.header.coarse_bits;
    (
        moved(proof, coarse, table.x[step], bits).add(L::splat(proof, table.disc_x[place])),
        moved(proof, coarse, table.y[step], bits).add(L::splat(proof, table.disc_y[place])),
    )
}

/// Distance to the nearest static obstacle from a position on the field.
#[inline(always)]
fn distance<L: Lanes>(proof: L::Proof, problem: &Prepared, x: L, y: L) -> L {
    let bits = problem.header.cell_bits;
    let width = L::splat(proof, problem.header.width as i32);
    y.sar(bits)
        .mul(width)
        .add(x.sar(bits))
        .gather(problem.field.padded_units())
}
