//! Eight lanes with AVX2.
#![expect(
    unsafe_code,
    reason = "vector instructions, several times the speed of the portable lanes"
)]

// The lint applies only outside of tests.
#[cfg_attr(
    not(test),
    expect(clippy::wildcard_imports, reason = "every other name in this file is an intrinsic")
)]
use core::arch::x86_64::*;

use super::super::Lanes;

const COUNT: usize = 8;

/// Swaps the halves of four lanes.
const HALVES: i32 = 0b01_00_11_10;

/// Swaps the lanes of each half.
const PAIRS: i32 = 0b10_11_00_01;

/// Eight lanes.
#[derive(Clone, Copy, Debug)]
pub struct Avx2(__m256i);

/// All bits of a lane are set where true.
#[derive(Clone, Copy, Debug)]
pub struct Mask(__m256i);

/// Shows that the processor has AVX2 and the bit manipulation instructions up to it.
#[derive(Clone, Copy, Debug)]
pub struct FeatureToken(());

/// For each mask, the indices of its lanes in order.
static ORDERS: [[i32; COUNT]; 256] = orders();

const fn orders() -> [[i32; COUNT]; 256] {
    let mut orders = [[0; COUNT]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut lane, mut count) = (0, 0);
        while lane < COUNT {
            if mask >> lane & 1 == 1 {
                orders[mask][count] = lane as i32;
                count += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    orders
}

impl Avx2 {
    /// A token, if the processor has the instructions.
    pub fn detect() -> Option<FeatureToken> {
        detected!("avx2" "bmi1" "bmi2" "lzcnt" "popcnt").then_some(FeatureToken(()))
    }
}

#[inline(always)]
fn halves(lanes: __m256i) -> (__m128i, __m128i) {
    run!((_mm256_castsi256_si128(lanes), _mm256_extracti128_si256::<1>(lanes)))
}

/// Truncates both halves towards zero.
#[inline(always)]
fn truncate(low: __m256d, high: __m256d) -> Avx2 {
    run!(Avx2(_mm256_set_m128i(_mm256_cvttpd_epi32(high), _mm256_cvttpd_epi32(low))))
}

/// The upper halves of the products of the even and of the odd lanes.
#[inline(always)]
fn upper_halves(even: __m256i, odd: __m256i) -> Avx2 {
    run!(Avx2(_mm256_blend_epi32::<0xAA>(_mm256_srli_epi64::<32>(even), odd)))
}

#[inline(always)]
fn length(x: __m128i, y: __m128i) -> __m256d {
    run!({
        let (x, y) = (_mm256_cvtepi32_pd(x), _mm256_cvtepi32_pd(y));
        _mm256_sqrt_pd(_mm256_add_pd(_mm256_mul_pd(x, x), _mm256_mul_pd(y, y)))
    })
}

/// 32 bits of each 64-bit lane, from bit `bits`: of the first vector to the even lanes, of the second to the odd lanes.
#[inline(always)]
fn in_turn(even: __m256i, odd: __m256i, bits: u32) -> Avx2 {
    run!({
        let even = _mm256_srlv_epi64(even, _mm256_set1_epi64x(i64::from(bits)));
        let odd = _mm256_sllv_epi64(odd, _mm256_set1_epi64x(i64::from(32 - bits)));
        Avx2(_mm256_blend_epi32::<0xAA>(even, odd))
    })
}

#[inline(always)]
fn odd(lanes: Avx2) -> __m256i {
    run!(_mm256_srli_epi64::<32>(lanes.0))
}

#[inline(always)]
fn count(bits: u32) -> __m256i {
    run!(_mm256_set1_epi32(bits as i32))
}

/// Maps the order of unsigned values to that of signed values.
#[inline(always)]
fn flip_sign(lanes: __m256i) -> __m256i {
    run!(_mm256_xor_si256(lanes, _mm256_set1_epi32(i32::MIN)))
}

/// Converts unsigned values to floats: flips them to the signed range, then adds 2^31.
#[inline(always)]
fn floats(lanes: __m256i) -> (__m256d, __m256d) {
    let (low, high) = halves(flip_sign(lanes));
    run!({
        let back = _mm256_set1_pd(2_147_483_648.0);
        (
            _mm256_add_pd(_mm256_cvtepi32_pd(low), back),
            _mm256_add_pd(_mm256_cvtepi32_pd(high), back),
        )
    })
}

/// Reductions of all lanes by an operation on pairs.
macro_rules! reductions {
    ($($name:ident = $intrinsic:ident,)*) => {$(
        #[inline(always)]
        fn $name(self) -> i32 {
            let (low, high) = halves(self.0);
            run!({
                let four = $intrinsic(low, high);
                let two = $intrinsic(four, _mm_shuffle_epi32::<HALVES>(four));
                _mm_cvtsi128_si32($intrinsic(two, _mm_shuffle_epi32::<PAIRS>(two)))
            })
        }
    )*};
}

impl Lanes for Avx2 {
    const COUNT: usize = COUNT;
    type FeatureToken = FeatureToken;
    type Mask = Mask;

    same_calls! {
        set = _mm256_set1_epi32, load = _mm256_loadu_si256, store = _mm256_storeu_si256,
        add = _mm256_add_epi32, mul = _mm256_mul_epi32, right = _mm256_srli_epi64,
        and = _mm256_and_si256, abs = _mm256_abs_epi32
    }

    one_instruction! {
        add = _mm256_add_epi32,
        sub = _mm256_sub_epi32,
        mul = _mm256_mullo_epi32,
        and = _mm256_and_si256,
        min = _mm256_min_epi32,
        max = _mm256_max_epi32,
        min_dirty_high = _mm256_min_epu16,
        min_halves = _mm256_min_epu16,
        shl_each = _mm256_sllv_epi32,
        mul_halves = _mm256_madd_epi16,
    }

    shifts! {
        shl = _mm256_sllv_epi32,
        sar = _mm256_srav_epi32,
        shr = _mm256_srlv_epi32,
    }

    look_up_in_memory! {}

    #[inline(always)]
    fn leading_zeros(self) -> Self {
        // The exponent of a float is the position of the highest bit. Without the bit below the highest, rounding
        // cannot reach the next power of two.
        run!({
            let kept = _mm256_andnot_si256(_mm256_srli_epi32::<1>(self.0), self.0);
            let float = _mm256_castps_si256(_mm256_cvtepi32_ps(kept));
            let highest = _mm256_srli_epi32::<23>(float);
            Self(_mm256_sub_epi32(_mm256_set1_epi32(127 + 31), highest))
        })
    }

    #[inline(always)]
    fn div_unsigned(self, divisor: Self) -> Self {
        // The float is off by less than one; the remainder corrects it. Half of an unsigned value fits a signed one.
        run!({
            let half = _mm256_cvtepi32_ps(_mm256_srli_epi32::<1>(self.0));
            let floats = _mm256_div_ps(_mm256_add_ps(half, half), _mm256_cvtepi32_ps(divisor.0));
            let quotient = _mm256_cvttps_epi32(floats);
            let product = _mm256_mullo_epi32(quotient, divisor.0);
            let remainder = _mm256_sub_epi32(self.0, product);
            // Minus one where true.
            let much = _mm256_srai_epi32::<31>(remainder);
            let enough = _mm256_cmpgt_epi32(divisor.0, remainder);
            let little = _mm256_andnot_si256(enough, _mm256_set1_epi32(1));
            Self(_mm256_add_epi32(_mm256_add_epi32(quotient, much), little))
        })
    }

    #[inline(always)]
    fn isqrt(self) -> Self {
        // Exact, see the portable lanes.
        let (low, high) = floats(self.0);
        run!(truncate(_mm256_sqrt_pd(low), _mm256_sqrt_pd(high)))
    }

    #[inline(always)]
    fn hypot(self, other: Self) -> Self {
        // Exact, see the portable lanes.
        let ((x_low, x_high), (y_low, y_high)) = (halves(self.0), halves(other.0));
        truncate(length(x_low, y_low), length(x_high, y_high))
    }

    #[inline(always)]
    fn row_major(_: FeatureToken, x: Self, y: Self, bits: u32, width: i32) -> Self {
        run!({
            let column = _mm256_srav_epi32(x.0, count(bits));
            let row = _mm256_srav_epi32(y.0, count(bits - 16));
            // Row and column in one word: one instruction multiplies and adds both.
            let mask_and = _mm256_blend_epi16::<0xAA>(column, row);
            Self(_mm256_madd_epi16(mask_and, _mm256_set1_epi32((width << 16) | 1)))
        })
    }

    #[inline(always)]
    fn gather_dirty_high(self, list: &[u16]) -> Self {
        // Each lane reads an entry and the next one, so the largest index is that of the last but one entry.
        let last = i32::try_from(list.len()).unwrap_or(i32::MAX) - 2;
        assert!(last >= 0, "a list to gather from has two entries at least");
        run!({
            let index = _mm256_min_epu32(self.0, _mm256_set1_epi32(last));
            Self(_mm256_i32gather_epi32::<2>(list.as_ptr().cast(), index))
        })
    }

    #[inline(always)]
    fn prefix_sums(self) -> Self {
        run!({
            // In each half, then the sum of the first half is added to the second.
            let sums = _mm256_add_epi32(self.0, _mm256_slli_si256::<4>(self.0));
            let sums = _mm256_add_epi32(sums, _mm256_slli_si256::<8>(sums));
            let first = _mm256_permute2x128_si256::<0x08>(sums, sums);
            Self(_mm256_add_epi32(sums, _mm256_shuffle_epi32::<0xFF>(first)))
        })
    }

    #[inline(always)]
    fn last(self) -> i32 {
        run!(_mm256_extract_epi32::<7>(self.0))
    }

    reductions! {
        reduce_min = _mm_min_epi32,
        reduce_max = _mm_max_epi32,
    }

    #[inline(always)]
    fn reduce_sum_unsigned(self) -> u64 {
        run!({
            let even = _mm256_and_si256(self.0, _mm256_set1_epi64x(0xFFFF_FFFF));
            let four = _mm256_add_epi64(even, odd(self));
            let two =
                _mm_add_epi64(_mm256_castsi256_si128(four), _mm256_extracti128_si256::<1>(four));
            _mm_cvtsi128_si64(_mm_add_epi64(two, _mm_unpackhi_epi64(two, two))) as u64
        })
    }

    #[inline(always)]
    fn less(self, other: Self) -> Mask {
        run!(Mask(_mm256_cmpgt_epi32(other.0, self.0)))
    }

    #[inline(always)]
    fn less_unsigned(self, other: Self) -> Mask {
        run!(Mask(_mm256_cmpgt_epi32(flip_sign(other.0), flip_sign(self.0))))
    }

    #[inline(always)]
    fn equal(self, other: Self) -> Mask {
        run!(Mask(_mm256_cmpeq_epi32(self.0, other.0)))
    }

    #[inline(always)]
    fn select(mask: Mask, yes: Self, no: Self) -> Self {
        run!(Self(_mm256_blendv_epi8(no.0, yes.0, mask.0)))
    }

    #[inline(always)]
    fn mask_none(_: FeatureToken) -> Mask {
        run!(Mask(_mm256_setzero_si256()))
    }

    #[inline(always)]
    fn mask_and(one: Mask, other: Mask) -> Mask {
        run!(Mask(_mm256_and_si256(one.0, other.0)))
    }

    #[inline(always)]
    fn mask_or(one: Mask, other: Mask) -> Mask {
        run!(Mask(_mm256_or_si256(one.0, other.0)))
    }

    #[inline(always)]
    fn mask_and_not(one: Mask, other: Mask) -> Mask {
        run!(Mask(_mm256_andnot_si256(other.0, one.0)))
    }

    #[inline(always)]
    fn compress(mask: Mask, lanes: Self, to: &mut [i32]) -> usize {
        let bits = Self::bitmask(mask);
        let order = &ORDERS[bits as usize & 0xFF];
        run!({
            let order = _mm256_loadu_si256(order.as_ptr().cast());
            Self(_mm256_permutevar8x32_epi32(lanes.0, order)).store(to);
        });
        bits.count_ones() as usize
    }

    #[inline(always)]
    fn bitmask(mask: Mask) -> u32 {
        run!(_mm256_movemask_ps(_mm256_castsi256_ps(mask.0)) as u32)
    }
}
