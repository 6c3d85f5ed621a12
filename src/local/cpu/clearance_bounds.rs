//! Lower bounds of the clearances of neighbouring samples of a tile, for each group of steps; lists of such groups.

use super::displacement_bounds::DisplacementBounds;
use super::displacement_table::lane_indices;
use super::lanes::{Lanes, MAX_LANES};
use super::min_pyramid::{Boxes, MinPyramid};
use super::register_tiles::RegisterTiles;
use super::soa_inputs::{GROUPS, SoaInputs};
use super::step_pruning::SampleTile;

/// The bounds of one tile.
#[derive(Debug, Default)]
pub struct ClearanceBounds {
    /// For each box of samples of each list ([`SampleTile::lists`]).
    lower: Vec<[i32; GROUPS]>,
}

impl ClearanceBounds {
    /// Computes the bounds from the cells that the samples visit, and passes those cells to `register_tiles`.
    #[inline(always)]
    pub fn fill<L: Lanes>(
        &mut self,
        token: L::FeatureToken,
        tile: &SampleTile<'_>,
        (displacements, pyramid): (&DisplacementBounds, &MinPyramid),
        register_tiles: &mut RegisterTiles,
    ) {
        let SampleTile { problem, inputs, .. } = *tile;
        self.lower.resize(tile.lists() * inputs.boxes, [0; GROUPS]);
        if L::LARGEST_REGISTER_TILE > 0 {
            register_tiles.begin(tile);
        }
        let mut lists = self.lower.chunks_exact_mut(inputs.boxes).enumerate();
        for coarse in inputs.coarse.chunks(inputs.chunk) {
            for ((disc, body), (list, lower)) in problem.discs.iter().enumerate().zip(&mut lists) {
                let radius = L::splat(token, body.radius);
                for at in (0..inputs.groups).step_by(L::COUNT) {
                    let missing = L::load(token, &inputs.absent_groups[at..]);
                    let mut visited = Boxes::<L>::empty(token);
                    for (number, lower) in lower.iter_mut().enumerate() {
                        let samples = box_samples(coarse, inputs.boxes, number);
                        let vx_samples = [samples[0], samples[samples.len() - 1]];
                        let boxes =
                            displacements.boxes::<L>(token, &problem.header, vx_samples, disc, at);
                        let least = pyramid.lower_bounds(token, &boxes).sub(radius);
                        least.max(missing).store(&mut lower[at..]);
                        visited = visited.union(boxes);
                    }
                    if L::LARGEST_REGISTER_TILE > 0 {
                        register_tiles.store_visited(list, at, visited);
                    }
                }
            }
        }
    }

    /// Selects, for each box of a list, the group with the smallest bound. [`Self::below`] does not select these groups
    /// again.
    #[inline(always)]
    pub fn select_smallest<L: Lanes>(
        &mut self,
        token: L::FeatureToken,
        inputs: &SoaInputs,
        list: usize,
        groups: &mut StepGroups,
    ) {
        let boxes = &mut self.lower[list * inputs.boxes..][..inputs.boxes];
        groups.clear();
        let mut taken = 0_u32;
        for lower in &*boxes {
            let (mut group, mut bound) = (0, i32::MAX);
            for at in (0..inputs.groups).step_by(L::COUNT) {
                let lower = L::load(token, &lower[at..]);
                let least = lower.reduce_min();
                if least < bound {
                    let here = L::bitmask(lower.equal(L::splat(token, least)));
                    (group, bound) = (at + here.trailing_zeros() as usize, least);
                }
            }
            taken |= 1 << group;
        }
        while taken != 0 {
            let group = taken.trailing_zeros() as usize;
            for lower in &mut *boxes {
                lower[group] = i32::MAX;
            }
            groups.push(group as i32);
            taken &= taken - 1;
        }
    }

    /// Selects the groups whose bound is below the clearance that matters to the samples of a list.
    #[inline(always)]
    pub fn below<L: Lanes>(
        &self,
        token: L::FeatureToken,
        inputs: &SoaInputs,
        list: usize,
        critical: &[i32],
        groups: &mut StepGroups,
    ) {
        let boxes = &self.lower[list * inputs.boxes..][..inputs.boxes];
        groups.clear();
        for at in (0..inputs.groups).step_by(L::COUNT) {
            let mut selected_groups = L::mask_none(token);
            for (number, lower) in boxes.iter().enumerate() {
                let most = greatest(box_samples(critical, inputs.boxes, number));
                let lower = L::load(token, &lower[at..]);
                selected_groups = L::mask_or(selected_groups, lower.less(L::splat(token, most)));
            }
            let numbers = lane_indices::<L>(token).add(L::splat(token, at as i32));
            groups.add::<L>(selected_groups, numbers);
        }
    }
}

#[inline(always)]
fn greatest(list: &[i32]) -> i32 {
    let mut greatest = i32::MIN;
    for &one in list {
        greatest = greatest.max(one);
    }
    greatest
}

/// The samples of one box of a chunk.
#[inline(always)]
fn box_samples(samples: &[i32], boxes: usize, number: usize) -> &[i32] {
    let size = samples.len() / boxes;
    &samples[number * size..][..size]
}

/// Some groups of steps, with space for one more vector store.
#[derive(Clone, Debug)]
pub struct StepGroups {
    list: [i32; GROUPS + MAX_LANES],
    count: usize,
}

impl Default for StepGroups {
    fn default() -> Self {
        Self { list: [0; GROUPS + MAX_LANES], count: 0 }
    }
}

impl StepGroups {
    /// Removes all groups.
    #[inline(always)]
    pub const fn clear(&mut self) {
        self.count = 0;
    }

    /// Adds one group; there are never more than [`GROUPS`].
    #[inline(always)]
    pub const fn push(&mut self, group: i32) {
        self.list[self.count] = group;
        self.count += 1;
    }

    /// Adds the groups in the lanes of a mask.
    #[inline(always)]
    pub fn add<L: Lanes>(&mut self, set: L::Mask, groups: L) {
        self.count += L::compress(set, groups, &mut self.list[self.count..]);
    }

    /// The groups, in the order in which they were added.
    #[inline(always)]
    pub fn as_slice(&self) -> &[i32] {
        &self.list[..self.count]
    }
}
