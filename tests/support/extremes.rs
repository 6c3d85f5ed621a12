//! A plain problem, and problems at the very limits of what is accepted, where an integer would overflow first.

use std::sync::Arc;

use inbye::geometry::{Point, Pose};
use inbye::local::{
    Axis, ClearanceField, Normalization, Outside, Problem, Stopping, Weights, Window,
};
use inbye::map::{Cell, GridFrame, MovingDisc, ObstacleGrid};
use inbye::robot::{Disc, Footprint};

/// Cells of this size have the largest unit of length but for rounding: 0.2441 mm.
const RESOLUTION_M: f64 = 0.124_99;

/// A square grid with its corner at the map's origin, free but for these cells (column and row).
pub fn field(side: i32, resolution_m: f64, blocked: &[[i32; 2]]) -> Arc<ClearanceField> {
    let frame = GridFrame {
        width: side,
        height: side,
        resolution_m,
        origin: Pose::default(),
    };
    let mut obstacles = ObstacleGrid::new(frame, vec![false; frame.len()]);
    for &[column, row] in blocked {
        obstacles.set(Cell::new(column, row), true);
    }
    Arc::new(ClearanceField::new(&obstacles).expect("a resolution within the range"))
}

/// One disc, nine samples, five steps, in the middle of a grid of 40 by 40 cells, one of them blocked.
pub fn plain() -> Problem {
    let axis = |low, high| Axis {
        low,
        high,
        count: 3,
    };
    Problem {
        field: field(40, RESOLUTION_M, &[[39, 0]]),
        pose: Pose::new(2.5, 2.5, 0.0),
        window: Window {
            linear: axis(0.0, 0.5),
            angular: axis(-0.5, 0.5),
        },
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

/// Problems at the limits, each with a name.
pub fn extremes() -> Vec<(&'static str, Problem)> {
    let unit_m = plain().field.unit_m();
    let far = 32_767.0 * unit_m;
    let fast = |metres_a_step: f64, steps: u32, step_s: f64| Problem {
        window: Window {
            linear: Axis {
                low: -metres_a_step / step_s,
                high: metres_a_step / step_s,
                count: 7,
            },
            angular: Axis {
                low: -1.5 / step_s,
                high: 1.5 / step_s,
                count: 9,
            },
        },
        steps,
        step_s,
        pose: Pose::new(2.5, 2.5, 0.785),
        outside: Outside::Free,
        braking_x: 1e3,
        braking_theta: 1e3,
        ..plain()
    };
    let widest = footprint(&[
        [far, far, 0.1],
        [-far, far, 0.1],
        [far, -far, 0.1],
        [-far, -far, 0.1],
        [far, 0.0, 0.1],
        [0.0, far, 0.1],
        [0.0, 0.0, 0.1],
        [-0.5, 0.0, 0.1],
    ]);
    let longest_m = 262_143.9 * unit_m;
    // From up to 480 m away, they meet at the robot just after the last step.
    let crowd = |index: i32| {
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
    let crowded = Problem {
        obstacles: (0..1024).map(crowd).collect(),
        ..fast(0.3, 50, 0.1)
    };
    vec![
        ("longest steps", fast(16_383.9 * unit_m, 16, 0.3)),
        ("farthest reach", fast(longest_m / 1023.0, 1023, 0.1)),
        (
            "widest footprint",
            Problem {
                footprint: widest,
                ..fast(0.01, 200, 0.1)
            },
        ),
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
                pose: Pose::new(-536_870_000.0 * unit_m, 536_870_000.0 * unit_m, 2.0),
                target: Point::new(-536_870_000.0 * unit_m, 536_870_000.0 * unit_m),
                key_node: Point::new(-536_870_000.0 * unit_m, 536_870_000.0 * unit_m),
                ..fast(longest_m / 100.0, 100, 0.3)
            },
        ),
        (
            "greatest clearance",
            Problem {
                max_clearance_m: 46_329.9 * unit_m - 0.5,
                footprint: footprint(&[[0.0, 0.0, 0.2]]),
                obstacles: vec![MovingDisc {
                    x: 9.0,
                    y: 2.5,
                    radius: 0.3,
                    vx: -0.5,
                    vy: 0.0,
                }],
                ..fast(0.05, 40, 0.1)
            },
        ),
        (
            "as many moving obstacles as any adapter takes",
            Problem {
                obstacles: crowded.obstacles[300..627].to_vec(),
                ..crowded.clone()
            },
        ),
        ("a thousand moving obstacles", crowded),
        (
            "standing still without weights",
            Problem {
                window: Window {
                    linear: Axis {
                        low: 0.0,
                        high: 0.0,
                        count: 4,
                    },
                    angular: Axis {
                        low: 0.0,
                        high: 0.0,
                        count: 4,
                    },
                },
                weights: Weights {
                    heading: 0.0,
                    clearance: 0.0,
                    velocity: 0.0,
                    path: 0.0,
                },
                ..plain()
            },
        ),
        (
            "a crawl",
            Problem {
                window: Window {
                    linear: Axis {
                        low: -1e-12,
                        high: 1e-12,
                        count: 5,
                    },
                    angular: Axis {
                        low: -1e-12,
                        high: 1e-12,
                        count: 5,
                    },
                },
                ..plain()
            },
        ),
    ]
}
