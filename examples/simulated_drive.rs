//! Simulates a drive among pedestrians in a built-in scene: `cargo run --release --example simulated_drive`

#![expect(clippy::print_stdout, reason = "an example prints its result")]

use std::sync::Arc;

use inbye::local::CpuEngine;
use inbye::navigator::Goal;
use inbye::runtime::{Config, Mission, Observer};
use inbye::sim::{PedestrianSpawner, Simulation, crossing};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (scene, config) = (crossing(), Config::default());
    let mission = Mission::new(Arc::new(scene.map), scene.start, Goal::at(scene.goal));
    let simulation = Simulation {
        moving_obstacles: PedestrianSpawner::new(3, 7).spawn_on_route(&mission, &config)?,
        seed: 7,
        ..Simulation::new(mission)
    };
    let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
    let result = simulation.run(&config, Box::new(CpuEngine::single_threaded()), &mut observer)?;
    println!(
        "reached: {}, {:.1} m in {:.1} s, trace {}",
        result.reached,
        result.travelled_m,
        result.time_s,
        result.trace.digest()
    );
    Ok(())
}
