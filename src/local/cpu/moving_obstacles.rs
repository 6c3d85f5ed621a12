//! Clearances to moving obstacles. Only an obstacle that can be nearer to a tile's neighbouring samples than anything
//! else is evaluated exactly: the middle sample of the middle row, and the distance of the others from it, give a
//! bound.

use super::displacement_table::{DisplacementTable, disc_steps, moved_steps};
use super::lanes::Lanes;
use super::ordered_steps::{MAX_OFFSET, bounded, moved, nearer, squared_distance};
use super::soa_inputs::{ROUNDING, SoaInputs};
use crate::local::QuantizedProblem;

const ROUNDING_UNITS: i32 = ROUNDING as i32;

/// Number of entries evaluated together: the memory does not depend on the number of obstacles.
const MAX_NEAR: usize = 256;

/// Working memory for one chunk of a tile.
#[derive(Debug, Default)]
pub struct MovingObstacles {
    /// Squared distances from the middle sample, for each vector of steps, disc and obstacle.
    squared: Vec<i32>,
    /// Candidates for the nearest obstacle.
    near: Vec<Near>,
}

/// A disc at a step, and a moving obstacle that can be the nearest one.
#[derive(Clone, Copy, Debug)]
struct Near {
    step: usize,
    /// Index of the disc and step in the tables.
    place: usize,
    body_x: i32,
    body_y: i32,
    radii: i32,
}

/// The samples of a chunk in all rows of a tile.
pub struct Chunk<'a> {
    /// One per row.
    pub tables: &'a [DisplacementTable],
    /// The first sample.
    pub first: usize,
    /// One past the last sample.
    pub end: usize,
}

impl MovingObstacles {
    /// Lowers the clearances of a chunk's samples, in all rows of a tile, to those to moving obstacles.
    ///
    /// The nearest obstacle at any step lowers the bound first; most other obstacles are then too far.
    #[inline(always)]
    pub fn lower<L: Lanes>(
        &mut self,
        token: L::FeatureToken,
        problem: &QuantizedProblem,
        inputs: &SoaInputs,
        chunk: &Chunk<'_>,
        least: &mut [i32],
    ) {
        self.near.clear();
        self.near.reserve(MAX_NEAR);
        let words = inputs.steps * problem.discs.len() * problem.obstacles.len();
        self.squared.resize(words, 0);
        let mut bound = 0;
        for least in least.chunks_exact(inputs.stride) {
            for &least in &least[chunk.first..chunk.end] {
                bound = bound.max(least);
            }
        }
        let least_radius = problem.obstacles.iter().map(|body| body.radius).min();
        let (Some(least_radius), Some(table)) =
            (least_radius, chunk.tables.get(chunk.tables.len() / 2))
        else {
            return;
        };
        if bound <= 0 {
            return;
        }
        let coarse = &inputs.coarse[chunk.first..chunk.end];
        let middle = L::splat(token, coarse[coarse.len() / 2]);
        // A manual counter: the compiler does not inline an iterator here.
        let mut place = 0;
        for at in (0..inputs.steps).step_by(L::COUNT) {
            let moved = moved_steps(token, problem, table, middle, at);
            for (number, disc) in problem.discs.iter().enumerate() {
                let (x, y) = disc_steps(token, table, moved, number * inputs.steps + at);
                let mut nearest = L::splat(token, i32::MAX);
                for body in 0..problem.obstacles.len() {
                    let (track_x, track_y) = inputs.track(body);
                    let across = bounded(token, x.sub(L::load(token, &track_x[at..])));
                    let along = bounded(token, y.sub(L::load(token, &track_y[at..])));
                    // Above 2^31 only if the distance exceeds every bound.
                    let squared = across.mul(across).add(along.mul(along));
                    squared.store(&mut self.squared[place..]);
                    place += L::COUNT;
                    nearest = nearest.min(squared.shr(1));
                }
                // Halved because the comparison is signed; the result is at most one too small.
                let nearest = f64::from(2 * nearest.reduce_min() as u32 + 1).sqrt() as i32 + 1;
                let apart = inputs.apart[at + L::COUNT - 1] + ROUNDING_UNITS;
                bound = bound.min(nearest + apart - disc.radius - least_radius);
            }
        }
        if bound <= 0 {
            // Every sample collides.
            for least in least.chunks_exact_mut(inputs.stride) {
                least[chunk.first..chunk.end].fill(0);
            }
            return;
        }
        let most = L::splat(token, MAX_OFFSET);
        // A manual counter: the compiler does not inline an iterator here.
        let mut place = 0;
        for at in (0..inputs.steps).step_by(L::COUNT) {
            let apart = L::load(token, &inputs.apart[at..]);
            let left = steps_left(problem.header.steps, at, L::COUNT);
            for (number, disc) in problem.discs.iter().enumerate() {
                for (index, body) in problem.obstacles.iter().enumerate() {
                    let radii = disc.radius + body.radius;
                    let within = apart.add(L::splat(token, bound + radii + ROUNDING_UNITS));
                    let squared = L::load(token, &self.squared[place..]);
                    place += L::COUNT;
                    let near =
                        L::mask_or(squared.less_unsigned(within.mul(within)), most.less(within));
                    let mut steps = L::bitmask(near) & left;
                    while steps != 0 {
                        let step = at + steps.trailing_zeros() as usize;
                        steps &= steps - 1;
                        let (track_x, track_y) = inputs.track(index);
                        if self.near.len() == MAX_NEAR {
                            self.look::<L>(token, problem, inputs, chunk, least);
                            self.near.clear();
                        }
                        self.near.push(Near {
                            step,
                            place: number * inputs.steps + step,
                            body_x: track_x[step],
                            body_y: track_y[step],
                            radii,
                        });
                    }
                }
            }
        }
        self.look::<L>(token, problem, inputs, chunk, least);
    }

    /// Lowers the clearances to those of the candidates.
    #[inline(always)]
    fn look<L: Lanes>(
        &self,
        token: L::FeatureToken,
        problem: &QuantizedProblem,
        inputs: &SoaInputs,
        chunk: &Chunk<'_>,
        least: &mut [i32],
    ) {
        if self.near.is_empty() {
            return;
        }
        let bits = problem.header.coarse_bits;
        for (table, least) in chunk
            .tables
            .iter()
            .zip(least.chunks_exact_mut(inputs.stride))
        {
            for at in (chunk.first..chunk.end).step_by(L::COUNT) {
                let coarse = L::load(token, &inputs.coarse[at..]);
                let mut nearest = L::load(token, &least[at..]);
                for near in &self.near {
                    let x = moved(token, coarse, table.x[near.step], bits)
                        .add(L::splat(token, table.disc_x[near.place]));
                    let y = moved(token, coarse, table.y[near.step], bits)
                        .add(L::splat(token, table.disc_y[near.place]));
                    let squared = squared_distance(token, x, y, near.body_x, near.body_y);
                    nearest = nearer(token, nearest, squared, near.radii);
                }
                nearest.store(&mut least[at..]);
            }
        }
    }
}

/// Bit mask of the lanes that are steps of the horizon.
fn steps_left(steps: u32, at: usize, lanes: usize) -> u32 {
    let left = (steps as usize).saturating_sub(at);
    if left >= lanes {
        u32::MAX
    } else {
        (1 << left) - 1
    }
}
