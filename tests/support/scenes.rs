//! Random problems with the list of their blocked cells, so that an oracle needs nothing of the engines.

use std::sync::Arc;

use core::f64::consts::PI;
use core::fmt;

use inbye::geometry::{Point, Pose, Twist};
use inbye::local::{
    Axis, ClearanceField, Normalization, Outside, Problem, Sampler, SamplerInputs, Stopping,
    Weights, Window,
};
use inbye::map::{Cell, GridFrame, MovingDisc, ObstacleGrid};
use inbye::robot::{Disc, Footprint, Limits};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// A problem and its static obstacles.
pub struct Scene {
    pub problem: Problem,
    pub blocked: Vec<Cell>,
}

/// Everything except the field, which the blocked cells determine.
impl fmt::Debug for Scene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let problem = &self.problem;
        f.debug_struct("Scene")
            .field("frame", problem.field.frame())
            .field("blocked", &self.blocked)
            .field("pose", &problem.pose)
            .field("window", &problem.window)
            .field("braking", &(problem.braking_x, problem.braking_theta))
            .field("horizon", &(problem.steps, problem.step_s))
            .field("footprint", &problem.footprint)
            .field("max_clearance_m", &problem.max_clearance_m)
            .field("outside", &problem.outside)
            .field("obstacles", &problem.obstacles)
            .field("goals", &(problem.target, problem.key_node))
            .field("weights", &problem.weights)
            .field("judging", &(problem.normalization, problem.stopping))
            .finish()
    }
}

impl Scene {
    /// A problem of [`inbye::bench::random_problem`]; its blocked cells are those at distance zero.
    pub fn of_bench(seed: u64, case: u64) -> Self {
        let problem = inbye::bench::random_problem(seed, case);
        let frame = *problem.field.frame();
        let units = problem.field.units();
        let blocked = (0..frame.len()).filter(|&index| units[index] == 0);
        Self { blocked: blocked.map(|index| frame.cell_at(index)).collect(), problem }
    }

    /// A scene with trajectories of up to `reach_m` metres: 10 to 200 steps, 1 to 400 samples, 1 to 8 discs, 0 to 8
    /// moving obstacles, 0 to 150 blocked cells, any origin.
    pub fn random(seed: u64, case: u64, reach_m: f64) -> Self {
        let seed = seed ^ case.wrapping_mul(0xD134_2543_DE82_EF95);
        let rng = &mut Pcg64Mcg::seed_from_u64(seed);
        let side_m = (reach_m * rng.random_range(0.5..1.5)).max(rng.random_range(2.0..6.0));
        let frame = frame(rng, side_m);
        let blocked: Vec<Cell> = (0..[0, 4, 40, 150][rng.random_range(0..4)])
            .map(|_| frame.cell_at(rng.random_range(0..frame.len())))
            .collect();
        let mut obstacles = ObstacleGrid::filled(frame, false);
        for cell in &blocked {
            obstacles.set(*cell, true);
        }
        let field = ClearanceField::new(&obstacles).expect("a resolution within the range");
        let steps = rng.random_range(10..=200);
        let step_s = [0.02, 0.05, 0.1][rng.random_range(0..3)];
        let most_m = 262_000.0 * field.unit_m();
        let fastest = (reach_m.min(most_m) / (f64::from(steps) * step_s)).min(15.0);
        let start = somewhere(rng, &frame);
        let mut goal = || {
            let offset = somewhere(rng, &frame) - start;
            start + offset * (most_m / offset.norm()).min(1.0)
        };
        let (target, key_node) = (goal(), goal());
        let problem = Problem {
            field: Arc::new(field),
            pose: Pose::new(start.x, start.y, rng.random_range(-9.0..9.0)),
            window: window(rng, fastest),
            braking_x: rng.random_range(0.2..4.0),
            braking_theta: rng.random_range(0.5..8.0),
            step_s,
            steps,
            footprint: footprint(rng),
            max_clearance_m: rng.random_range(0.3..4.0),
            outside: [Outside::Obstacle, Outside::Free][rng.random_range(0..2)],
            obstacles: (0..rng.random_range(0..=8)).map(|_| moving(rng, &frame)).collect(),
            target,
            key_node,
            weights: Weights::default()
                .heading(rng.random_range(0.0..1.0))
                .clearance(rng.random_range(0.0..1.0))
                .velocity(rng.random_range(0.0..1.0))
                .path([0.0, 0.15, 0.7][rng.random_range(0..3)]),
            normalization: [Normalization::Sum, Normalization::MinMax][rng.random_range(0..2)],
            stopping: [Stopping::Clearance, Stopping::Arc][rng.random_range(0..2)],
            sampler: Sampler::ALL[rng.random_range(0..4)],
            sampler_inputs: sampler_inputs(rng, fastest),
        };
        Self { problem, blocked }
    }
}

/// Limits with speeds of at most `fastest`, m/s.
fn sampler_inputs(rng: &mut Pcg64Mcg, fastest: f64) -> SamplerInputs {
    SamplerInputs {
        twist: Twist::new(rng.random_range(-0.3..1.0) * fastest, rng.random_range(-1.5..1.5)),
        limits: Limits::default()
            .min_vel_x([0.0, -0.4 * fastest][rng.random_range(0..2)])
            .max_vel_x(rng.random_range(0.2..1.0) * fastest)
            .max_vel_theta(rng.random_range(0.3..2.0))
            .acc_lim_x(rng.random_range(0.3..3.0))
            .decel_lim_x(-rng.random_range(0.3..3.0))
            .acc_lim_theta(rng.random_range(0.5..5.0)),
        control_period_s: [0.02, 0.1, 0.25][rng.random_range(0..3)],
        ramp_time_s: rng.random_range(0.05..4.0),
        seed: rng.random_range(0..1000),
    }
}

fn frame(rng: &mut Pcg64Mcg, side_m: f64) -> GridFrame {
    let resolution_m: f64 = [0.02, 0.05, 0.1, 0.124, 0.25][rng.random_range(0..5)];
    let cells = (side_m / resolution_m).clamp(8.0, 600.0);
    GridFrame {
        width: (cells * rng.random_range(0.5..1.0)) as i32,
        height: (cells * rng.random_range(0.5..1.0)) as i32,
        resolution_m,
        origin: Pose::new(
            rng.random_range(-80.0..80.0),
            rng.random_range(-80.0..80.0),
            [0.0, 0.7, -2.9][rng.random_range(0..3)],
        ),
    }
}

fn somewhere(rng: &mut Pcg64Mcg, frame: &GridFrame) -> Point {
    frame.from_cell_units(&Point::new(
        rng.random_range(0.0..1.0) * f64::from(frame.width),
        rng.random_range(0.0..1.0) * f64::from(frame.height),
    ))
}

fn window(rng: &mut Pcg64Mcg, fastest: f64) -> Window {
    let low = rng.random_range(-0.4..0.8) * fastest;
    let turn = rng.random_range(-1.5..1.0);
    Window {
        vx: Axis::new(low, rng.random_range(low..=fastest), rng.random_range(1..=20)),
        vtheta: Axis::new(turn, rng.random_range(turn..=1.5), rng.random_range(1..=20)),
    }
}

fn footprint(rng: &mut Pcg64Mcg) -> Footprint {
    let discs = (0..[1, 2, 3, 8][rng.random_range(0..4)]).map(|_| Disc {
        x: rng.random_range(-0.6..0.6),
        y: rng.random_range(-0.4..0.4),
        radius: rng.random_range(0.01..0.25),
    });
    Footprint::new(discs.collect()).expect("at least one disc with a radius")
}

fn moving(rng: &mut Pcg64Mcg, frame: &GridFrame) -> MovingDisc {
    let center = somewhere(rng, frame);
    let (speed, course) = (rng.random_range(0.0..2.0), rng.random_range(-PI..PI));
    MovingDisc {
        x: center.x,
        y: center.y,
        radius: rng.random_range(0.05..0.4),
        vx: speed * libm::cos(course),
        vy: speed * libm::sin(course),
    }
}
