//! Worlds that differ from the map: the lidar counts.

use inbye::global::PlanError;
use inbye::navigator::{Fault, Mode};

use super::Test;
use super::driving::{arrive, drive, has_mode, mission, story};
use super::ground::{Ground, hall};

pub const TESTS: &[Test] = &[
    (
        "robot replans through the far passage when the near door is closed",
        replans_through_the_far_passage,
    ),
    ("door that is closed in the map stays unused", trusts_the_map),
    ("mission fails with a reason when the only door is closed", fails_with_a_reason),
    ("robot gives up between two passages that are both closed", both_closed),
    ("enclosed robot stands and fails with a reason", walled_in),
    ("robot leaves an unmapped trap", out_of_a_trap),
    ("robot drives around an unmapped pillar", around_a_pillar),
];

/// Two halls joined by two passages, the near one straight ahead.
fn two_passages() -> Ground {
    Ground::rock(16.0, 12.0)
        .room([0.5, 0.5, 5.0, 11.5])
        .room([11.0, 0.5, 15.5, 11.5])
        .room([5.0, 1.5, 11.0, 3.7])
        .room([5.0, 8.0, 11.0, 10.2])
}

const NEAR_DOOR: [f64; 4] = [8.0, 1.5, 8.3, 3.7];
const FAR_DOOR: [f64; 4] = [8.0, 8.0, 8.3, 10.2];
const START: [f64; 3] = [2.5, 2.6, 0.0];
const GOAL: [f64; 2] = [13.5, 2.6];

fn replans_through_the_far_passage() {
    let ground = two_passages();
    let open = arrive(&mission(&ground, START, GOAL));
    assert_eq!(open.plans.len(), 1, "{}", story(&open));
    let mut closed = mission(&ground, START, GOAL);
    closed.truth = Some(ground.wall(NEAR_DOOR).obstacles());
    let result = arrive(&closed);
    assert!(result.plans.len() > 1, "{}", story(&result));
    let through_far =
        |row: &inbye::runtime::TraceRow| (5.0..11.0).contains(&row.pose.x) && row.pose.y > 7.5;
    assert!(result.trace.rows.iter().any(through_far), "{}", story(&result));
    // The robot need not drive to the door: the lidar sees it from the hall.
    assert!(result.travelled_m < open.travelled_m + 19.0, "{}", story(&result));
}

fn trusts_the_map() {
    let ground = two_passages();
    let mut task = mission(&ground.clone().wall(NEAR_DOOR), START, GOAL);
    task.truth = Some(ground.obstacles());
    let result = arrive(&task);
    assert!(result.trace.rows.iter().any(|row| row.pose.y > 7.5), "{}", story(&result));
}

fn fails_with_a_reason() {
    let ground = two_passages().wall(FAR_DOOR);
    let mut task = mission(&ground, START, GOAL);
    task.truth = Some(ground.wall(NEAR_DOOR).obstacles());
    let result = drive(&task);
    assert!(!result.reached, "{}", story(&result));
    assert!(
        matches!(result.fault, Some(Fault::Plan(PlanError::NoValidPath { .. }))),
        "{}",
        story(&result)
    );
    let why = result.why().unwrap_or_default();
    assert!(why.contains("obstacles that the map does not show"), "{why}");
    // Well before the time limit, and standing.
    assert!(result.time_s < 200.0, "{}", story(&result));
    let last = result.trace.rows.last().expect("a drive has ticks");
    assert_eq!(last.mode, Mode::Failed);
    assert!(last.pose.x < 8.0, "{}", story(&result));
}

fn both_closed() {
    let ground = two_passages();
    let mut task = mission(&ground, START, GOAL);
    task.truth = Some(ground.wall(NEAR_DOOR).wall(FAR_DOOR).obstacles());
    let result = drive(&task);
    assert!(
        matches!(result.fault, Some(Fault::Plan(PlanError::NoValidPath { .. }))),
        "{}",
        story(&result)
    );
    // It looks at each again, and then ends instead of driving to and fro until its time is up.
    assert!(result.plans.len() > 3 && result.time_s < 200.0, "{}", story(&result));
}

fn walled_in() {
    let ground = hall(10.0, 6.0);
    let mut task = mission(&ground, [3.05, 3.55, 0.0], [9.5, 3.5]);
    // A ring of 1 m inner width: the robot, 0.84 m long, cannot even turn in it with its margins.
    let ring = ground.wall([2.3, 2.8, 3.8, 4.3]).room([2.55, 3.05, 3.55, 4.05]);
    task.truth = Some(ring.obstacles());
    let result = drive(&task);
    assert!(!result.reached && result.travelled_m < 0.2, "{}", story(&result));
    let fault = result.fault.as_ref().map(ToString::to_string).unwrap_or_default();
    assert!(fault.starts_with("NO_VALID_CONTROL"), "{}", story(&result));
    assert!(has_mode(&result, Mode::Blocked) && result.time_s < 120.0, "{}", story(&result));
}

fn out_of_a_trap() {
    let ground = hall(16.0, 12.0);
    let mut task = mission(&ground, [2.0, 6.5, 0.0], [14.5, 6.5]);
    // A U that opens towards the robot, across its straight line to the goal.
    let trap =
        ground.wall([7.0, 3.5, 10.3, 3.8]).wall([7.0, 9.2, 10.3, 9.5]).wall([10.0, 3.5, 10.3, 9.5]);
    task.truth = Some(trap.obstacles());
    let result = arrive(&task);
    assert!(result.plans.len() > 1, "{}", story(&result));
}

fn around_a_pillar() {
    let ground = hall(12.0, 5.0);
    let mut task = mission(&ground, [1.5, 3.0, 0.0], [11.0, 3.0]);
    task.truth = Some(ground.wall([6.0, 2.7, 6.5, 3.3]).obstacles());
    let result = arrive(&task);
    assert!(result.plans.len() > 1 && result.time_s < 60.0, "{}", story(&result));
}
