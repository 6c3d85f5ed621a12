//! Compares the CPU engine with the limit of the machine and with a conventional DWA, for the same decisions.
//!
//! The limit is [`GatherBaseline`]: each step of each sample reads one entry of the field per disc, and nothing else.
//! The conventional planner is [`PointDwa`]. Answers are checked before anything is timed. Times on a shared machine
//! vary, so the ratios after each group come from alternating runs of both sides.

mod gather_baseline;
mod point_dwa;

use std::hint::black_box;
use std::sync::Arc;
use std::time::{Duration, Instant};

use criterion::measurement::WallTime;
use criterion::{
    BenchmarkGroup, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main,
};
use gather_baseline::GatherBaseline;
use inbye::bench::{Roadway, roadway_field, roadway_obstacles};
use inbye::local::{
    ClearanceField, CpuEngine, Detail, Engine, Evaluation, InstructionSet, QuantizedProblem,
};
use inbye::sim::{Lidar, World};
use point_dwa::PointDwa;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

/// The robot is midway along its stretch of the drift.
const TICK: usize = 50;
/// The baseline reads whole blocks of this many cells.
const BLOCK: usize = 64;
/// Largest difference of the point planner's command from the engine's, samples per axis: beams leave gaps between
/// points, and points lie on the faces of cells, while the field measures from their centres.
const SLACK: u32 = 4;
/// Pairs of runs per ratio, and the time limit for them.
const PAIRS: (usize, Duration) = (301, Duration::from_millis(700));
/// The same for the point planner, whose runs take long.
const FEW_PAIRS: (usize, Duration) = (3, Duration::from_millis(600));

/// A decision and everything that is timed on it.
struct Scene {
    roadway: Roadway,
    field: Arc<ClearanceField>,
    /// The entries of the field, and one more that the baseline may read.
    units: Vec<u16>,
    /// Cells that the engine must look up, for each disc.
    cells: Vec<i32>,
    points: PointDwa,
}

impl Scene {
    fn new(roadway: Roadway, field: &Arc<ClearanceField>, world: &World) -> Self {
        let mut cells = roadway.cells(field, TICK).repeat(roadway.discs);
        cells.truncate(cells.len() / BLOCK * BLOCK);
        let units = field.units().iter().copied().chain([0]).collect();
        let points = as_points(&roadway, field, world);
        Self { roadway, field: Arc::clone(field), units, cells, points }
    }

    fn name(&self) -> String {
        let Roadway { vx_samples, vtheta_samples, steps, window_s, discs, people, .. } =
            self.roadway;
        format!(
            "{vx_samples} x {vtheta_samples} x {steps}, window {window_s} s, {discs} discs, {people} people"
        )
    }

    /// A whole decision for a caller: from the input to the answer.
    fn decide(&self, engine: &mut CpuEngine) -> Evaluation {
        let problem = self.roadway.problem(&self.field, TICK);
        let quantized = QuantizedProblem::new(&problem).expect("within the ranges");
        let evaluation = engine.evaluate(&quantized, Detail::Answer);
        evaluation.expect("a CPU answers")
    }

    /// Checks that all engines give one answer, all baselines read the same entry, and the point planner nearly the
    /// same command.
    fn check(&self, engines: &mut [CpuEngine], baselines: &[(&str, GatherBaseline)]) {
        let units = self.field.units();
        let least = self.cells.iter().map(|&cell| i32::from(units[cell as usize]));
        let least = least.min().expect("the robot is on the field");
        for (name, baseline) in baselines {
            assert_eq!(baseline.min_entry(&self.units, &self.cells), least, "{name}");
        }
        let expected = self.decide(&mut engines[0]);
        for engine in engines {
            assert_eq!(self.decide(engine), expected, "{}", engine.name());
        }
        let winner = expected.winner.expect("the drift is open").index;
        let chosen = self.points.choose().expect("the drift is open") as u32;
        let place = |index: u32| (index % self.roadway.vx_samples, index / self.roadway.vx_samples);
        let ((v, omega), (by_v, by_omega)) = (place(winner), place(chosen));
        assert!(
            v.abs_diff(by_v) <= SLACK && omega.abs_diff(by_omega) <= SLACK,
            "{}: speed {v} and turn {omega}, by points {by_v} and {by_omega}",
            self.name()
        );
    }
}

/// The same decision for points, as a lidar of 360 beams without noise measures the walls.
fn as_points(roadway: &Roadway, field: &Arc<ClearanceField>, world: &World) -> PointDwa {
    let problem = roadway.problem(field, TICK);
    let lidar = Lidar::default().range_sigma_m(0.0).dropout(0.0);
    let rng = &mut Pcg64Mcg::seed_from_u64(0);
    let seen = lidar.scan(world, &problem.pose, rng).scan;
    let weights = problem.weights;
    PointDwa {
        points: seen.hits(&problem.pose).collect(),
        velocities: (0..problem.window.len() as u32)
            .map(|sample| problem.window.twist(sample))
            .collect(),
        people: problem.obstacles,
        discs: problem.footprint.discs().to_vec(),
        pose: problem.pose,
        steps: problem.steps,
        step_s: problem.step_s,
        max_clearance_m: problem.max_clearance_m,
        braking: [problem.braking_x, problem.braking_theta],
        target: problem.target,
        key_node: problem.key_node,
        weights: [weights.heading, weights.clearance, weights.velocity, weights.path],
    }
}

fn scenes() -> Vec<Scene> {
    let (field, world) = (roadway_field(), World::new(roadway_obstacles()));
    let plain = Roadway::default();
    let roadways = [
        plain,
        Roadway { window_s: 0.1, ..plain },
        Roadway { vx_samples: 128, vtheta_samples: 128, window_s: 0.1, ..plain },
        Roadway { discs: 3, ..plain },
        Roadway { people: 10, ..plain },
    ];
    roadways.map(|roadway| Scene::new(roadway, &field, &world)).into()
}

/// One thread with each instruction set, then two with the fastest.
fn engines() -> Vec<CpuEngine> {
    let here = InstructionSet::ALL.into_iter().filter(|one| one.is_available());
    here.map(|instructions| (instructions, 1))
        .chain([(InstructionSet::best(), 2)])
        .map(|(instructions, threads)| {
            CpuEngine::with_instruction_set(instructions, threads).expect("they are here")
        })
        .collect()
}

fn baselines() -> Vec<(&'static str, GatherBaseline)> {
    let here = InstructionSet::ALL.into_iter().filter(|one| one.is_available());
    here.map(|one| (one.name(), GatherBaseline(one))).collect()
}

fn compare(criterion: &mut Criterion) {
    let (mut engines, baselines) = (engines(), baselines());
    for scene in scenes() {
        scene.check(&mut engines, &baselines);
        let mut group = criterion.benchmark_group(scene.name());
        let samples = scene.roadway.vx_samples * scene.roadway.vtheta_samples;
        group.throughput(Throughput::Elements(u64::from(samples * scene.roadway.steps)));
        group.warm_up_time(Duration::from_millis(200));
        group.measurement_time(Duration::from_millis(800));
        measure(&mut group, &scene, &mut engines, &baselines);
        group.finish();
        print_ratios(&scene, &mut engines, &baselines);
    }
}

fn measure(
    group: &mut BenchmarkGroup<'_, WallTime>,
    scene: &Scene,
    engines: &mut [CpuEngine],
    baselines: &[(&str, GatherBaseline)],
) {
    for (name, baseline) in baselines {
        group.bench_function(BenchmarkId::new("gather only", name), |bencher| {
            bencher.iter(|| baseline.min_entry(&scene.units, black_box(&scene.cells)));
        });
    }
    for engine in engines {
        group.bench_function(BenchmarkId::new("engine", engine.name()), |bencher| {
            bencher.iter(|| scene.decide(black_box(engine)));
        });
    }
    group.sample_size(10);
    group.bench_function("points in f64", |bencher| {
        bencher.iter(|| black_box(&scene.points).choose());
    });
}

#[expect(clippy::print_stdout, reason = "a bench prints what it finds")]
fn print_ratios(scene: &Scene, engines: &mut [CpuEngine], baselines: &[(&str, GatherBaseline)]) {
    for engine in engines {
        let word = engine.instructions().name();
        let own = baselines.iter().find(|(name, _)| *name == word);
        let (_, baseline) = own.expect("one for each set of instructions");
        let (ratio, pairs) = median_ratio(
            PAIRS,
            || drop(black_box(scene.decide(engine))),
            || {
                black_box(baseline.min_entry(&scene.units, black_box(&scene.cells)));
            },
        );
        let name = engine.name();
        println!("{name}: {ratio:.2} times as long as gathering alone (median of {pairs} pairs)");
        let (ratio, pairs) = median_ratio(
            FEW_PAIRS,
            || {
                black_box(black_box(&scene.points).choose());
            },
            || drop(black_box(scene.decide(engine))),
        );
        println!("{name}: points in f64 take {ratio:.0} times as long (median of {pairs} pairs)");
    }
}

/// Ratio of the times of two functions, in alternating runs, and the number of pairs.
fn median_ratio(
    (most, patience): (usize, Duration),
    mut one: impl FnMut(),
    mut other: impl FnMut(),
) -> (f64, usize) {
    // Both once without timing: caches and threads are warm then.
    other();
    let mut ratios = Vec::new();
    let start = Instant::now();
    while ratios.len() < most && (ratios.is_empty() || start.elapsed() < patience) {
        ratios.push(seconds(&mut one) / seconds(&mut other));
    }
    ratios.sort_by(f64::total_cmp);
    (ratios[ratios.len() / 2], ratios.len())
}

fn seconds(act: &mut impl FnMut()) -> f64 {
    let start = Instant::now();
    act();
    start.elapsed().as_secs_f64()
}

criterion_group!(benches, compare);
criterion_main!(benches);
