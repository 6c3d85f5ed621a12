//! Times one decision on each engine at several sampling densities, batches, opening an engine, and the distance field.

use std::hint::black_box;
use std::sync::Arc;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use inbye::bench::{Roadway, grid_counts, roadway_field, roadway_obstacles, usual_shape};
use inbye::local::{
    AdapterSelection, ClearanceField, CpuEngine, CpuEngines, Detail, Engine, EngineChoice,
    Evaluation, QuantizedProblem, Sampler, open_engine, open_engines,
};
use inbye::map::{GridFrame, ObstacleGrid};

/// Steps of the horizon.
const STEPS: u32 = 30;

fn roadway(speeds: u32, turns: u32) -> Roadway {
    Roadway { vx_samples: speeds, vtheta_samples: turns, steps: STEPS, ..Roadway::default() }
}

/// The CPU on one and on all of these threads, and the adapters.
fn engines(threads: usize) -> Vec<Box<dyn Engine>> {
    let opened = open_engines(CpuEngines::OneAndAll, AdapterSelection::All, threads, |_| ());
    opened.expect("threads")
}

fn decide(engine: &mut dyn Engine, roadway: &Roadway, field: &Arc<ClearanceField>) -> Evaluation {
    let quantized = QuantizedProblem::new(&roadway.problem(field, 0)).expect("within the ranges");
    black_box(engine.evaluate(&quantized, Detail::Answer).expect("an answer"))
}

fn decisions(criterion: &mut Criterion) {
    let field = roadway_field();
    let mut engines = engines(2);
    for (speeds, turns) in [(20, 40), (70, 72), (128, 128)] {
        let roadway = roadway(speeds, turns);
        let mut group = criterion.benchmark_group(format!("decision of {speeds} x {turns}"));
        group.throughput(Throughput::Elements(u64::from(speeds * turns * STEPS)));
        group.sample_size(20);
        for engine in &mut engines {
            group.bench_function(BenchmarkId::from_parameter(engine.name()), |bencher| {
                bencher.iter(|| decide(&mut **engine, &roadway, &field));
            });
        }
        group.finish();
    }
}

/// The same number of samples of each sampler, within 2 s, on one thread.
fn samplers(criterion: &mut Criterion) {
    const SAMPLES: usize = 4096;
    let field = roadway_field();
    let mut engine = CpuEngine::single_threaded();
    let mut group = criterion.benchmark_group(format!("decision of {SAMPLES} samples"));
    for window_s in [0.1, 1.0] {
        for sampler in Sampler::ALL {
            let (vx_samples, vtheta_samples) = grid_counts(SAMPLES, usual_shape(sampler));
            let plain = Roadway { steps: 20, window_s, ..Roadway::default() };
            let roadway = Roadway { vx_samples, vtheta_samples, sampler, ..plain };
            let name = format!("{}, window {window_s} s", sampler.name());
            group.bench_function(BenchmarkId::from_parameter(name), |bencher| {
                bencher.iter(|| decide(&mut engine, &roadway, &field));
            });
        }
    }
    group.finish();
}

fn batches(criterion: &mut Criterion) {
    let (speeds, turns) = (20, 40);
    let field = roadway_field();
    let mut engines = engines(2);
    for count in [1, 8, 64, 256] {
        // All equal, so that only their number makes a difference.
        let problem = roadway(speeds, turns).problem(&field, 50);
        let problems = vec![QuantizedProblem::new(&problem).expect("within the ranges"); count];
        let name = format!("batch of {count}, {} x {STEPS} each", speeds * turns);
        let mut group = criterion.benchmark_group(name);
        let steps_each = u64::from(speeds * turns * STEPS);
        group.throughput(Throughput::Elements(count as u64 * steps_each));
        group.sample_size(10);
        for engine in &mut engines {
            group.bench_function(BenchmarkId::from_parameter(engine.name()), |bencher| {
                bencher.iter(|| {
                    let evaluations = engine.evaluate_batch(&problems, Detail::Answer);
                    black_box(evaluations.expect("answers"))
                });
            });
        }
        group.finish();
    }
}

/// The time from opening an engine to its first decision. `decisions` times an engine that is open.
fn cold_starts(criterion: &mut Criterion) {
    let field = roadway_field();
    let problem = roadway(20, 40).problem(&field, 0);
    let quantized = QuantizedProblem::new(&problem).expect("within the ranges");
    let mut group = criterion.benchmark_group("opening an engine and one decision of 20 x 40");
    group.sample_size(10);
    for engine in engines(1) {
        let preference = match engine.kind() {
            "gpu" => EngineChoice::Gpu(Some(engine.name())),
            _ => EngineChoice::Cpu,
        };
        group.bench_function(BenchmarkId::from_parameter(engine.name()), |bencher| {
            bencher.iter(|| {
                let mut opened = open_engine(&preference, 1).expect("opened before");
                let evaluation = opened.engine.evaluate(&quantized, Detail::Answer);
                black_box(evaluation.expect("an answer"))
            });
        });
    }
    group.finish();
}

fn distance_field(criterion: &mut Criterion) {
    let side = 400;
    let origin = inbye::geometry::Pose::default();
    let frame = GridFrame { width: side, height: side, resolution_m: 0.05, origin };
    let scene = |is_blocked: fn(i32, i32) -> bool| {
        ObstacleGrid::from_fn(frame, |cell| is_blocked(cell.column, cell.row))
    };
    let scenes = [
        ("drift", roadway_obstacles()),
        ("clutter", scene(|column, row| (column + 400 * row) % 97 == 0 || column % 31 == row % 37)),
        ("large room", scene(|column, row| column % 399 == 0 || row % 399 == 0)),
        ("one pillar", scene(|column, row| column == 200 && row == 200)),
    ];
    let mut group = criterion.benchmark_group("clearance field of 400 x 400");
    for (name, obstacles) in &scenes {
        group.bench_function(*name, |bencher| {
            bencher.iter(|| black_box(ClearanceField::new(obstacles).expect("5 cm cells")));
        });
    }
    group.finish();
}

criterion_group!(benches, decisions, samplers, batches, cold_starts, distance_field);
criterion_main!(benches);
