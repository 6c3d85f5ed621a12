//! The ranges in which the engines are exact and close to the real-valued result.

use super::{Problem, ProblemError, Window};
use crate::settings::{SettingError, require};

/// Longest distance of one step, units.
pub(super) const MAX_STEP_UNITS: f64 = 16_384.0;
/// Longest distance over the horizon, to the target and to the key node, units.
pub(super) const MAX_REACH_UNITS: f64 = 262_144.0;
/// Largest sum of clearance cap and radii, units: two squares of it fit in a `u32`.
pub(super) const MAX_CLEARANCE_UNITS: f64 = 46_330.0;
/// Largest coordinate of a disc in the robot's frame, units.
pub(super) const MAX_OFFSET_UNITS: f64 = 32_767.0;
/// Largest forward speed, m/s: its term has 24 bits, 20 of them fractional.
pub(super) const MAX_SPEED: f64 = 15.99;
/// Largest number of samples of a problem.
pub(super) const MAX_SAMPLES: usize = 1 << 22;
/// Largest number of steps of a horizon.
pub(super) const MAX_STEPS: u32 = 1023;
/// Largest number of discs of a footprint.
pub const MAX_DISCS: usize = 8;
/// Largest number of moving obstacles.
pub(super) const MAX_OBSTACLES: usize = 1024;

/// Checks every number whose limit does not depend on the map's resolution.
pub(super) fn check_numbers(problem: &Problem) -> Result<(), ProblemError> {
    let Window { vx, vtheta } = &problem.window;
    let finite = [
        ("pose", problem.pose.is_finite()),
        ("forward speed window", vx.low.is_finite() && vx.high.is_finite()),
        ("turn rate window", vtheta.low.is_finite() && vtheta.high.is_finite()),
        ("target", problem.target.iter().all(|c| c.is_finite())),
        ("key node", problem.key_node.iter().all(|c| c.is_finite())),
    ];
    if let Some((quantity, _)) = finite.into_iter().find(|(_, finite)| !finite) {
        return Err(ProblemError::NotFinite { quantity });
    }
    let above_zero = "finite and above zero";
    for (quantity, value, unit) in [
        ("deceleration along the path", problem.braking_x, "m/s^2"),
        ("angular deceleration", problem.braking_theta, "rad/s^2"),
        ("duration of a step", problem.step_s, "s"),
    ] {
        in_range(quantity, value, unit, value > 0.0 && value.is_finite(), above_zero)?;
    }
    // A cap below one unit of length rounds to zero, and every sample collides.
    let cap = problem.max_clearance_m;
    let cap_fits = cap >= 0.001 && cap.is_finite();
    in_range("clearance cap", cap, "m", cap_fits, "finite and at least 0.001 m")?;
    let fastest = vx.max_abs();
    let speed_fits = fastest <= MAX_SPEED;
    in_range("forward speed", fastest, "m/s", speed_fits, "at most 15.99 m/s")?;
    problem.weights.validate()?;
    let turn = vtheta.max_abs() * problem.step_s;
    in_range("turn in one step", turn, "rad", turn <= 1.5, "at most 1.5 rad")?;
    check_counts(vx.count, vtheta.count, problem.steps)?;
    let discs = problem.footprint.discs().len();
    in_range("number of discs", discs as f64, "", discs <= MAX_DISCS, "1 to 8")?;
    let moving = problem.obstacles.len();
    in_range("moving obstacles", moving as f64, "", moving <= MAX_OBSTACLES, "at most 1024")
}

/// Checks the numbers of forward speeds, turn rates and steps.
pub(super) fn check_counts(
    vx_count: u32,
    vtheta_count: u32,
    steps: u32,
) -> Result<(), SettingError> {
    let samples = f64::from(vx_count) * f64::from(vtheta_count);
    let samples_fit = samples >= 1.0 && samples <= MAX_SAMPLES as f64;
    let expected = "1 to 4194304 (vx_samples times vtheta_samples)";
    require(samples_fit, "number of samples", samples, expected)?;
    let expected = "1 to 1023 (sim_time_s over sim_step_s)";
    require((1..=MAX_STEPS).contains(&steps), "number of steps", f64::from(steps), expected)
}

/// Returns an error unless `good`.
pub(super) fn in_range(
    quantity: &'static str,
    value: f64,
    unit: &'static str,
    good: bool,
    limit: &'static str,
) -> Result<(), ProblemError> {
    if good { Ok(()) } else { Err(ProblemError::OutOfRange { quantity, value, unit, limit }) }
}

/// Checks a length in units against a limit in units.
pub(super) fn at_most(
    quantity: &'static str,
    units: f64,
    limit: f64,
    unit_m: f64,
) -> Result<(), ProblemError> {
    if units <= limit {
        Ok(())
    } else {
        Err(ProblemError::TooFar { quantity, value: units * unit_m, limit_m: limit * unit_m })
    }
}
