//! Integer arithmetic shared by all engines. TWIN of `shaders/numeric.wgsl`: same names, same order, same bits.
//!
//! All values that decide a command are two's complement integers. Their sums are identical on every processor, unlike floats
//! in WGSL. Angles are binary angles: a full turn is 2^32, so a wrapped difference is a plain subtraction. `Qn` denotes a
//! fixed-point number with n fractional bits.

/// One in the fixed-point format of [`sin_q20`] and [`cos_q20`].
pub const ONE_Q20: i32 = 1 << 20;

/// A quarter turn as a binary angle.
pub const QUARTER_TURN: u32 = 1 << 30;

/// A half turn as a binary angle.
pub const HALF_TURN: u32 = 1 << 31;

/// The upper 32 bits of an unsigned product.
#[must_use]
#[inline]
pub const fn mul_hi_u32(a: u32, b: u32) -> u32 {
    ((a as u64 * b as u64) >> 32) as u32
}

/// The upper 32 bits of a signed product, rounded down.
#[must_use]
#[inline]
pub const fn mul_hi_i32(a: i32, b: i32) -> i32 {
    ((a as i64 * b as i64) >> 32) as i32
}

/// `value / 2^bits` rounded to nearest, halves up. `bits` is 0..=30 and the sum must not overflow.
#[must_use]
#[inline]
pub const fn shift_round(value: i32, bits: u32) -> i32 {
    value.wrapping_add((1 << bits) >> 1) >> bits
}

/// Sine of a binary angle in Q20, within 6e-7.
///
/// Folds the angle to at most a quarter turn to either side and evaluates an odd minimax polynomial of degree nine (error 3e-9
/// before rounding).
#[must_use]
#[inline]
pub const fn sin_q20(angle: u32) -> i32 {
    let signed = angle as i32;
    // Beyond a quarter turn, sin(x) = sin(half turn - x).
    let folded = if angle.wrapping_add(QUARTER_TURN) > HALF_TURN {
        (HALF_TURN as i32).wrapping_sub(signed)
    } else {
        signed
    };
    // One unit below the peak keeps the doubling in range; the sine is flat there.
    let peak = QUARTER_TURN as i32 - 1;
    let x = if folded > peak { peak } else { folded };
    let square = mul_hi_i32(x << 1, x << 1);
    let mut sum = 80_971;
    sum = mul_hi_i32(sum << 2, square) - 2_508_383;
    sum = mul_hi_i32(sum << 2, square) + 42_782_427;
    sum = mul_hi_i32(sum << 2, square) - 346_798_938;
    sum = mul_hi_i32(sum << 2, square) + 843_314_837;
    shift_round(mul_hi_i32(x << 1, sum << 1), 9)
}

/// Cosine of a binary angle in Q20, within 6e-7.
#[must_use]
#[inline]
pub const fn cos_q20(angle: u32) -> i32 {
    sin_q20(angle.wrapping_add(QUARTER_TURN))
}

/// Direction of the vector (x, y) as a binary angle, within 3e-5 rad; zero for the zero vector.
///
/// Each coordinate is above -2^31 and below 2^31.
#[must_use]
#[inline]
pub const fn atan2_turn(y: i32, x: i32) -> u32 {
    let (width, height) = (x.unsigned_abs(), y.unsigned_abs());
    let steep = height > width;
    let (long, short) = if steep { (height, width) } else { (width, height) };
    if long == 0 {
        return 0;
    }
    let scale = long.leading_zeros();
    let divisor = ((long << scale) >> 16) + (((long << scale) >> 15) & 1);
    let quotient = (short << scale) / divisor;
    let ratio = if quotient > 65_536 { 65_536 } else { quotient };
    let x_q30 = (ratio << 14) as i32;
    let square = mul_hi_i32(x_q30.wrapping_shl(1), x_q30.wrapping_shl(1));
    let mut sum = -4_005_397;
    sum = mul_hi_i32(sum << 2, square) + 17_993_950;
    sum = mul_hi_i32(sum << 2, square) - 39_792_550;
    sum = mul_hi_i32(sum << 2, square) + 66_148_740;
    sum = mul_hi_i32(sum << 2, square) - 113_684_708;
    sum = mul_hi_i32(sum << 2, square) + 341_774_852;
    let flat = mul_hi_u32((x_q30 as u32) << 1, (sum as u32) << 2);
    let octant = if steep { QUARTER_TURN - flat } else { flat };
    let half = if x < 0 { HALF_TURN - octant } else { octant };
    if y < 0 { half.wrapping_neg() } else { half }
}

/// Square root rounded down.
#[must_use]
#[inline]
pub const fn isqrt32(value: u32) -> u32 {
    value.isqrt()
}

/// Square root rounded down. `value` is below 2^62.
#[must_use]
#[inline]
pub const fn isqrt64(value: u64) -> u32 {
    value.isqrt() as u32
}

/// Squared length of a vector with coordinates below 2^30 in magnitude.
#[must_use]
#[inline]
pub const fn squared_length(x: i32, y: i32) -> u64 {
    let (width, height) = (x.unsigned_abs() as u64, y.unsigned_abs() as u64);
    width * width + height * height
}

/// Absolute value of a signed binary angle, 0..=2^31.
#[must_use]
#[inline]
pub const fn turn_size(angle: u32) -> u32 {
    (angle as i32).unsigned_abs()
}

/// `(upper * 2^32) / divisor` rounded down. `upper` is below `divisor`, so that the quotient fits in 32 bits.
#[must_use]
#[inline]
pub const fn div_wide(upper: u32, divisor: u32) -> u32 {
    (((upper as u64) << 32) / divisor as u64) as u32
}

/// `value * 2^-bits`, rounded down. `bits` may be negative, down to -63, if the result fits.
#[must_use]
#[inline]
pub const fn shift_wide(value: u64, bits: i32) -> u64 {
    if bits >= 64 {
        0
    } else if bits >= 0 {
        value >> bits
    } else {
        value << -bits
    }
}
