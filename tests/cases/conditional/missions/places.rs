//! Difficult starts and goals.

use core::f64::consts::{FRAC_PI_2, PI};

use inbye::geometry::wrap_angle;
use inbye::global::PlanError;
use inbye::local::CpuEngine;
use inbye::navigator::{Fault, Mode};
use inbye::runtime::{Config, MissionError};
use inbye::sim::SimError;

use super::Test;
use super::driving::{arrive, has_mode, mission, story, try_drive};
use super::ground::{Ground, hall};

pub const TESTS: &[Test] = &[
    ("robot that faces away from its path rotates first", turns_first),
    ("robot reaches a goal deep in a narrow dead end", into_a_dead_end),
    ("robot leaves a narrow dead end that it faces", out_of_a_dead_end),
    ("robot parks at any yaw of the goal", meets_a_yaw),
    ("robot leaves a start within the margins", leaves_a_margin),
    ("start on or in a wall is rejected", rejects_a_start),
    ("robot parks at a goal 0.1 m away", stands_at_its_goal),
    ("robot drives hairpins", hairpins),
];

fn turns_first() {
    for yaw in [PI, -2.5, 2.0] {
        let result = arrive(&mission(&hall(10.0, 4.0), [2.0, 2.5, yaw], [9.0, 2.5]));
        assert_eq!(result.trace.rows[0].mode, Mode::Rotating);
        let backwards = result.trace.rows.iter().any(|row| row.pose.x < 1.9);
        assert!(!backwards && result.time_s < 30.0, "{}", story(&result));
    }
}

/// A hall with a dead end 1.5 m wide.
fn dead_end() -> Ground {
    Ground::rock(11.0, 10.0).room([0.5, 0.5, 10.5, 4.5]).room([8.0, 4.5, 9.5, 9.5])
}

fn into_a_dead_end() {
    let result = arrive(&mission(&dead_end(), [2.0, 2.5, 0.0], [8.75, 8.6]));
    assert!(result.time_s < 60.0, "{}", story(&result));
}

fn out_of_a_dead_end() {
    let result = arrive(&mission(&dead_end(), [8.75, 8.6, FRAC_PI_2], [2.0, 2.5]));
    assert!(result.time_s < 120.0, "{}", story(&result));
}

fn meets_a_yaw() {
    for yaw in [0.0, 1.3, PI, -FRAC_PI_2, 9.0] {
        let mut task = mission(&hall(8.0, 4.0), [1.5, 2.5, 0.3], [7.0, 2.5]);
        task.mission.goal.yaw = Some(yaw);
        let result = arrive(&task);
        let error = result.final_yaw_error.expect("the goal has a yaw");
        let last = result.trace.rows.last().expect("a drive has ticks");
        assert!((error - wrap_angle(last.pose.yaw - yaw)).abs() < 1e-12);
        let tolerance = Config::default().navigator.yaw_goal_tolerance;
        assert!(error.abs() <= tolerance, "{yaw}: {}", story(&result));
    }
}

fn leaves_a_margin() {
    // 0.44 m from a wall to its left, behind it or in front of it: the body, 0.25 m to the side and 0.35 m to the ends, is
    // clear, but no path may come so near.
    for start in [[4.0, 4.06, 0.0], [4.0, 4.06, PI], [0.98, 2.5, 0.0], [10.02, 2.5, 0.0]] {
        let result = arrive(&mission(&hall(10.0, 4.0), start, [7.0, 1.5]));
        assert!(result.trace.rows[0].gap_m < 0.2, "not within the margin: {start:?}");
        assert!(result.time_s < 90.0, "{start:?}: {}", story(&result));
    }
}

fn rejects_a_start() {
    for (x, y) in [(4.0, 4.4), (4.0, 4.7)] {
        let task = mission(&hall(10.0, 4.0), [x, y, 0.0], [7.0, 1.5]);
        let engine = Box::new(CpuEngine::single_threaded());
        let rejected = try_drive(&task, &Config::default(), engine).map(|result| story(&result));
        let occupied = matches!(
            rejected,
            Err(SimError::Mission(MissionError::Fault(Fault::Plan(
                PlanError::StartOccupied { .. }
            ))))
        );
        assert!(occupied, "{rejected:?}");
    }
}

fn stands_at_its_goal() {
    let result = arrive(&mission(&hall(6.0, 4.0), [3.0, 2.5, 1.0], [3.1, 2.5]));
    assert!(result.travelled_m < 0.12 && result.time_s < 5.0, "{}", story(&result));
}

fn hairpins() {
    let ground = hall(12.0, 9.0).wall([0.0, 3.2, 10.3, 3.8]).wall([2.7, 6.2, 13.0, 6.8]);
    let result = arrive(&mission(&ground, [1.5, 1.8, 0.0], [11.5, 8.2]));
    assert!(result.travelled_m > 25.0 && result.time_s < 90.0, "{}", story(&result));
    assert!(!has_mode(&result, Mode::Escaping), "{}", story(&result));
}
