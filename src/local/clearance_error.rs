//! The bound by which the engines may overestimate the clearance.
//!
//! The engines check the poses of a trajectory at its steps, and compute in integers. Between the steps, and between the model
//! (eq. 27, which moves along the old heading before it turns) and the true arc, the robot may come nearer to an obstacle:
//!
//! - Between two steps of `dt` a point of the body is at most `(v + omega r) dt / 2` from one of its checked places, where `r`
//!   is the distance of a disc from the robot's origin.
//! - The model's position is the true one turned by `omega dt / 2` around the start: it is off by at most
//!   `v t omega dt / 2` after a time `t`.
//!
//! An admissible sample has a clearance `d` of at least `v^2 / (2 a)` and `omega^2 / (2 b)` for the decelerations `a` and `b`
//! (eq. 30). So `v <= sqrt(2 a d)` and `omega <= sqrt(2 b d)`, and the two errors are at most `c sqrt(d)` and `k d`, with
//! `c = (sqrt(2 a) + r sqrt(2 b)) dt / 2` and `k = t dt sqrt(a b)`. For `k` up to 1/2 their sum exceeds `d` by at most
//! `c^2 / 2`, whatever `d` is. A robot that keeps that much in addition keeps its margin along the whole true arc.
//!
//! With the default settings `k` is 0.42 at the end of the horizon. For longer horizons the margin is kept until the robot could
//! stand: it drives at most `d` until then, and `k` is at most `omega dt`. With [`Stopping::Arc`](super::Stopping) the clearance
//! may be below the braking distance, and only the checked poses keep the margin.

use super::LocalSettings;
use crate::robot::{Footprint, Limits};

/// Largest sum of all roundings to units, of positions, discs, radii and distances.
const ROUNDING_UNITS: f64 = 8.0;

/// The largest amount, metres, by which the clearance of an admissible sample exceeds the clearance along the true arc. The unit
/// is that of the field, metres.
#[must_use]
pub fn clearance_error_m(
    footprint: &Footprint,
    limits: &Limits,
    settings: &LocalSettings,
    unit_m: f64,
) -> f64 {
    let arms_m = footprint.discs().iter().map(|disc| libm::hypot(disc.x, disc.y));
    let arm_m = arms_m.fold(0.0, f64::max);
    let braking =
        (-2.0 * limits.decel_lim_x).sqrt() + arm_m * (-2.0 * limits.decel_lim_theta).sqrt();
    let c = braking * settings.sim_step_s / 2.0;
    c * c / 2.0 + ROUNDING_UNITS * unit_m
}
