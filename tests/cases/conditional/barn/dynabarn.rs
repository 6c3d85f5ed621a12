//! DynaBARN world files, and the attribution of contacts.

use std::fs;
use std::path::Path;

use inbye::experiment::ContactCause;
use inbye::experiment::barn::barn_config;
use inbye::experiment::dynabarn::{
    ContactAttribution, ScriptedCylinder, State, read_world, read_worlds,
};
use inbye::geometry::{Point, Pose, Twist};
use inbye::map::MovingDisc;
use inbye::sim::TimedPath;
use libtest_mimic::{Failed, Trial};

use super::Test;
use crate::support::trials::with_data;

pub const TESTS: &[Test] = &[
    ("a script repeats from keyframe to keyframe", plays),
    ("a world file is read, and an error names its place", reads),
    ("a robot that drives into an obstacle causes the contact", drives_into),
    ("a contact that a steady command avoids is avoidable", could_step_aside),
    ("a contact without an avoiding command is attributed to the other", run_over),
    ("the state before a contact is the latest one with enough time to react", before),
];

fn plays() {
    let keys =
        [(1.0, Point::new(0.0, 0.0)), (3.0, Point::new(4.0, 0.0)), (4.0, Point::new(4.0, 1.0))];
    let body = ScriptedCylinder {
        radius_m: 0.5,
        script: TimedPath::new(&keys, Some(5.0)).expect("a sound script"),
    };
    for (time_s, x, y, vx, vy) in [
        (0.0, 0.0, 0.0, 0.0, 0.0),
        (0.999, 0.0, 0.0, 0.0, 0.0),
        (1.0, 0.0, 0.0, 2.0, 0.0),
        (2.5, 3.0, 0.0, 2.0, 0.0),
        (3.0, 4.0, 0.0, 0.0, 1.0),
        (3.5, 4.0, 0.5, 0.0, 1.0),
        (4.5, 4.0, 1.0, 0.0, 0.0),
        // It jumps from its last key to the first.
        (5.0, 0.0, 0.0, 0.0, 0.0),
        (12.5, 3.0, 0.0, 2.0, 0.0),
    ] {
        let MovingDisc { x: at_x, y: at_y, vx: by_x, vy: by_y, radius } = body.at(time_s);
        assert_eq!((at_x, at_y, by_x, by_y, radius), (x, y, vx, vy, 0.5), "{time_s}");
    }
}

const WORLD: &str = r#"{"world": 4, "barn_index": 304, "start_x_y_yaw": [11, 0, 3.14], "goal_x_y": [-9, 0], "obstacles": [
    {"name": "a", "radius_m": 0.5, "loop_s": 3.5, "keyframes_t_x_y": [[0.0, -8.67, -10.0], [1.5, -7.0, 2.0]]},
    {"name": "b", "radius_m": 0.5, "loop_s": 9, "keyframes_t_x_y": [[0.0, 1, 1]]}], "other_models": []}"#;

fn reads() {
    let folder = tempfile::tempdir().expect("a place for temporary files");
    let file = folder.path().join("world_04.json");
    let read = |text: &str| {
        fs::write(&file, text).expect("the folder can be written to");
        read_world(&file)
    };
    let world = read(WORLD).expect("a whole world");
    assert_eq!((world.number, world.goal), (4, Point::new(-9.0, 0.0)));
    assert_eq!((world.cylinders.len(), world.cylinders[0].script.keys().len()), (2, 2));
    // On a spline it is slower at its ends than on a straight line, and faster between them.
    let fastest = world.cylinders[0].at(0.75);
    assert!((fastest.vy - 1.25 * 12.0 / 1.5).abs() < 1e-12, "{fastest:?}");
    for (from, to, words) in [
        ("\"goal_x_y\": [-9, 0], ", "", "missing field `goal_x_y`"),
        ("[-9, 0]", "[-9]", "invalid length 1"),
        ("[11, 0,", "[1e9, 0,", "line 1: start_x_y_yaw.0 is 1000000000: it must be -1000 to 1000"),
        (
            "\"radius_m\": 0.5, \"loop_s\": 9",
            "\"radius_m\": 0, \"loop_s\": 9",
            "line 3: obstacles.1.radius_m is 0: it must be above zero",
        ),
        ("[[0.0, 1, 1]]", "[]", "obstacles.1.keyframes_t_x_y is empty: it must be at least one"),
        (
            "[1.5, -7.0",
            "[0.0, -7.0",
            "line 2: obstacles.0.keyframes_t_x_y.1 is 0: it must be a time of at least zero and after",
        ),
        (
            "[1.5, -7.0",
            "[4.5, -7.0",
            "obstacles.0.loop_s is 3.5: it must be above zero, at most 1000 and not before",
        ),
        (
            "[1.5, -7.0",
            "[1.5, -7e9",
            "obstacles.0.keyframes_t_x_y.1.1 is -7000000000: it must be -1000 to 1000",
        ),
    ] {
        assert!(WORLD.contains(from), "{from}");
        let error = read(&WORLD.replacen(from, to, 1)).expect_err(words).to_string();
        assert!(error.contains(words) && error.contains("world_04.json"), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
    fs::remove_file(&file).expect("it is there");
    let error = read_worlds(folder.path(), None).expect_err("an empty folder").to_string();
    assert!(error.contains("holds no world_NN.json"), "{error}");
    let error = read_worlds(&folder.path().join("gone"), None).expect_err("no folder").to_string();
    assert!(error.contains("gone: cannot be read"), "{error}");
}

fn state(time_s: f64, pose: Pose, linear: f64) -> State {
    let twist = Twist::new(linear, 0.0);
    State { time_s, pose, twist }
}

/// A disc with a radius of 0.5 m that moves along x and is at a given point at time 10 s.
fn passing(at: [f64; 2], vx: f64) -> impl Fn(f64) -> Vec<MovingDisc> {
    move |time_s| {
        vec![MovingDisc { x: at[0] + vx * (time_s - 10.0), y: at[1], radius: 0.5, vx, vy: 0.0 }]
    }
}

/// The cause of a contact at time 10 s with the robot at the origin.
fn cause(linear: f64, moving: &dyn Fn(f64) -> Vec<MovingDisc>) -> ContactCause {
    let config = barn_config(2.0);
    let attribution = ContactAttribution {
        footprint: &config.robot.footprint,
        limits: &config.robot.limits,
        moving,
    };
    let at = state(10.0, Pose::default(), linear);
    let before = state(7.5, Pose::new(-2.5 * linear, 0.0, 0.0), linear);
    attribution.cause(&before, &at)
}

fn drives_into() {
    // The disc stands or moves away too slowly.
    for vx in [0.0, 0.3] {
        let found = cause(0.5, &passing([0.7, 0.0], vx));
        assert_eq!(found, ContactCause::Robot, "{vx}");
    }
    // In the opposite case the robot stands or backs away.
    for linear in [0.0, 0.04, -0.2] {
        let found = cause(linear, &passing([0.7, 0.0], -0.5));
        assert_ne!(found, ContactCause::Robot, "{linear}");
    }
    // Driving backwards into a disc behind the robot counts as well.
    let behind = cause(-0.2, &passing([-0.7, 0.0], 0.5));
    assert_eq!(behind, ContactCause::Robot);
}

fn could_step_aside() {
    // The disc approaches a standing robot for 2.5 s, so the robot could have left.
    let found = cause(0.0, &passing([0.7, 0.0], -0.8));
    assert_eq!(found, ContactCause::Avoidable);
}

fn run_over() {
    // The obstacle is too fast and too wide for the robot to avoid it.
    let moving = |time_s: f64| {
        let wide = |index: i32| MovingDisc {
            x: 0.7 - 6.0 * (time_s - 10.0),
            y: f64::from(index) * 0.4,
            radius: 0.5,
            vx: -6.0,
            vy: 0.0,
        };
        (-30..=30).map(wide).collect::<Vec<_>>()
    };
    assert_eq!(cause(0.0, &moving), ContactCause::Other);
    // With a gap that the robot can stand in, the contact is avoidable.
    let with_a_gap = |time_s: f64| {
        let mut discs = moving(time_s);
        discs.retain(|disc| disc.y.abs() > 1.5 || disc.y < -0.1);
        discs
    };
    assert_eq!(cause(0.0, &with_a_gap), ContactCause::Avoidable);
}

fn before() {
    let states: Vec<State> =
        (0..100).map(|tick| state(f64::from(tick) * 0.05, Pose::default(), 0.0)).collect();
    let at = |contact_s: f64| {
        let contact = state(contact_s, Pose::default(), 0.0);
        ContactAttribution::before(&states, &contact)
            .map(|state| (state.time_s * 100.0).round() / 100.0)
    };
    assert_eq!(at(4.0), Some(1.5));
    assert_eq!(at(1.0), Some(0.0));
    assert_eq!(ContactAttribution::before(&[], &states[0]), None);
}

pub fn trial() -> Trial {
    with_data("the worlds of DynaBARN are read", "dynabarn", all_are_read)
}

fn all_are_read(worlds: &Path) -> Result<(), Failed> {
    let worlds = read_worlds(worlds, None)?;
    assert_eq!(worlds.len(), 30);
    for world in &worlds {
        assert_eq!(world.start.position(), Point::new(11.0, 0.0));
        assert!((5..=24).contains(&world.cylinders.len()), "{}", world.number);
        assert!(world.cylinders.iter().all(|body| body.radius_m == 0.5));
    }
    Ok(())
}
