//! Estimates the pose on a map by wheel odometry and lidar scans: `cargo run --release --features sim --example localize`
//!
//! The odometry and the scans are those of a simulated drive; a real robot gives the same values.

#![expect(clippy::print_stdout, reason = "an example prints its result")]

use std::error::Error;
use std::sync::Arc;

use inbye::local::CpuEngine;
use inbye::localization::{LocalizationSettings, Localizer};
use inbye::map::{TimedScan, UnknownPolicy};
use inbye::navigator::Goal;
use inbye::runtime::{Config, Mission, Observer, TickEvent};
use inbye::sim::{Simulation, roadway};

fn main() -> Result<(), Box<dyn Error>> {
    let (scene, mut config) = (roadway(), Config::default());
    // The tracks slip: the odometry counts 5 % too much.
    config.simulation.dynamics.slip.mean = 0.05;
    let obstacles = scene.map.obstacles(UnknownPolicy::Blocked);
    let mut localizer = Localizer::new(&obstacles, LocalizationSettings::default(), &scene.start)?;
    // For a robot that does not know its place: `Localizer::without_pose`.
    let mut largest_errors_m = [0.0_f64; 2];
    let mut on_tick = |event: &TickEvent<'_>| {
        let (odometry, time_s) = (&event.odometry.pose, event.observation.scan_s);
        localizer.predict(time_s, odometry);
        // A scan whose beams have times of their own: a `TimedScan` of `Beam`s.
        let estimate =
            localizer.update(&TimedScan::from_scan(&event.observation.scan, time_s, 0.0));
        if let Some(reason) = estimate.status.lost_reason() {
            println!("{time_s:.1} s: lost: {reason:?}");
        }
        let truth = event.row.pose.position();
        for (largest_m, pose) in largest_errors_m.iter_mut().zip([&estimate.pose, odometry]) {
            *largest_m = largest_m.max((pose.position() - truth).norm());
        }
    };
    let mission = Mission::new(Arc::new(scene.map), scene.start, Goal::at(scene.goal));
    let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut on_tick };
    let engine = Box::new(CpuEngine::single_threaded());
    let result = Simulation::new(mission).run(&config, engine, &mut observer)?;
    let [of_scans_m, of_odometry_m] = largest_errors_m;
    println!(
        "{:.1} m: largest error {of_scans_m:.3} m with scans, {of_odometry_m:.3} m by odometry alone",
        result.travelled_m
    );
    Ok(())
}
