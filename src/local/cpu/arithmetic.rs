//! The operations of [`crate::numeric`] in lanes: same names, same order, same bits.

use super::lanes::Lanes;
use crate::numeric::{HALF_TURN, QUARTER_TURN};

/// `value / 2^bits` rounded to the nearest, halves up; `bits` is 0..=30.
#[must_use]
#[inline(always)]
pub fn shift_round<L: Lanes>(token: L::FeatureToken, value: L, bits: u32) -> L {
    value.add(L::splat(token, (1 << bits) >> 1)).sar(bits)
}

/// Sine of binary angles in Q20.
#[must_use]
#[inline(always)]
pub fn sin_q20<L: Lanes>(token: L::FeatureToken, angle: L) -> L {
    let half = L::splat(token, HALF_TURN as i32);
    let quarter = L::splat(token, QUARTER_TURN as i32);
    let beyond = half.less_unsigned(angle.add(quarter));
    let folded = L::select(beyond, half.sub(angle), angle);
    let x = folded.min(L::splat(token, QUARTER_TURN as i32 - 1));
    let sine = x.odd_polynomial(30, [80_971, -2_508_383, 42_782_427, -346_798_938, 843_314_837]);
    shift_round(token, sine, 9)
}

/// Cosine of binary angles in Q20.
#[must_use]
#[inline(always)]
pub fn cos_q20<L: Lanes>(token: L::FeatureToken, angle: L) -> L {
    sin_q20(token, angle.add(L::splat(token, QUARTER_TURN as i32)))
}

/// Directions of vectors (x, y) as binary angles; zero for the zero vector.
#[must_use]
#[inline(always)]
pub fn atan2_turn<L: Lanes>(token: L::FeatureToken, y: L, x: L) -> L {
    let zero = L::splat(token, 0);
    let one = L::splat(token, 1);
    let (width, height) = (x.abs(), y.abs());
    let steep = width.less(height);
    let (long, short) = (width.max(height), width.min(height));
    // The zero vector then has the ratio zero.
    let long = long.max(one);
    let scale = long.leading_zeros();
    // Upper halves, rounded to the nearest. They are at least 2^15, so no ratio exceeds 2^16.
    let divisor = long.shl_each(scale).shr(15).add(one).shr(1);
    let ratio = short.shl_each(scale).div_unsigned(divisor);
    let flat = ratio.shl(14).odd_polynomial(
        29,
        [-4_005_397, 17_993_950, -39_792_550, 66_148_740, -113_684_708, 341_774_852],
    );
    let octant = L::select(steep, L::splat(token, QUARTER_TURN as i32).sub(flat), flat);
    let back = x.less(zero);
    let half = L::select(back, L::splat(token, HALF_TURN as i32).sub(octant), octant);
    L::select(y.less(zero), zero.sub(half), half)
}

/// The absolute values of binary angles, 0..=2^31 as unsigned values.
#[must_use]
#[inline(always)]
pub fn turn_size<L: Lanes>(angle: L) -> L {
    angle.abs()
}
