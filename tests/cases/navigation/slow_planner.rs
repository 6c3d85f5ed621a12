//! A search that takes seconds, on its real thread: the ticks of a robot in real time do not wait for it.

use core::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

use inbye::geometry::{Point, Pose, Twist};
use inbye::global::PlanError;
use inbye::local::CpuEngine;
use inbye::map::{Cell, GridFrame, ObstacleGrid, OccupancyGrid, UnknownPolicy};
use inbye::navigator::Goal;
use inbye::runtime::{Config, GroundTruth, Mission, Observer, Robot, SensorData, TickEvent};
use inbye::sim::{SimBase, Simulation};

const RESOLUTION_M: f64 = 0.05;
const COLUMNS: i32 = 1200;
const ROWS: i32 = 600;
/// Columns of the wall between the robot's hall and its goal, and rows of the door in it.
const WALL: core::ops::Range<i32> = 1120..1124;
const DOOR: core::ops::Range<i32> = 280..320;
/// Share of the search that no tick may take.
const SHARE: f64 = 0.25;

/// A hall of 56 by 30 m, and a room behind a door.
fn hall(is_open: bool) -> OccupancyGrid {
    let frame = GridFrame::new(COLUMNS, ROWS, RESOLUTION_M, Pose::default()).expect("a valid size");
    OccupancyGrid::from_fn(frame, |Cell { column, row }| {
        let is_border = column == 0 || row == 0 || column == COLUMNS - 1 || row == ROWS - 1;
        let is_wall = WALL.contains(&column) && !(is_open && DOOR.contains(&row));
        if is_border || is_wall { 100 } else { 0 }
    })
}

/// A simulated base that counts as a real one, with the time of its clock, seconds. Its ticks follow each other without a pause.
struct RealTimeBase(SimBase, f64);

impl Robot for RealTimeBase {
    fn sense(&mut self, time_s: f64) -> SensorData {
        self.0.sense(time_s)
    }

    fn ground_truth(&self) -> Option<GroundTruth> {
        self.0.ground_truth()
    }

    fn now_s(&self) -> Option<f64> {
        Some(self.1)
    }

    fn drive(&mut self, command: &Twist, period_s: f64) -> ControlFlow<()> {
        self.1 += period_s;
        self.0.drive(command, period_s)
    }
}

const START: Pose = Pose { x: 51.0, y: 15.0, yaw: 0.0 };
const GOAL: Point = Point { x: 58.5, y: 15.0 };

/// Duration of the search for a way around the closed door, seconds. There is none, so that it visits the whole hall.
fn search_s(config: &Config, closed: &ObstacleGrid) -> f64 {
    let mut planner = config.route_planner(RESOLUTION_M);
    let began = Instant::now();
    let found = planner.plan(closed, START.position(), GOAL, &mut || 0.0);
    assert!(matches!(found, Err(PlanError::NoValidPath { .. })), "{found:?}");
    began.elapsed().as_secs_f64()
}

/// Drives at a door that is closed and that the map shows open. Returns the longest tick, seconds.
fn longest_tick_s(config: &Config, closed: &ObstacleGrid, is_real_time: bool) -> f64 {
    let goal = Goal { position: GOAL, yaw: None };
    let mission = Mission { time_limit_s: 3.0, ..Mission::new(Arc::new(hall(true)), START, goal) };
    let simulation = Simulation { truth: Some(closed.clone()), ..Simulation::new(mission) };
    let (mut before, mut longest_s): (Option<Instant>, f64) = (None, 0.0);
    let mut on_tick = |_: &TickEvent<'_>| {
        let now = Instant::now();
        let began = before.replace(now).unwrap_or(now);
        longest_s = longest_s.max((now - began).as_secs_f64());
    };
    // By a scripted clock: whether a tick waits must not depend on a deadline.
    let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut on_tick };
    let engine = Box::new(CpuEngine::single_threaded());
    let base = SimBase::of(config, START, 0).expect("valid settings");
    let result = if is_real_time {
        simulation.run_with(&mut RealTimeBase(base, 0.0), config, engine, &mut observer)
    } else {
        let mut base = base;
        simulation.run_with(&mut base, config, engine, &mut observer)
    };
    assert!(!result.expect("a mission that can start").collided);
    longest_s
}

#[test]
fn search_of_seconds_does_not_delay_a_tick_of_a_real_time_robot() {
    let config = Config::default();
    let closed = hall(false).obstacles(UnknownPolicy::Blocked);
    let search_s = search_s(&config, &closed);
    let simulated_s = longest_tick_s(&config, &closed, false);
    assert!(simulated_s > SHARE * search_s, "it waits: {simulated_s} of {search_s} s");
    let real_s = longest_tick_s(&config, &closed, true);
    assert!(real_s < SHARE * search_s, "{real_s} of {search_s} s");
}
