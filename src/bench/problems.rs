//! Random problems; a seed gives the same problems on every machine.

use std::sync::Arc;

use core::f64::consts::PI;

use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::geometry::{Point, Pose, Twist};
use crate::local::{
    Axis, ClearanceField, MAX_REACH_UNITS, Normalization, Outside, Problem, Sampler, SamplerInputs,
    Stopping, Weights, Window,
};
use crate::map::{GridFrame, MovingDisc, ObstacleGrid};
use crate::robot::{Disc, Footprint, Limits};

/// Largest distance to the target and to the key node, as a share of the range of a problem: rounding stays below the range.
const REACH_SHARE: f64 = 0.999_999;

/// Problem number `case` of a seed: grids of 8 to 120 cells a side at 0.02 to 0.5 m, any origin, empty to crowded;
/// 1 to about 900 samples; 1 to 80 steps; 1 to 3 discs; 0 to 5 moving obstacles; both normalisations, both stopping
/// rules, both readings of the outside; every sampler.
///
/// # Panics
/// Never: every random number is within the ranges of a problem.
#[must_use]
pub fn random_problem(seed: u64, case: u64) -> Problem {
    let mut rng = Pcg64Mcg::seed_from_u64(seed ^ case.wrapping_mul(0x9E37_79B9_7F4A_7C15));
    let rng = &mut rng;
    let field = random_field(rng);
    let frame = *field.frame();
    let side = f64::from(frame.width.max(frame.height)) * frame.resolution_m;
    let within = |rng: &mut Pcg64Mcg, margin: f64| {
        let column = rng.random_range(-margin..1.0 + margin) * f64::from(frame.width);
        let row = rng.random_range(-margin..1.0 + margin) * f64::from(frame.height);
        frame.from_cell_units(&Point::new(column, row))
    };
    let start = within(rng, 0.02);
    // A large grid is longer from corner to corner than the range of a problem.
    let reach_m = REACH_SHARE * MAX_REACH_UNITS * field.unit_m();
    let near_start = |place: Point| {
        let offset = place - start;
        let distance_m = offset.norm();
        if distance_m > reach_m { start + offset * (reach_m / distance_m) } else { place }
    };
    let step_s = *pick(rng, &[0.05, 0.1, 0.25]);
    let steps = rng.random_range(1..=80);
    // Slow enough that most trajectories end near the grid and within the specified ranges.
    let fastest = (side / (f64::from(steps) * step_s)).min(2.0);
    let low = rng.random_range(-0.3..0.5) * fastest;
    let turn = rng.random_range(-1.0..0.8);
    let axis = |low: f64, high: f64, count: u32| Axis {
        through: [Some(0.0), Some(low + 0.45 * (high - low))],
        ..Axis::new(low, high, count)
    };
    let linear = axis(low, rng.random_range(low..fastest), rng.random_range(1..=30));
    let angular = axis(turn, rng.random_range(turn..1.2), rng.random_range(1..=30));
    let discs = (0..rng.random_range(1..=3)).map(|_| Disc {
        x: rng.random_range(-0.4..0.4),
        y: rng.random_range(-0.2..0.2),
        radius: rng.random_range(0.02..0.3),
    });
    let footprint = Footprint::new(discs.collect()).expect("at least one disc with a radius");
    let obstacles = (0..rng.random_range(0..=5)).map(|_| {
        let center = within(rng, 0.2);
        MovingDisc {
            x: center.x,
            y: center.y,
            radius: rng.random_range(0.05..0.5),
            vx: rng.random_range(-1.0..1.0),
            vy: rng.random_range(-1.0..1.0),
        }
    });
    Problem {
        obstacles: obstacles.collect(),
        field: Arc::new(field),
        pose: Pose::new(start.x, start.y, rng.random_range(-PI..PI)),
        window: Window { vx: linear, vtheta: angular },
        braking_x: rng.random_range(0.2..3.0),
        braking_theta: rng.random_range(0.5..6.0),
        step_s,
        steps,
        footprint,
        max_clearance_m: rng.random_range(0.3..3.0),
        outside: *pick(rng, &[Outside::Obstacle, Outside::Free]),
        target: near_start(within(rng, 0.0)),
        key_node: near_start(within(rng, 0.0)),
        weights: Weights {
            heading: rng.random_range(0.0..1.0),
            clearance: rng.random_range(0.0..1.0),
            velocity: rng.random_range(0.0..1.0),
            path: *pick(rng, &[0.0, 0.15, 0.7]),
        },
        normalization: *pick(rng, &[Normalization::Sum, Normalization::MinMax]),
        stopping: *pick(rng, &[Stopping::Clearance, Stopping::Arc]),
        sampler: *pick(rng, &Sampler::ALL),
        sampler_inputs: random_sampler_inputs(rng, fastest),
    }
}

/// Limits with speeds of at most `fastest`, m/s.
fn random_sampler_inputs(rng: &mut Pcg64Mcg, fastest: f64) -> SamplerInputs {
    SamplerInputs {
        twist: Twist::new(rng.random_range(-0.3..1.0) * fastest, rng.random_range(-1.0..1.0)),
        limits: Limits {
            min_vel_x: *pick(rng, &[0.0, -0.3]) * fastest,
            max_vel_x: rng.random_range(0.3..1.0) * fastest,
            max_vel_theta: rng.random_range(0.3..1.5),
            acc_lim_x: rng.random_range(0.3..2.0),
            decel_lim_x: -rng.random_range(0.3..2.0),
            acc_lim_theta: rng.random_range(0.5..4.0),
            ..Limits::default()
        },
        control_period_s: *pick(rng, &[0.05, 0.1, 0.2]),
        ramp_time_s: rng.random_range(0.1..3.0),
        seed: rng.random(),
    }
}

fn random_field(rng: &mut Pcg64Mcg) -> ClearanceField {
    let frame = GridFrame {
        width: rng.random_range(8..=120),
        height: rng.random_range(8..=120),
        resolution_m: *pick(rng, &[0.02, 0.05, 0.1, 0.1254, 0.5]),
        origin: Pose::new(
            rng.random_range(-50.0..50.0),
            rng.random_range(-50.0..50.0),
            *pick(rng, &[0.0, 0.0, 0.3, -2.0]),
        ),
    };
    let density = *pick(rng, &[0.0, 0.0005, 0.002, 0.01, 0.05]);
    let obstacles = ObstacleGrid::from_fn(frame, |_| rng.random_bool(density));
    ClearanceField::new(&obstacles).expect("a resolution within the range")
}

fn pick<'a, T>(rng: &mut impl Rng, choices: &'a [T]) -> &'a T {
    &choices[rng.random_range(0..choices.len())]
}
