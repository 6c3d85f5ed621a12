//! A plain problem, and problems at the limits of the accepted ranges, where an integer would overflow first.

use std::sync::Arc;

use inbye::geometry::{Point, Pose};
use inbye::local::{
    Axis, ClearanceField, Normalization, Outside, Problem, Sampler, SamplerInputs, Stopping,
    Weights, Window,
};
use inbye::map::{Cell, GridFrame, MovingDisc, ObstacleGrid};
use inbye::robot::{Disc, Footprint};

/// Cells of this size have almost the largest unit of length, 0.2441 mm.
const RESOLUTION_M: f64 = 0.124_99;

/// A square grid with its corner at the map's origin, free except for these cells (column and row).
pub fn field(side: i32, resolution_m: f64, blocked: &[[i32; 2]]) -> Arc<ClearanceField> {
    let frame = GridFrame { width: side, height: side, resolution_m, origin: Pose::default() };
    let mut obstacles = ObstacleGrid::filled(frame, false);
    for &[column, row] in blocked {
        obstacles.set(Cell::new(column, row), true);
    }
    Arc::new(ClearanceField::new(&obstacles).expect("a resolution within the range"))
}

/// One disc, nine samples and five steps, in the middle of a grid of 40 by 40 cells with one blocked cell.
pub fn plain() -> Problem {
    Problem {
        field: field(40, RESOLUTION_M, &[[39, 0]]),
        pose: Pose::new(2.5, 2.5, 0.0),
        window: Window { vx: axis(0.0, 0.5, 3), vtheta: axis(-0.5, 0.5, 3) },
        sampler: Sampler::Arcs,
        sampler_inputs: SamplerInputs::default(),
        braking_x: 1.0,
        braking_theta: 2.0,
        step_s: 0.1,
        steps: 5,
        footprint: footprint(&[[0.0, 0.0, 0.2]]),
        max_clearance_m: 2.0,
        outside: Outside::Obstacle,
        obstacles: Vec::new(),
        target: Point::new(4.0, 2.5),
        key_node: Point::new(3.0, 2.5),
        weights: Weights::default(),
        normalization: Normalization::Sum,
        stopping: Stopping::Clearance,
    }
}

/// Discs from their x, y and radius.
pub fn footprint(discs: &[[f64; 3]]) -> Footprint {
    let disc = |&[x, y, radius]: &[f64; 3]| Disc { x, y, radius };
    Footprint::new(discs.iter().map(disc).collect()).expect("at least one disc with a radius")
}

/// Name and problem.
type Named = (&'static str, Problem);

/// Problems at the limits.
pub fn extremes() -> Vec<Named> {
    let mut all = long_distances();
    all.extend(crowds());
    all.extend(stationary_windows());
    all
}

fn axis(low: f64, high: f64, count: u32) -> Axis {
    Axis::new(low, high, count)
}

/// Forwards and backwards by this distance per step, with the fastest allowed turn, ignoring obstacles.
fn fast(metres_per_step: f64, steps: u32, step_s: f64) -> Problem {
    let (speed, rate) = (metres_per_step / step_s, 1.5 / step_s);
    Problem {
        window: Window { vx: axis(-speed, speed, 7), vtheta: axis(-rate, rate, 9) },
        steps,
        step_s,
        pose: Pose::new(2.5, 2.5, 0.785),
        outside: Outside::Free,
        braking_x: 1e3,
        braking_theta: 1e3,
        ..plain()
    }
}

fn long_distances() -> Vec<Named> {
    let unit_m = plain().field.unit_m();
    let longest_m = 262_143.9 * unit_m;
    let far = 32_767.0 * unit_m;
    let corners = [[far, far], [-far, far], [far, -far], [-far, -far]];
    let sides = [[far, 0.0], [0.0, far], [0.0, 0.0], [-0.5, 0.0]];
    let discs: Vec<[f64; 3]> = corners.iter().chain(&sides).map(|&[x, y]| [x, y, 0.1]).collect();
    let away = Point::new(-536_870_000.0 * unit_m, 536_870_000.0 * unit_m);
    vec![
        ("longest steps", fast(16_383.9 * unit_m, 16, 0.3)),
        ("farthest reach", fast(longest_m / 1023.0, 1023, 0.1)),
        ("widest footprint", Problem { footprint: footprint(&discs), ..fast(0.01, 200, 0.1) }),
        (
            "farthest target and key node",
            Problem {
                target: Point::new(2.5 - longest_m, 2.5),
                key_node: Point::new(2.5, 2.5 - longest_m),
                normalization: Normalization::MinMax,
                ..fast(longest_m / 100.0, 100, 0.3)
            },
        ),
        (
            "far from the field",
            Problem {
                pose: Pose::new(away.x, away.y, 2.0),
                target: away,
                key_node: away,
                ..fast(longest_m / 100.0, 100, 0.3)
            },
        ),
    ]
}

fn crowds() -> Vec<Named> {
    let unit_m = plain().field.unit_m();
    // From up to 480 m away, they reach the robot just after the last step.
    let body = |index: i32| {
        let from_middle = |place: i32| f64::from(place) - 15.5;
        let (across, along) = (from_middle(index % 32), from_middle(index / 32));
        MovingDisc {
            x: 2.5 + across * 21.0,
            y: 2.5 + along * 21.0,
            radius: 0.3,
            vx: -across * 4.0,
            vy: -along * 4.0,
        }
    };
    let crowd = |bodies: core::ops::Range<i32>| Problem {
        obstacles: bodies.map(body).collect(),
        ..fast(0.3, 50, 0.1)
    };
    let lone = MovingDisc { x: 9.0, y: 2.5, radius: 0.3, vx: -0.5, vy: 0.0 };
    vec![
        ("as many moving obstacles as any adapter takes", crowd(300..625)),
        ("a thousand moving obstacles", crowd(0..1024)),
        (
            "greatest clearance",
            Problem {
                // The radii of the plain robot and of the obstacle complete the sum.
                max_clearance_m: 46_329.9 * unit_m - 0.5,
                obstacles: vec![lone],
                ..fast(0.05, 40, 0.1)
            },
        ),
    ]
}

fn stationary_windows() -> Vec<Named> {
    let with = |rate: f64| Problem {
        window: Window { vx: axis(-rate, rate, 5), vtheta: axis(-rate, rate, 5) },
        ..plain()
    };
    let weights = Weights::default().heading(0.0).clearance(0.0).velocity(0.0).path(0.0);
    vec![
        ("standing still without weights", Problem { weights, ..with(0.0) }),
        ("a crawl", with(1e-12)),
    ]
}
