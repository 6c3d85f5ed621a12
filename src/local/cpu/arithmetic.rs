//! The operations of [`crate::numeric`] on many lanes: same names, same order, same bits.

use super::lanes::Lanes;
use crate::numeric::{HALF_TURN, QUARTER_TURN};

/// Upper half of a product with itself, of a number doubled first.
#[inline(always)]
fn square_of_doubled<L: Lanes>(x: L) -> L {
    let doubled = x.add(x);
    doubled.mul_hi(doubled)
}

/// `value / 2^bits` rounded to the nearest, halves up; `bits` is 0..=30.
#[inline(always)]
pub fn shift_round<L: Lanes>(proof: L::Proof, value: L, bits: u32) -> L {
    value.add(L::splat(proof, (1 << bits) >> 1)).sar(bits)
}

/// Sine of binary angles in Q20.
#[inline(always)]
pub fn sin_q20<L: Lanes>(proof: L::Proof, angle: L) -> L {
    let half = L::splat(proof, HALF_TURN as i32);
    let quarter = L::splat(proof, QUARTER_TURN as i32);
    let beyond = half.less_unsigned(angle.add(quarter));
    let folded = L::select(beyond, half.sub(angle), angle);
    let x = folded.min(L::splat(proof, QUARTER_TURN as i32 - 1));
    let square = square_of_doubled(x);
    let sum = L::polynomial(
        proof,
        square,
        [80_971, -2_508_383, 42_782_427, -346_798_938, 843_314_837],
    );
    shift_round(proof, x.shl(1).mul_hi(sum.shl(1)), 9)
}

/// Cosine of binary angles in Q20.
#[inline(always)]
pub fn cos_q20<L: Lanes>(proof: L::Proof, angle: L) -> L {
    sin_q20(proof, angle.add(L::splat(proof, QUARTER_TURN as i32)))
}

/// Directions of vectors (x, y) as binary angles; zero for the zero vector.
#[inline(always)]
pub fn atan2_turn<L: Lanes>(proof: L::Proof, y: L, x: L) -> L {
    let zero = L::splat(proof, 0);
    let one = L::splat(proof, 1);
    let (width, height) = (x.abs(), y.abs());
    let steep = width.less(height);
    let (long, short) = (width.max(height), width.min(height));
    let nowhere = long.equal(zero);
    let long = long.max(one);
    let scale = long.leading_zeros();
    let scaled = long.shl_each(scale);
    let divisor = scaled.shr(16).add(scaled.shr(15).and(one));
    let ratio = short
        .shl_each(scale)
        .div_unsigned(divisor)
        .min(L::splat(proof, 65_536));
    let x_q30 = ratio.shl(14);
    let square = square_of_doubled(x_q30);
    let sum = L::polynomial(
        proof,
        square,
        [
            -4_005_397,
            17_993_950,
            -39_792_550,
            66_148_740,
            -113_684_708,
            341_774_852,
        ],
    );
    let flat = x_q30.shl(1).mul_hi_unsigned(sum.shl(2));
    let octant = L::select(steep, L::splat(proof, QUARTER_TURN as i32).sub(flat), flat);
    let back = x.less(zero);
    let half = L::select(back, L::splat(proof, HALF_TURN as i32).sub(octant), octant);
    let direction = L::select(y.less(zero), zero.sub(half), half);
    L::select(nowhere, zero, direction)
}

/// The sizes of binary angles' turns either way, 0..=2^31 as unsigned values.
#[inline(always)]
pub fn turn_size<L: Lanes>(angle: L) -> L {
    angle.abs()
}
