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

use super::course::Course;
use super::lanes::Lanes;
use super::looked::{Looked, PAIR};
use super::moving::{Chunk, Moving};
use super::pooled::Pooled;
use super::spans::{GROUPS, Spans};
use super::table::{Table, lane_numbers, stays_inside};
use crate::local::Prepared;
use crate::local::inputs::Turn;

/// The work on one tile, and room for it.
#[derive(Debug, Default)]
pub struct Sieve {
    spans: Spans,
    /// For each box of each disc of each chunk, and each group of steps: what no clearance is below.
    lower: Vec<[i32; GROUPS]>,
    /// For each disc of each chunk the steps to look at.
    picks: Vec<Vec<i32>>,
    /// What a clearance must be below to matter to any row's sample of a speed.
    matters: Vec<i32>,
    /// For each row the smallest clearances of its samples.
    least: Vec<i32>,
    moving: Moving,
}

/// Whose samples a tile's are.
pub struct Tile<'a> {
    /// One for each row.
    pub turns: &'a [Turn],
    /// One for each row.
    pub tables: &'a [Table],
}

impl Sieve {
    /// Finds the smallest clearance of each sample of a tile's rows that stay on the field: not above zero where it
    /// collides, and of one that cannot stop either way some clearance with which it could not. What other rows get
    /// means nothing.
    #[inline(always)]
    pub fn sift<L: Lanes>(
        &mut self,
        proof: L::Proof,
        problem: &Prepared,
        course: &Course,
        pooled: &Pooled,
        tile: &Tile<'_>,
    ) {
        let rows = tile.tables.len();
        self.least.resize(course.stride * rows, 0);
        self.least.fill(problem.header.max_clearance as i32);
        let mut all_inside = true;
        for table in tile.tables {
            all_inside &= stays_inside::<L>(proof, problem, course, table);
        }
        if !pooled.is_empty() && all_inside {
            let discs = problem.discs.len();
            self.spans.fill::<L>(proof, course, discs, tile.tables);
            self.bound::<L>(proof, problem, course, pooled);
            self.pick_first::<L>(proof, course);
            self.meet_picks::<L>(proof, problem, course, tile);
            self.weigh::<L>(proof, course, tile);
            self.pick::<L>(proof, course, discs);
            self.meet_picks::<L>(proof, problem, course, tile);
        } else {
            self.meet_all::<L>(proof, problem, course, tile);
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

    /// The steps that the last tile was looked at, for each disc of each chunk, after those that came first.
    #[cfg(test)]
    pub fn picked(&self) -> &[Vec<i32>] {
        &self.picks
    }

    /// The smallest clearances of one row of the tile.
    #[inline(always)]
    pub fn clearances(&self, course: &Course, row: usize) -> &[i32] {
        &self.least[row * course.stride..][..course.stride]
    }

    /// Looks at every step.
    #[inline(always)]
    fn meet_all<L: Lanes>(
        &mut self,
        proof: L::Proof,
        problem: &Prepared,
        course: &Course,
        tile: &Tile<'_>,
    ) {
        let rows = self.least.chunks_exact_mut(course.stride);
        for (table, least) in tile.tables.iter().zip(rows) {
            for disc in 0..problem.discs.len() {
                let looked = Looked::new(problem, course, table, disc);
                looked.lower_all::<L>(proof, &course.every_step, &course.coarse_twice, least);
            }
        }
    }

    /// Finds what no clearance is below.
    #[inline(always)]
    fn bound<L: Lanes>(
        &mut self,
        proof: L::Proof,
        problem: &Prepared,
        course: &Course,
        pooled: &Pooled,
    ) {
        let discs = problem.discs.len();
        let chunks = course.stride.div_ceil(course.chunk);
        self.lower
            .resize(chunks * discs * course.boxes, [0; GROUPS]);
        let mut place = 0;
        for chunk in course.coarse.chunks(course.chunk) {
            for (disc, body) in problem.discs.iter().enumerate() {
                let radius = L::splat(proof, body.radius);
                for number in 0..course.boxes {
                    let samples = in_box(chunk, course.boxes, number);
                    let speeds = [samples[0], samples[samples.len() - 1]];
                    for at in (0..course.groups).step_by(L::COUNT) {
                        let boxes = self
                            .spans
                            .boxes::<L>(proof, &problem.header, speeds, disc, at);
                        let least = pooled.least(proof, &boxes).sub(radius);
                        let missing = L::load(proof, &course.missing[at..]);
                        least.max(missing).store(&mut self.lower[place][at..]);
                    }
                    place += 1;
                }
            }
        }
        self.picks.resize_with(chunks * discs, Vec::new);
        for picks in &mut self.picks {
            picks.clear();
            picks.reserve(course.steps + PAIR);
        }
    }

    /// Picks the group that promises the smallest clearance, for each disc of each chunk; it is not picked again.
    #[inline(always)]
    fn pick_first<L: Lanes>(&mut self, proof: L::Proof, course: &Course) {
        let boxes = self.lower.chunks_exact_mut(course.boxes);
        for (boxes, picks) in boxes.zip(&mut self.picks) {
            let mut smallest = [i32::MAX; GROUPS];
            let mut bound = i32::MAX;
            for at in (0..course.groups).step_by(L::COUNT) {
                let mut least = L::splat(proof, i32::MAX);
                for lower in boxes.iter() {
                    least = least.min(L::load(proof, &lower[at..]));
                }
                least.store(&mut smallest[at..]);
                bound = bound.min(least.least());
            }
            let mut groups = [0; GROUPS];
            let mut count = 0;
            for at in (0..course.groups).step_by(L::COUNT) {
                let here = L::load(proof, &smallest[at..]).equal(L::splat(proof, bound));
                let numbers = lane_numbers::<L>(proof).add(L::splat(proof, at as i32));
                count += L::compress(here, numbers, &mut groups[count..]);
            }
            for lower in boxes {
                lower[groups[0] as usize] = i32::MAX;
            }
            list(course, &groups[..1], picks);
        }
    }

    /// Finds what a clearance must be below to matter, by those found so far.
    #[inline(always)]
    fn weigh<L: Lanes>(&mut self, proof: L::Proof, course: &Course, tile: &Tile<'_>) {
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
    fn pick<L: Lanes>(&mut self, proof: L::Proof, course: &Course, discs: usize) {
        let mut boxes = self.lower.chunks_exact(course.boxes);
        let mut lists = self.picks.iter_mut();
        for matters in self.matters.chunks(course.chunk) {
            for (boxes, picks) in boxes.by_ref().zip(lists.by_ref()).take(discs) {
                let mut groups = [0; GROUPS];
                let mut count = 0;
                for at in (0..course.groups).step_by(L::COUNT) {
                    let mut picked = L::none(proof);
                    for (number, lower) in boxes.iter().enumerate() {
                        let most = greatest(in_box(matters, course.boxes, number));
                        let lower = L::load(proof, &lower[at..]);
                        picked = L::either(picked, lower.less(L::splat(proof, most)));
                    }
                    let numbers = lane_numbers::<L>(proof).add(L::splat(proof, at as i32));
                    count += L::compress(picked, numbers, &mut groups[count..]);
                }
                list(course, &groups[..count], picks);
            }
        }
    }

    /// Looks at what was picked.
    #[inline(always)]
    fn meet_picks<L: Lanes>(
        &mut self,
        proof: L::Proof,
        problem: &Prepared,
        course: &Course,
        tile: &Tile<'_>,
    ) {
        // Row after row for the same list: its length is then foreseen.
        let discs = problem.discs.len();
        for (number, steps) in self.picks.iter().enumerate() {
            if steps.is_empty() {
                continue;
            }
            let first = number / discs * course.chunk;
            let end = (first + course.chunk).min(course.stride);
            let coarse = &course.coarse_twice[first..end];
            let rows = self.least.chunks_exact_mut(course.stride);
            for (table, least) in tile.tables.iter().zip(rows) {
                let looked = Looked::new(problem, course, table, number % discs);
                looked.lower_all::<L>(proof, steps, coarse, &mut least[first..end]);
            }
        }
    }
}

/// Lists the steps of these groups, the last one twice where they are not whole pairs.
#[inline(always)]
fn list(course: &Course, groups: &[i32], steps: &mut Vec<i32>) {
    steps.clear();
    for &group in groups {
        let first = group * course.group;
        steps.extend(first..first + course.group);
    }
    if let Some(&last) = steps.last()
        && !steps.len().is_multiple_of(PAIR)
    {
        steps.push(last);
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

/// The samples of one of the boxes that a chunk is divided into.
#[inline(always)]
fn in_box(samples: &[i32], boxes: usize, number: usize) -> &[i32] {
    let size = samples.len() / boxes;
    &samples[number * size..][..size]
}
