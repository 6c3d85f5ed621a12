//! Missions with a lidar that sees nothing, or not all: the robot touches nothing, and the fault has a name.

use core::f64::consts::PI;
use std::sync::Arc;

use inbye::experiment::missions::{MissionSite, Rules};
use inbye::geometry::{Point, Pose};
use inbye::local::CpuEngine;
use inbye::map::OccupancyGrid;
use inbye::navigator::{Fault, Goal, Mode, ObservationFault};
use inbye::runtime::{Config, Mission, MissionResult, Observer};
use inbye::sim::{FaultInjection, Simulation, crossing, roadway};

const FROM_S: f64 = 6.0;
const TO_S: f64 = f64::INFINITY;

/// Twelve missions of two maps with one or two obstacles on the path that the map does not show, and a fault of the lidar. They
/// last for this time at most, seconds.
fn missions(faults: &[FaultInjection], most_s: f64) -> Vec<MissionResult> {
    let config = Config::default();
    let rules = Rules { unmapped_share: 1.0, max_people: 0, longest_m: 30.0, ..Rules::default() };
    let maps = [("crossing", crossing().map), ("roadway", roadway().map)];
    let mut results = Vec::new();
    for (name, map) in maps {
        let site = MissionSite::new(name, map, &config);
        for seed in 1..=6 {
            let mut simulation =
                site.generate(seed, &rules, &config).expect("there is room").simulation;
            simulation.faults = faults.to_vec();
            simulation.mission.time_limit_s = most_s;
            let engine = Box::new(CpuEngine::single_threaded());
            let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
            let result = simulation.run(&config, engine, &mut observer);
            let result = result.expect("a path");
            assert!(!result.collided, "{name} {seed}: contact");
            results.push(result);
        }
    }
    results
}

fn failed_by(result: &MissionResult, expected: ObservationFault) -> bool {
    matches!(result.fault, Some(Fault::FaultyObservation { fault, .. }) if fault == expected)
}

/// The time from the begin of a fault to the first tick on which the robot brakes for it, seconds.
fn brakes_after_s(result: &MissionResult) -> Option<f64> {
    let rows = &result.trace.rows;
    let first = rows.iter().find(|row| row.time_s >= FROM_S && row.mode == Mode::SensorFault)?;
    Some(first.time_s - FROM_S)
}

#[test]
fn missions_with_a_blind_lidar_end_without_contact_and_with_a_reason() {
    for result in missions(&[FaultInjection::LidarOccluded { from_s: 0.0, to_s: TO_S }], 60.0) {
        assert!(failed_by(&result, ObservationFault::LidarBlind), "{:?}", result.fault);
        assert!(result.travelled_m < 0.1, "{}", result.travelled_m);
    }
}

#[test]
fn lidar_that_goes_blind_stops_the_robot_within_a_third_of_a_second() {
    let results = missions(&[FaultInjection::LidarOccluded { from_s: FROM_S, to_s: TO_S }], 60.0);
    for result in results.iter().filter(|result| !result.reached) {
        assert!(failed_by(result, ObservationFault::LidarBlind), "{:?}", result.fault);
        let after_s = brakes_after_s(result).expect("the robot brakes");
        assert!(after_s < 0.31, "{after_s}");
    }
    assert!(results.iter().filter(|result| !result.reached).count() > 8);
}

#[test]
fn lidar_that_sees_nothing_ahead_stops_the_robot() {
    let ahead = FaultInjection::LidarSectorOccluded {
        from_s: FROM_S,
        to_s: TO_S,
        from_rad: -0.6,
        width_rad: 1.2,
    };
    for result in missions(&[ahead], 60.0).iter().filter(|result| !result.reached) {
        let counts = &result.observation_faults;
        assert!(counts.contains_key(&ObservationFault::LidarPartlyBlind), "{counts:?}");
    }
}

#[test]
fn robot_keeps_out_of_a_blind_sector_aside_and_behind() {
    for (from_rad, width_rad) in [(0.7, 1.4), (0.75 * PI, 0.5 * PI)] {
        let aside =
            FaultInjection::LidarSectorOccluded { from_s: 3.0, to_s: TO_S, from_rad, width_rad };
        let results = missions(&[aside], 30.0);
        let is_named = |result: &&MissionResult| {
            result.observation_faults.contains_key(&ObservationFault::LidarPartlyBlind)
        };
        assert!(results.iter().filter(is_named).count() >= 8);
    }
}

/// A box stands ahead in a hall whose walls are out of range. The lidar sees it for a while.
#[test]
fn obstacle_that_a_cover_hides_in_a_hall_is_not_forgotten() {
    let config = Config::default();
    let mut rows = vec![format!("#{}#", ".".repeat(198)); 150];
    (rows[0], rows[149]) = ("#".repeat(200), "#".repeat(200));
    let map = Arc::new(OccupancyGrid::from_rows(&rows, 0.2, Pose::default()).expect("a map"));
    let mut truth = map.obstacles(config.unknown);
    let place = truth.frame().cell_of(&Point::new(20.0, 15.0)).expect("a place in the map");
    truth.set(place, true);
    let goal = Goal::at(Point::new(25.0, 15.0));
    let mission = Mission::new(map, Pose::new(14.0, 15.0, 0.0), goal);
    for (from_s, width_rad) in [(3.0, 0.5), (3.0, 1.5), (4.5, 4.0)] {
        let from_rad = -0.5 * width_rad;
        let sector =
            FaultInjection::LidarSectorOccluded { from_s, to_s: TO_S, from_rad, width_rad };
        let mut simulation = Simulation::new(mission.clone());
        (simulation.truth, simulation.faults) = (Some(truth.clone()), vec![sector]);
        simulation.mission.time_limit_s = 40.0;
        let engine = Box::new(CpuEngine::single_threaded());
        let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
        let result = simulation.run(&config, engine, &mut observer).expect("a path");
        assert!(!result.collided, "{width_rad} rad from {from_s} s on");
    }
}

#[test]
fn frozen_lidar_stops_the_robot() {
    let results = missions(&[FaultInjection::LidarFrozen { from_s: FROM_S, to_s: TO_S }], 60.0);
    for result in results.iter().filter(|result| !result.reached) {
        assert!(failed_by(result, ObservationFault::FrozenScan), "{:?}", result.fault);
    }
    assert!(results.iter().filter(|result| !result.reached).count() > 8);
}

#[test]
fn sound_lidar_has_no_fault_in_the_same_missions() {
    for result in missions(&[], 90.0) {
        assert!(result.reached, "{:?}", result.fault);
        assert!(result.observation_faults.is_empty(), "{:?}", result.observation_faults);
    }
}
