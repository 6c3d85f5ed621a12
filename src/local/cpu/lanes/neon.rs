//! Eight lanes with NEON, which every aarch64 processor has, in two registers.
#![expect(unsafe_code, reason = "vector instructions, fewer than the compiler makes of loops")]

// The lint applies only outside of tests.
#[cfg_attr(
    not(test),
    expect(clippy::wildcard_imports, reason = "every other name in this file is an intrinsic")
)]
use core::arch::aarch64::*;

use super::{LaneTask, Lanes, SMALL_TILE, Square};

const COUNT: usize = 8;

/// Lanes of a register.
const HALF: usize = COUNT / 2;

/// Runs an intrinsic.
macro_rules! run {
    ($call:expr) => {{
        // SAFETY: NEON belongs to the target. Addresses are those of arrays of the right length.
        unsafe { $call }
    }};
}

mod register_tile;

pub use register_tile::RegisterTile;

/// Eight lanes.
#[derive(Clone, Copy, Debug)]
pub struct Neon([int32x4_t; 2]);

/// All bits of a lane are set where true.
#[derive(Clone, Copy, Debug)]
pub struct Mask([uint32x4_t; 2]);

/// For each mask of four lanes, the bytes of its lanes in order. The other bytes are those of no lane.
static ORDERS: [[u8; 4 * HALF]; 1 << HALF] = orders();

const fn orders() -> [[u8; 4 * HALF]; 1 << HALF] {
    let mut orders = [[u8::MAX; 4 * HALF]; 1 << HALF];
    let mut mask = 0;
    while mask < orders.len() {
        let (mut lane, mut count) = (0, 0);
        while lane < HALF {
            if mask >> lane & 1 == 1 {
                let mut byte = 0;
                while byte < 4 {
                    orders[mask][4 * count + byte] = (4 * lane + byte) as u8;
                    byte += 1;
                }
                count += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    orders
}

impl Neon {
    #[inline(always)]
    fn map(self, function: impl Fn(int32x4_t) -> int32x4_t) -> Self {
        Self([function(self.0[0]), function(self.0[1])])
    }

    #[inline(always)]
    fn zip(self, other: Self, function: impl Fn(int32x4_t, int32x4_t) -> int32x4_t) -> Self {
        Self([function(self.0[0], other.0[0]), function(self.0[1], other.0[1])])
    }

    #[inline(always)]
    fn test(self, other: Self, function: impl Fn(int32x4_t, int32x4_t) -> uint32x4_t) -> Mask {
        Mask([function(self.0[0], other.0[0]), function(self.0[1], other.0[1])])
    }
}

impl Mask {
    #[inline(always)]
    fn zip(self, other: Self, function: impl Fn(uint32x4_t, uint32x4_t) -> uint32x4_t) -> Self {
        Self([function(self.0[0], other.0[0]), function(self.0[1], other.0[1])])
    }
}

/// Operations on pairs of lanes that are one instruction for each register.
macro_rules! one_instruction {
    ($($name:ident = $intrinsic:ident,)*) => {$(
        #[inline(always)]
        fn $name(self, other: Self) -> Self {
            self.zip(other, |one, other| run!($intrinsic(one, other)))
        }
    )*};
}

/// Comparisons that are one instruction for each register.
macro_rules! comparisons {
    ($($name:ident = $intrinsic:ident,)*) => {$(
        #[inline(always)]
        fn $name(self, other: Self) -> Mask {
            self.test(other, |one, other| run!($intrinsic(one, other)))
        }
    )*};
}

/// Operations on masks that are one instruction for each register.
macro_rules! on_masks {
    ($($name:ident = $intrinsic:ident,)*) => {$(
        #[inline(always)]
        fn $name(one: Mask, other: Mask) -> Mask {
            one.zip(other, |one, other| run!($intrinsic(one, other)))
        }
    )*};
}

/// The unsigned view of signed lanes.
#[inline(always)]
fn unsigned(lanes: int32x4_t) -> uint32x4_t {
    run!(vreinterpretq_u32_s32(lanes))
}

/// The signed view of unsigned lanes.
#[inline(always)]
fn signed(lanes: uint32x4_t) -> int32x4_t {
    run!(vreinterpretq_s32_u32(lanes))
}

/// The products of the lower and of the upper two lanes.
#[inline(always)]
fn products(one: int32x4_t, other: int32x4_t) -> (int64x2_t, int64x2_t) {
    run!((vmull_s32(vget_low_s32(one), vget_low_s32(other)), vmull_high_s32(one, other)))
}

/// A product divided by 2^`bits` and rounded down. The first factor is above -2^`bits` and below 2^`bits`. The instruction doubles
/// the product and takes its upper half.
#[inline(always)]
fn scaled_product(small: int32x4_t, other: int32x4_t, bits: u32) -> int32x4_t {
    run!(vqdmulhq_s32(vshlq_s32(small, vdupq_n_s32(31 - bits as i32)), other))
}

/// Square roots, rounded down, of integers that are exact as floats.
#[inline(always)]
fn roots(low: float64x2_t, high: float64x2_t) -> int32x4_t {
    run!({
        let low = vmovn_u64(vcvtq_u64_f64(vsqrtq_f64(low)));
        signed(vmovn_high_u64(low, vcvtq_u64_f64(vsqrtq_f64(high))))
    })
}

/// The squared lengths of two vectors; exact below 2^53.
#[inline(always)]
fn squared_lengths(x: int64x2_t, y: int64x2_t) -> float64x2_t {
    run!({
        let (x, y) = (vcvtq_f64_s64(x), vcvtq_f64_s64(y));
        vfmaq_f64(vmulq_f64(x, x), y, y)
    })
}

impl Lanes for Neon {
    const COUNT: usize = COUNT;
    type FeatureToken = ();
    type Mask = Mask;

    #[inline(always)]
    fn splat((): (), value: i32) -> Self {
        Self([run!(vdupq_n_s32(value)); 2])
    }

    #[inline(always)]
    fn load((): (), from: &[i32]) -> Self {
        let from = &from[..COUNT];
        run!(Self([vld1q_s32(from.as_ptr()), vld1q_s32(from[HALF..].as_ptr())]))
    }

    #[inline(always)]
    fn store(self, to: &mut [i32]) {
        let to = &mut to[..COUNT];
        run!(vst1q_s32(to.as_mut_ptr(), self.0[0]));
        run!(vst1q_s32(to[HALF..].as_mut_ptr(), self.0[1]));
    }

    one_instruction! {
        add = vaddq_s32,
        sub = vsubq_s32,
        mul = vmulq_s32,
        min = vminq_s32,
        max = vmaxq_s32,
        and = vandq_s32,
        shl_each = vshlq_s32,
    }

    #[inline(always)]
    fn mul_hi(self, other: Self) -> Self {
        self.zip(other, |one, other| {
            let (low, high) = products(one, other);
            run!(vuzp2q_s32(vreinterpretq_s32_s64(low), vreinterpretq_s32_s64(high)))
        })
    }

    #[inline(always)]
    fn odd_polynomial<const N: usize>(self, bits: u32, coefficients: [i32; N]) -> Self {
        self.map(|x| {
            // Twice the least or greatest value would not fit.
            let (low, high) = products(x, x);
            let square = run!(vshrn_high_n_s64::<30>(vshrn_n_s64::<30>(low), high));
            let mut sum = run!(vdupq_n_s32(coefficients[0]));
            for &coefficient in &coefficients[1..] {
                sum = scaled_product(sum, square, 30);
                sum = run!(vaddq_s32(sum, vdupq_n_s32(coefficient)));
            }
            scaled_product(sum, x, bits)
        })
    }

    #[inline(always)]
    fn shl(self, bits: u32) -> Self {
        self.map(|lanes| run!(vshlq_s32(lanes, vdupq_n_s32(bits as i32))))
    }

    #[inline(always)]
    fn sar(self, bits: u32) -> Self {
        self.map(|lanes| run!(vshlq_s32(lanes, vdupq_n_s32(-(bits as i32)))))
    }

    #[inline(always)]
    fn shr(self, bits: u32) -> Self {
        self.map(|lanes| signed(run!(vshlq_u32(unsigned(lanes), vdupq_n_s32(-(bits as i32))))))
    }

    #[inline(always)]
    fn mul_halves(self, halves: Self) -> Self {
        self.zip(halves, |number, halves| {
            run!({
                let number = vshrq_n_s32::<16>(vshlq_n_s32::<16>(number));
                vmulq_s32(number, vpaddlq_s16(vreinterpretq_s16_s32(halves)))
            })
        })
    }

    // A large tile does not fit in the registers.
    const LARGEST_REGISTER_TILE: usize = SMALL_TILE;
    type RegisterTile = RegisterTile;

    #[inline(always)]
    fn register_tile<const SIDE: usize>((): (), square: &Square<'_>) -> RegisterTile {
        RegisterTile::of::<SIDE>(square)
    }

    #[inline(always)]
    fn look_up<const SIDE: usize>(
        (): (),
        register_tile: &RegisterTile,
        (x, y): (Self, Self),
        (other_x, other_y): (Self, Self),
        bits: u32,
    ) -> Self {
        Self(register_tile.look_up::<SIDE>([x.0, other_x.0], [y.0, other_y.0], bits))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.map(|lanes| run!(vabsq_s32(lanes)))
    }

    #[inline(always)]
    fn leading_zeros(self) -> Self {
        self.map(|lanes| run!(vclzq_s32(lanes)))
    }

    #[inline(always)]
    fn div_unsigned(self, divisor: Self) -> Self {
        // The float is off by less than one; the remainder corrects it.
        self.zip(divisor, |value, divisor| {
            run!({
                let floats = (vcvtq_f32_u32(unsigned(value)), vcvtq_f32_s32(divisor));
                let quotient = vcvtq_s32_f32(vdivq_f32(floats.0, floats.1));
                let remainder = vmlsq_s32(value, quotient, divisor);
                // Minus one where true.
                let much = vshrq_n_s32::<31>(remainder);
                let little = signed(vcgeq_s32(remainder, divisor));
                vsubq_s32(vaddq_s32(quotient, much), little)
            })
        })
    }

    #[inline(always)]
    fn isqrt(self) -> Self {
        // Exact, see the portable lanes.
        self.map(|lanes| {
            run!({
                let low = vcvtq_f64_u64(vmovl_u32(vget_low_u32(unsigned(lanes))));
                roots(low, vcvtq_f64_u64(vmovl_high_u32(unsigned(lanes))))
            })
        })
    }

    #[inline(always)]
    fn hypot(self, other: Self) -> Self {
        // Exact, see the portable lanes.
        self.zip(other, |x, y| {
            run!({
                let low = squared_lengths(vmovl_s32(vget_low_s32(x)), vmovl_s32(vget_low_s32(y)));
                roots(low, squared_lengths(vmovl_high_s32(x), vmovl_high_s32(y)))
            })
        })
    }

    #[inline(always)]
    fn row_major((): (), x: Self, y: Self, bits: u32, width: i32) -> Self {
        x.sar(bits).zip(y.sar(bits), |column, row| run!(vmlaq_n_s32(column, row, width)))
    }

    #[inline(always)]
    fn gather_dirty_high(self, list: &[u16]) -> Self {
        assert!(!list.is_empty(), "a list to gather from has an entry at least");
        // Clamped lanes are indices of entries.
        let last = run!(vdupq_n_u32(list.len() as u32 - 1));
        self.map(|lanes| {
            let mut index = [0_u32; HALF];
            run!(vst1q_u32(index.as_mut_ptr(), vminq_u32(unsigned(lanes), last)));
            let entries = index.map(|index| i32::from(run!(*list.get_unchecked(index as usize))));
            run!(vld1q_s32(entries.as_ptr()))
        })
    }

    // The upper halves of gathered entries are zero.
    #[inline(always)]
    fn min_dirty_high(self, other: Self) -> Self {
        self.min(other)
    }

    #[inline(always)]
    fn mask_high(self) -> Self {
        self.and(Self::splat((), 0xFFFF))
    }

    #[inline(always)]
    fn min_halves(self, other: Self) -> Self {
        self.zip(other, |one, other| {
            run!({
                let (one, other) = (vreinterpretq_u16_s32(one), vreinterpretq_u16_s32(other));
                vreinterpretq_s32_u16(vminq_u16(one, other))
            })
        })
    }

    #[inline(always)]
    fn prefix_sums(self) -> Self {
        run!({
            let zero = vdupq_n_s32(0);
            let Self([low, high]) = self.map(|lanes| {
                let sums = vaddq_s32(lanes, vextq_s32::<3>(zero, lanes));
                vaddq_s32(sums, vextq_s32::<2>(zero, sums))
            });
            Self([low, vaddq_s32(high, vdupq_laneq_s32::<3>(low))])
        })
    }

    #[inline(always)]
    fn last(self) -> i32 {
        run!(vgetq_lane_s32::<3>(self.0[1]))
    }

    #[inline(always)]
    fn reduce_min(self) -> i32 {
        run!(vminvq_s32(vminq_s32(self.0[0], self.0[1])))
    }

    #[inline(always)]
    fn reduce_max(self) -> i32 {
        run!(vmaxvq_s32(vmaxq_s32(self.0[0], self.0[1])))
    }

    #[inline(always)]
    fn reduce_sum_unsigned(self) -> u64 {
        run!(vaddlvq_u32(unsigned(self.0[0])) + vaddlvq_u32(unsigned(self.0[1])))
    }

    comparisons! {
        less = vcltq_s32,
        equal = vceqq_s32,
    }

    #[inline(always)]
    fn less_unsigned(self, other: Self) -> Mask {
        self.test(other, |one, other| run!(vcltq_u32(unsigned(one), unsigned(other))))
    }

    #[inline(always)]
    fn select(mask: Mask, yes: Self, no: Self) -> Self {
        run!(Self([
            vbslq_s32(mask.0[0], yes.0[0], no.0[0]),
            vbslq_s32(mask.0[1], yes.0[1], no.0[1]),
        ]))
    }

    #[inline(always)]
    fn mask_none((): ()) -> Mask {
        Mask([run!(vdupq_n_u32(0)); 2])
    }

    on_masks! {
        mask_and = vandq_u32,
        mask_or = vorrq_u32,
        mask_and_not = vbicq_u32,
    }

    #[inline(always)]
    fn compress(mask: Mask, lanes: Self, to: &mut [i32]) -> usize {
        let to = &mut to[..COUNT];
        let bits = Self::bitmask(mask) as usize;
        let ordered = |lanes: int32x4_t, bits: usize| {
            let order = &ORDERS[bits & 0xF];
            run!({
                let bytes = vqtbl1q_u8(vreinterpretq_u8_s32(lanes), vld1q_u8(order.as_ptr()));
                vreinterpretq_s32_u8(bytes)
            })
        };
        let first = (bits & 0xF).count_ones() as usize;
        run!(vst1q_s32(to.as_mut_ptr(), ordered(lanes.0[0], bits)));
        run!(vst1q_s32(to[first..][..HALF].as_mut_ptr(), ordered(lanes.0[1], bits >> HALF)));
        first + (bits >> HALF).count_ones() as usize
    }

    #[inline(always)]
    fn bitmask(mask: Mask) -> u32 {
        const BITS: [[u32; HALF]; 2] = [[1, 2, 4, 8], [16, 32, 64, 128]];
        run!({
            let low = vandq_u32(mask.0[0], vld1q_u32(BITS[0].as_ptr()));
            vaddvq_u32(vorrq_u32(low, vandq_u32(mask.0[1], vld1q_u32(BITS[1].as_ptr()))))
        })
    }
}

/// Runs a task with NEON.
pub fn run_neon<T: LaneTask>(task: T) -> T::Output {
    task.run::<Neon>(())
}
