//! A global path on a built-in scene, stage by stage.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use inbye::global::{Ground, Heuristic, Searcher, Settings, plan};
use inbye::map::{FreeSpace, UnknownPolicy};
use inbye::sim::scenes;

/// The robot's circle with its margin, and that with the comfortable distance.
const RADII_M: (f64, f64) = (0.5, 0.75);

fn scene_plan(criterion: &mut Criterion) {
    let scene = &scenes()[0];
    let obstacles = scene.map.obstacles(UnknownPolicy::Blocked);
    criterion.bench_function("free space of 600 x 400", |bencher| {
        bencher.iter(|| black_box(FreeSpace::new(&obstacles, RADII_M.0)));
    });
    let proof = FreeSpace::new(&obstacles, RADII_M.0);
    let search = FreeSpace::new(&obstacles, RADII_M.1);
    let ground = Ground {
        search: &search,
        proof: &proof,
        costs: None,
    };
    let start = scene.start.position();
    let modes = [
        ("octile", Heuristic::Octile),
        ("normalized 0.1", Heuristic::default()),
        ("manhattan", Heuristic::Manhattan),
        ("euclid", Heuristic::Euclid),
    ];
    for (name, heuristic) in modes {
        let settings = Settings {
            heuristic,
            ..Settings::default()
        };
        criterion.bench_function(&format!("plan 25 m, {name}"), |bencher| {
            bencher.iter(|| {
                let found = plan(
                    &mut Searcher::default(),
                    &ground,
                    start,
                    scene.goal,
                    &settings,
                    &mut || 0.0,
                );
                black_box(found.expect("the scene has a path"))
            });
        });
    }
}

criterion_group!(benches, scene_plan);
criterion_main!(benches);
