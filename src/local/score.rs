//! The four terms of a trajectory, their normalisation and the score. TWIN of `shaders/score.wgsl`.

use super::engine::{Terms, Totals};
use super::kernel_inputs::{Header, VxSample};
use crate::numeric::{
    HALF_TURN, atan2_turn, div_wide, isqrt64, shift_wide, squared_length, turn_size,
};

/// The terms of an admissible sample (eqs. 32 and 34) whose final position is in fine units relative to the start.
#[must_use]
pub fn terms(
    header: &Header,
    vx: &VxSample,
    end_heading: u32,
    (end_x, end_y): (i32, i32),
    clearance: u32,
) -> Terms {
    let to_key_x = header.key_x - end_x;
    let to_key_y = header.key_y - end_y;
    Terms {
        heading: heading_term(header.target_x - end_x, header.target_y - end_y, end_heading),
        clearance,
        velocity: vx.velocity_term,
        path: isqrt64(squared_length(to_key_x, to_key_y)),
    }
}

/// Half a turn minus the angle between the heading and the direction to the target; 2^23 is half a turn. At the target
/// itself every heading is perfect.
fn heading_term(to_target_x: i32, to_target_y: i32, heading: u32) -> u32 {
    if to_target_x == 0 && to_target_y == 0 {
        return HALF_TURN >> 8;
    }
    let direction = atan2_turn(to_target_y, to_target_x);
    (HALF_TURN - turn_size(direction.wrapping_sub(heading))) >> 8
}

/// The factor from a term to its weighted share: `(term - offset) * mantissa * 2^-bits`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Normalizer {
    /// Subtracted from the term first: the minimum of the term in min-max mode, otherwise zero.
    pub offset: u32,
    /// At least 2^31; zero for a term that contributes nothing.
    pub mantissa: u32,
    /// Shift right; a negative number shifts left.
    pub bits: i32,
}

/// The four normalisers: weight over sum (eq. 33), or weight over range in min-max mode.
///
/// A weight is a share of 2^30, and a full share of its term is 2^62 of the score. So the sum of the four fits an
/// `i64`.
#[must_use]
pub fn normalizers(header: &Header, totals: &Totals) -> [Normalizer; 4] {
    core::array::from_fn(|term| {
        let min_max = header.min_max == 1 && totals.min[term] <= totals.max[term];
        let offset = if min_max { totals.min[term] } else { 0 };
        let scale = if min_max {
            u64::from(totals.max[term] - totals.min[term])
        } else {
            totals.sums[term]
        };
        normalizer(offset, header.weights[term], scale)
    })
}

/// `weight * 2^32 / scale` as a 32-bit mantissa and a shift, rounded down.
#[must_use]
pub fn normalizer(offset: u32, weight: u32, scale: u64) -> Normalizer {
    if weight == 0 || scale == 0 {
        return Normalizer::default();
    }
    let scale_zeros = scale.leading_zeros();
    let weight_zeros = weight.leading_zeros();
    let divisor = ((scale << scale_zeros) >> 32) as u32;
    let dividend = weight << weight_zeros;
    // Halves the dividend if the quotient would not fit.
    let halved = u32::from(dividend >= divisor);
    let mantissa = div_wide(dividend >> halved, divisor);
    let bits = 32 - halved as i32 + weight_zeros as i32 - scale_zeros as i32;
    Normalizer { offset, mantissa, bits }
}

/// The weighted share of a term.
#[must_use]
#[inline]
pub fn share(term: u32, normalizer: &Normalizer) -> u64 {
    let product = u64::from(term - normalizer.offset) * u64::from(normalizer.mantissa);
    shift_wide(product, normalizer.bits)
}

/// The score of eq. 35, with the distance to the key node subtracted.
#[must_use]
#[inline]
pub fn score(terms: &Terms, normalizers: &[Normalizer; 4]) -> i64 {
    let [heading, clearance, velocity, path] = terms.to_array();
    let sum = share(heading, &normalizers[0])
        .wrapping_add(share(clearance, &normalizers[1]))
        .wrapping_add(share(velocity, &normalizers[2]));
    sum.wrapping_sub(share(path, &normalizers[3])) as i64
}
