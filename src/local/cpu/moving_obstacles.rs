//! Clearances to moving obstacles. An obstacle is evaluated exactly only if it can be nearer to the samples of a tile than
//! anything else. The bound for this comes from the middle sample of the middle row, and the distance of the other samples
//! from it.

use super::displacement_table::{DisplacementTable, disc_positions_at, displacements_at};
use super::lanes::Lanes;
use super::ordered_steps::{
    MAX_OFFSET, clamp_offset, displacement, nearest_clearance, squared_distance,
};
use super::soa_inputs::{ROUNDING, SoaInputs};
use crate::local::QuantizedProblem;

const ROUNDING_UNITS: i32 = ROUNDING as i32;

/// Number of entries evaluated together: the memory does not depend on the number of obstacles.
const MAX_CANDIDATES: usize = 256;

/// Working memory for one chunk of a tile.
#[derive(Debug, Default)]
pub struct MovingObstacles {
    /// Squared distances from the middle sample, for each vector of steps, disc and obstacle.
    squared: Vec<i32>,
    /// Candidates for the nearest obstacle.
    candidates: Vec<Candidate>,
}

/// A disc at a step, and a moving obstacle that can be the nearest one.
#[derive(Clone, Copy, Debug)]
struct Candidate {
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
        clearances: &mut [i32],
    ) {
        self.candidates.clear();
        self.candidates.reserve(MAX_CANDIDATES);
        let words = |obstacles: usize| inputs.steps * problem.discs.len() * obstacles;
        // For all moving obstacles: the number of near ones changes from one decision to the next.
        let most = words(problem.obstacles.capacity());
        self.squared.reserve(most.saturating_sub(self.squared.len()));
        self.squared.resize(words(problem.obstacles.len()), 0);
        let mut bound = 0;
        for clearances in clearances.chunks_exact(inputs.stride) {
            for &clearance in &clearances[chunk.first..chunk.end] {
                bound = bound.max(clearance);
            }
        }
        let min_radius = problem.obstacles.iter().map(|body| body.radius).min();
        let (Some(min_radius), Some(table)) =
            (min_radius, chunk.tables.get(chunk.tables.len() / 2))
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
            let moved = displacements_at(token, problem, table, middle, at);
            for (number, disc) in problem.discs.iter().enumerate() {
                let (x, y) = disc_positions_at(token, table, moved, number * inputs.steps + at);
                let mut nearest = L::splat(token, i32::MAX);
                for body in 0..problem.obstacles.len() {
                    let (track_x, track_y) = inputs.track(body);
                    let across = clamp_offset(token, x.sub(L::load(token, &track_x[at..])));
                    let along = clamp_offset(token, y.sub(L::load(token, &track_y[at..])));
                    // Above 2^31 only if the distance exceeds every bound.
                    let squared = across.mul(across).add(along.mul(along));
                    squared.store(&mut self.squared[place..]);
                    place += L::COUNT;
                    nearest = nearest.min(squared.shr(1));
                }
                // Halved because the comparison is signed; the result is at most one too small.
                let nearest = f64::from(2 * nearest.reduce_min() as u32 + 1).sqrt() as i32 + 1;
                let apart = inputs.max_spread[at + L::COUNT - 1] + ROUNDING_UNITS;
                bound = bound.min(nearest + apart - disc.radius - min_radius);
            }
        }
        if bound <= 0 {
            // Every sample collides.
            for clearances in clearances.chunks_exact_mut(inputs.stride) {
                clearances[chunk.first..chunk.end].fill(0);
            }
            return;
        }
        let most = L::splat(token, MAX_OFFSET);
        // A manual counter: the compiler does not inline an iterator here.
        let mut place = 0;
        for at in (0..inputs.steps).step_by(L::COUNT) {
            let apart = L::load(token, &inputs.max_spread[at..]);
            let left = horizon_lanes(problem.header.steps, at, L::COUNT);
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
                        if self.candidates.len() == MAX_CANDIDATES {
                            self.lower_to_candidates::<L>(
                                token, problem, inputs, chunk, clearances,
                            );
                            self.candidates.clear();
                        }
                        self.candidates.push(Candidate {
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
        self.lower_to_candidates::<L>(token, problem, inputs, chunk, clearances);
    }

    /// Lowers the clearances to those of the candidates.
    #[inline(always)]
    fn lower_to_candidates<L: Lanes>(
        &self,
        token: L::FeatureToken,
        problem: &QuantizedProblem,
        inputs: &SoaInputs,
        chunk: &Chunk<'_>,
        clearances: &mut [i32],
    ) {
        if self.candidates.is_empty() {
            return;
        }
        let bits = problem.header.coarse_bits;
        for (table, clearances) in
            chunk.tables.iter().zip(clearances.chunks_exact_mut(inputs.stride))
        {
            for at in (chunk.first..chunk.end).step_by(L::COUNT) {
                let coarse = L::load(token, &inputs.coarse[at..]);
                let mut nearest = L::load(token, &clearances[at..]);
                for candidate in &self.candidates {
                    let x = displacement(token, coarse, table.x[candidate.step], bits)
                        .add(L::splat(token, table.disc_x[candidate.place]));
                    let y = displacement(token, coarse, table.y[candidate.step], bits)
                        .add(L::splat(token, table.disc_y[candidate.place]));
                    let squared = squared_distance(token, x, y, candidate.body_x, candidate.body_y);
                    nearest = nearest_clearance(token, nearest, squared, candidate.radii);
                }
                nearest.store(&mut clearances[at..]);
            }
        }
    }
}

/// Bit mask of the lanes that are steps of the horizon.
fn horizon_lanes(steps: u32, at: usize, lanes: usize) -> u32 {
    let left = (steps as usize).saturating_sub(at);
    if left >= lanes { u32::MAX } else { (1 << left) - 1 }
}
