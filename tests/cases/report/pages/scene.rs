//! A generated mission: a robot drives along pillars while obstacles cross its path. It is data, not a simulation.

use std::sync::Arc;

use inbye::bench::{DensityRow, QualityRow, SkippedCell};
use inbye::experiment::Group;
use inbye::geometry::{Point, Pose, Twist, bearing, wrap_angle};
use inbye::global::Path;
use inbye::local::CpuEngine;
use inbye::map::{Cell, GridFrame, OccupancyGrid};
use inbye::navigator::{Goal, Mode};
use inbye::report::{EngineComparison, MissionView};
use inbye::robot::{Disc, Footprint};
use inbye::runtime::{Config, Mission, MissionResult, Observer, Trace, TraceRow};
use inbye::sim::{self, Simulation};
use rand::{RngExt, SeedableRng};

/// The data that a [`MissionView`] borrows.
#[derive(Clone)]
pub struct Scene {
    pub mission: Mission,
    pub config: Config,
    pub result: MissionResult,
    pub facts: Vec<(String, String)>,
}

pub const PERIOD_S: f64 = 0.1;

/// Roadways between pillars, 36 by 20 m, with an unknown area.
pub fn pillars(resolution_m: f64) -> OccupancyGrid {
    let frame = GridFrame {
        width: (36.0 / resolution_m) as i32,
        height: (20.0 / resolution_m) as i32,
        resolution_m,
        origin: Pose::new(-2.0, -2.0, 0.0),
    };
    OccupancyGrid::from_fn(frame, |Cell { column, row }| {
        let x = f64::from(column) * resolution_m;
        let y = f64::from(row) * resolution_m;
        let edge = !(0.4..35.6).contains(&x) || !(0.4..19.6).contains(&y);
        let pillar = x % 9.0 > 3.5 && y % 7.0 > 3.2;
        let unknown = x > 30.0 && y < 3.2;
        if unknown { -1 } else { i8::from(edge || pillar) * 100 }
    })
}

/// A run around the pillars.
pub fn scene(ticks: usize) -> Scene {
    let corners = [(0.0, 0.0), (8.0, 0.4), (8.6, 7.0), (17.5, 7.3), (18.0, 14.0), (31.0, 14.5)];
    let pruned: Vec<Point> = corners.iter().map(|&(x, y)| Point::new(x, y)).collect();
    let smoothed: Vec<Point> = rounded(&pruned);
    let replanned = vec![
        Point::new(9.0, 7.4),
        Point::new(13.0, 8.2),
        Point::new(17.0, 7.8),
        Point::new(18.4, 14.0),
        Point::new(31.0, 14.5),
    ];
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(3);
    let decision_s = (0..ticks).map(|tick| {
        let spike = if tick % 97 == 50 { 5.0 } else { 1.0 };
        0.35e-3 * spike * (1.0 + 0.3 * rng.random::<f64>() * rng.random::<f64>())
    });
    let goal = Goal { position: Point::new(31.0, 14.5), yaw: Some(0.0) };
    let start = Pose::new(0.0, 0.0, 0.05);
    let mission = Mission::new(Arc::new(pillars(0.1)), start, goal);
    let mut config = Config::default();
    let footprint = [0.25, -0.25].map(|x| Disc { x, y: 0.0, radius: 0.35 }).to_vec();
    config.robot.footprint = Footprint::new(footprint).expect("two sound discs");
    config.local.control_period_s = PERIOD_S;
    let mut result = short_drive();
    let plan = &mut result.plans[0];
    plan.raw = Path::new(staircase(&pruned));
    plan.smoothed = Path::new(smoothed.clone());
    plan.pruned = Path::new(pruned);
    result.trace = Trace {
        rows: drive(&smoothed, ticks),
        paths: vec![smoothed, replanned],
        moving_radii: vec![0.4, 0.3, 0.5],
    };
    result.decision_s = decision_s.collect();
    "CPU, 2 threads, AVX2".clone_into(&mut result.engine);
    (result.reached, result.collided) = (true, false);
    result.time_s = result.trace.rows.last().map_or(0.0, |row| row.time_s);
    (result.travelled_m, result.min_clearance_m) = (47.9, 0.141);
    (result.final_error_m, result.final_yaw_error) = ((0.004, -0.011), Some(0.003));
    Scene {
        mission,
        config,
        result,
        facts: vec![
            ("Digest".to_owned(), "9f2c".repeat(16)),
            ("Engine choice".to_owned(), "auto: the GPU is faster from 2000 samples on".to_owned()),
        ],
    }
}

/// The result of a mission of half a second. Only the library creates results.
fn short_drive() -> MissionResult {
    let mission = sim::crossing().mission(0.5);
    let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
    let engine = Box::new(CpuEngine::single_threaded());
    let run = Simulation::new(mission).run(&Config::default(), engine, &mut observer);
    run.expect("a mission that can start")
}

impl Scene {
    pub fn view(&self) -> MissionView<'_> {
        MissionView {
            title: "Around the pillars, with three obstacles",
            command: "inbye drive --map pillars.yaml --start 0,0 --goal 31,14.5 --obstacles 3 --seed 7 --report out",
            mission: &self.mission,
            config: &self.config,
            result: &self.result,
            playback: None,
            facts: &self.facts,
        }
    }
}

pub fn density() -> Vec<DensityRow> {
    let engine = |name: &str, adapter: Option<&str>, threads, floor_ms: f64, per_sample_ms: f64| {
        [100, 500, 2000, 10_000, 50_000, 200_000]
            .map(|samples| {
                let p50_ms = floor_ms + per_sample_ms * samples as f64;
                DensityRow {
                    sampler: "arcs".to_owned(),
                    engine: if adapter.is_some() { "gpu" } else { "cpu" }.to_owned(),
                    adapter: adapter.map(str::to_owned),
                    threads,
                    samples,
                    steps: 40,
                    p50_ms,
                    p95_ms: p50_ms * 1.2,
                    p99_ms: p50_ms * 1.6,
                    max_ms: p50_ms * 3.0,
                    decisions: 500,
                    steps_per_s: samples as f64 * 40.0 / p50_ms * 1e3,
                    name: name.to_owned(),
                    missed_20_hz: 0,
                    missed_50_hz: if p50_ms > 20.0 { 499 } else { 0 },
                    missed_100_hz: if p50_ms > 10.0 { 500 } else { 1 },
                }
            })
            .to_vec()
    };
    [
        engine("CPU, 1 thread, AVX2", None, 1, 0.01, 4e-3),
        engine("CPU, 16 threads, AVX2", None, 16, 0.05, 3e-4),
        engine("NVIDIA H200", Some("NVIDIA H200"), 0, 0.2, 6e-6),
    ]
    .concat()
}

pub fn skipped() -> Vec<SkippedCell> {
    vec![SkippedCell {
        sampler: "arcs".to_owned(),
        name: "SwiftShader Device (Subzero)".to_owned(),
        samples: 1_048_576,
        reason: "a decision would take about 6.2 s".to_owned(),
    }]
}

/// Two windows, two shapes, five densities; the regret of the densest is zero.
pub fn quality() -> Vec<QualityRow> {
    let mut rows = Vec::new();
    for window_s in [0.1, 1.0] {
        for (side, lost) in [(16, 8.0), (32, 4.0), (64, 1.0), (128, 0.1), (256, 0.0)] {
            for stretch in [1, 2] {
                let regret = |share: f64| Some(share * lost * window_s / f64::from(stretch * 100));
                rows.push(QualityRow {
                    sampler: "arcs".to_owned(),
                    window_s,
                    samples: (side * side) as usize,
                    vx_samples: side / stretch,
                    vtheta_samples: side * stretch,
                    densest: 1_048_576,
                    decisions: 100,
                    without_command: 0,
                    regret_p50: regret(1.0),
                    regret_max: regret(7.0),
                    v_off_p50_m_s: Some(0.01),
                    v_off_max_m_s: Some(0.05),
                    omega_off_p50_rad_s: Some(0.002),
                    omega_off_max_rad_s: Some(0.03),
                });
            }
        }
    }
    rows
}

/// Five densities in two shapes; with the fewest samples half of the missions reach their goal, and one shape has no shared
/// time.
pub fn closed_loop() -> Vec<Group> {
    let mut rows = Vec::new();
    for (side, reached, time_s) in
        [(8, 6, 40.0), (16, 11, 34.0), (32, 12, 31.0), (64, 12, 30.5), (128, 12, 30.0)]
    {
        for stretch in [1, 2] {
            let time_s = Some(time_s).filter(|_| side > 8 || stretch == 1);
            rows.push(Group {
                vx_samples: side / stretch,
                vtheta_samples: side * stretch,
                samples: u64::from(side * side),
                runs: 12,
                reached,
                contacts: 0,
                mean_time_ratio: time_s.map(|time_s| time_s / 30.0),
                shared: 6,
                shared_time_p50_s: time_s,
                shared_time_p90_s: time_s.map(|time_s| time_s * 1.5),
                mean_clearance_reached_m: Some(0.4),
                tick_p50_ms: Some(0.3),
                tick_p99_ms: Some(9.0),
                ..Group::default()
            });
        }
    }
    rows
}

pub fn comparisons() -> Vec<EngineComparison> {
    ["CPU, 1 thread, AVX2", "CPU, 16 threads, AVX2", "NVIDIA H200"]
        .map(|name| EngineComparison {
            name: name.to_owned(),
            digest: "5b1e".repeat(16),
            agrees: true,
        })
        .to_vec()
}

/// The steps of a grid search between corners.
fn staircase(corners: &[Point]) -> Vec<Point> {
    let mut steps = Vec::new();
    for ends in corners.windows(2) {
        let (mut at, to) = (ends[0], ends[1]);
        while (to - at).norm() > 0.15 {
            steps.push(at);
            let step = |gap: f64| {
                if gap.abs() > 0.07 { gap.signum() * 0.1 } else { 0.0 }
            };
            at = Point::new(at.x + step(to.x - at.x), at.y + step(to.y - at.y));
        }
    }
    steps.extend(corners.last());
    steps
}

/// A path with rounded corners.
fn rounded(corners: &[Point]) -> Vec<Point> {
    let mut line = corners.to_vec();
    for _ in 0..4 {
        let mut finer = vec![line[0]];
        for ends in line.windows(2) {
            finer.push(ends[0] + (ends[1] - ends[0]) * 0.25);
            finer.push(ends[0] + (ends[1] - ends[0]) * 0.75);
        }
        finer.extend(line.last());
        line = finer;
    }
    line
}

/// A robot that drives towards a point ahead on its path, and crossing discs.
fn drive(path: &[Point], ticks: usize) -> Vec<TraceRow> {
    let length: f64 = path.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum();
    let speed = length / (ticks.max(1) as f64 * PERIOD_S) * 1.15;
    let (mut pose, mut twist, mut next) = (Pose::new(0.0, 0.0, 0.05), Twist::STOP, 0);
    (0..ticks)
        .map(|tick| {
            let share = tick as f64 / ticks as f64;
            while next + 1 < path.len() && (path[next] - pose.position()).norm() < 0.8 {
                next += 1;
            }
            let target = path[next];
            let mode = match share {
                0.38..0.42 => Mode::Blocked,
                0.42..0.44 => Mode::Escaping,
                0.62..0.66 => Mode::Rotating,
                0.985.. => Mode::Arrived,
                _ => Mode::Driving,
            };
            let turn = wrap_angle(bearing(&pose.position(), &target) - pose.yaw).clamp(-0.8, 0.8);
            let command = match mode {
                Mode::Blocked
                | Mode::SensorFault
                | Mode::Parking
                | Mode::AtWaypoint
                | Mode::Arrived
                | Mode::Failed => Twist::STOP,
                Mode::Escaping | Mode::Evading => Twist::new(-0.3, 0.0),
                Mode::Rotating => Twist::new(0.0, turn),
                _ => Twist::new(speed * (1.0 - turn.abs()), turn),
            };
            let row = TraceRow {
                time_s: tick as f64 * PERIOD_S,
                pose,
                belief: pose,
                twist,
                command,
                local_target: target,
                gap_m: 0.9 + 0.7 * libm::cos(share * 40.0) + 0.05 * libm::sin(share * 300.0),
                admissible: 700,
                samples: 800,
                mode,
                path: usize::from(share > 0.45),
                moving: crossing(share),
            };
            twist.linear += 0.25 * (command.linear - twist.linear);
            twist.angular += 0.35 * (command.angular - twist.angular);
            pose.yaw += twist.angular * PERIOD_S;
            pose.x += twist.linear * libm::cos(pose.yaw) * PERIOD_S;
            pose.y += twist.linear * libm::sin(pose.yaw) * PERIOD_S;
            row
        })
        .collect()
}

fn crossing(share: f64) -> Vec<Option<Point>> {
    [
        Point::new(8.5 - 6.0 * (share - 0.1), -1.2 + 14.0 * share),
        Point::new(30.0 - 28.0 * share, 7.8),
        Point::new(18.8, 15.0 - 16.0 * (share - 0.5).abs()),
    ]
    .map(Some)
    .to_vec()
}
