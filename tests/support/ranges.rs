//! Every limit of a problem: just inside it the problem is evaluated, just outside it the error names the quantity.

use core::f64::consts::PI;

use inbye::geometry::{Point, Pose, Vector};
use inbye::local::{
    Axis, ClearanceField, CpuEngine, Detail, Engine, Evaluation, Problem, ProblemError,
    QuantizedProblem, Window,
};
use inbye::map::{GridFrame, MovingDisc, ObstacleGrid};

use super::extremes::{extremes, field, footprint, plain};

/// Evaluates a problem that must be accepted. Release builds check for overflow too, so it would panic.
fn assert_accepted(what: &str, problem: &Problem) -> Evaluation {
    let quantized = match QuantizedProblem::new(problem) {
        Ok(quantized) => quantized,
        Err(error) => panic!("{what}, just inside the limit, was rejected: {error}"),
    };
    CpuEngine::single_threaded()
        .evaluate(&quantized, Detail::Answer)
        .expect("the CPU engine has no device to lose")
}

/// The quantity that an error names.
fn quantity(error: &ProblemError) -> String {
    match error {
        ProblemError::OutOfRange { quantity, .. }
        | ProblemError::TooFar { quantity, .. }
        | ProblemError::NotFinite { quantity } => (*quantity).to_owned(),
        ProblemError::BadObstacle { index } => format!("moving obstacle {index}"),
        other => panic!("an unknown kind of error: {other:?}"),
    }
}

fn assert_rejected(what: &str, problem: &Problem) {
    let Err(error) = QuantizedProblem::new(problem) else {
        panic!("{what}, just outside the limit, was accepted");
    };
    assert_eq!(quantity(&error), what, "{error}");
    let message = error.to_string();
    assert!(message.contains(what) && !message.contains('\n'), "{message}");
}

/// Sets a number of the plain problem to a value just inside and then just outside a limit.
fn limit(what: &str, inside: f64, outside: f64, set: impl Fn(&mut Problem, f64)) {
    let with = |value| {
        let mut problem = plain();
        set(&mut problem, value);
        problem
    };
    assert_accepted(what, &with(inside));
    assert_rejected(what, &with(outside));
}

fn linear(low: f64, high: f64, count: u32) -> Axis {
    Axis::new(low, high, count)
}

#[test]
fn resolution_out_of_range_is_rejected() {
    for (inside, outside) in [(0.001, 0.000_999), (2.0, 2.001)] {
        let with = |resolution_m| {
            let frame = GridFrame { resolution_m, ..*plain().field.frame() };
            ClearanceField::new(&ObstacleGrid::filled(frame, false))
        };
        let unit_m = with(inside).expect("just inside").unit_m();
        assert!((1.22e-4..=2.4415e-4).contains(&unit_m), "{unit_m}");
        let error = with(outside).expect_err("just outside");
        assert_eq!(quantity(&error), "map resolution", "{error}");
        let error = with(f64::NAN).expect_err("not a number");
        assert_eq!(quantity(&error), "map resolution", "{error}");
    }
}

#[test]
fn counts_out_of_range_are_rejected() {
    let counts = |linear, angular, steps| {
        let mut problem = plain();
        problem.window.vx.count = linear;
        problem.window.vtheta.count = angular;
        problem.steps = steps;
        problem
    };
    let evaluation = assert_accepted("number of samples", &counts(2048, 2048, 1));
    assert_eq!(evaluation.counts.admissible, 1 << 22);
    assert_rejected("number of samples", &counts(2048, 2049, 1));
    assert_rejected("number of samples", &counts(u32::MAX, u32::MAX, 1));
    assert_accepted("number of samples", &counts(1, 1, 1));
    assert_rejected("number of samples", &counts(0, 5, 1));
    assert_rejected("number of samples", &counts(5, 0, 1));
    assert_accepted("number of steps", &counts(3, 3, 1023));
    assert_rejected("number of steps", &counts(3, 3, 1024));
    assert_rejected("number of steps", &counts(3, 3, 0));
}

#[test]
fn trajectory_distances_out_of_range_are_rejected() {
    let unit_m = plain().field.unit_m();
    let longest_m = 16_384.0 * unit_m;
    limit("distance in one step", 0.999 * longest_m, 1.001 * longest_m, |problem, metres| {
        problem.step_s = 0.5;
        problem.window.vx = linear(-metres / 0.5, 0.0, 3);
    });
    let reach_m = 262_144.0 * unit_m;
    limit("distance over the horizon", 0.999 * reach_m, 1.001 * reach_m, |problem, metres| {
        problem.steps = 100;
        problem.window.vx = linear(0.0, metres / 10.0, 3);
    });
    limit("distance to the target", 0.999 * reach_m, 1.001 * reach_m, |problem, metres| {
        problem.target = problem.pose.position() + Vector::new(0.6, -0.8) * metres;
    });
    limit("distance to the key node", 0.999 * reach_m, 1.001 * reach_m, |problem, metres| {
        problem.key_node = problem.pose.position() + Vector::new(-0.8, 0.6) * metres;
    });
    let corner_m = 2.0_f64.powi(29) * unit_m;
    limit(
        "distance to the field's corner",
        0.999 * corner_m,
        1.001 * corner_m,
        |problem, metres| {
            problem.pose = Pose::new(2.5, -metres, PI);
            (problem.target, problem.key_node) = (problem.pose.position(), problem.pose.position());
        },
    );
}

#[test]
fn rates_out_of_range_are_rejected() {
    limit("forward speed", 15.99, 16.0, |problem, speed| {
        problem.window.vx = linear(0.0, speed, 3);
    });
    limit("turn in one step", 1.5, 1.501, |problem, angle| {
        problem.window.vtheta = linear(-angle / problem.step_s, 0.0, 3);
    });
}

#[test]
fn footprints_and_clearances_out_of_range_are_rejected() {
    let unit_m = plain().field.unit_m();
    let offset_m = 32_767.0 * unit_m;
    limit("disc offset", 0.999 * offset_m, 1.001 * offset_m, |problem, metres| {
        problem.footprint = footprint(&[[0.1, -metres, 0.2]]);
    });
    let sum_m = 46_330.0 * unit_m;
    limit("max_clearance_m plus disc radius", 0.999 * sum_m, 1.001 * sum_m, |problem, metres| {
        problem.max_clearance_m = metres - 0.2;
    });
    let together = "max_clearance_m plus disc and obstacle radius";
    limit(together, 0.999 * sum_m, 1.001 * sum_m, |problem, metres| {
        problem.max_clearance_m = metres - 0.7;
        problem.obstacles = vec![body(4.0, 0.5, 0.0)];
    });
    limit("max_clearance_m", 0.001, 0.000_9, |problem, metres| {
        problem.max_clearance_m = metres;
    });
    limit("number of discs", 8.0, 9.0, |problem, count| {
        problem.footprint = footprint(&vec![[0.0, 0.0, 0.1]; count as usize]);
    });
}

fn body(x: f64, radius: f64, vx: f64) -> MovingDisc {
    MovingDisc { x, y: 2.5, radius, vx, vy: 0.0 }
}

#[test]
fn moving_obstacles_out_of_range_are_rejected() {
    limit("moving obstacles", 1024.0, 1025.0, |problem, count| {
        problem.obstacles = vec![body(4.0, 0.1, 0.1); count as usize];
    });
    let way_m = 2.0_f64.powi(22) * plain().field.unit_m();
    limit("distance of a moving obstacle", 0.999 * way_m, 1.001 * way_m, |problem, metres| {
        problem.obstacles = vec![body(3.5, 0.1, (metres - 1.0) / 0.5)];
    });
    for value in [f64::NAN, f64::INFINITY] {
        for broken in [
            MovingDisc { x: value, ..body(3.0, 0.1, 0.0) },
            MovingDisc { vy: value, ..body(3.0, 0.1, 0.0) },
            body(3.0, value, 0.0),
            body(3.0, 0.0, 0.0),
            body(3.0, -0.1, 0.0),
        ] {
            let obstacles = vec![body(4.0, 0.1, 0.0), broken];
            assert_rejected("moving obstacle 1", &Problem { obstacles, ..plain() });
        }
    }
    // An obstacle too far away to matter may have any size and speed.
    let obstacles = vec![body(-1e6, 0.1, 3.0)];
    assert_accepted("moving obstacles", &Problem { obstacles, ..plain() });
}

#[test]
fn non_positive_numbers_are_rejected() {
    type Set = fn(&mut Problem, f64);
    let above_zero: [(&str, Set); 4] = [
        ("deceleration along the path", |problem, value| {
            problem.braking_x = value;
        }),
        ("angular deceleration", |problem, value| {
            problem.braking_theta = value;
        }),
        ("duration of a step", |problem, value| {
            problem.step_s = value;
        }),
        ("max_clearance_m", |problem, value| {
            problem.max_clearance_m = value;
        }),
    ];
    for (what, set) in above_zero {
        for outside in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            limit(what, 0.01, outside, set);
        }
    }
    let weights: [(&str, Set); 4] = [
        ("heading", |problem, value| {
            problem.weights.heading = value;
        }),
        ("clearance", |problem, value| {
            problem.weights.clearance = value;
        }),
        ("velocity", |problem, value| {
            problem.weights.velocity = value;
        }),
        ("path", |problem, value| problem.weights.path = value),
    ];
    for (what, set) in weights {
        for (inside, outside) in [(0.0, -1e-9), (1e6, 1.1e6), (1.0, f64::NAN)] {
            limit(what, inside, outside, set);
        }
    }
}

#[test]
fn numbers_that_are_not_finite_are_rejected() {
    type Set = fn(&mut Problem, f64);
    let sets: [(&str, Set); 5] = [
        ("pose", |problem, value| problem.pose.yaw = value),
        ("forward speed window", |problem, value| {
            problem.window.vx.high = value;
        }),
        ("turn rate window", |problem, value| {
            problem.window.vtheta.low = value;
        }),
        ("target", |problem, value| problem.target.y = value),
        ("key node", |problem, value| problem.key_node.x = value),
    ];
    for (what, set) in sets {
        for outside in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            limit(what, 0.1, outside, set);
        }
    }
}

#[test]
fn problems_at_the_limits_do_not_overflow() {
    for (name, problem) in extremes() {
        let evaluation = assert_accepted(name, &problem);
        let counts = evaluation.counts;
        let judged = counts.admissible + counts.collision + counts.cannot_stop + counts.outside;
        assert_eq!(judged as usize, problem.window.len(), "{name}");
    }
    // The window is one way to many samples; the largest grid that suits a test is another.
    let large = Problem {
        field: field(3000, 0.05, &[[0, 0]]),
        pose: Pose::new(75.0, 75.0, 1.0),
        target: Point::new(80.0, 80.0),
        key_node: Point::new(76.0, 76.0),
        window: Window { vx: linear(0.0, 1.0, 20), vtheta: linear(-1.0, 1.0, 20) },
        ..plain()
    };
    assert_eq!(assert_accepted("a large grid", &large).counts.admissible, 400);
}
