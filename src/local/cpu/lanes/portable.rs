//! Lanes for any processor: loops over a short array, which the compiler vectorises.
#![expect(
    clippy::needless_range_loop,
    reason = "one index for several arrays is what compilers turn into vectors"
)]

use super::Lanes;

const COUNT: usize = 8;

/// Eight lanes in an array.
#[derive(Clone, Copy, Debug)]
pub struct Portable([i32; COUNT]);

/// All bits of a lane are set where true.
#[derive(Clone, Copy, Debug)]
pub struct Mask([i32; COUNT]);

impl Portable {
    #[inline(always)]
    fn map(self, function: impl Fn(i32) -> i32) -> Self {
        Self(self.0.map(function))
    }

    #[inline(always)]
    fn zip(self, other: Self, function: impl Fn(i32, i32) -> i32) -> Self {
        let mut result = [0; COUNT];
        for lane in 0..COUNT {
            result[lane] = function(self.0[lane], other.0[lane]);
        }
        Self(result)
    }

    #[inline(always)]
    fn test(self, other: Self, function: impl Fn(i32, i32) -> bool) -> Mask {
        Mask(self.zip(other, |one, other| -i32::from(function(one, other))).0)
    }
}

impl Mask {
    #[inline(always)]
    fn zip(self, other: Self, function: impl Fn(i32, i32) -> i32) -> Self {
        Self(Portable(self.0).zip(Portable(other.0), function).0)
    }
}

/// Operations on pairs of lanes.
macro_rules! on_pairs {
    ($($name:ident = $function:expr;)*) => {$(
        #[inline(always)]
        fn $name(self, other: Self) -> Self {
            self.zip(other, $function)
        }
    )*};
}

impl Lanes for Portable {
    const COUNT: usize = COUNT;
    type FeatureToken = ();
    type Mask = Mask;

    #[inline(always)]
    fn splat((): (), value: i32) -> Self {
        Self([value; COUNT])
    }

    #[inline(always)]
    fn load((): (), from: &[i32]) -> Self {
        let mut lanes = [0; COUNT];
        lanes.copy_from_slice(&from[..COUNT]);
        Self(lanes)
    }

    #[inline(always)]
    fn store(self, to: &mut [i32]) {
        to[..COUNT].copy_from_slice(&self.0);
    }

    on_pairs! {
        add = i32::wrapping_add;
        sub = i32::wrapping_sub;
        mul = i32::wrapping_mul;
        mul_hi = crate::numeric::mul_hi_i32;
        min = Ord::min;
        max = Ord::max;
        and = |one, other| one & other;
        shl_each = |value, bits| value.wrapping_shl(bits as u32);
        mul_halves = |number, halves| {
            i32::from(number as i16).wrapping_mul(i32::from(halves as i16) + (halves >> 16))
        };
        div_unsigned = |value, divisor| (value as u32 / divisor as u32) as i32;
        // Exact: the squares and their sum are integers below 2^53; for the root see `isqrt`.
        hypot = |x, y| {
            let (x, y) = (f64::from(x), f64::from(y));
            (x * x + y * y).sqrt() as i32
        };
        min_halves = |one, other| {
            let low = (one as u16).min(other as u16);
            let high = (one as u32 >> 16).min(other as u32 >> 16);
            (high << 16 | u32::from(low)) as i32
        };
    }

    #[inline(always)]
    fn odd_polynomial<const N: usize>(self, bits: u32, coefficients: [i32; N]) -> Self {
        let product = |bits| move |one, other| ((i64::from(one) * i64::from(other)) >> bits) as i32;
        let square = self.zip(self, product(30));
        let mut sum = Self::splat((), coefficients[0]);
        for &coefficient in &coefficients[1..] {
            sum = sum.zip(square, product(30));
            sum = sum.add(Self::splat((), coefficient));
        }
        sum.zip(self, product(bits))
    }

    #[inline(always)]
    fn shl(self, bits: u32) -> Self {
        self.map(|value| value.wrapping_shl(bits))
    }

    #[inline(always)]
    fn sar(self, bits: u32) -> Self {
        self.map(|value| value.wrapping_shr(bits))
    }

    #[inline(always)]
    fn shr(self, bits: u32) -> Self {
        self.map(|value| (value as u32).wrapping_shr(bits) as i32)
    }

    look_up_in_memory! {}

    #[inline(always)]
    fn abs(self) -> Self {
        self.map(i32::wrapping_abs)
    }

    #[inline(always)]
    fn leading_zeros(self) -> Self {
        self.map(|value| value.leading_zeros() as i32)
    }

    #[inline(always)]
    fn isqrt(self) -> Self {
        // Exact: the root of an integer below 2^32 is never within half an ulp below the next integer.
        self.map(|value| f64::from(value as u32).sqrt() as i32)
    }

    #[inline(always)]
    fn row_major((): (), x: Self, y: Self, bits: u32, width: i32) -> Self {
        let width = Self::splat((), width);
        y.sar(bits).mul(width).add(x.sar(bits))
    }

    #[inline(always)]
    fn gather_dirty_high(self, list: &[u16]) -> Self {
        let last = list.len() - 1;
        self.map(|index| i32::from(list[(index as u32 as usize).min(last)]))
    }

    #[inline(always)]
    fn min_dirty_high(self, other: Self) -> Self {
        self.min(other)
    }

    #[inline(always)]
    fn mask_high(self) -> Self {
        self
    }

    #[inline(always)]
    fn prefix_sums(mut self) -> Self {
        for lane in 1..COUNT {
            self.0[lane] = self.0[lane].wrapping_add(self.0[lane - 1]);
        }
        self
    }

    #[inline(always)]
    fn last(self) -> i32 {
        self.0[COUNT - 1]
    }

    #[inline(always)]
    fn reduce_min(self) -> i32 {
        self.0.into_iter().fold(i32::MAX, Ord::min)
    }

    #[inline(always)]
    fn reduce_max(self) -> i32 {
        self.0.into_iter().fold(i32::MIN, Ord::max)
    }

    #[inline(always)]
    fn reduce_sum_unsigned(self) -> u64 {
        self.0.into_iter().map(|lane| u64::from(lane as u32)).sum()
    }

    #[inline(always)]
    fn less(self, other: Self) -> Mask {
        self.test(other, |one, other| one < other)
    }

    #[inline(always)]
    fn less_unsigned(self, other: Self) -> Mask {
        self.test(other, |one, other| (one as u32) < other as u32)
    }

    #[inline(always)]
    fn equal(self, other: Self) -> Mask {
        self.test(other, |one, other| one == other)
    }

    #[inline(always)]
    fn select(mask: Mask, yes: Self, no: Self) -> Self {
        let mut result = [0; COUNT];
        for lane in 0..COUNT {
            result[lane] = (yes.0[lane] & mask.0[lane]) | (no.0[lane] & !mask.0[lane]);
        }
        Self(result)
    }

    #[inline(always)]
    fn mask_none((): ()) -> Mask {
        Mask([0; COUNT])
    }

    #[inline(always)]
    fn mask_and(one: Mask, other: Mask) -> Mask {
        one.zip(other, |one, other| one & other)
    }

    #[inline(always)]
    fn mask_or(one: Mask, other: Mask) -> Mask {
        one.zip(other, |one, other| one | other)
    }

    #[inline(always)]
    fn mask_and_not(one: Mask, other: Mask) -> Mask {
        one.zip(other, |one, other| one & !other)
    }

    #[inline(always)]
    fn compress(mask: Mask, lanes: Self, to: &mut [i32]) -> usize {
        let to = &mut to[..COUNT];
        let mut count = 0;
        for lane in 0..COUNT {
            to[count.min(lane)] = lanes.0[lane];
            count += (mask.0[lane] & 1) as usize;
        }
        count
    }

    #[inline(always)]
    fn bitmask(mask: Mask) -> u32 {
        let mut bits = 0;
        for (lane, value) in mask.0.into_iter().enumerate() {
            bits |= (value & 1) << lane;
        }
        bits as u32
    }
}
