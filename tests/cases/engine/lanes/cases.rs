//! Inputs of the operation tests: edge cases of integer arithmetic and random words of every size.

use std::sync::LazyLock;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use inbye::local::internals::lanes::{MAX_LANES, Square};

/// Inputs of one lane.
pub type Case = [i32; 2];

/// Inputs of all lanes of a vector.
#[derive(Clone, Copy, Debug)]
pub struct Shared {
    /// 0 to 31.
    pub bits: u32,
    /// 1 to 32767.
    pub width: i32,
}

impl Shared {
    /// A list to gather from, one entry longer than `width`.
    pub fn list(&self) -> &'static [u16] {
        &LIST[..=self.width as usize]
    }

    /// `bits` of `look_up`.
    pub const fn tile_bits(&self) -> u32 {
        20 + self.bits % 9
    }

    /// A square of a list with rows of 100.
    pub fn square(&self) -> Square<'static> {
        let first = (self.width % 30_000) as usize;
        Square { entries: &LIST[first..], stride: 100, column: first % 100, row: first / 100 }
    }

    /// The entry of a register tile of this square.
    pub fn entry<const SIDE: usize>(&self, x: i32, y: i32) -> i32 {
        let square = self.square();
        let after = |word: i32, first: usize| {
            let cell = (word as u32 >> self.tile_bits()) as usize;
            (cell + SIDE * first - first) % SIDE
        };
        let (column, row) = (after(x, square.column), after(y, square.row));
        i32::from(square.entries[row * square.stride + column])
    }
}

/// Cases for the largest number of lanes.
pub struct Group {
    pub shared: Shared,
    pub cases: [Case; MAX_LANES],
}

/// An odd factor makes all entries differ, so a lane that reads the wrong entry is detected.
static LIST: LazyLock<Vec<u16>> =
    LazyLock::new(|| (0..1_u32 << 15).map(|n| (n * 40_503) as u16).collect());

/// Number of random groups in addition to the edge cases.
const RANDOM_GROUPS: usize = 2000;

/// Zero, every power of two, its two neighbours, and the negatives of all these.
fn edges() -> Vec<i32> {
    let mut edges = vec![0];
    for bit in 0..32 {
        let power = 1_i32 << bit;
        for word in [power.wrapping_sub(1), power, power.wrapping_add(1)] {
            edges.extend([word, word.wrapping_neg()]);
        }
    }
    edges.sort_unstable();
    edges.dedup();
    edges
}

/// Every pair of edge cases, then random words of every size.
pub fn groups(seed: u64) -> Vec<Group> {
    let rng = &mut Pcg64Mcg::seed_from_u64(seed);
    let edges = edges();
    let mut cases = Vec::new();
    for &x in &edges {
        cases.extend(edges.iter().map(|&y| [x, y]));
    }
    let all = cases.len().next_multiple_of(MAX_LANES) + RANDOM_GROUPS * MAX_LANES;
    cases.resize_with(all, || [word(rng, &edges), word(rng, &edges)]);
    let (vectors, _) = cases.as_chunks::<MAX_LANES>();
    let group = |cases: &[Case; MAX_LANES]| Group {
        shared: Shared { bits: rng.random_range(0..32), width: width(rng) },
        cases: *cases,
    };
    vectors.iter().map(group).collect()
}

fn width(rng: &mut Pcg64Mcg) -> i32 {
    match rng.random_range(0..4) {
        0 => 1,
        1 => 32_767,
        2 => rng.random_range(2..20),
        _ => rng.random_range(1..=32_767),
    }
}

fn word(rng: &mut Pcg64Mcg, edges: &[i32]) -> i32 {
    match rng.random_range(0..4) {
        0 => edges[rng.random_range(0..edges.len())],
        1 => (rng.random::<u32>() >> rng.random_range(0..32)) as i32,
        2 => ((rng.random::<u32>() >> rng.random_range(0..32)) as i32).wrapping_neg(),
        _ => rng.random::<u32>() as i32,
    }
}
