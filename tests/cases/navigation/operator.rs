//! A mission whose robot stands until an operator arms it.

use core::ops::ControlFlow;
use std::sync::Arc;

use inbye::base::ProtectiveAction;
use inbye::geometry::{Point, Pose, Twist};
use inbye::local::CpuEngine;
use inbye::map::{GridFrame, OccupancyGrid};
use inbye::navigator::{Goal, Mode};
use inbye::runtime::{
    Config, GroundTruth, Mission, Observer, Robot, SensorData, TraceRow, run_mission,
};
use inbye::sim::Simulation;

/// Longer than the navigator's patience with a robot that makes no progress.
const ARMED_S: f64 = 100.0;

/// A robot that stands until it is armed, and stands again in a time after that.
struct Operated<R> {
    robot: R,
    stopped_s: core::ops::Range<f64>,
    time_s: f64,
}

impl<R> Operated<R> {
    fn may_drive(&self) -> bool {
        self.time_s >= ARMED_S && !self.stopped_s.contains(&self.time_s)
    }
}

impl<R: Robot> Robot for Operated<R> {
    fn sense(&mut self, time_s: f64) -> SensorData {
        let sensed = self.robot.sense(time_s);
        self.time_s = time_s;
        sensed
    }

    fn ground_truth(&self) -> Option<GroundTruth> {
        self.robot.ground_truth()
    }

    fn drive(&mut self, command: &Twist, period_s: f64) -> ControlFlow<()> {
        let command = if self.may_drive() { *command } else { Twist::STOP };
        self.robot.drive(&command, period_s)
    }

    fn protective_action(&self) -> ProtectiveAction {
        match self.may_drive() {
            true => self.robot.protective_action(),
            false if self.time_s < ARMED_S => ProtectiveAction::NotArmed,
            false => ProtectiveAction::OperatorStop,
        }
    }
}

#[test]
fn robot_that_waits_for_its_operator_is_not_stuck() {
    let frame = GridFrame::new(240, 120, 0.05, Pose::default()).expect("a valid size");
    let map = OccupancyGrid::filled(frame, 0);
    let (start, goal) = (Pose::new(2.0, 3.0, 0.0), Goal::at(Point::new(10.0, 3.0)));
    let mission = Mission { time_limit_s: 60.0, ..Mission::new(Arc::new(map), start, goal) };
    // The robot waits for three times the time limit, which is for driving.
    let config = Config::default();
    let robot = Simulation::new(mission.clone()).robot(&config).expect("valid settings");
    let stopped_s = ARMED_S + 3.0..2.0 * ARMED_S;
    let mut robot = Operated { robot, stopped_s: stopped_s.clone(), time_s: 0.0 };
    let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
    let engine = Box::new(CpuEngine::single_threaded());
    let result = run_mission(&mission, &config, engine, &mut robot, &mut observer)
        .expect("a mission that can start");
    assert!(result.reached, "{:?}", result.fault);
    let rows = &result.trace.rows;
    let escapes = |row: &&TraceRow| row.mode == Mode::Escaping;
    assert_eq!(rows.iter().filter(escapes).count(), 0);
    assert_eq!(rows.last().map(|row| row.path), Some(0), "it keeps its first path");
    for armed_s in [ARMED_S, stopped_s.end] {
        let mut later = rows.iter().skip_while(|row| row.time_s <= armed_s + 0.1);
        let first = later.find(|row| row.twist.linear.abs() > 0.01).expect("a motion");
        assert!(first.twist.linear > 0.0 && first.time_s < armed_s + 1.0, "{first:?}");
    }
}
