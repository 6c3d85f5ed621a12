//! Drives by scans through two roadways, of which a wall is gone, or the robot is carried.

use std::sync::Arc;

use inbye::geometry::{Point, Pose};
use inbye::local::CpuEngine;
use inbye::map::{Cell, GridFrame, OccupancyGrid, UnknownPolicy};
use inbye::navigator::Goal;
use inbye::runtime::{Config, Mission, Observer, PoseSource, TickEvent};
use inbye::sim::{FaultInjection, Simulation};

/// Free rectangles, cells of 0.1 m: first column, width, first row, height. Two roadways with a connection at each end, and niches.
const FREE: [[i32; 4]; 9] = [
    [10, 180, 20, 30],
    [10, 180, 80, 30],
    [10, 30, 50, 30],
    [170, 20, 50, 30],
    [70, 10, 10, 10],
    [120, 6, 13, 7],
    [170, 7, 12, 8],
    [90, 10, 110, 6],
    [150, 20, 110, 8],
];
/// The wall across the lower roadway, columns.
const WALL: core::ops::Range<i32> = 150..153;
const START: Pose = Pose { x: 4.0, y: 3.5, yaw: 0.0 };

fn roadways(has_wall: bool) -> OccupancyGrid {
    let frame = GridFrame::new(200, 120, 0.1, Pose::default()).expect("a valid size");
    let mut cells = vec![100; frame.len()];
    for [column, width, row, height] in FREE {
        for cell in (row..row + height)
            .flat_map(|row| (column..column + width).map(move |column| Cell::new(column, row)))
            .filter(|cell| !(has_wall && WALL.contains(&cell.column) && cell.row < 50))
        {
            cells[frame.index(cell)] = 0;
        }
    }
    OccupancyGrid::new(frame, cells)
}

/// Once scans have shown for a minute that a wall is gone, the robot plans and drives through its place.
#[test]
fn robot_drives_through_the_place_of_a_wall_that_is_gone() {
    let goal = |x: f64, y: f64| Goal::at(Point::new(x, y));
    // To and fro on one side for a minute, then three times to the other side.
    let near = [goal(12.0, 3.5), goal(5.0, 3.0), goal(12.0, 4.0), goal(5.0, 4.0), goal(12.0, 3.5)];
    let across = [goal(18.0, 3.5), goal(12.0, 3.0)];
    let mission = Mission {
        via: near.into_iter().chain(across).collect(),
        ..Mission::new(Arc::new(roadways(true)), START, goal(18.0, 3.5))
    };
    let truth = roadways(false).obstacles(UnknownPolicy::Blocked);
    let simulation = Simulation { truth: Some(truth), ..Simulation::new(mission) };
    let mut config = Config::default();
    config.pose_source = PoseSource::Scans;
    let (mut distances_m, mut last, mut x) = (vec![0.0], START.position(), Vec::new());
    let mut on_tick = |event: &TickEvent<'_>| {
        let at = event.row.pose.position();
        distances_m.resize(event.navigator.goals_passed() + 1, 0.0);
        *distances_m.last_mut().expect("a leg") += (at - last).norm();
        last = at;
        x.push(event.row.belief.x - event.row.pose.x);
    };
    let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut on_tick };
    let engine = Box::new(CpuEngine::single_threaded());
    let result = simulation.run(&config, engine, &mut observer).expect("a mission that can start");
    let faults = &result.observation_faults;
    assert!(result.reached && faults.is_empty(), "{:?} {faults:?}", result.why());
    // The way round is 32 m.
    assert!(distances_m.len() == 8 && distances_m[5..].iter().all(|m| *m < 9.0), "{distances_m:?}");
    assert!(x.iter().all(|error_m| error_m.abs() < 0.1), "{x:?}");
}

/// Before a carried robot knows that it is lost, its scans mark obstacles around the place where it seems to be: here its goal.
#[test]
fn robot_carried_away_from_its_goal_comes_back() {
    let goal = Goal::at(Point::new(17.5, 3.5));
    let mission = Mission::new(Arc::new(roadways(false)), START, goal);
    // It faces a wall at about the distance of the goal, next to a niche.
    let to = Pose::new(8.4, 9.4, core::f64::consts::FRAC_PI_2);
    let faults = vec![FaultInjection::Kidnapped { at_s: 13.2, to }];
    let simulation = Simulation { faults, ..Simulation::new(mission) };
    let mut config = Config::default();
    config.pose_source = PoseSource::Scans;
    let mut left_m = f64::INFINITY;
    let mut on_tick = |event: &TickEvent<'_>| {
        if event.row.time_s < 13.15 {
            left_m = (event.row.pose.position() - goal.position).norm();
        }
    };
    let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut on_tick };
    let engine = Box::new(CpuEngine::single_threaded());
    let result = simulation.run(&config, engine, &mut observer).expect("a mission that can start");
    assert!((1.0..2.5).contains(&left_m), "{left_m} m left when it is carried");
    assert!(result.reached, "{:?} after {:?}", result.why(), result.trace.rows.last());
}
