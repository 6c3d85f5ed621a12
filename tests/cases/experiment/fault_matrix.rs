//! The simulated half of the fault matrix: its rows, and drives that fail without what acts on the fault.

use std::collections::BTreeSet;

use inbye::experiment::{simulated_fault_names, simulated_faults};
use inbye::local::CpuEngine;
use inbye::runtime::{Config, MissionResult, Observer};
use inbye::sim::{FaultInjection, LidarChange, Simulation, WrongPlanner, roadway};

const FROM_S: f64 = 6.0;
const TO_S: f64 = f64::INFINITY;

/// A drive of this time, seconds, through the roadways.
fn drive(config: &Config, fault: FaultInjection, most_s: f64) -> MissionResult {
    let mut simulation = Simulation::new(roadway().mission(most_s));
    simulation.faults.push(fault);
    let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
    let engine = Box::new(CpuEngine::single_threaded());
    simulation.run(config, engine, &mut observer).expect("a path")
}

fn without_layer() -> Config {
    let mut config = Config::default();
    config.collision_monitor.enabled = false;
    config
}

#[test]
fn fault_matrix_has_a_row_for_every_fault_of_a_drive() {
    let names: Vec<&str> = simulated_fault_names().collect();
    assert_eq!(names.iter().collect::<BTreeSet<_>>().len(), names.len(), "equal names");
    for word in [
        "sees no surface",
        "measures nothing",
        "sends nothing",
        "repeats a revolution",
        "blind ahead",
        "left half",
        "half of its beams",
        "negative",
        "no beams",
        "third of its beams",
        "angle step",
        "2 s old",
        "from the future",
        "jumps forwards",
        "jumps backwards",
        "dust",
        "odometry is not finite",
        "odometry jumps",
        "odometry repeats",
        "wrong sign",
        "odometry is 1 s old",
        "positioning repeats",
        "no fixes",
        "carried away",
        "belts spin",
        "another mine",
        "1 m ahead",
        "1.9 m ahead",
        "beside the robot",
        "all sides",
        "door closes",
        "trap",
        "nearer to a wall",
        "decisions take",
        "never ends",
        "not finite",
        "1000 m/s",
        "at walls",
        "at a person",
        "10 s old",
        "no fallback",
        "GPU is lost",
        "in time",
        "wrongly",
        "latency",
        "brakes",
        "slip",
        "does not move",
    ] {
        assert!(names.iter().any(|name| name.contains(word)), "{word}");
    }
}

#[test]
fn robot_stands_after_a_loss_of_the_engine_and_drives_on_with_a_fallback() {
    let names = ["engine gives no answer and has no fallback", "GPU answers wrongly"];
    let rows = simulated_faults(&names, &[1], || {}).expect("a path");
    assert_eq!(rows.len(), names.len());
    for row in rows {
        assert!(row.passed, "{row:?}");
    }
}

#[test]
fn planner_that_drives_at_walls_hits_one_without_the_protective_layer() {
    let planner = WrongPlanner::Obstacles;
    let fault = FaultInjection::WrongPlanner { from_s: FROM_S, to_s: TO_S, planner };
    assert!(drive(&without_layer(), fault, 40.0).collided);
    assert!(!drive(&Config::default(), fault, 40.0).collided);
}

#[test]
fn robot_drives_on_old_scans_where_no_scan_is_too_old() {
    let change = LidarChange::Late(2.0);
    let fault = FaultInjection::Lidar { from_s: FROM_S, to_s: TO_S, change };
    let mut patient = without_layer();
    patient.navigator.scan_timeout_s = 10.0;
    let speed_at_end = |config: &Config| {
        let result = drive(config, fault, FROM_S + 2.5);
        result.trace.rows.last().map_or(0.0, |row| row.twist.linear)
    };
    assert!(speed_at_end(&patient) > 0.3);
    assert!(speed_at_end(&Config::default()) < 0.02);
}
