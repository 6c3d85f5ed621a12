//! Evaluates trajectories that may leave the field, or stop within the remaining arc: every step in order, as in
//! `rollout.rs`.

use super::arithmetic::shift_round;
use super::displacement_table::DisplacementTable;
use super::lanes::Lanes;
use super::soa_inputs::SoaInputs;
use crate::local::QuantizedProblem;

/// The result of the rollout of one vector of samples.
#[derive(Clone, Copy)]
pub struct LaneOutcome<L: Lanes> {
    /// Samples that touch an obstacle.
    pub collision: L::Mask,
    /// Samples that leave the field.
    pub outside: L::Mask,
    /// Smallest clearance, units.
    pub clearance: L,
    /// Available for stopping: that clearance, or free steps.
    pub available: L,
}

impl<L: Lanes> LaneOutcome<L> {
    /// The result of samples that stay on the field and whose status depends on the smallest clearance.
    #[inline(always)]
    pub fn of_clearance(token: L::FeatureToken, least: L) -> Self {
        let zero = L::splat(token, 0);
        Self {
            collision: L::mask_and_not(zero.equal(zero), zero.less(least)),
            outside: L::mask_none(token),
            clearance: least,
            available: least,
        }
    }
}

/// Evaluates the samples of one vector.
#[inline(always)]
pub fn evaluate<L: Lanes>(
    token: L::FeatureToken,
    problem: &QuantizedProblem,
    inputs: &SoaInputs,
    table: &DisplacementTable,
    first: usize,
) -> LaneOutcome<L> {
    let header = &problem.header;
    let by_arc = header.stop_by_arc == 1;
    let zero = L::splat(token, 0);
    let coarse = L::load(token, &inputs.coarse[first..]);
    let cap = L::splat(token, header.max_clearance as i32);
    let (mut least, mut free) = (cap, zero);
    let (mut collision, mut outside) = (L::mask_none(token), L::mask_none(token));
    let mut active = zero.equal(zero);
    for step in 0..header.steps as usize {
        let moved_x = displacement(token, coarse, table.x[step], header.coarse_bits);
        let moved_y = displacement(token, coarse, table.y[step], header.coarse_bits);
        let (mut clearance, mut out) = (cap, L::mask_none(token));
        for (number, disc) in problem.discs.iter().enumerate() {
            let at = number * inputs.steps + step;
            let x = moved_x.add(L::splat(token, table.disc_x[at]));
            let y = moved_y.add(L::splat(token, table.disc_y[at]));
            let (distance, off) = distance_or_off(token, problem, x, y);
            let here = clearance.min(distance.sub(L::splat(token, disc.radius)));
            clearance = L::select(off, clearance, here);
            if header.outside_is_free == 0 {
                out = L::mask_or(out, off);
            }
            for (number, body) in problem.obstacles.iter().enumerate() {
                let (track_x, track_y) = inputs.track(number);
                let squared = squared_distance(token, x, y, track_x[step], track_y[step]);
                clearance = nearest_clearance(token, clearance, squared, disc.radius + body.radius);
            }
        }
        let hit = L::mask_and_not(active, zero.less(clearance));
        collision = L::mask_or(collision, hit);
        active = L::mask_and_not(active, hit);
        let left = L::mask_and(out, active);
        outside = L::mask_or(outside, left);
        if by_arc {
            active = L::mask_and_not(active, left);
        }
        if L::bitmask(active) == 0 {
            break;
        }
        least = L::select(active, least.min(clearance), least);
        free = L::select(active, free.add(L::splat(token, 1)), free);
    }
    if !by_arc {
        return LaneOutcome { collision, outside, clearance: least, available: least };
    }
    // The end of a trajectory decides only if no step is free.
    let started = zero.less(free);
    LaneOutcome {
        collision: L::mask_and_not(collision, started),
        outside: L::mask_and_not(outside, started),
        clearance: least,
        available: free,
    }
}

/// Displacement in units.
#[inline(always)]
pub fn displacement<L: Lanes>(token: L::FeatureToken, coarse: L, table: i32, bits: u32) -> L {
    shift_round(token, coarse.mul(L::splat(token, table)), bits)
}

/// Distance to the nearest static obstacle, and the lanes that are off the field; their distance is undefined.
#[inline(always)]
fn distance_or_off<L: Lanes>(
    token: L::FeatureToken,
    problem: &QuantizedProblem,
    x: L,
    y: L,
) -> (L, L::Mask) {
    let header = &problem.header;
    let (width, height) =
        (L::splat(token, header.width as i32), L::splat(token, header.height as i32));
    let (column, row) = (x.sar(header.cell_bits), y.sar(header.cell_bits));
    let on = L::mask_and(column.less_unsigned(width), row.less_unsigned(height));
    let distance = row.mul(width).add(column).gather(problem.field.padded_units());
    let zero = L::splat(token, 0);
    (distance, L::mask_and_not(zero.equal(zero), on))
}

/// Squared distance to a point, each coordinate clamped as in `rollout.rs`.
#[inline(always)]
pub fn squared_distance<L: Lanes>(token: L::FeatureToken, x: L, y: L, to_x: i32, to_y: i32) -> L {
    let across = clamp_offset(token, x.sub(L::splat(token, to_x)));
    let along = clamp_offset(token, y.sub(L::splat(token, to_y)));
    across.mul(across).add(along.mul(along))
}

/// Limits a coordinate so that two squares fit in 32 bits.
#[inline(always)]
pub fn clamp_offset<L: Lanes>(token: L::FeatureToken, value: L) -> L {
    value.min(L::splat(token, MAX_OFFSET)).max(L::splat(token, -MAX_OFFSET))
}

/// Two squares of this fit in 32 bits.
pub const MAX_OFFSET: i32 = 46_340;

/// The smaller of the clearance and the clearance to a body at this squared distance.
#[inline(always)]
pub fn nearest_clearance<L: Lanes>(
    token: L::FeatureToken,
    clearance: L,
    squared: L,
    radii: i32,
) -> L {
    let radii = L::splat(token, radii);
    let reach = clearance.add(radii);
    let near = L::mask_and(L::splat(token, 0).less(reach), squared.less_unsigned(reach.mul(reach)));
    // The root is computed only where it can matter, which is rare.
    if L::bitmask(near) == 0 {
        clearance
    } else {
        L::select(near, squared.isqrt().sub(radii), clearance)
    }
}
