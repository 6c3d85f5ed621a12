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
use super::course::{Course, ROUNDING};
use super::lanes::{Lanes, MOST_LANES};
use super::march::{MOST_ACROSS, bounded, moved, nearer, squared_distance};
use super::row::{Step, Table, lane_numbers};
use crate::local::Prepared;

/// Steps that are looked at together.
const GROUP: usize = 4;

/// What one row needs, and room for it.
#[derive(Debug, Default)]
pub struct Sieve {
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
    /// Of one chunk: squared distances to moving obstacles, for each vector of steps, disc and obstacle.
    squared: Vec<i32>,
    /// Of one chunk: where moving obstacles can matter.
    near: Vec<Near>,
    /// Smallest clearances of the row's samples.
    least: Vec<i32>,
}

/// A disc at a step at which a moving obstacle can be nearest.
#[derive(Clone, Copy, Debug)]
struct Near {
    step: Step,
    body_x: i32,
    body_y: i32,
    radii: i32,
}

impl Sieve {
    /// Smallest clearance of each sample of a row that stays on the field, not above zero where it collides.
    #[inline(always)]
    pub fn clearances<L: Lanes>(
        &mut self,
        proof: L::Proof,
        problem: &Prepared,
        course: &Course,
        table: &Table,
    ) -> &[i32] {
        let discs = problem.discs.len();
        let chunks = course.stride.div_ceil(course.chunk);
        self.room = course.steps + MOST_LANES + GROUP;
        self.least.resize(course.stride, 0);
        self.bounds.resize(chunks, 0);
        self.counts.resize(chunks * discs, 0);
        self.picks.resize(chunks * discs * self.room, 0);
        self.lower.resize(course.steps * discs, 0);
        if course.is_worth_sifting() {
            self.sift::<L>(proof, problem, course, table);
            for chunk in 0..chunks {
                self.meet_picks::<L>(proof, problem, course, table, chunk);
            }
        } else {
            self.meet_all::<L>(proof, problem, course, table);
        }
        if !problem.obstacles.is_empty() {
            for chunk in 0..chunks {
                self.sift_bodies::<L>(proof, problem, course, table, chunk);
            }
        }
        &self.least
    }

    /// Finds the steps that can matter to each chunk of a row. All chunks at once: they do not depend on one another, so
    /// the processor need not wait for the gathers of one before it begins the next.
    #[inline(always)]
    fn sift<L: Lanes>(
        &mut self,
        proof: L::Proof,
        problem: &Prepared,
        course: &Course,
        table: &Table,
    ) {
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
        let entries = table.entries.chunks_exact(course.steps);
        for ((disc, entries), (picks, &count)) in
            problem.discs.iter().zip(entries).zip(picks.zip(counts))
        {
            let coarse = &course.coarse_twice[first..end];
            let looked = Looked {
                entries,
                picks: &picks[..count],
                radius: disc.radius,
            };
            looked.lower_all::<L>(proof, problem, coarse, least);
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
        let entries = table.entries.chunks_exact(course.steps);
        for (disc, entries) in problem.discs.iter().zip(entries) {
            let looked = Looked {
                entries,
                picks: &course.every_step,
                radius: disc.radius,
            };
            looked.lower_all::<L>(proof, problem, &course.coarse_twice, &mut self.least);
        }
    }

    /// Finds where moving obstacles can come nearer than a chunk's clearances so far, and looks there.
    ///
    /// The nearest of them at any step lowers the bound first; most of the others are then too far.
    #[inline(always)]
    fn sift_bodies<L: Lanes>(
        &mut self,
        proof: L::Proof,
        problem: &Prepared,
        course: &Course,
        table: &Table,
        chunk: usize,
    ) {
        self.near.clear();
        let first = chunk * course.chunk;
        let samples = first..(first + course.chunk).min(course.stride);
        let bound = self.least[samples.clone()].iter().copied().max();
        let least_radius = problem.obstacles.iter().map(|body| body.radius).min();
        let (Some(least_radius), Some(mut bound @ 1..)) = (least_radius, bound) else {
            return;
        };
        let samples = &course.coarse[samples];
        let middle = L::splat(proof, samples[samples.len() / 2]);
        let words = course.steps * problem.discs.len() * problem.obstacles.len();
        self.squared.resize(words, 0);
        let mut places = (0..words).step_by(L::COUNT);
        for at in (0..course.steps).step_by(L::COUNT) {
            let moved = moved_steps(proof, problem, table, middle, at);
            for (number, disc) in problem.discs.iter().enumerate() {
                let (x, y) = disc_steps(proof, table, moved, number * course.steps + at);
                let mut nearest = L::splat(proof, i32::MAX);
                for (body, place) in (0..problem.obstacles.len()).zip(&mut places) {
                    let (track_x, track_y) = course.track(body);
                    let across = bounded(proof, x.sub(L::load(proof, &track_x[at..])));
                    let along = bounded(proof, y.sub(L::load(proof, &track_y[at..])));
                    // Above 2^31 only where the distance is beyond every bound.
                    let squared = across.mul(across).add(along.mul(along));
                    squared.store(&mut self.squared[place..]);
                    nearest = nearest.min(squared.shr(1));
                }
                // Halved, for the comparison is signed: at most one less than it was.
                let nearest = (2 * nearest.least() as u32 + 1).isqrt() as i32;
                let apart = course.apart[at + L::COUNT - 1] + ROUNDING as i32;
                bound = bound.min(nearest + apart - disc.radius - least_radius);
            }
        }
        if bound <= 0 {
            // All of them collide.
            self.least[first..first + samples.len()].fill(0);
            return;
        }
        let most = L::splat(proof, MOST_ACROSS);
        let mut places = (0..words).step_by(L::COUNT);
        for at in (0..course.steps).step_by(L::COUNT) {
            let apart = L::load(proof, &course.apart[at..]);
            let left = steps_left(problem.header.steps, at, L::COUNT);
            for (number, disc) in problem.discs.iter().enumerate() {
                for ((index, body), place) in problem.obstacles.iter().enumerate().zip(&mut places)
                {
                    let radii = disc.radius + body.radius;
                    let within = apart.add(L::splat(proof, bound + radii + ROUNDING as i32));
                    let squared = L::load(proof, &self.squared[place..]);
                    let near =
                        L::either(squared.less_unsigned(within.mul(within)), most.less(within));
                    let mut steps = L::bits(near) & left;
                    while steps != 0 {
                        let step = at + steps.trailing_zeros() as usize;
                        steps &= steps - 1;
                        let (track_x, track_y) = course.track(index);
                        self.near.push(Near {
                            step: table.entries[number * course.steps + step],
                            body_x: track_x[step],
                            body_y: track_y[step],
                            radii,
                        });
                    }
                }
            }
        }
        self.meet_bodies::<L>(proof, problem, course, first);
    }

    #[inline(always)]
    fn meet_bodies<L: Lanes>(
        &mut self,
        proof: L::Proof,
        problem: &Prepared,
        course: &Course,
        first: usize,
    ) {
        if self.near.is_empty() {
            return;
        }
        let end = (first + course.chunk).min(course.stride);
        for at in (first..end).step_by(L::COUNT) {
            let coarse = L::load(proof, &course.coarse[at..]);
            let mut nearest = L::load(proof, &self.least[at..]);
            for near in &self.near {
                let (x, y) = position(proof, problem, coarse, &near.step);
                let squared = squared_distance(proof, x, y, near.body_x, near.body_y);
                nearest = nearer(proof, nearest, squared, near.radii);
            }
            nearest.store(&mut self.least[at..]);
        }
    }
}

/// One disc at some of its steps.
struct Looked<'a> {
    entries: &'a [Step],
    picks: &'a [i32],
    radius: i32,
}

impl Looked<'_> {
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
                let step = &self.entries[pick as usize];
                let (x, y) = (
                    L::splat(proof, step.x_halves),
                    L::splat(proof, step.y_halves),
                );
                let across = L::splat(proof, step.across);
                let along = L::splat(proof, step.along);
                let cell = L::splat(proof, step.cell);
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

/// The field's entry, in the lower half, for products with what leads from them to a cell ([`Step`]).
#[inline(always)]
fn entry<L: Lanes>(proof: L::Proof, problem: &Prepared, x: L, y: L, cell: L) -> L {
    let header = &problem.header;
    let bits = header.coarse_bits + header.cell_bits;
    L::row_major(proof, x, y, bits, header.width as i32)
        .add(cell)
        .gather_loose(problem.field.padded_units())
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
fn position<L: Lanes>(proof: L::Proof, problem: &Prepared, coarse: L, step: &Step) -> (L, L) {
    let bits = problem.header.coarse_bits;
    (
        moved(proof, coarse, step.x, bits).add(L::splat(proof, step.disc_x)),
        moved(proof, coarse, step.y, bits).add(L::splat(proof, step.disc_y)),
    )
}
