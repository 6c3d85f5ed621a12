//! Checks of the checks: they find a fault that a test injects.

use inbye::geometry::Twist;
use inbye::local::CpuEngine;
use inbye::robot::Footprint;
use inbye::runtime::{Config, MissionResult, Trace};
use inbye::sim::World;

use super::Test;
use super::driving::{arrive, drive, is_lawful, mission, moving_at, people, story, try_drive};
use super::ground::{Ground, hall};

pub const TESTS: &[Test] = &[
    ("trace gaps equal the distances in its world", gaps_are_true),
    ("gap check finds contact of a robot planned too small", too_small),
    ("contact ends a run as a collision", contact_ends_a_run),
    ("trace digest changes with any single bit", one_bit),
    ("command check finds a command outside the limits", unlawful),
];

/// A hall divided by a wall with a gate of 0.8 m.
fn gate() -> Ground {
    hall(10.0, 5.0).wall([5.3, 0.0, 5.7, 2.6]).wall([5.3, 3.4, 5.7, 6.0])
}

/// The smallest gap of a footprint along a trace, metres.
fn least_gap_m(trace: &Trace, ground: &Ground, footprint: &Footprint) -> f64 {
    let mut world = World::new(ground.obstacles());
    let mut least = f64::INFINITY;
    for row in &trace.rows {
        world.moving = moving_at(trace, row);
        least = least.min(world.gap_m(footprint, &row.pose));
    }
    least
}

fn with_pedestrian() -> MissionResult {
    let mut task = mission(&hall(10.0, 5.0), [1.5, 3.0, 0.0], [9.5, 3.0]);
    task.moving_obstacles =
        people(&task, r#"[{"x": 5, "y": 1.0, "radius": 0.3, "speed": 0.5, "route": [[5, 5]]}]"#);
    drive(&task)
}

fn gaps_are_true() {
    let result = with_pedestrian();
    let footprint = Config::default().robot.footprint;
    let least = least_gap_m(&result.trace, &hall(10.0, 5.0), &footprint);
    assert!((least - result.min_clearance_m).abs() < 1e-9, "{least}: {}", story(&result));
}

fn too_small() {
    let task = mission(&gate(), [2.0, 3.0, 0.0], [9.0, 3.0]);
    let small = Footprint::round(0.15);
    let mut config = Config::default();
    config.robot.footprint = small.expect("one disc");
    let engine = Box::new(CpuEngine::single_threaded());
    let result = try_drive(&task, &config, engine).expect("a small robot passes the gate");
    assert!(result.reached && !result.collided, "{}", story(&result));
    let own = least_gap_m(&result.trace, &gate(), &config.robot.footprint);
    assert!(own > 0.0);
    // A body 0.9 m wide went through a gate of 0.8 m.
    let wide = Footprint::round(0.45);
    let true_gap = least_gap_m(&result.trace, &gate(), &wide.expect("one disc"));
    assert!(true_gap < 0.0, "contact was not found: {true_gap}");
}

fn contact_ends_a_run() {
    // The robot cannot avoid a pedestrian that is faster and ignores it.
    let mut task = mission(&hall(12.0, 2.0), [2.0, 1.5, 0.0], [11.5, 1.5]);
    task.moving_obstacles = people(
        &task,
        r#"[{"x": 11.9, "y": 1.5, "radius": 0.3, "speed": 3.0, "route": [[0.8, 1.5]], "yields": false}]"#,
    );
    let engine = Box::new(CpuEngine::single_threaded());
    let result = try_drive(&task, &Config::default(), engine).expect("a mission that can start");
    let last = result.trace.rows.last().expect("a drive has ticks");
    assert!(result.collided && !result.reached && last.gap_m <= 0.0, "{}", story(&result));
}

/// Changes one number of a row, by the given function where it is a float.
type Change = fn(&mut Trace, usize, &dyn Fn(&mut f64));

fn one_bit() {
    let trace = with_pedestrian().trace;
    let digest = trace.digest();
    let flip = |number: &mut f64| *number = f64::from_bits(number.to_bits() ^ 1);
    let middle = trace.rows.len() / 2;
    let changes: [Change; 12] = [
        |trace, row, flip| flip(&mut trace.rows[row].time_s),
        |trace, row, flip| flip(&mut trace.rows[row].pose.x),
        |trace, row, flip| flip(&mut trace.rows[row].pose.yaw),
        |trace, row, flip| flip(&mut trace.rows[row].twist.linear),
        |trace, row, flip| flip(&mut trace.rows[row].command.angular),
        |trace, row, flip| flip(&mut trace.rows[row].local_target.y),
        |trace, row, flip| flip(&mut trace.rows[row].gap_m),
        |trace, row, flip| flip(&mut trace.rows[row].moving[0].as_mut().expect("a pedestrian").x),
        |trace, row, _| trace.rows[row].admissible ^= 1,
        |trace, _, flip| flip(&mut trace.paths[0][1].x),
        |trace, _, flip| flip(&mut trace.moving_radii[0]),
        |trace, row, _| trace.rows.truncate(row),
    ];
    for (number, change) in changes.iter().enumerate() {
        let mut other = trace.clone();
        change(&mut other, middle, &flip);
        assert_ne!(other.digest(), digest, "change {number} was not found");
    }
}

fn unlawful() {
    let result = arrive(&mission(&hall(6.0, 3.0), [1.5, 2.0, 0.0], [5.5, 2.0]));
    let config = Config::default();
    let limits = config.robot.limits;
    let reach_s = config.local.control_period_s + config.navigator.actuation_delay_s;
    let row = result.trace.rows.iter().find(|row| row.twist.linear > 0.5);
    let mut row = row.expect("the robot drives faster than that").clone();
    for command in [
        Twist::new(row.twist.linear - 0.3, 0.0),
        Twist::new(row.twist.linear, 0.6),
        Twist::new(1.01, 0.0),
        Twist::new(f64::NAN, 0.0),
    ] {
        assert!(is_lawful(&row, &limits, reach_s));
        let lawful = std::mem::replace(&mut row.command, command);
        assert!(!is_lawful(&row, &limits, reach_s), "{command:?} was not found");
        row.command = lawful;
    }
}
