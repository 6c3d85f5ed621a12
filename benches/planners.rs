//! Timings of global planning by stage, and of localisation updates, on a built-in scene.

use std::hint::black_box;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use inbye::geometry::Pose;
use inbye::global::{Heuristic, PlanningSpace, Searcher, Settings, plan};
use inbye::localization::{LocalizationSettings, Localizer};
use inbye::map::{FreeSpace, UnknownPolicy};
use inbye::sim::{Lidar, World, roadway, scenes};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

/// The robot's radius with its margin, and with the preferred clearance.
const RADII_M: (f64, f64) = (0.5, 0.75);

fn scene_plan(criterion: &mut Criterion) {
    let scene = &scenes()[0];
    let obstacles = scene.map.obstacles(UnknownPolicy::Blocked);
    criterion.bench_function("free space of 600 x 400", |bencher| {
        bencher.iter(|| black_box(FreeSpace::new(&obstacles, RADII_M.0)));
    });
    let proof = FreeSpace::new(&obstacles, RADII_M.0);
    let search = FreeSpace::new(&obstacles, RADII_M.1);
    let ground = PlanningSpace { search: &search, smoothing: &proof, costs: None };
    let start = scene.start.position();
    let modes = [
        ("octile", Heuristic::Octile),
        ("normalized 0.1", Heuristic::default()),
        ("manhattan", Heuristic::Manhattan),
        ("euclid", Heuristic::Euclid),
    ];
    for (name, heuristic) in modes {
        let settings = Settings::default().heuristic(heuristic);
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

/// Updates with a revolution of 450 beams on the roadway scene: while tracking, and while lost.
fn scene_revolution(criterion: &mut Criterion) {
    let scene = roadway();
    let obstacles = scene.map.obstacles(UnknownPolicy::Blocked);
    let world = World::new(obstacles.clone());
    let lidar = Lidar::default().beams(450).range_max_m(12.0);
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let sweep = lidar.sweep(&world, |_| scene.start, 0.0, &mut random);
    let settings = LocalizationSettings::default();
    let start = Pose::new(scene.start.x + 0.03, scene.start.y - 0.02, scene.start.yaw + 0.01);
    let localizer = Localizer::new(&obstacles, settings, &start).expect("valid settings");
    criterion.bench_function("localizer, new on a map of 600 x 400", |bencher| {
        bencher.iter(|| black_box(Localizer::new(&obstacles, settings, &start)));
    });
    criterion.bench_function("localizer, revolution of 450 beams", |bencher| {
        bencher.iter_batched_ref(
            || localizer.clone(),
            |localizer| black_box(localizer.update(&sweep).iterations),
            BatchSize::LargeInput,
        );
    });
    let elsewhere = Pose::new(15.5, 12.0, 1.6);
    let sweep = lidar.sweep(&world, |_| elsewhere, 0.0, &mut random);
    let mut lost = localizer;
    while lost.estimate().status.lost_reason().is_none() {
        lost.update(&sweep);
    }
    criterion.bench_function("localizer, relocalisation", |bencher| {
        bencher.iter_batched_ref(
            || lost.clone(),
            |localizer| black_box(localizer.update(&sweep).status),
            BatchSize::LargeInput,
        );
    });
}

criterion_group!(benches, scene_plan, scene_revolution);
criterion_main!(benches);
