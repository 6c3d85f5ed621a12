//! A robot that does not know where it starts.

use core::ops::ControlFlow;
use std::sync::Arc;

use inbye::geometry::{Point, Pose, Twist};
use inbye::local::CpuEngine;
use inbye::map::{Cell, GridFrame, OccupancyGrid};
use inbye::navigator::Goal;
use inbye::runtime::{
    Config, Mission, MissionEnd, Observer, PoseSource, Robot, SensorData, run_mission,
};
use inbye::sim::SimBase;

/// A base whose true pose nothing knows, without a lidar.
struct Base(SimBase);

impl Robot for Base {
    fn sense(&mut self, time_s: f64) -> SensorData {
        self.0.sense(time_s)
    }

    fn drive(&mut self, command: &Twist, period_s: f64) -> ControlFlow<()> {
        self.0.drive(command, period_s)
    }
}

/// Its pose is a corner of the map until it is found, where a wall is.
#[test]
fn robot_that_is_not_located_touches_no_wall_of_the_map() {
    let mut config = Config::default();
    config.pose_source = PoseSource::Scans;
    let frame = GridFrame::new(100, 60, 0.1, Pose::default()).expect("a valid size");
    let map = OccupancyGrid::from_fn(
        frame,
        |Cell { column, row }| {
            if column.min(row) == 0 { 100 } else { 0 }
        },
    );
    let (start, goal) = (Pose::new(2.0, 3.0, 0.0), Goal::at(Point::new(8.0, 3.0)));
    let mission = Mission::new(Arc::new(map), start, goal);
    let mission = Mission { is_start_unknown: true, time_limit_s: 1.0, ..mission };
    let mut base = Base(SimBase::of(&config, start, 0).expect("valid settings"));
    let engine = Box::new(CpuEngine::single_threaded());
    let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
    let result = run_mission(&mission, &config, engine, &mut base, &mut observer).expect("a drive");
    assert_eq!(result.end(), MissionEnd::Timeout);
    assert!(result.trace.rows.len() >= 10, "{:?}", result.why());
    assert_eq!((result.min_clearance_m, result.travelled_m), (f64::INFINITY, 0.0));
}
