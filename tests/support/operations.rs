//! Every integer helper that the engines share, in Rust and as called in the shaders, over the same cases.

use inbye::local::internals::score::{Normalizer, normalizer, share};
use inbye::local::internals::select::better;
use inbye::numeric::{
    atan2_turn, cos_q20, div_wide, isqrt32, isqrt64, mul_hi_i32, mul_hi_u32, shift_round,
    shift_wide, sin_q20, squared_length, turn_size,
};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

/// Arguments of an operation.
pub type Arguments = [u32; 6];
/// Results; unused words are zero.
pub type Outcome = [u32; 4];

/// One operation.
pub struct Operation {
    pub name: &'static str,
    /// A WGSL expression of the arguments `a`, of type `vec4<u32>`; see `kernel.rs` for `one`, `two` and `int`.
    pub wgsl: &'static str,
    pub rust: fn(Arguments) -> Outcome,
    /// Maps any arguments to the operation's domain.
    pub fit: fn(Arguments) -> Arguments,
}

/// All operations.
pub const OPERATIONS: [Operation; 20] = [
    Operation {
        name: "mul_wide",
        wgsl: "two(mul_wide(a[0], a[1]))",
        rust: |a| two(u64::from(a[0]) * u64::from(a[1])),
        fit: any,
    },
    Operation {
        name: "mul_hi_u32",
        wgsl: "one(mul_hi_u32(a[0], a[1]))",
        rust: |a| one(mul_hi_u32(a[0], a[1])),
        fit: any,
    },
    Operation {
        name: "mul_hi_i32",
        wgsl: "int(mul_hi_i32(bitcast<i32>(a[0]), bitcast<i32>(a[1])))",
        rust: |a| int(mul_hi_i32(a[0] as i32, a[1] as i32)),
        fit: any,
    },
    Operation {
        name: "shift_round",
        wgsl: "int(shift_round(bitcast<i32>(a[0]), a[1]))",
        rust: |a| int(shift_round(a[0] as i32, a[1])),
        fit: |a| [a[0], a[1] % 31, 0, 0, 0, 0],
    },
    Operation {
        name: "sin_q20",
        wgsl: "int(sin_q20(a[0]))",
        rust: |a| int(sin_q20(a[0])),
        fit: any,
    },
    Operation {
        name: "cos_q20",
        wgsl: "int(cos_q20(a[0]))",
        rust: |a| int(cos_q20(a[0])),
        fit: any,
    },
    Operation {
        name: "atan2_turn",
        wgsl: "one(atan2_turn(bitcast<i32>(a[0]), bitcast<i32>(a[1])))",
        rust: |a| one(atan2_turn(a[0] as i32, a[1] as i32)),
        // Above -2^31.
        fit: |a| {
            let inside = |word: u32| if word == 1 << 31 { 0 } else { word };
            [inside(a[0]), inside(a[1]), 0, 0, 0, 0]
        },
    },
    Operation {
        name: "isqrt32",
        wgsl: "one(isqrt32(a[0]))",
        rust: |a| one(isqrt32(a[0])),
        fit: any,
    },
    Operation {
        name: "isqrt32 about squares",
        wgsl: "one(isqrt32(a[0]))",
        rust: |a| one(isqrt32(a[0])),
        fit: |a| {
            let root = a[0] & 0xffff;
            let square = (root * root).wrapping_add(a[1] % 3).wrapping_sub(1);
            [square, 0, 0, 0, 0, 0]
        },
    },
    Operation {
        name: "isqrt64",
        wgsl: "one(isqrt64(vec2<u32>(a[0], a[1])))",
        rust: |a| one(isqrt64(wide(a[0], a[1]))),
        // Below 2^62.
        fit: |a| [a[0], a[1] >> 2, 0, 0, 0, 0],
    },
    Operation {
        name: "isqrt64 about squares",
        wgsl: "one(isqrt64(vec2<u32>(a[0], a[1])))",
        rust: |a| one(isqrt64(wide(a[0], a[1]))),
        fit: |a| {
            let root = u64::from(a[0] >> 1);
            let square = (root * root + u64::from(a[1] % 3)).saturating_sub(1);
            [square as u32, (square >> 32) as u32, 0, 0, 0, 0]
        },
    },
    Operation {
        name: "squared_length",
        wgsl: "two(squared_length(bitcast<i32>(a[0]), bitcast<i32>(a[1])))",
        rust: |a| two(squared_length(a[0] as i32, a[1] as i32)),
        // Below 2^30 in absolute value.
        fit: |a| {
            let inside = |word: u32| (word as i32 % (1 << 30)) as u32;
            [inside(a[0]), inside(a[1]), 0, 0, 0, 0]
        },
    },
    Operation {
        name: "turn_size",
        wgsl: "one(turn_size(a[0]))",
        rust: |a| one(turn_size(a[0])),
        fit: any,
    },
    Operation {
        name: "div_wide",
        wgsl: "one(div_wide(a[0], a[1]))",
        rust: |a| one(div_wide(a[0], a[1])),
        // The dividend's upper half is below the divisor.
        fit: |a| {
            let divisor = a[1].max(1);
            [a[0] % divisor, divisor, 0, 0, 0, 0]
        },
    },
    Operation {
        name: "shift_wide",
        wgsl: "two(shift_wide(vec2<u32>(a[0], a[1]), bitcast<i32>(a[2])))",
        rust: |a| two(shift_wide(wide(a[0], a[1]), a[2] as i32)),
        fit: |a| [a[0], a[1], (a[2] % 160).wrapping_sub(63), 0, 0, 0],
    },
    Operation {
        name: "add_wide and sub_wide",
        wgsl: "vec4<u32>(add_wide(vec2<u32>(a[0], a[1]), vec2<u32>(a[2], a[3])), sub_wide(vec2<u32>(a[0], a[1]), vec2<u32>(a[2], a[3])))",
        rust: |a| {
            let (one, other) = (wide(a[0], a[1]), wide(a[2], a[3]));
            let [low, high, ..] = two(one.wrapping_add(other));
            let [lower, upper, ..] = two(one.wrapping_sub(other));
            [low, high, lower, upper]
        },
        fit: any,
    },
    Operation {
        name: "less_wide and leading_zeros_wide",
        wgsl: "vec4<u32>(select(0u, 1u, less_wide(vec2<u32>(a[0], a[1]), vec2<u32>(a[2], a[3]))), leading_zeros_wide(vec2<u32>(a[0], a[1])), 0u, 0u)",
        rust: |a| {
            let (one, other) = (wide(a[0], a[1]), wide(a[2], a[3]));
            [u32::from(one < other), one.leading_zeros(), 0, 0]
        },
        // Half of the upper halves are equal.
        fit: |a| [a[0], a[1], a[2], if a[4] & 1 == 0 { a[1] } else { a[3] }, 0, 0],
    },
    Operation {
        name: "normalizer",
        wgsl: "of_normalizer(normalizer(a[0], a[1], vec2<u32>(a[2], a[3])))",
        rust: |a| {
            let Normalizer { offset, mantissa, bits } = normalizer(a[0], a[1], wide(a[2], a[3]));
            [offset, mantissa, bits as u32, 0]
        },
        // Weights are at most 2^30; scales are sums of up to 2^22 terms below 2^24.
        fit: |a| [a[0], a[1].min(1 << 30), a[2], a[3] >> 18, 0, 0],
    },
    Operation {
        name: "share",
        wgsl: "two(share(a[0], Normalizer(a[1], a[2], bitcast<i32>(a[3]))))",
        rust: |a| {
            let by = Normalizer { offset: a[1], mantissa: a[2], bits: a[3] as i32 };
            two(share(a[0], &by))
        },
        // A term is at least its offset.
        fit: |a| [a[0].max(a[1]), a[1], a[2], (a[3] % 128).wrapping_sub(63), 0, 0],
    },
    Operation {
        name: "better",
        wgsl: "of_candidate(better(Candidate(vec2<u32>(a[0], a[1]), a[2]), Candidate(vec2<u32>(a[3], a[4]), a[5])))",
        rust: |a| {
            let one = (wide(a[0], a[1]) as i64, a[2]);
            let (score, index) = better(one, (wide(a[3], a[4]) as i64, a[5]));
            let [low, high, ..] = two(score as u64);
            [low, high, index, 0]
        },
        // Often equal scores or upper halves.
        fit: |mut a| {
            if a[2] & 1 == 0 {
                a[4] = a[1];
            }
            if a[2].trailing_zeros() >= 2 {
                a[3] = a[0];
            }
            a
        },
    },
];

/// Edge cases of integer arithmetic.
const EDGES: [u32; 16] = [
    0,
    1,
    2,
    3,
    0xffff,
    0x1_0000,
    0x1_0001,
    0x3fff_ffff,
    0x4000_0000,
    0x4000_0001,
    0x7fff_ffff,
    0x8000_0000,
    0x8000_0001,
    0xc000_0000,
    0xffff_fffe,
    0xffff_ffff,
];

/// Cases of an operation: every pair of edge cases in the first two arguments, then random words of every size.
pub fn cases(operation: &Operation, rng: &mut Pcg64Mcg) -> Vec<Arguments> {
    let mut cases = Vec::new();
    for first in EDGES {
        for second in EDGES {
            let [_, _, rest @ ..] = random(rng);
            let [c, d, e, f] = rest;
            cases.push((operation.fit)([first, second, c, d, e, f]));
        }
    }
    cases.extend((0..8000).map(|_| (operation.fit)(random(rng))));
    cases
}

fn random(rng: &mut Pcg64Mcg) -> Arguments {
    core::array::from_fn(|_| match rng.random_range(0..4) {
        0 => EDGES[rng.random_range(0..EDGES.len())],
        1 => rng.random::<u32>() >> rng.random_range(0..32),
        2 => (rng.random::<u32>() >> rng.random_range(0..32)).wrapping_neg(),
        _ => rng.random(),
    })
}

/// Describes how an operation's results differ from Rust's: their number, and the first few in hexadecimal.
pub fn differences(
    operation: &Operation,
    cases: &[Arguments],
    found: &[Outcome],
) -> Option<String> {
    let differing: Vec<String> = cases
        .iter()
        .zip(found)
        .filter(|(case, found)| (operation.rust)(**case) != **found)
        .map(|(case, found)| {
            format!("{case:x?} gives {found:x?}, not {:x?}", (operation.rust)(*case))
        })
        .collect();
    let missing = cases.len().abs_diff(found.len());
    if differing.is_empty() && missing == 0 {
        return None;
    }
    let first: Vec<&str> = differing.iter().take(4).map(String::as_str).collect();
    let (name, count, all) = (operation.name, differing.len(), cases.len());
    let wgsl = operation.wgsl;
    Some(format!(
        "{name}: {count} of {all} differ, {missing} missing, by {wgsl}: {}",
        first.join("; ")
    ))
}

fn any(arguments: Arguments) -> Arguments {
    arguments
}

const fn one(word: u32) -> Outcome {
    [word, 0, 0, 0]
}

const fn int(word: i32) -> Outcome {
    [word as u32, 0, 0, 0]
}

const fn two(wide: u64) -> Outcome {
    [wide as u32, (wide >> 32) as u32, 0, 0]
}

fn wide(low: u32, high: u32) -> u64 {
    u64::from(high) << 32 | u64::from(low)
}
