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
use super::problem::MAX_STEPS;
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
    let c = error_rate(footprint, limits) * settings.sim_step_s;
    c * c / 2.0 + ROUNDING_UNITS * unit_m
}

/// The longest step, a whole part of the configured one, with which the engines overlook at most this besides their roundings,
/// metres. There are at most as many steps as a problem may have. Times in seconds.
pub(crate) fn step_that_overlooks(
    most_m: f64,
    footprint: &Footprint,
    limits: &Limits,
    (step_s, horizon_s): (f64, f64),
) -> f64 {
    let c = error_rate(footprint, limits) * step_s;
    let most_parts = (f64::from(MAX_STEPS) * step_s / horizon_s).floor().max(1.0);
    step_s / (c / (2.0 * most_m).sqrt()).ceil().clamp(1.0, most_parts)
}

/// `c` of a step of one second, in units of the square root of a metre per second.
fn error_rate(footprint: &Footprint, limits: &Limits) -> f64 {
    let arms_m = footprint.discs().iter().map(|disc| libm::hypot(disc.x, disc.y));
    let arm_m = arms_m.fold(0.0, f64::max);
    let braking =
        (-2.0 * limits.decel_lim_x).sqrt() + arm_m * (-2.0 * limits.decel_lim_theta).sqrt();
    braking / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::Disc;

    #[test]
    fn step_is_the_longest_part_that_overlooks_little_enough() {
        let discs = [-0.4, 0.4].map(|x| Disc { x, y: 0.0, radius: 0.3 });
        let footprint = Footprint::new(discs.to_vec()).expect("two discs");
        let (most_m, times_s) = (0.005, (0.1, 2.5));
        for (decel, parts) in [(0.1, 1.0), (0.8, 1.0), (3.0, 2.0), (30.0, 7.0), (1e7, 40.0)] {
            let limits = Limits::default().decel_lim_x(-decel).decel_lim_theta(-2.0 * decel);
            let step_s = step_that_overlooks(most_m, &footprint, &limits, times_s);
            assert_eq!(step_s, 0.1 / parts, "{decel} m/s^2");
            let overlooked_m = |sim_step_s| {
                let settings = LocalSettings { sim_step_s, ..LocalSettings::default() };
                clearance_error_m(&footprint, &limits, &settings, 0.0)
            };
            assert!(overlooked_m(step_s) <= most_m || parts == 40.0, "{decel} m/s^2");
            assert!(parts == 1.0 || overlooked_m(0.1 / (parts - 1.0)) > most_m, "{decel} m/s^2");
        }
    }
}
