//! Tests of the schema of the messages in the book.

use std::collections::BTreeSet;

use serde::Serialize;
use serde_json::Value;

use super::protocol::{
    GridMessage, LidarMessage, PROTOCOL, PathRequest, PlannedPath, Ready, Request, Robot, Role,
    ScanMessage, Simulate, SimulatedState, Start, Step, Tick, Velocity,
};
use crate::geometry::{Point, Pose, Twist};
use crate::map::{GridFrame, ObstacleGrid, Scan};
use crate::navigator::Goal;
use crate::robot::{Footprint, Limits};

/// Keys of an object, and those that the book's schema requires and permits.
fn assert_follows_schema(name: &str, message: &impl Serialize) {
    let schema: Value =
        serde_json::from_str(include_str!("../../docs/src/protocol.schema.json")).expect("JSON");
    let schema = &schema["$defs"][name];
    let message = serde_json::to_value(message).expect("a message has a JSON form");
    let keys: BTreeSet<&str> =
        message.as_object().expect("an object").keys().map(String::as_str).collect();
    let known = schema["properties"].as_object().expect("the schema lists the fields");
    assert_eq!(keys, known.keys().map(String::as_str).collect(), "{name}");
    let required = schema["required"].as_array().expect("a list");
    assert!(required.iter().all(|key| keys.contains(key.as_str().expect("a key"))), "{name}");
}

/// Whether a value follows a part of the book's schema, by the keywords that it uses.
fn follows(value: &Value, schema: &Value, whole: &Value) -> bool {
    let follows = |value: &Value, schema: &Value| follows(value, schema, whole);
    let all_of = |list: &Value| -> Vec<Value> { list.as_array().cloned().unwrap_or_default() };
    schema.as_object().expect("a schema").iter().all(|(keyword, rule)| match keyword.as_str() {
        "$ref" => {
            let pointer = rule.as_str().and_then(|name| name.strip_prefix('#'));
            follows(value, whole.pointer(pointer.expect("a place")).expect("a definition"))
        }
        "anyOf" => all_of(rule).iter().any(|schema| follows(value, schema)),
        "oneOf" => all_of(rule).iter().filter(|schema| follows(value, schema)).count() == 1,
        "const" => value == rule,
        "enum" => all_of(rule).contains(value),
        "type" => {
            let kind = match value {
                Value::Null => "null",
                Value::Bool(_) => "boolean",
                Value::Number(number) if number.is_f64() => "number",
                Value::Number(_) => "integer",
                Value::String(_) => "string",
                Value::Array(_) => "array",
                Value::Object(_) => "object",
            };
            let is_kind = |rule: &Value| rule == kind || (rule == "number" && kind == "integer");
            is_kind(rule) || all_of(rule).iter().any(is_kind)
        }
        "required" => {
            all_of(rule).iter().all(|key| value.get(key.as_str().expect("a key")).is_some())
        }
        "properties" => value.as_object().is_none_or(|fields| {
            fields.iter().all(|(key, value)| rule.get(key).is_none_or(|it| follows(value, it)))
        }),
        "additionalProperties" => value
            .as_object()
            .is_none_or(|fields| fields.keys().all(|key| schema["properties"].get(key).is_some())),
        "items" => all_of(value).iter().all(|item| follows(item, rule)),
        "prefixItems" => {
            all_of(value).iter().zip(&all_of(rule)).all(|(item, it)| follows(item, it))
        }
        "minItems" => all_of(value).len() as u64 >= rule.as_u64().expect("a number"),
        "maxItems" => all_of(value).len() as u64 <= rule.as_u64().expect("a number"),
        "description" | "title" | "$schema" | "$defs" => true,
        other => panic!("{other} is not checked"),
    })
}

#[test]
fn schema_in_the_book_accepts_what_the_program_accepts() {
    let schema: Value =
        serde_json::from_str(include_str!("../../docs/src/protocol.schema.json")).expect("JSON");
    let is_answer = |name: &str, text: &str| match name {
        "velocity_answer" => serde_json::from_str::<Velocity>(text).is_ok(),
        "path_answer" => serde_json::from_str::<PlannedPath>(text).is_ok(),
        "state" => serde_json::from_str::<SimulatedState>(text).is_ok(),
        _ => serde_json::from_str::<Ready>(text).is_ok(),
    };
    let state = r#"{"odometry": {"pose": [0, 0, 0], "twist": [0, 0]},
        "scan": {"angle_min": 0, "angle_increment": 0.1, "range_max": 9, "ranges": [1, null]},
        "truth": {"pose": [0, 0, 0], "twist": [0, 0], "contact": false}}"#;
    for (name, text, is_valid) in [
        ("velocity_answer", r#"{"linear": 0.5, "angular": 1}"#, true),
        ("velocity_answer", r#"{"error": "x"}"#, true),
        ("velocity_answer", r#"{"tick": 3, "linear": 0.5, "angular": 1}"#, true),
        ("velocity_answer", r#"{"tick": 3, "error": "x"}"#, true),
        ("velocity_answer", r#"{"tick": "3", "error": "x"}"#, false),
        ("velocity_answer", r#"{"step": 3, "error": "x"}"#, false),
        ("velocity_answer", "{}", false),
        ("velocity_answer", r#"{"linear": 1}"#, false),
        ("velocity_answer", r#"{"linear": 1, "angular": 0, "error": "x"}"#, false),
        ("path_answer", r#"{"path": [[0, 0], [1, 1]]}"#, true),
        ("path_answer", r#"{"error": "x"}"#, true),
        ("path_answer", r#"{"request": 3, "path": [[0, 0], [1, 1]]}"#, true),
        ("path_answer", r#"{"request": 3, "error": "x"}"#, true),
        ("path_answer", r#"{"path": [[0, 0, 0], [1, 1]]}"#, false),
        ("path_answer", r#"{"path": [[0, 0], [1, 1]], "cost": 1}"#, false),
        ("ready", r#"{"protocol": 1, "wants": ["map"]}"#, true),
        ("ready", r#"{"protocol": 1, "wants": ["maps"]}"#, false),
        ("state", state, true),
        ("state", &state.replacen('{', r#"{"step": 3, "#, 1), true),
        ("state", r#"{"odometry": null}"#, false),
    ] {
        let value: Value = serde_json::from_str(text).expect("JSON");
        assert_eq!(follows(&value, &schema["$defs"][name], &schema), is_valid, "{name}: {text}");
        assert_eq!(is_answer(name, text), is_valid, "{name}: {text}");
        // Other kinds of messages do not accept it instead.
        assert_eq!(follows(&value, &schema, &schema), is_valid, "{text}");
    }
}

#[test]
fn messages_have_the_fields_of_the_schema_in_the_book() {
    let (footprint, limits) = (Footprint::round(0.3).expect("a radius"), Limits::default());
    let frame = GridFrame::new(1, 1, 0.1, Pose::default()).expect("a size");
    let grid = GridMessage::of_grid(&ObstacleGrid::new(frame, vec![true]));
    let (pose, twist, place) = (Pose::default(), Twist::STOP, Point::default());
    let scan = Scan::default();
    let robot = || Robot::new(&footprint, &limits);
    let role = Role::Controller;
    for (budget_s, goal_tolerance) in [(None, None), (Some(0.1), Some([0.25, 0.1]))] {
        let (protocol, period_s, robot) = (PROTOCOL, 0.1, robot());
        let start = Start { protocol, role, period_s, budget_s, goal_tolerance, robot };
        assert_follows_schema("start", &Request::Start(start));
    }
    assert_follows_schema("robot", &robot());
    assert_follows_schema("limits", &limits);
    assert_follows_schema("grid", &grid);
    assert_follows_schema("scan", &ScanMessage::new(&scan));
    let tick = Tick {
        tick: 0,
        time_s: 0.0,
        pose,
        twist,
        odometry_s: 0.0,
        predicted_pose: pose,
        predicted_twist: twist,
        last_command: twist,
        limits: &limits,
        goal: Goal::at(place),
        local_target: place,
        path: Some(Vec::new()),
        path_progress_m: 0.0,
        reset: false,
        scan: ScanMessage::new(&scan),
        scan_s: 0.0,
        moving_obstacles: Some(&[]),
        local_grid: Some(grid.clone()),
        map: Some(&grid),
    };
    assert_follows_schema("tick", &Request::Tick(Box::new(tick)));
    let plan = PathRequest { request: 0, start: place, goal: place, radius_m: 0.3, grid: &grid };
    assert_follows_schema("plan", &Request::Plan(plan));
    let lidar =
        LidarMessage { beams: 1, field_of_view_rad: 1.0, range_max_m: 1.0, range_sigma_m: 0.0 };
    assert_follows_schema("lidar", &lidar);
    let simulate = Simulate {
        protocol: PROTOCOL,
        period_s: 0.1,
        seed: 0,
        robot: robot(),
        track_width_m: 0.4,
        start: pose,
        goal: Goal::at(place),
        lidar,
        obstacles: grid.clone(),
    };
    assert_follows_schema("simulate", &Request::Simulate(Box::new(simulate)));
    let step = Step { step: 0, period_s: 0.1, linear: 0.0, angular: 0.0 };
    assert_follows_schema("step", &Request::Step(step));
}
