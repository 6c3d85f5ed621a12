//! What no clearance is below: for neighbouring samples of a tile, group of steps by group of steps.

use super::course::Course;
use super::groups::Groups;
use super::lanes::Lanes;
use super::patches::Patches;
use super::pooled::{Boxes, Pooled};
use super::sieve::Tile;
use super::spans::{GROUPS, Spans};
use super::table::lane_numbers;

/// The bounds of one tile.
#[derive(Debug, Default)]
pub struct Bounds {
    /// For each box of samples of each list ([`Tile::lists`]).
    lower: Vec<[i32; GROUPS]>,
}

impl Bounds {
    /// Finds them, by the cells that the samples visit; says to `patches` which cells those are.
    #[inline(always)]
    pub fn fill<L: Lanes>(
        &mut self,
        proof: L::Proof,
        tile: &Tile<'_>,
        (spans, pooled): (&Spans, &Pooled),
        patches: &mut Patches,
    ) {
        let Tile {
            problem, course, ..
        } = *tile;
        self.lower.resize(tile.lists() * course.boxes, [0; GROUPS]);
        if L::LOOKS_UP {
            patches.begin(tile);
        }
        let mut lists = self.lower.chunks_exact_mut(course.boxes).enumerate();
        for coarse in course.coarse.chunks(course.chunk) {
            for ((disc, body), (list, lower)) in problem.discs.iter().enumerate().zip(&mut lists) {
                let radius = L::splat(proof, body.radius);
                for at in (0..course.groups).step_by(L::COUNT) {
                    let missing = L::load(proof, &course.missing[at..]);
                    let mut visited = Boxes::<L>::nowhere(proof);
                    for (number, lower) in lower.iter_mut().enumerate() {
                        let samples = in_box(coarse, course.boxes, number);
                        let speeds = [samples[0], samples[samples.len() - 1]];
                        let boxes = spans.boxes::<L>(proof, &problem.header, speeds, disc, at);
                        let least = pooled.least(proof, &boxes).sub(radius);
                        least.max(missing).store(&mut lower[at..]);
                        visited = visited.with(boxes);
                    }
                    if L::LOOKS_UP {
                        patches.note(list, at, visited);
                    }
                }
            }
        }
    }

    /// Lists for each box of a list the group that promises it the smallest clearance. They are not told again.
    #[inline(always)]
    pub fn take_smallest<L: Lanes>(
        &mut self,
        proof: L::Proof,
        course: &Course,
        list: usize,
        groups: &mut Groups,
    ) {
        let boxes = &mut self.lower[list * course.boxes..][..course.boxes];
        groups.clear();
        let mut taken = 0_u32;
        for lower in &*boxes {
            let (mut group, mut bound) = (0, i32::MAX);
            for at in (0..course.groups).step_by(L::COUNT) {
                let lower = L::load(proof, &lower[at..]);
                let least = lower.least();
                if least < bound {
                    let here = L::bits(lower.equal(L::splat(proof, least)));
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

    /// Lists the groups in which a clearance can be below what matters to the samples of a list.
    #[inline(always)]
    pub fn below<L: Lanes>(
        &self,
        proof: L::Proof,
        course: &Course,
        list: usize,
        matters: &[i32],
        groups: &mut Groups,
    ) {
        let boxes = &self.lower[list * course.boxes..][..course.boxes];
        groups.clear();
        for at in (0..course.groups).step_by(L::COUNT) {
            let mut picked = L::none(proof);
            for (number, lower) in boxes.iter().enumerate() {
                let most = greatest(in_box(matters, course.boxes, number));
                let lower = L::load(proof, &lower[at..]);
                picked = L::either(picked, lower.less(L::splat(proof, most)));
            }
            let numbers = lane_numbers::<L>(proof).add(L::splat(proof, at as i32));
            groups.add::<L>(picked, numbers);
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

/// The samples of one of the boxes that a chunk is divided into.
#[inline(always)]
fn in_box(samples: &[i32], boxes: usize, number: usize) -> &[i32] {
    let size = samples.len() / boxes;
    &samples[number * size..][..size]
}
