//! Selects the steps that can matter to a tile of neighbouring samples (a few speeds of a few turn rates); skipping the
//! others changes no bit.
//!
//! The column and the row of a rounded position are monotonic in the speed. So all cells that neighbouring samples
//! visit in a group of steps lie in the box between the smallest and the largest displacement. The smallest entry of
//! the field in this box bounds the clearance from below. If every sample already has a smaller clearance, the group
//! cannot matter.
//!
//! This applies to trajectories that cannot leave the field and whose status depends on the smallest clearance: the
//! order of their steps does not matter.

use super::clearance_bounds::{ClearanceBounds, StepGroups};
use super::disc_lookup::DiscLookup;
use super::displacement_bounds::DisplacementBounds;
use super::displacement_table::{DisplacementTable, stays_on_field};
use super::lanes::Lanes;
use super::min_pyramid::MinPyramid;
use super::moving_obstacles::{Chunk, MovingObstacles};
use super::register_tiles::{RegisterTiles, SampleList};
use super::soa_inputs::{MAX_ROWS, PAIR, SoaInputs};
use crate::local::QuantizedProblem;
use crate::local::kernel_inputs::TurnProfile;

/// Working memory for one tile.
#[derive(Debug, Default)]
pub struct StepPruning {
    displacements: DisplacementBounds,
    bounds: ClearanceBounds,
    /// The groups of steps to look up, for each list.
    pub selected: Vec<StepGroups>,
    /// For each speed, the bound below which a clearance can matter to the sample of any row.
    critical: Vec<i32>,
    /// The smallest clearances of the samples of each row.
    clearances: Vec<i32>,
    pub register_tiles: RegisterTiles,
    /// Groups that are looked up in the field itself, and their steps.
    remaining: StepGroups,
    steps: Vec<i32>,
    moving: MovingObstacles,
}

/// Neighbouring rows of a problem.
pub struct SampleTile<'a> {
    pub problem: &'a QuantizedProblem,
    pub inputs: &'a SoaInputs,
    /// One per row.
    pub profiles: &'a [TurnProfile],
    /// One per row.
    pub tables: &'a [DisplacementTable],
}

impl SampleTile<'_> {
    /// Number of lists of steps: one per disc of each chunk.
    #[inline(always)]
    pub fn lists(&self) -> usize {
        self.inputs.stride.div_ceil(self.inputs.chunk) * self.problem.discs.len()
    }

    /// The samples of a list.
    #[inline(always)]
    fn list_samples(&self, number: usize) -> SampleList {
        let discs = self.problem.discs.len();
        let first = number / discs * self.inputs.chunk;
        SampleList {
            number,
            disc: number % discs,
            samples: first..(first + self.inputs.chunk).min(self.inputs.stride),
        }
    }
}

impl StepPruning {
    /// Finds the smallest clearance of each sample of the tile's rows that stay on the field. The clearance of a
    /// colliding sample is only known to be not above zero. That of a sample that cannot stop is any value with which
    /// it cannot stop. The results of other rows are undefined.
    #[inline(always)]
    pub fn prune<L: Lanes>(
        &mut self,
        token: L::FeatureToken,
        tile: &SampleTile<'_>,
        pyramid: &MinPyramid,
    ) {
        let SampleTile { problem, inputs, .. } = *tile;
        // Reserves for the largest tile and for all steps: not every decision needs them.
        self.steps.clear();
        self.steps.reserve(inputs.steps + PAIR);
        self.clearances.clear();
        self.clearances.reserve(inputs.stride * MAX_ROWS);
        let cap = problem.header.max_clearance as i32;
        self.clearances.resize(inputs.stride * tile.tables.len(), cap);
        let mut all_inside = true;
        for table in tile.tables {
            all_inside &= stays_on_field::<L>(token, problem, inputs, table);
        }
        if !pyramid.is_empty() && all_inside {
            self.displacements.fill::<L>(token, inputs, &problem.discs, tile.tables);
            let sources = (&self.displacements, pyramid);
            self.bounds.fill::<L>(token, tile, sources, &mut self.register_tiles);
            // A loop of two rounds, because the inlined lookup is large: one copy of it stays in the instruction cache.
            for round in 0..2 {
                if round == 0 {
                    self.selected.resize_with(tile.lists(), StepGroups::default);
                    for (list, selected) in self.selected.iter_mut().enumerate() {
                        self.bounds.select_smallest::<L>(token, inputs, list, selected);
                    }
                } else {
                    self.update_critical::<L>(token, tile);
                    for (list, selected) in self.selected.iter_mut().enumerate() {
                        let critical = &self.critical[tile.list_samples(list).samples];
                        self.bounds.below::<L>(token, inputs, list, critical, selected);
                    }
                }
                self.look_up_selected::<L>(token, tile, pyramid);
            }
        } else {
            self.look_up_all::<L>(token, tile);
        }
        if problem.obstacles.is_empty() {
            return;
        }
        for first in (0..inputs.stride).step_by(inputs.chunk) {
            let chunk = Chunk {
                tables: tile.tables,
                first,
                end: (first + inputs.chunk).min(inputs.stride),
            };
            self.moving.lower::<L>(token, problem, inputs, &chunk, &mut self.clearances);
        }
    }

    /// The smallest clearances of one row of the tile.
    #[inline(always)]
    pub fn clearances(&self, inputs: &SoaInputs, row: usize) -> &[i32] {
        &self.clearances[row * inputs.stride..][..inputs.stride]
    }

    /// Looks up every step.
    #[inline(always)]
    fn look_up_all<L: Lanes>(&mut self, token: L::FeatureToken, tile: &SampleTile<'_>) {
        let SampleTile { problem, inputs, .. } = *tile;
        let rows = self.clearances.chunks_exact_mut(inputs.stride);
        for (table, clearances) in tile.tables.iter().zip(rows) {
            for disc in 0..problem.discs.len() {
                let lookup = DiscLookup::new(problem, inputs, table, disc);
                lookup.lower_all::<L>(token, &inputs.all_steps, &inputs.coarse_twice, clearances);
            }
        }
    }

    /// Computes the bounds below which a clearance can matter, from the clearances found so far.
    #[inline(always)]
    fn update_critical<L: Lanes>(&mut self, token: L::FeatureToken, tile: &SampleTile<'_>) {
        let inputs = tile.inputs;
        let zero = L::splat(token, 0);
        let one = L::splat(token, 1);
        let nothing = L::splat(token, i32::MIN);
        self.critical.resize(inputs.stride, 0);
        for at in (0..inputs.stride).step_by(L::COUNT) {
            let stopping_need = L::load(token, &inputs.stopping_need[at..]);
            let mut most = nothing;
            for (row, profile) in tile.profiles.iter().enumerate() {
                let clearance = L::load(token, &self.clearances[row * inputs.stride + at..]);
                let stopping_need =
                    stopping_need.max(L::splat(token, profile.stopping_need as i32));
                // A sample that cannot stop can still collide; the status of a colliding sample is final.
                let critical = L::select(clearance.less(stopping_need), one, clearance);
                let critical = L::select(zero.less(clearance), critical, nothing);
                most = most.max(critical);
            }
            most.store(&mut self.critical[at..]);
        }
    }

    /// Looks up the selected groups.
    #[inline(always)]
    fn look_up_selected<L: Lanes>(
        &mut self,
        token: L::FeatureToken,
        tile: &SampleTile<'_>,
        pyramid: &MinPyramid,
    ) {
        let SampleTile { problem, inputs, .. } = *tile;
        for (number, selected) in self.selected.iter().enumerate() {
            let list_samples = tile.list_samples(number);
            let mut groups = selected.as_slice();
            if L::LARGEST_REGISTER_TILE > 0 && self.register_tiles.applies {
                let (clearances, remaining) = (&mut self.clearances, &mut self.remaining);
                self.register_tiles.lower::<L>(
                    token,
                    (tile, pyramid),
                    &list_samples,
                    groups,
                    clearances,
                    remaining,
                );
                groups = self.remaining.as_slice();
            }
            if groups.is_empty() {
                continue;
            }
            steps_of(inputs, groups, &mut self.steps);
            let SampleList { disc, samples, .. } = list_samples;
            let coarse = &inputs.coarse_twice[samples.clone()];
            // All rows of one list in a row: the branch predictor then knows the length of the list.
            let rows = self.clearances.chunks_exact_mut(inputs.stride);
            for (table, clearances) in tile.tables.iter().zip(rows) {
                let lookup = DiscLookup::new(problem, inputs, table, disc);
                lookup.lower_all::<L>(token, &self.steps, coarse, &mut clearances[samples.clone()]);
            }
        }
    }
}

/// Lists the steps of these groups; repeats the last step to complete a pair.
#[inline(always)]
pub fn steps_of(inputs: &SoaInputs, groups: &[i32], steps: &mut Vec<i32>) {
    steps.clear();
    steps.reserve(inputs.steps + PAIR);
    for &group in groups {
        for step in inputs.steps_of(group) {
            steps.push(step as i32);
        }
    }
    if let Some(&last) = steps.last()
        && !steps.len().is_multiple_of(PAIR)
    {
        steps.push(last);
    }
}
