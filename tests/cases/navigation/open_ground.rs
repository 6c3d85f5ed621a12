//! Drives in an empty hall: to goals beside the way, and from a wall.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use inbye::geometry::{Point, Pose};
use inbye::local::CpuEngine;
use inbye::map::{Cell, GridFrame, OccupancyGrid};
use inbye::navigator::{Goal, Mode};
use inbye::runtime::{Config, Mission, MissionResult, Observer, TickEvent};
use inbye::sim::Simulation;

/// A hall of 12 by 9 m in cells of 0.1 m, with walls of one cell.
fn hall() -> OccupancyGrid {
    let frame = GridFrame::new(120, 90, 0.1, Pose::default()).expect("a valid size");
    let is_wall = |cell: Cell| [0, 119].contains(&cell.column) || [0, 89].contains(&cell.row);
    let cells = (0..90).flat_map(|row| (0..120).map(move |column| Cell::new(column, row)));
    OccupancyGrid::new(frame, cells.map(|cell| if is_wall(cell) { 100 } else { 0 }).collect())
}

/// Drives from a pose to a place. Returns the result, and the time for which the robot rotated after the first metre, seconds.
fn drive(start: Pose, goal: Point) -> (MissionResult, f64) {
    let simulation = Simulation::new(Mission::new(Arc::new(hall()), start, Goal::at(goal)));
    let mut rotated_s = 0.0;
    let mut on_tick = |event: &TickEvent<'_>| {
        let away_m = (event.row.pose.position() - start.position()).norm();
        if event.row.mode == Mode::Rotating && away_m > 1.0 {
            rotated_s += 0.1;
        }
    };
    let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut on_tick };
    let engine = Box::new(CpuEngine::single_threaded());
    let result = simulation.run(&Config::default(), engine, &mut observer).expect("a drive");
    (result, rotated_s)
}

/// It comes at full speed, with more room on the other side: it must turn in before it has passed the goal.
#[test]
fn robot_drives_to_a_goal_beside_its_way_and_not_past_it() {
    for yaw in [0.0, 0.3, -0.3, 0.6] {
        for y in [1.2, 2.5, 4.5, 6.8] {
            let goal = Point::new(8.0, y);
            let (result, rotated_s) = drive(Pose::new(2.0, 4.0, yaw), goal);
            assert!(result.reached, "{yaw} {y}: {:?}", result.why());
            assert!(rotated_s < 0.3, "{yaw} {y}: it rotated for {rotated_s} s");
        }
    }
}

/// Its side is 5 cm from the wall, within all margins, and a turn would lead a corner into it.
#[test]
fn robot_that_stands_along_a_wall_leaves_it() {
    for (x, y, yaw) in [(2.0, 0.4, 0.0), (6.0, 0.4, PI), (11.6, 5.0, FRAC_PI_2)] {
        let start = Pose::new(x, y, yaw);
        let (result, _) = drive(start, Point::new(6.0, 6.0));
        assert!(result.reached, "{start:?}: {:?}", result.why());
        assert!(result.time_s < 90.0, "{start:?}: {} s", result.time_s);
        assert!(result.min_clearance_m > 0.03, "{start:?}: {} m", result.min_clearance_m);
    }
}
