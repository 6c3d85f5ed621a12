//! Which steps can matter to a tile of neighbouring samples, a few speeds of a few turn rates; the others change no bit
//! and are left out.
//!
//! A position's column and row rise or fall with the speed, rounded as they are. So all cells that neighbouring samples
//! visit in a group of steps lie in the box between the least and the greatest of their displacements, and no clearance
//! there is below the smallest entry in that box. Where each of the samples has met something nearer already, the group
//! cannot matter.
//!
//! This is for trajectories that cannot leave the field and that are judged by their smallest clearance: there the
//! order of the steps does not matter.

use super::bounds::Bounds;
use super::course::{Course, MOST_ROWS};
use super::groups::Groups;
use super::lanes::Lanes;
use super::looked::{Looked, PAIR};
use super::moving::{Chunk, Moving};
use super::patches::{Listed, Patches};
use super::pooled::Pooled;
use super::spans::Spans;
use super::table::{Table, stays_inside};
use crate::local::Prepared;
use crate::local::inputs::Turn;

/// The work on one tile, and room for it.
#[derive(Debug, Default)]
pub struct Sieve {
    spans: Spans,
    bounds: Bounds,
    /// For each list the groups of steps to look at.
    picks: Vec<Groups>,
    /// What a clearance must be below to matter to any row's sample of a speed.
    matters: Vec<i32>,
    /// For each row the smallest clearances of its samples.
    least: Vec<i32>,
    patches: Patches,
    /// Groups that are looked up in the field itself, and their steps.
    rest: Groups,
    steps: Vec<i32>,
    moving: Moving,
}

/// Neighbouring rows of a problem.
pub struct Tile<'a> {
    pub problem: &'a Prepared,
    pub course: &'a Course,
    /// One for each row.
    pub turns: &'a [Turn],
    /// One for each row.
    pub tables: &'a [Table],
}

impl Tile<'_> {
    /// Steps are listed for each disc of each chunk.
    #[inline(always)]
    pub fn lists(&self) -> usize {
        self.course.stride.div_ceil(self.course.chunk) * self.problem.discs.len()
    }

    /// The samples of a list.
    #[inline(always)]
    fn listed(&self, number: usize) -> Listed {
        let discs = self.problem.discs.len();
        let first = number / discs * self.course.chunk;
        Listed {
            number,
            disc: number % discs,
            samples: first..(first + self.course.chunk).min(self.course.stride),
        }
    }
}

impl Sieve {
    /// Finds the smallest clearance of each sample of a tile's rows that stay on the field: not above zero where it
    /// collides, and of one that cannot stop either way some clearance with which it could not. What other rows get
    /// means nothing.
    #[inline(always)]
    pub fn sift<L: Lanes>(&mut self, proof: L::Proof, tile: &Tile<'_>, pooled: &Pooled) {
        let Tile {
            problem, course, ..
        } = *tile;
        // Room for the largest tile, and for all steps: not every decision needs them.
        self.steps.clear();
        self.steps.reserve(course.steps + PAIR);
        self.least.clear();
        self.least.reserve(course.stride * MOST_ROWS);
        let cap = problem.header.max_clearance as i32;
        self.least.resize(course.stride * tile.tables.len(), cap);
        let mut all_inside = true;
        for table in tile.tables {
            all_inside &= stays_inside::<L>(proof, problem, course, table);
        }
        if !pooled.is_empty() && all_inside {
            self.spans
                .fill::<L>(proof, course, &problem.discs, tile.tables);
            let of_boxes = (&self.spans, pooled);
            self.bounds
                .fill::<L>(proof, tile, of_boxes, &mut self.patches);
            // In a loop, as what looks at the picks is large: in one copy it stays near the processor.
            for round in 0..2 {
                if round == 0 {
                    self.pick_first::<L>(proof, tile);
                } else {
                    self.weigh::<L>(proof, tile);
                    self.pick::<L>(proof, tile);
                }
                self.meet_picks::<L>(proof, tile, pooled);
            }
        } else {
            self.meet_all::<L>(proof, tile);
        }
        if problem.obstacles.is_empty() {
            return;
        }
        for first in (0..course.stride).step_by(course.chunk) {
            let chunk = Chunk {
                tables: tile.tables,
                first,
                end: (first + course.chunk).min(course.stride),
            };
            self.moving
                .lower::<L>(proof, problem, course, &chunk, &mut self.least);
        }
    }

    /// The groups of steps that the last tile was looked at, list by list, after those that came first.
    #[cfg(test)]
    pub fn picked(&self) -> &[Groups] {
        &self.picks
    }

    /// How many patches were looked up so far.
    #[cfg(test)]
    pub const fn looked_up(&self) -> usize {
        self.patches.looked_up
    }

    /// The smallest clearances of one row of the tile.
    #[inline(always)]
    pub fn clearances(&self, course: &Course, row: usize) -> &[i32] {
        &self.least[row * course.stride..][..course.stride]
    }

    /// Looks at every step.
    #[inline(always)]
    fn meet_all<L: Lanes>(&mut self, proof: L::Proof, tile: &Tile<'_>) {
        let Tile {
            problem, course, ..
        } = *tile;
        let rows = self.least.chunks_exact_mut(course.stride);
        for (table, least) in tile.tables.iter().zip(rows) {
            for disc in 0..problem.discs.len() {
                let looked = Looked::new(problem, course, table, disc);
                looked.lower_all::<L>(proof, &course.every_step, &course.coarse_twice, least);
            }
        }
    }

    /// Picks for each list the groups that promise its boxes the smallest clearances.
    #[inline(always)]
    fn pick_first<L: Lanes>(&mut self, proof: L::Proof, tile: &Tile<'_>) {
        self.picks.resize_with(tile.lists(), Groups::default);
        for (list, picks) in self.picks.iter_mut().enumerate() {
            self.bounds
                .take_smallest::<L>(proof, tile.course, list, picks);
        }
    }

    /// Finds what a clearance must be below to matter, by those found so far.
    #[inline(always)]
    fn weigh<L: Lanes>(&mut self, proof: L::Proof, tile: &Tile<'_>) {
        let course = tile.course;
        let zero = L::splat(proof, 0);
        let one = L::splat(proof, 1);
        let nothing = L::splat(proof, i32::MIN);
        self.matters.resize(course.stride, 0);
        for at in (0..course.stride).step_by(L::COUNT) {
            let needs = L::load(proof, &course.needs[at..]);
            let mut most = nothing;
            for (row, turn) in tile.turns.iter().enumerate() {
                let least = L::load(proof, &self.least[row * course.stride + at..]);
                let needs = needs.max(L::splat(proof, turn.needs as i32));
                // One that cannot stop can still collide; one that collides can do nothing else.
                let matters = L::select(least.less(needs), one, least);
                let matters = L::select(zero.less(least), matters, nothing);
                most = most.max(matters);
            }
            most.store(&mut self.matters[at..]);
        }
    }

    /// Picks the groups of steps that can matter.
    #[inline(always)]
    fn pick<L: Lanes>(&mut self, proof: L::Proof, tile: &Tile<'_>) {
        for (number, picks) in self.picks.iter_mut().enumerate() {
            let matters = &self.matters[tile.listed(number).samples];
            self.bounds
                .below::<L>(proof, tile.course, number, matters, picks);
        }
    }

    /// Looks at what was picked.
    #[inline(always)]
    fn meet_picks<L: Lanes>(&mut self, proof: L::Proof, tile: &Tile<'_>, pooled: &Pooled) {
        let Tile {
            problem, course, ..
        } = *tile;
        for (number, picks) in self.picks.iter().enumerate() {
            let listed = tile.listed(number);
            let mut groups = picks.as_slice();
            if L::LOOKS_UP && self.patches.can_be() {
                let (least, rest) = (&mut self.least, &mut self.rest);
                self.patches
                    .lower::<L>(proof, (tile, pooled), &listed, groups, least, rest);
                groups = self.rest.as_slice();
            }
            if groups.is_empty() {
                continue;
            }
            steps_of(course, groups, &mut self.steps);
            let Listed { disc, samples, .. } = listed;
            let coarse = &course.coarse_twice[samples.clone()];
            // Row after row for the same list: its length is then foreseen.
            let rows = self.least.chunks_exact_mut(course.stride);
            for (table, least) in tile.tables.iter().zip(rows) {
                let looked = Looked::new(problem, course, table, disc);
                looked.lower_all::<L>(proof, &self.steps, coarse, &mut least[samples.clone()]);
            }
        }
    }
}

/// Lists the steps of these groups, the last one twice where they are not whole pairs.
#[inline(always)]
pub fn steps_of(course: &Course, groups: &[i32], steps: &mut Vec<i32>) {
    steps.clear();
    steps.reserve(course.steps + PAIR);
    for &group in groups {
        for step in course.steps_of(group) {
            steps.push(step as i32);
        }
    }
    if let Some(&last) = steps.last()
        && !steps.len().is_multiple_of(PAIR)
    {
        steps.push(last);
    }
}
