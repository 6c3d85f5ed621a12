//! The table of operations: in lanes and as scalar arithmetic.

use super::cases::{Case, Shared};
use super::lookups::lists;
use super::reductions::reductions;
use inbye::local::internals::lanes as arithmetic;
use inbye::local::internals::lanes::{Lanes, MAX_LANES};
use inbye::numeric;

/// The two implementations of an operation.
pub enum Way<L: Lanes> {
    /// Lane by lane.
    Each(fn(L::FeatureToken, L, L, &Shared) -> L, fn(i32, i32, &Shared) -> i32),
    /// All lanes of a vector together, returning a list.
    Whole(fn(L::FeatureToken, L, L, &Shared) -> Vec<i32>, fn(&[Case], &Shared) -> Vec<i32>),
}

/// Coefficients that leave all sums below 2^29.
const POLYNOMIAL: [i32; 4] = [-400_539, 17_993_950, -113_684_708, 341_774_852];

/// One operation.
pub struct Operation<L: Lanes> {
    pub name: &'static str,
    /// Maps any arguments to the domain that the trait documents.
    pub fit: fn(Case, &Shared) -> Case,
    pub way: Way<L>,
}

pub const fn each<L: Lanes>(
    name: &'static str,
    fit: fn(Case, &Shared) -> Case,
    lanes: fn(L::FeatureToken, L, L, &Shared) -> L,
    plain: fn(i32, i32, &Shared) -> i32,
) -> Operation<L> {
    let way = Way::Each(lanes, plain);
    Operation { name, fit, way }
}

pub const fn whole<L: Lanes>(
    name: &'static str,
    fit: fn(Case, &Shared) -> Case,
    lanes: fn(L::FeatureToken, L, L, &Shared) -> Vec<i32>,
    plain: fn(&[Case], &Shared) -> Vec<i32>,
) -> Operation<L> {
    let way = Way::Whole(lanes, plain);
    Operation { name, fit, way }
}

/// All operations.
pub fn operations<L: Lanes>() -> Vec<Operation<L>> {
    let shards =
        [moves(), sums(), reductions(), bits(), roots(), lists(), masks(), of_masks(), angles()];
    shards.into_iter().flatten().collect()
}

fn moves<L: Lanes>() -> Vec<Operation<L>> {
    vec![
        whole(
            "splat",
            any,
            |p, _, _, s| stored(L::splat(p, s.width)),
            |cases, s| vec![s.width; cases.len()],
        ),
        whole("load and store", any, |_, x, _, _| stored(x), firsts),
        whole(
            "load and store in a longer list",
            any,
            |p, x, _, _| {
                let mut list = [7; 2 * MAX_LANES];
                x.store(&mut list);
                L::load(p, &list).store(&mut list[MAX_LANES..]);
                let gap = list[L::COUNT..MAX_LANES].iter().all(|&word| word == 7);
                let end = list[MAX_LANES + L::COUNT..].iter().all(|&word| word == 7);
                let mut found = list[MAX_LANES..][..L::COUNT].to_vec();
                found.push(i32::from(gap && end));
                found
            },
            |cases, s| firsts(cases, s).into_iter().chain([1]).collect(),
        ),
    ]
}

fn sums<L: Lanes>() -> Vec<Operation<L>> {
    vec![
        each("add", any, |_, x, y, _| x.add(y), |x, y, _| x.wrapping_add(y)),
        each("sub", any, |_, x, y, _| x.sub(y), |x, y, _| x.wrapping_sub(y)),
        each("mul", any, |_, x, y, _| x.mul(y), |x, y, _| x.wrapping_mul(y)),
        each("mul_hi", any, |_, x, y, _| x.mul_hi(y), |x, y, _| numeric::mul_hi_i32(x, y)),
        each(
            "mul_halves",
            // The number is in both halves.
            |[x, y], _| [(x << 16) | (x & 0xFFFF), y],
            |_, x, y, _| x.mul_halves(y),
            |x, y, _| i32::from(x as i16).wrapping_mul(i32::from(y as i16) + (y >> 16)),
        ),
        each(
            "odd_polynomial",
            // Covers both ends of the domain.
            |[x, y], _| [if x == i32::MAX { 1 << 30 } else { x >> 1 }, y],
            |_, x, _, s| x.odd_polynomial(29 + s.bits % 3, POLYNOMIAL),
            |x, _, s| {
                let x = i64::from(x);
                let square = (x * x) >> 30;
                let next = |sum: i64, &one: &i32| ((sum * square) >> 30) + i64::from(one);
                let sum = POLYNOMIAL.iter().fold(0, next);
                ((sum * x) >> (29 + s.bits % 3)) as i32
            },
        ),
        each("min", any, |_, x, y, _| x.min(y), |x, y, _| x.min(y)),
        each("max", any, |_, x, y, _| x.max(y), |x, y, _| x.max(y)),
        each("abs", any, |_, x, _, _| x.abs(), |x, _, _| x.wrapping_abs()),
    ]
}

fn bits<L: Lanes>() -> Vec<Operation<L>> {
    vec![
        each("shl", any, |_, x, _, s| x.shl(s.bits), |x, _, s| x << s.bits),
        each("sar", any, |_, x, _, s| x.sar(s.bits), |x, _, s| x >> s.bits),
        each("shr", any, |_, x, _, s| x.shr(s.bits), |x, _, s| (x as u32 >> s.bits) as i32),
        each("shl_each", |[x, y], _| [x, y & 31], |_, x, y, _| x.shl_each(y), |x, y, _| x << y),
        each("and", any, |_, x, y, _| x.and(y), |x, y, _| x & y),
        each(
            "leading_zeros",
            |[x, y], _| [(x & i32::MAX).max(1), y],
            |_, x, _, _| x.leading_zeros(),
            |x, _, _| x.leading_zeros() as i32,
        ),
        each(
            "shift_round",
            any,
            |p, x, _, s| arithmetic::shift_round(p, x, s.bits.min(30)),
            |x, _, s| numeric::shift_round(x, s.bits.min(30)),
        ),
    ]
}

/// The largest divisor and quotient of `div_unsigned`.
const MAX_DIVISOR: u32 = 1 << 17;

/// A divisor from 1 to 2^17, and a value whose quotient is at most 2^17.
fn dividable([x, y]: Case, _: &Shared) -> Case {
    let divisor = y as u32 % MAX_DIVISOR + 1;
    let limit = u64::from(divisor) * u64::from(MAX_DIVISOR + 1);
    [(u64::from(x as u32) % limit) as i32, divisor as i32]
}

/// A multiple of such a divisor, or one less.
fn about_multiple([x, y]: Case, shared: &Shared) -> Case {
    let divisor = y as u32 % MAX_DIVISOR + 1;
    let most = MAX_DIVISOR.min(u32::MAX / divisor);
    let multiple = x as u32 % (most + 1) * divisor;
    [multiple.saturating_sub(shared.bits % 2) as i32, divisor as i32]
}

fn roots<L: Lanes>() -> Vec<Operation<L>> {
    vec![
        each(
            "div_unsigned",
            dividable,
            |_, x, y, _| x.div_unsigned(y),
            |x, y, _| (x as u32 / y as u32) as i32,
        ),
        each(
            "div_unsigned about multiples",
            about_multiple,
            |_, x, y, _| x.div_unsigned(y),
            |x, y, _| (x as u32 / y as u32) as i32,
        ),
        each("isqrt", any, |_, x, _, _| x.isqrt(), |x, _, _| (x as u32).isqrt() as i32),
        each(
            "isqrt about squares",
            |[x, y], s| {
                let root = x as u32 & 0xFFFF;
                let square = (root * root).wrapping_add(s.bits % 3).wrapping_sub(1);
                [square as i32, y]
            },
            |_, x, _, _| x.isqrt(),
            |x, _, _| (x as u32).isqrt() as i32,
        ),
        each("hypot", short, |_, x, y, _| x.hypot(y), |x, y, _| length(x, y)),
        each(
            "hypot about whole lengths",
            // (2a)^2 + (a^2 - 1)^2 is a square; (2a)^2 + (2a^2)^2 is one less than a square, which rounds up first.
            |[x, y], s| {
                let a = x % 4095;
                let long = if s.bits % 2 == 0 { a * a - 1 } else { 2 * a * a };
                let signed = if y < 0 { -long } else { long };
                if y & 1 == 0 { [2 * a, signed] } else { [signed, 2 * a] }
            },
            |_, x, y, _| x.hypot(y),
            |x, y, _| length(x, y),
        ),
    ]
}

/// Below 2^25 in absolute value.
fn short([x, y]: Case, _: &Shared) -> Case {
    [x % (1 << 25), y % (1 << 25)]
}

fn length(x: i32, y: i32) -> i32 {
    numeric::isqrt64(numeric::squared_length(x, y)) as i32
}

/// A mask as ones and zeros.
fn truth<L: Lanes>(token: L::FeatureToken, mask: L::Mask) -> L {
    L::select(mask, L::splat(token, 1), L::splat(token, 0))
}

/// Two masks of the same values; they differ where one value is negative.
fn two<L: Lanes>(x: L, y: L) -> (L::Mask, L::Mask) {
    (x.less(y), x.less_unsigned(y))
}

fn masks<L: Lanes>() -> Vec<Operation<L>> {
    vec![
        each("less", any, |p, x, y, _| truth(p, x.less(y)), |x, y, _| i32::from(x < y)),
        each(
            "less_unsigned",
            any,
            |p, x, y, _| truth(p, x.less_unsigned(y)),
            |x, y, _| i32::from((x as u32) < y as u32),
        ),
        each(
            "equal",
            // Often equal, otherwise different in one bit.
            |[x, y], s| [x, if y & 1 == 0 { x } else { x ^ (1 << s.bits) }],
            |p, x, y, _| truth(p, x.equal(y)),
            |x, y, _| i32::from(x == y),
        ),
        each(
            "select",
            any,
            |_, x, y, _| L::select(x.less(y), x, y.add(y)),
            |x, y, _| if x < y { x } else { y.wrapping_add(y) },
        ),
    ]
}

fn of_masks<L: Lanes>() -> Vec<Operation<L>> {
    vec![
        each("none", any, |p, _, _, _| truth(p, L::mask_none(p)), |_, _, _| 0),
        each(
            "mask_and",
            any,
            |p, x, y, _| {
                let (one, other) = two(x, y);
                truth(p, L::mask_and(one, other))
            },
            |x, y, _| i32::from(x < y && (x as u32) < y as u32),
        ),
        each(
            "mask_or",
            any,
            |p, x, y, _| {
                let (one, other) = two(x, y);
                truth(p, L::mask_or(one, other))
            },
            |x, y, _| i32::from(x < y || (x as u32) < y as u32),
        ),
        each(
            "mask_and_not",
            any,
            |p, x, y, _| {
                let (one, other) = two(x, y);
                truth(p, L::mask_and_not(one, other))
            },
            |x, y, _| i32::from(x < y && (x as u32) >= y as u32),
        ),
        whole(
            "bits",
            any,
            |_, x, y, _| vec![L::bitmask(x.less(y)) as i32],
            |cases, _| {
                let set = cases.iter().enumerate().filter(|(_, [x, y])| x < y);
                vec![set.fold(0, |bits, (lane, _)| bits | 1 << lane)]
            },
        ),
        whole(
            "compress",
            any,
            |_, x, y, _| {
                let mut list = [0; MAX_LANES];
                let count = L::compress(x.less(y), x, &mut list);
                let mut found = vec![count as i32];
                found.extend(&list[..count]);
                found
            },
            |cases, _| {
                let set = cases.iter().filter(|[x, y]| x < y);
                let kept: Vec<i32> = set.map(|case| case[0]).collect();
                [kept.len() as i32].into_iter().chain(kept).collect()
            },
        ),
    ]
}

fn angles<L: Lanes>() -> Vec<Operation<L>> {
    vec![
        each(
            "sin_q20",
            any,
            |p, x, _, _| arithmetic::sin_q20(p, x),
            |x, _, _| numeric::sin_q20(x as u32),
        ),
        each(
            "cos_q20",
            any,
            |p, x, _, _| arithmetic::cos_q20(p, x),
            |x, _, _| numeric::cos_q20(x as u32),
        ),
        each(
            "atan2_turn",
            // Above -2^31.
            |[x, y], _| [x.max(-i32::MAX), y.max(-i32::MAX)],
            |p, x, y, _| arithmetic::atan2_turn(p, y, x),
            |x, y, _| numeric::atan2_turn(y, x) as i32,
        ),
        each(
            "turn_size",
            any,
            |_, x, _, _| arithmetic::turn_size(x),
            |x, _, _| numeric::turn_size(x as u32) as i32,
        ),
    ]
}

pub const fn any(case: Case, _: &Shared) -> Case {
    case
}

pub fn stored<L: Lanes>(lanes: L) -> Vec<i32> {
    let mut list = vec![0; L::COUNT];
    lanes.store(&mut list);
    list
}

fn firsts(cases: &[Case], _: &Shared) -> Vec<i32> {
    cases.iter().map(|case| case[0]).collect()
}
