//! Sixteen lanes with AVX-512.
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

use super::super::{Avx2, LARGE_TILE, Lanes, SMALL_TILE, Square};

const COUNT: usize = 16;

/// Rounds to integers without raising a flag.
const TOWARDS_ZERO: i32 = _MM_FROUND_TO_ZERO | _MM_FROUND_NO_EXC;

/// Copies the odd lanes to the even lanes.
const ODD_TWICE: i32 = 0b11_11_01_01;

/// Sixteen lanes.
#[derive(Clone, Copy, Debug)]
pub struct Avx512(__m512i);

/// Shows that the processor has AVX-512 F, BW, CD, DQ and VL, and all that the token of AVX2 shows.
#[derive(Clone, Copy, Debug)]
pub struct FeatureToken(());

impl Avx512 {
    /// A token, if the processor has the instructions.
    pub fn detect() -> Option<FeatureToken> {
        let has = Avx2::detect().is_some()
            && detected!("avx512f" "avx512bw" "avx512cd" "avx512dq" "avx512vl");
        has.then_some(FeatureToken(()))
    }
}

#[inline(always)]
fn halves(lanes: __m512i) -> (__m256i, __m256i) {
    run!((_mm512_castsi512_si256(lanes), _mm512_extracti64x4_epi64::<1>(lanes)))
}

/// Truncates both halves towards zero.
#[inline(always)]
fn truncate(low: __m512d, high: __m512d) -> Avx512 {
    run!(Avx512(_mm512_inserti64x4::<1>(
        _mm512_castsi256_si512(_mm512_cvttpd_epi32(low)),
        _mm512_cvttpd_epi32(high)
    )))
}

/// The upper halves of the products of the even and of the odd lanes.
#[inline(always)]
fn upper_halves(even: __m512i, odd: __m512i) -> Avx512 {
    run!(Avx512(_mm512_mask_blend_epi32(0xAAAA, _mm512_shuffle_epi32::<ODD_TWICE>(even), odd)))
}

/// `floor(sqrt(x^2 + y^2))` or one less, and a mask of the lanes with one less. The squares and their sum are exact.
/// Newton's step from a reciprocal root of 14 bits ends less than one below the root; a small subtrahend covers the
/// rounding.
#[inline(always)]
fn length(x: __m256i, y: __m256i) -> (__m512d, __mmask8) {
    run!({
        let (x, y) = (_mm512_cvtepi32_pd(x), _mm512_cvtepi32_pd(y));
        // Vanishes in every sum except that of zeros, which has no reciprocal.
        let next_to_nothing = _mm512_set1_pd(1.0 / (1_u64 << 60) as f64);
        let squared = _mm512_fmadd_pd(x, x, _mm512_fmadd_pd(y, y, next_to_nothing));
        let guess = _mm512_rsqrt14_pd(squared);
        let root = _mm512_mul_pd(squared, guess);
        let three = _mm512_set1_pd(3.0 - 1.0 / (1_u64 << 38) as f64);
        let twice = _mm512_fnmadd_pd(root, guess, three);
        let root = _mm512_mul_pd(_mm512_mul_pd(root, _mm512_set1_pd(0.5)), twice);
        let root = _mm512_roundscale_pd::<TOWARDS_ZERO>(root);
        let next = _mm512_add_pd(root, _mm512_set1_pd(1.0));
        let left = _mm512_fnmadd_pd(next, next, squared);
        let is_next = _mm512_cmp_pd_mask::<_CMP_GE_OQ>(left, _mm512_setzero_pd());
        (root, is_next)
    })
}

/// 32 bits of each 64-bit lane, from bit `bits`: of the first vector to the even lanes, of the second to the odd lanes.
#[inline(always)]
fn in_turn(even: __m512i, odd: __m512i, bits: u32) -> Avx512 {
    run!({
        let even = _mm512_srlv_epi64(even, _mm512_set1_epi64(i64::from(bits)));
        let odd = _mm512_sllv_epi64(odd, _mm512_set1_epi64(i64::from(32 - bits)));
        Avx512(_mm512_mask_blend_epi32(0xAAAA, even, odd))
    })
}

#[inline(always)]
fn odd(lanes: Avx512) -> __m512i {
    run!(_mm512_srli_epi64::<32>(lanes.0))
}

#[inline(always)]
fn count(bits: u32) -> __m512i {
    run!(_mm512_set1_epi32(bits as i32))
}

/// The bits of `mask` from one vector, the others from another.
#[inline(always)]
fn merged(mask: i32, from: __m512i, other: __m512i) -> __m512i {
    run!(_mm512_ternarylogic_epi32::<0xCA>(_mm512_set1_epi32(mask), from, other))
}

/// Indices in one register.
static PLACES: [u16; 32] = {
    let mut places = [0; 32];
    let mut place = 0;
    while place < 32 {
        places[place] = place as u16;
        place += 1;
    }
    places
};

/// Registers of a large register tile.
const REGISTERS: usize = LARGE_TILE * LARGE_TILE / 32;

/// The rows of a square, consecutively. A small square fills two registers.
#[derive(Clone, Copy, Debug)]
pub struct RegisterTile([__m512i; REGISTERS]);

/// Address of a row of a square.
#[inline(always)]
fn row_of<const SIDE: usize>(square: &Square<'_>, row: usize) -> *const u16 {
    let after = row.wrapping_sub(square.row) % SIDE;
    square.entries.as_ptr().wrapping_add(after * square.stride)
}

impl Lanes for Avx512 {
    const COUNT: usize = COUNT;
    type FeatureToken = FeatureToken;
    type Mask = __mmask16;

    same_calls! {
        set = _mm512_set1_epi32, load = _mm512_loadu_si512, store = _mm512_storeu_si512,
        add = _mm512_add_epi32, mul = _mm512_mul_epi32, right = _mm512_srli_epi64,
        and = _mm512_and_si512, abs = _mm512_abs_epi32
    }

    one_instruction! {
        add = _mm512_add_epi32,
        sub = _mm512_sub_epi32,
        mul = _mm512_mullo_epi32,
        and = _mm512_and_si512,
        min = _mm512_min_epi32,
        max = _mm512_max_epi32,
        min_dirty_high = _mm512_min_epu16,
        min_halves = _mm512_min_epu16,
        shl_each = _mm512_sllv_epi32,
        mul_halves = _mm512_madd_epi16,
    }

    shifts! {
        shl = _mm512_sllv_epi32,
        sar = _mm512_srav_epi32,
        shr = _mm512_srlv_epi32,
    }

    #[inline(always)]
    fn leading_zeros(self) -> Self {
        run!(Self(_mm512_lzcnt_epi32(self.0)))
    }

    #[inline(always)]
    fn div_unsigned(self, divisor: Self) -> Self {
        // Both roundings are down, so the float is less than one too small; the remainder corrects it.
        run!({
            let dividend = _mm512_cvt_roundepu32_ps::<TOWARDS_ZERO>(self.0);
            let floats =
                _mm512_div_round_ps::<TOWARDS_ZERO>(dividend, _mm512_cvtepi32_ps(divisor.0));
            let quotient = _mm512_cvttps_epi32(floats);
            let product = _mm512_mullo_epi32(quotient, divisor.0);
            let remainder = _mm512_sub_epi32(self.0, product);
            let little = _mm512_cmpge_epi32_mask(remainder, divisor.0);
            let one = _mm512_set1_epi32(1);
            Self(_mm512_mask_add_epi32(quotient, little, quotient, one))
        })
    }

    #[inline(always)]
    fn isqrt(self) -> Self {
        // Exact, see the portable lanes.
        let (low, high) = halves(self.0);
        run!(truncate(
            _mm512_sqrt_pd(_mm512_cvtepu32_pd(low)),
            _mm512_sqrt_pd(_mm512_cvtepu32_pd(high))
        ))
    }

    #[inline(always)]
    fn hypot(self, other: Self) -> Self {
        let ((x_low, x_high), (y_low, y_high)) = (halves(self.0), halves(other.0));
        let ((low, low_next), (high, high_next)) = (length(x_low, y_low), length(x_high, y_high));
        let lengths = truncate(low, high);
        run!({
            let next = _mm512_kunpackb(u16::from(high_next), u16::from(low_next));
            let one = _mm512_set1_epi32(1);
            Self(_mm512_mask_add_epi32(lengths.0, next, lengths.0, one))
        })
    }

    #[inline(always)]
    fn row_major(_: FeatureToken, x: Self, y: Self, bits: u32, width: i32) -> Self {
        run!({
            let column = _mm512_srav_epi32(x.0, count(bits));
            let row = _mm512_srav_epi32(y.0, count(bits - 16));
            // Row and column in one word: one instruction multiplies and adds both.
            let upper = _mm512_set1_epi32(0xFFFF << 16);
            let mask_and = _mm512_ternarylogic_epi32::<0xCA>(upper, row, column);
            Self(_mm512_madd_epi16(mask_and, _mm512_set1_epi32((width << 16) | 1)))
        })
    }

    #[inline(always)]
    fn gather_dirty_high(self, list: &[u16]) -> Self {
        // Each lane reads an entry and the next one, so the largest index is that of the last but one entry.
        let last = i32::try_from(list.len()).unwrap_or(i32::MAX) - 2;
        assert!(last >= 0, "a list to gather from has two entries at least");
        run!({
            let index = _mm512_min_epu32(self.0, _mm512_set1_epi32(last));
            Self(_mm512_i32gather_epi32::<2>(index, list.as_ptr().cast()))
        })
    }

    const LARGEST_REGISTER_TILE: usize = LARGE_TILE;
    type RegisterTile = RegisterTile;

    #[inline(always)]
    fn register_tile<const SIDE: usize>(_: FeatureToken, square: &Square<'_>) -> RegisterTile {
        let last = (SIDE - 1) * square.stride + SIDE;
        assert!(square.entries.len() >= last, "a square is within its grid");
        run!({
            // Columns are modulo the side, in each row.
            let places = _mm512_loadu_si512(PLACES.as_ptr().cast());
            let column = _mm512_set1_epi16(square.column as i16);
            let before = _mm512_sub_epi16(places, column);
            let within = _mm512_set1_epi16(SIDE as i16 - 1);
            let from = _mm512_ternarylogic_epi32::<0xCA>(within, before, places);
            let mut register_tile = [_mm512_setzero_si512(); REGISTERS];
            let mut number = 0;
            while number < SIDE * SIDE / 32 {
                let rows = if SIDE == SMALL_TILE {
                    let row = |number| _mm_loadu_si128(row_of::<SIDE>(square, number).cast());
                    let rows = _mm512_castsi128_si512(row(4 * number));
                    let rows = _mm512_inserti32x4::<1>(rows, row(4 * number + 1));
                    let rows = _mm512_inserti32x4::<2>(rows, row(4 * number + 2));
                    _mm512_inserti32x4::<3>(rows, row(4 * number + 3))
                } else {
                    let one = _mm256_loadu_si256(row_of::<SIDE>(square, 2 * number).cast());
                    let other = _mm256_loadu_si256(row_of::<SIDE>(square, 2 * number + 1).cast());
                    _mm512_inserti64x4::<1>(_mm512_castsi256_si512(one), other)
                };
                register_tile[number] = _mm512_permutexvar_epi16(from, rows);
                number += 1;
            }
            RegisterTile(register_tile)
        })
    }

    #[inline(always)]
    fn look_up<const SIDE: usize>(
        _: FeatureToken,
        RegisterTile(register_tile): &RegisterTile,
        (x, y): (Self, Self),
        (other_x, other_y): (Self, Self),
        bits: u32,
    ) -> Self {
        let side = SIDE.ilog2();
        let rows = (SIDE as i32 - 1) << side;
        run!({
            // Rows are shifted less than columns and end above them. The bits above both are ignored.
            let column = _mm512_srlv_epi32(x.0, count(bits));
            let row = _mm512_srlv_epi32(y.0, count(bits - side));
            let place = merged(rows, row, column);
            let column = _mm512_srlv_epi32(other_x.0, count(bits - 16));
            let row = _mm512_srlv_epi32(other_y.0, count(bits - side - 16));
            let other = merged(rows << 16, row, column);
            let place = merged(0xFFFF, place, other);
            let first = _mm512_permutex2var_epi16(register_tile[0], place, register_tile[1]);
            if SIDE == SMALL_TILE {
                return Self(first);
            }
            let second = _mm512_permutex2var_epi16(register_tile[2], place, register_tile[3]);
            let third = _mm512_permutex2var_epi16(register_tile[4], place, register_tile[5]);
            let fourth = _mm512_permutex2var_epi16(register_tile[6], place, register_tile[7]);
            let odd = _mm512_test_epi16_mask(place, _mm512_set1_epi16(1 << 6));
            let late = _mm512_test_epi16_mask(place, _mm512_set1_epi16(1 << 7));
            let one = _mm512_mask_blend_epi16(odd, first, second);
            let other = _mm512_mask_blend_epi16(odd, third, fourth);
            Self(_mm512_mask_blend_epi16(late, one, other))
        })
    }

    #[inline(always)]
    fn prefix_sums(self) -> Self {
        run!({
            let zero = _mm512_setzero_si512();
            let sums = _mm512_add_epi32(self.0, _mm512_alignr_epi32::<15>(self.0, zero));
            let sums = _mm512_add_epi32(sums, _mm512_alignr_epi32::<14>(sums, zero));
            let sums = _mm512_add_epi32(sums, _mm512_alignr_epi32::<12>(sums, zero));
            Self(_mm512_add_epi32(sums, _mm512_alignr_epi32::<8>(sums, zero)))
        })
    }

    #[inline(always)]
    fn last(self) -> i32 {
        run!(_mm_extract_epi32::<3>(_mm512_extracti32x4_epi32::<3>(self.0)))
    }

    #[inline(always)]
    fn reduce_min(self) -> i32 {
        run!(_mm512_reduce_min_epi32(self.0))
    }

    #[inline(always)]
    fn reduce_max(self) -> i32 {
        run!(_mm512_reduce_max_epi32(self.0))
    }

    #[inline(always)]
    fn reduce_sum_unsigned(self) -> u64 {
        let even = run!(_mm512_and_si512(self.0, _mm512_set1_epi64(0xFFFF_FFFF)));
        run!(_mm512_reduce_add_epi64(_mm512_add_epi64(even, odd(self)))) as u64
    }

    #[inline(always)]
    fn less(self, other: Self) -> __mmask16 {
        run!(_mm512_cmplt_epi32_mask(self.0, other.0))
    }

    #[inline(always)]
    fn less_unsigned(self, other: Self) -> __mmask16 {
        run!(_mm512_cmplt_epu32_mask(self.0, other.0))
    }

    #[inline(always)]
    fn equal(self, other: Self) -> __mmask16 {
        run!(_mm512_cmpeq_epi32_mask(self.0, other.0))
    }

    #[inline(always)]
    fn select(mask: __mmask16, yes: Self, no: Self) -> Self {
        run!(Self(_mm512_mask_blend_epi32(mask, no.0, yes.0)))
    }

    #[inline(always)]
    fn mask_none(_: FeatureToken) -> __mmask16 {
        0
    }

    #[inline(always)]
    fn mask_and(one: __mmask16, other: __mmask16) -> __mmask16 {
        one & other
    }

    #[inline(always)]
    fn mask_or(one: __mmask16, other: __mmask16) -> __mmask16 {
        one | other
    }

    #[inline(always)]
    fn mask_and_not(one: __mmask16, other: __mmask16) -> __mmask16 {
        one & !other
    }

    #[inline(always)]
    fn compress(mask: __mmask16, lanes: Self, to: &mut [i32]) -> usize {
        run!(Self(_mm512_maskz_compress_epi32(mask, lanes.0))).store(to);
        mask.count_ones() as usize
    }

    #[inline(always)]
    fn bitmask(mask: __mmask16) -> u32 {
        u32::from(mask)
    }
}
