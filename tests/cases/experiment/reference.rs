//! The ideal time of a run is that of the world's own robot, for every planner.

use std::sync::Arc;

use crate::support::room;
use inbye::experiment::{Grid, RunRow, Setup, World, open_engine, rankings, run_cell};
use inbye::geometry::{Point, Pose};
use inbye::local::SharedEngines;
use inbye::map::OccupancyGrid;
use inbye::navigator::Goal;
use inbye::robot::Footprint;
use inbye::runtime::Config;

/// The rows of planners in a room of 12 by 6 m. A wall with a gap of 0.5 m stands across it, where it is asked for.
fn rows(planners: &[(&str, &str)], has_wall: bool) -> Vec<RunRow> {
    let walls = [(30..31, 0..13), (30..31, 16..30)];
    let rows = room::rows(60, 30, if has_wall { &walls } else { &[] });
    let map = OccupancyGrid::from_rows(&rows, 0.2, Pose::default()).expect("a map");
    let (start, goal) = (Pose::new(1.5, 3.0, 0.0), Goal::at(Point::new(10.0, 3.0)));
    let worlds = [World::on_map("room", Arc::new(map), None, start, goal, 0, Some(120.0))];
    let setup = |(name, changes): &(&str, &str)| {
        Setup::named(name, Config::default().with_changes(changes).expect("valid settings"))
    };
    let setups: Vec<Setup> = planners.iter().map(setup).collect();
    let grid = Grid::of_worlds("planners", &worlds, &setups, &[0]).expect("a grid");
    let run = |cell| {
        let engine = open_engine(cell, &SharedEngines::default()).expect("the CPU");
        run_cell(cell, engine, &mut || 0.0, "machine").expect("a run").row
    };
    grid.distinct().into_iter().map(run).collect()
}

#[test]
fn slow_robot_is_measured_against_the_time_of_the_robot_of_the_world() {
    let rows = rows(
        &[
            ("normal", ""),
            ("slow", "robot.limits.max_vel_x = 0.25"),
            // It takes the same path, but not because nothing of the plan changes.
            ("patient", "navigator.movement_time_allowance = 31"),
        ],
        false,
    );
    let [normal, slow, patient] = &rows[..] else { panic!("{rows:?}") };
    assert!(rows.iter().all(RunRow::reached), "{rows:?}");
    assert!(normal.ideal_time_s.is_some_and(|ideal_s| (8.0..9.0).contains(&ideal_s)));
    assert_eq!(slow.ideal_time_s, normal.ideal_time_s);
    assert_eq!(patient.ideal_time_s, normal.ideal_time_s);
    assert_eq!(patient.time_weighted_success, normal.time_weighted_success);
    assert!(slow.time_s > 2.0 * normal.time_s, "{slow:?}");
    let success = |row: &RunRow| row.time_weighted_success.expect("a figure");
    assert!(success(slow) < 0.5 * success(normal), "{slow:?}");
    let ranked = rankings(&rows);
    assert_eq!(ranked.last().map(|last| last.planner.as_str()), Some("slow"), "{ranked:?}");
}

#[test]
fn robot_that_fits_where_that_of_the_world_has_no_path_has_the_straight_line_as_its_reference() {
    let footprint = Footprint::round(0.15).expect("a radius");
    let footprint = toml::Value::try_from(footprint).expect("a value");
    let changes = format!("robot.footprint = {footprint}\nrobot.track_width_m = 0.2");
    let rows = rows(&[("normal", ""), ("slim", &changes)], true);
    let [normal, slim] = &rows[..] else { panic!("{rows:?}") };
    assert_eq!((normal.reached(), normal.ideal_time_s), (false, None));
    assert!(slim.reached(), "{slim:?}");
    let limits = &Config::default().robot.limits;
    assert_eq!(slim.ideal_time_s, Some(8.5 / limits.max_vel_x));
}
