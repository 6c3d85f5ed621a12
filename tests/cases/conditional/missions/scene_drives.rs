//! The built-in scenes with their pedestrians.

use inbye::local::CpuEngine;
use inbye::map::UnknownPolicy;
use inbye::runtime::Config;
use inbye::sim::{PedestrianSpawner, Scene, Simulation, crossing, dead_end, roadway};

use super::Test;
use super::driving::{arrive, try_drive};

pub const TESTS: &[Test] = &[
    ("robot drives the roadway scene among pedestrians", || {
        drives(&roadway());
    }),
    ("robot drives the crossing scene among pedestrians", || {
        drives(&crossing());
    }),
    ("robot drives the dead end scene among pedestrians", || {
        drives(&dead_end());
    }),
    ("trace of a scene depends on its seed alone", depends_on_its_seed_alone),
];

/// A mission in a scene, with this offset to the seed of pedestrians and noise.
fn task(scene: &Scene, offset: u64) -> Simulation {
    let config = Config::default();
    let obstacles = scene.map.obstacles(UnknownPolicy::Blocked);
    let mut planner = config.route_planner(scene.map.frame().resolution_m);
    let start = scene.start.position();
    let plan = planner.plan(&obstacles, start, scene.goal, &mut || 0.0);
    let path = plan.expect("a scene has a path").smoothed;
    let seed = scene.seed + offset;
    let spawner = PedestrianSpawner::new(scene.obstacles, seed);
    let ends = [start, scene.goal];
    Simulation {
        moving_obstacles: spawner
            .spawn(&obstacles, path.points(), &ends, 0.5)
            .expect("free space for pedestrians"),
        seed,
        ..Simulation::new(scene.mission(600.0))
    }
}

fn drives(scene: &Scene) {
    for other in 0..5 {
        let result = arrive(&task(scene, other));
        let direct_m = (scene.goal - scene.start.position()).norm();
        assert!(result.travelled_m > direct_m - 0.5, "{}: the path cannot be so short", scene.name);
    }
}

fn depends_on_its_seed_alone() {
    let digest = |other| {
        let engine = Box::new(CpuEngine::single_threaded());
        let result = try_drive(&task(&dead_end(), other), &Config::default(), engine);
        result.expect("a scene can be driven").trace.digest()
    };
    assert_eq!(digest(0), digest(0));
    assert_ne!(digest(0), digest(1));
}
