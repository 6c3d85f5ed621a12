//! Prints the golden digest of each engine variant of this processor, and the digest of a drive on one thread. `inbye` prints the
//! same with `verify --json` and `drive --scene dead_end --json`, and takes three times as long to compile: `tests/aarch64`.

#![expect(clippy::print_stdout, reason = "a program that prints its result")]

use std::error::Error;
use std::sync::Arc;

use inbye::bench::verify_golden;
use inbye::local::{AdapterSelection, CpuEngine, CpuEngines, open_engines};
use inbye::navigator::Goal;
use inbye::runtime::{Config, Mission, Observer};
use inbye::sim::{PedestrianSpawner, Simulation, dead_end};

fn main() -> Result<(), Box<dyn Error>> {
    let mut engines = open_engines(CpuEngines::InstructionSets, AdapterSelection::All, 1, |_| {})?;
    let digests = verify_golden(&mut engines)?.digests;
    for (engine, digest) in engines.iter().zip(digests) {
        println!("{digest}  {}", engine.name());
    }
    let (scene, config) = (dead_end(), Config::default());
    let mission = Mission::new(Arc::new(scene.map), scene.start, Goal::at(scene.goal));
    let spawner = PedestrianSpawner::new(scene.obstacles, scene.seed);
    let simulation = Simulation {
        moving_obstacles: spawner.spawn_on_route(&mission, &config)?,
        seed: scene.seed,
        ..Simulation::new(mission)
    };
    let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
    let engine = CpuEngine::single_threaded();
    let result = simulation.run(&config, Box::new(engine), &mut observer)?;
    println!("{}  drive", result.trace.digest());
    Ok(())
}
