//! Trajectories that may leave the field, or stop within the arc left: every step in order, as `rollout.rs` does.

use super::arithmetic::shift_round;
use super::course::Course;
use super::lanes::Lanes;
use super::row::Fate;
use super::table::Table;
use crate::local::Prepared;

/// What the samples of one vector meet.
#[inline(always)]
pub fn meet<L: Lanes>(
    proof: L::Proof,
    problem: &Prepared,
    course: &Course,
    table: &Table,
    first: usize,
) -> Fate<L> {
    let header = &problem.header;
    let by_arc = header.stop_by_arc == 1;
    let zero = L::splat(proof, 0);
    let coarse = L::load(proof, &course.coarse[first..]);
    let cap = L::splat(proof, header.max_clearance as i32);
    let (mut least, mut free) = (cap, zero);
    let (mut collision, mut outside) = (L::none(proof), L::none(proof));
    let mut under_way = zero.equal(zero);
    for step in 0..header.steps as usize {
        let moved_x = moved(proof, coarse, table.x[step], header.coarse_bits);
        let moved_y = moved(proof, coarse, table.y[step], header.coarse_bits);
        let (mut clearance, mut out) = (cap, L::none(proof));
        for (number, disc) in problem.discs.iter().enumerate() {
            let at = number * course.steps + step;
            let x = moved_x.add(L::splat(proof, table.disc_x[at]));
            let y = moved_y.add(L::splat(proof, table.disc_y[at]));
            let (distance, off) = distance_or_off(proof, problem, x, y);
            let here = clearance.min(distance.sub(L::splat(proof, disc.radius)));
            clearance = L::select(off, clearance, here);
            if header.outside_is_free == 0 {
                out = L::either(out, off);
            }
            for (number, body) in problem.obstacles.iter().enumerate() {
                let (track_x, track_y) = course.track(number);
                let squared = squared_distance(proof, x, y, track_x[step], track_y[step]);
                clearance = nearer(proof, clearance, squared, disc.radius + body.radius);
            }
        }
        let hit = L::but_not(under_way, zero.less(clearance));
        collision = L::either(collision, hit);
        under_way = L::but_not(under_way, hit);
        let left = L::both(out, under_way);
        outside = L::either(outside, left);
        if by_arc {
            under_way = L::but_not(under_way, left);
        }
        if L::bits(under_way) == 0 {
            break;
        }
        least = L::select(under_way, least.min(clearance), least);
        free = L::select(under_way, free.add(L::splat(proof, 1)), free);
    }
    if !by_arc {
        return Fate {
            collision,
            outside,
            clearance: least,
            has: least,
        };
    }
    // What ends a trajectory decides only where no step was free.
    let started = zero.less(free);
    Fate {
        collision: L::but_not(collision, started),
        outside: L::but_not(outside, started),
        clearance: least,
        has: free,
    }
}

/// Displacement in units.
#[inline(always)]
pub fn moved<L: Lanes>(proof: L::Proof, coarse: L, table: i32, bits: u32) -> L {
    shift_round(proof, coarse.mul(L::splat(proof, table)), bits)
}

/// Distance to the nearest static obstacle, and where the position is off the field; there the distance means nothing.
#[inline(always)]
fn distance_or_off<L: Lanes>(proof: L::Proof, problem: &Prepared, x: L, y: L) -> (L, L::Mask) {
    let header = &problem.header;
    let (width, height) = (
        L::splat(proof, header.width as i32),
        L::splat(proof, header.height as i32),
    );
    let (column, row) = (x.sar(header.cell_bits), y.sar(header.cell_bits));
    let on = L::both(column.less_unsigned(width), row.less_unsigned(height));
    let distance = row
        .mul(width)
        .add(column)
        .gather(problem.field.padded_units());
    let zero = L::splat(proof, 0);
    (distance, L::but_not(zero.equal(zero), on))
}

/// Squared distance to a point, each coordinate bounded as in `rollout.rs`.
#[inline(always)]
pub fn squared_distance<L: Lanes>(proof: L::Proof, x: L, y: L, to_x: i32, to_y: i32) -> L {
    let across = bounded(proof, x.sub(L::splat(proof, to_x)));
    let along = bounded(proof, y.sub(L::splat(proof, to_y)));
    across.mul(across).add(along.mul(along))
}

/// Within what can be squared and added in 32 bits.
#[inline(always)]
pub fn bounded<L: Lanes>(proof: L::Proof, value: L) -> L {
    value
        .min(L::splat(proof, MOST_ACROSS))
        .max(L::splat(proof, -MOST_ACROSS))
}

/// Two squares of this still fit in 32 bits.
pub const MOST_ACROSS: i32 = 46_340;

/// The clearance, or that to a body at this squared distance where it is smaller.
#[inline(always)]
pub fn nearer<L: Lanes>(proof: L::Proof, clearance: L, squared: L, radii: i32) -> L {
    let radii = L::splat(proof, radii);
    let reach = clearance.add(radii);
    let near = L::both(
        L::splat(proof, 0).less(reach),
        squared.less_unsigned(reach.mul(reach)),
    );
    // The root is taken only where it can matter, which is seldom.
    if L::bits(near) == 0 {
        clearance
    } else {
        L::select(near, squared.isqrt().sub(radii), clearance)
    }
}
