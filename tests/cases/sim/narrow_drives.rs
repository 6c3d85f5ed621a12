//! Drives through passages that only one heading of the body fits.

use std::f64::consts::PI;
use std::sync::Arc;

use inbye::geometry::{Point, Pose};
use inbye::local::CpuEngine;
use inbye::map::{GridFrame, OccupancyGrid};
use inbye::navigator::Goal;
use inbye::runtime::{Config, Mission, MissionResult, Observer};
use inbye::sim::Simulation;

fn map(is_blocked: impl Fn(f64, f64) -> bool) -> Arc<OccupancyGrid> {
    let frame = GridFrame::new(200, 120, 0.05, Pose::new(-5.0, -3.0, 0.0)).expect("a sound size");
    let cells = (0..frame.len()).map(|index| {
        let at = frame.center_of(frame.cell_at(index));
        let is_border = at.x.abs() > 4.9 || at.y.abs() > 2.9;
        if is_border || is_blocked(at.x, at.y) { 100 } else { 0 }
    });
    Arc::new(OccupancyGrid::new(frame, cells.collect()))
}

fn drive(map: Arc<OccupancyGrid>, start: Pose, goal: Point, seed: u64) -> MissionResult {
    let mission = Mission { time_limit_s: 120.0, ..Mission::new(map, start, Goal::at(goal)) };
    let simulation = Simulation { seed, ..Simulation::new(mission) };
    let engine = Box::new(CpuEngine::single_threaded());
    let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
    simulation.run(&Config::default(), engine, &mut observer).expect("a mission")
}

/// The default robot is 0.5 m wide and keeps 0.05 m on each side; its circle needs 1.05 m.
#[test]
fn robot_drives_through_doors_little_wider_than_its_body() {
    for (half_m, wall_m) in [(0.325, 0.1), (0.35, 0.5), (0.3, 0.1)] {
        for (seed, yaw) in [(1, 0.0), (2, 2.0)] {
            let map = map(|x, y| x.abs() < wall_m && (y - 0.5).abs() > half_m);
            let result = drive(map, Pose::new(-3.5, -1.0, yaw), Point::new(3.5, 1.0), seed);
            let case = format!("{half_m} {wall_m} {seed}: {:?} {} s", result.fault, result.time_s);
            assert!(result.reached && !result.collided, "{case}");
            assert!(result.plans.iter().any(|plan| !plan.narrow.is_empty()), "{case}");
        }
    }
}

#[test]
fn robot_backs_out_of_a_dead_end_too_narrow_to_turn_in() {
    let map = map(|x, y| {
        (-3.0..0.0).contains(&x) && (0.35..0.8).contains(&y.abs())
            || (-3.2..=-3.0).contains(&x) && y.abs() < 0.8
    });
    let result = drive(map, Pose::new(-2.4, 0.02, PI), Point::new(3.5, 1.5), 3);
    assert!(result.reached && !result.collided, "{:?} {} s", result.fault, result.time_s);
    let backs = result.trace.rows.iter().take_while(|row| row.pose.x < 0.0);
    assert!(backs.clone().any(|row| row.command.linear < -0.1), "it reverses");
}
