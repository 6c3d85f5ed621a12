//! A control loop of one's own: it measures, asks the navigator, and sends the command. The robot is simulated; a real one gives the
//! same values.

#![expect(clippy::print_stdout, reason = "an example prints its result")]

use std::error::Error;
use std::sync::Arc;

use inbye::local::CpuEngine;
use inbye::map::{ScanChange, UnknownPolicy};
use inbye::navigator::{Goal, Mode, Observation, Waypoints};
use inbye::runtime::{Config, LidarData, Mission, Robot};
use inbye::sim::{Simulation, dead_end};

fn main() -> Result<(), Box<dyn Error>> {
    let scene = dead_end();
    let config = Config::default();
    let period_s = config.local.control_period_s;
    let goal = Goal::at(scene.goal);
    let waypoints = Waypoints { start: scene.start.position(), goals: vec![goal] };
    // A map of your own is an `ObstacleGrid`, or a `NavigationMap` with zones.
    let obstacles = scene.map.obstacles(UnknownPolicy::Blocked);
    let engine = Box::new(CpuEngine::single_threaded());
    let mut navigator = config.new_navigator(obstacles, &waypoints, engine, &mut || 0.0)?;

    let mission = Mission::new(Arc::new(scene.map), scene.start, goal);
    let mut robot = Simulation::new(mission).robot(&config)?;
    // It notices a lidar that sends the same ranges again and again.
    let mut scan_change = ScanChange::default();
    for tick in 0..3000 {
        let time_s = f64::from(tick) * period_s;
        let sensed = robot.sense(time_s);
        // The ranges of another lidar: `Scan::from_measurements`, with `Scan::from_mount` for one that is not at the robot's origin.
        let (Some(pose), Some(LidarData::Scan(scan))) = (sensed.pose, sensed.lidar) else {
            return Err("the simulated robot has a pose and a lidar".into());
        };
        let decision = navigator.step(&Observation {
            time_s,
            pose,
            pose_s: sensed.pose_s.unwrap_or(sensed.odometry_s),
            lost: None,
            twist: sensed.odometry.twist,
            odometry_s: sensed.odometry_s,
            scan_changed_s: scan_change.update(sensed.odometry_s, scan.ranges.iter().copied()),
            scan,
            scan_s: sensed.odometry_s,
            sent: sensed.sent,
        });
        match decision.mode {
            Mode::Arrived => {
                println!("arrived after {time_s:.1} s");
                return Ok(());
            }
            Mode::Failed => {
                let fault = navigator.fault().map(ToString::to_string);
                return Err(fault.unwrap_or_default().into());
            }
            // The robot brakes; the reason is for the operator.
            Mode::SensorFault => println!("{time_s:.1} s: {:?}", navigator.observation_fault()),
            _ => {}
        }
        let _ = robot.drive(&decision.command, period_s);
    }
    Err("the time is up".into())
}
