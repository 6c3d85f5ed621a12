//! Pedestrians that cross, follow or approach the robot, stand on its path or appear in front of it.

use inbye::geometry::{Pose, wrap_angle};
use inbye::runtime::{Config, MissionResult};
use inbye::sim::{Simulation, World};

use super::Test;
use super::driving::{arrive, drive, mission, moving_at, people, story, try_drive};
use super::ground::{Ground, hall};

pub const TESTS: &[Test] = &[
    ("robot arrives among crossing pedestrians", crossing),
    ("robot evades an oncoming pedestrian that does not yield in a wide roadway", head_on),
    ("robot is not hit by an overtaking pedestrian that does not yield", from_behind),
    ("robot drives around a standing pedestrian", standing),
    ("robot passes two standing pedestrians", standing_pair),
    ("robot starts next to a standing pedestrian", next_to_one),
    ("robot does not touch a pedestrian that steps out at braking distance", steps_out),
    ("robot keeps its distance behind a slow pedestrian", slow_ahead),
    ("robot passes a gate after a pedestrian leaves it", gate),
];

/// A drive along a roadway 6 m wide.
fn roadway() -> Simulation {
    mission(&hall(24.0, 6.0), [2.0, 3.5, 0.0], [23.0, 3.5])
}

fn with(mut task: Simulation, json: &str) -> Simulation {
    task.moving_obstacles = people(&task, json);
    task
}

fn crossing() {
    let task = with(
        roadway(),
        r#"[{"x": 7, "y": 1.2, "radius": 0.3, "speed": 0.5, "route": [[7, 5.8]]},
            {"x": 12, "y": 5.8, "radius": 0.3, "speed": 0.7, "route": [[11, 1.2]]},
            {"x": 16, "y": 1.2, "radius": 0.3, "speed": 0.35, "route": [[17, 5.8]]}]"#,
    );
    let result = arrive(&task);
    assert!(result.time_s < 90.0, "{}", story(&result));
}

/// Whether the robot moved towards what it touched: only then it caused the contact.
fn caused_contact(result: &MissionResult) -> bool {
    let footprint = Config::default().robot.footprint;
    let rows = &result.trace.rows;
    let Some(last) = rows.last().filter(|row| row.gap_m <= 0.0) else {
        return false;
    };
    let mut world = World::new(hall(24.0, 6.0).obstacles());
    world.moving = moving_at(&result.trace, last);
    let step = last.twist.linear * 0.05;
    let ahead = Pose {
        x: last.pose.x + step * libm::cos(last.pose.yaw),
        y: last.pose.y + step * libm::sin(last.pose.yaw),
        yaw: wrap_angle(last.pose.yaw + last.twist.angular * 0.05),
    };
    world.gap_m(&footprint, &ahead) < world.gap_m(&footprint, &last.pose) - 1e-3
}

fn head_on() {
    for (lane, speed) in [(3.5, 0.5), (3.2, 0.8), (4.2, 0.3), (2.6, 0.6)] {
        let task = with(
            roadway(),
            &format!(
                r#"[{{"x": 22, "y": {lane}, "radius": 0.3, "speed": {speed}, "route": [[3, {lane}]], "yields": false}}]"#
            ),
        );
        let result = drive_unchecked(&task);
        assert!(!caused_contact(&result), "{}", story(&result));
        assert!(
            result.reached && !result.collided,
            "lane {lane}, speed {speed}: {}",
            story(&result)
        );
    }
}

fn from_behind() {
    let task = with(
        roadway(),
        r#"[{"x": 1.2, "y": 4.6, "radius": 0.3, "speed": 1.1, "route": [[23, 4.2]], "yields": false}]"#,
    );
    let result = drive_unchecked(&task);
    assert!(result.reached && !result.collided, "{}", story(&result));
}

/// Drives without the check for contact.
fn drive_unchecked(task: &Simulation) -> MissionResult {
    let engine = Box::new(inbye::local::CpuEngine::single_threaded());
    try_drive(task, &Config::default(), engine).expect("a mission that can start")
}

fn standing() {
    let task = with(roadway(), r#"[{"x": 12, "y": 3.5, "radius": 0.3, "speed": 0}]"#);
    let result = arrive(&task);
    assert!(result.time_s < 60.0, "{}", story(&result));
}

fn standing_pair() {
    let task = with(
        roadway(),
        r#"[{"x": 12, "y": 3.6, "radius": 0.3, "speed": 0}, {"x": 12.3, "y": 2.7, "radius": 0.3, "speed": 0}]"#,
    );
    let result = arrive(&task);
    assert!(result.time_s < 90.0, "{}", story(&result));
}

fn next_to_one() {
    // 0.2 m from its left side, within its margin for moving obstacles.
    let task = with(roadway(), r#"[{"x": 2.1, "y": 4.3, "radius": 0.3, "speed": 0}]"#);
    let result = arrive(&task);
    assert!(result.trace.rows[0].gap_m < 0.25 && result.time_s < 45.0, "{}", story(&result));
    let closest = result.min_clearance_m;
    assert!(closest > 0.1, "came nearer: {}", story(&result));
}

fn steps_out() {
    // A niche next to the roadway hides a pedestrian that steps out in front of the robot.
    let ground = hall(16.0, 5.5).wall([0.5, 3.5, 8.0, 6.0]).wall([9.2, 3.5, 16.5, 6.0]);
    for speed in [0.4, 0.6, 0.8, 1.0] {
        let task = with(
            mission(&ground, [1.5, 2.0, 0.0], [15.0, 2.0]),
            &format!(
                r#"[{{"x": 8.6, "y": 5.6, "radius": 0.3, "speed": {speed}, "route": [[8.6, 1.6]]}}]"#
            ),
        );
        drive(&task);
    }
}

fn slow_ahead() {
    let ground = hall(20.0, 2.4);
    let task = with(
        mission(&ground, [1.2, 1.7, 0.0], [13.0, 1.7]),
        r#"[{"x": 3, "y": 1.7, "radius": 0.3, "speed": 0.25, "route": [[20, 1.7]]}]"#,
    );
    let result = arrive(&task);
    assert!(result.min_clearance_m > 0.1, "{}", story(&result));
}

fn gate() {
    let ground: Ground = hall(14.0, 6.0).wall([7.0, 0.0, 7.4, 2.8]).wall([7.0, 4.2, 7.4, 7.0]);
    let task = with(
        mission(&ground, [1.5, 3.5, 0.0], [13.0, 3.5]),
        r#"[{"x": 7.2, "y": 3.5, "radius": 0.3, "speed": 0.05, "route": [[9.2, 3.5], [9.2, 6.0]]}]"#,
    );
    let result = arrive(&task);
    assert!(result.time_s > 20.0, "the gate was free: {}", story(&result));
}
