//! A decision allocates nothing once engine and planner are warm. The count covers the whole process, with the engine's
//! threads.
//!
//! The trials run one after the other in the main thread, because the allocations of a parallel test would count too.

use std::alloc::System;
use std::hint::black_box;
use std::process::ExitCode;
use std::sync::Arc;

use inbye::bench::{Roadway, roadway_field, roadway_obstacles};
use inbye::geometry::{Point, Pose, Twist};
use inbye::global::{ClearanceCosts, Heuristic, Searcher};
use inbye::local::{
    Axis, ClearanceField, CpuEngine, DecisionInput, Detail, Engine, InstructionSet, LocalPlanner,
    LocalSettings, Problem, QuantizedProblem, Sampler, Stopping, Window,
};
use inbye::localization::{LocalizationSettings, LocalizationStatus, Localizer};
use inbye::map::{Cell, FreeSpace, MovingDisc, TimedScan, UnknownPolicy};
use inbye::robot::{Footprint, Limits};
use inbye::ros::msg::{
    Header, LaserScan, MapMetaData, OccupancyGrid, Odometry, TFMessage, Time, Transform,
    TransformStamped,
};
use inbye::ros::node::{IncomingMessage, NodeCore, NodeSettings};
use inbye::sim::{Lidar, World, roadway};
use libtest_mimic::{Arguments, Failed, Trial};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static COUNTED: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Number of different decisions of a lap. The first lap is the warm-up: it grows the engine's lists to the size of the
/// most demanding decision.
const LAP: usize = 40;

fn main() -> ExitCode {
    let arguments = Arguments {
        // With one thread the harness uses the main thread, so it allocates nothing during a trial.
        test_threads: Some(1),
        ..Arguments::from_args()
    };
    let trials = vec![
        Trial::test("repeated_decision_allocates_nothing", same_again),
        Trial::test("larger_decisions_allocate_nothing", larger_decisions),
        Trial::test("warm_planner_allocates_nothing", warm_planners),
        Trial::test("quantizing_again_allocates_nothing", quantizing_again),
        Trial::test("warm_searcher_allocates_nothing", warm_searchers),
        Trial::test("warm_localizer_allocates_nothing", warm_localizers),
        Trial::test("idle_node_allocates_nothing", idle_node),
        Trial::test("allocations_are_counted", allocations_are_counted),
    ];
    libtest_mimic::run(&arguments, trials).exit_code()
}

/// Counts the allocations and reallocations of a call.
fn allocations(act: impl FnOnce()) -> usize {
    let region = Region::new(COUNTED);
    act();
    let change = region.change();
    change.allocations + change.reallocations
}

/// Name, and the problem at each tick.
type Scene = (&'static str, fn(&Arc<ClearanceField>, usize) -> Problem);

const SCENES: [Scene; 8] = [
    ("the roadway", |field, tick| Roadway::default().problem(field, tick)),
    ("3 discs", |field, tick| {
        let discs = 3;
        Roadway { discs, ..Roadway::default() }.problem(field, tick)
    }),
    ("10 people", |field, tick| {
        let people = 10;
        Roadway { people, ..Roadway::default() }.problem(field, tick)
    }),
    ("ramps", |field, tick| {
        let sampler = Sampler::Ramps;
        Roadway { sampler, ..Roadway::default() }.problem(field, tick)
    }),
    ("two segments", |field, tick| {
        let sampler = Sampler::TwoSegments;
        Roadway { sampler, people: 3, discs: 2, ..Roadway::default() }.problem(field, tick)
    }),
    ("sequences", |field, tick| {
        let sampler = Sampler::Sequences;
        Roadway { sampler, ..Roadway::default() }.problem(field, tick)
    }),
    ("a narrow window", |field, tick| {
        let window_s = 0.1;
        Roadway { window_s, ..Roadway::default() }.problem(field, tick)
    }),
    ("off the field, stopping by arc", |field, tick| {
        let edge = field.frame().resolution_m * f64::from(field.frame().width);
        let problem = Roadway::default().problem(field, tick);
        Problem {
            pose: Pose::new(edge - 0.8, 10.0, 0.01 * tick as f64),
            stopping: Stopping::Arc,
            ..problem
        }
    }),
];

/// Runs a check with an engine of each kind in each scene; fails if it allocates.
fn in_every_scene(
    count: impl Fn(&mut CpuEngine, &[QuantizedProblem]) -> Result<usize, Failed>,
) -> Result<(), Failed> {
    let field = roadway_field();
    let here = InstructionSet::ALL.into_iter().filter(|one| one.is_available());
    let engines: Vec<_> = here.flat_map(|one| [1, 2, 4].map(|threads| (one, threads))).collect();
    for (scene, problem) in SCENES {
        let lap = (0..LAP).map(|tick| QuantizedProblem::new(&problem(&field, tick)));
        let lap = lap.collect::<Result<Vec<QuantizedProblem>, _>>()?;
        for &(instructions, threads) in &engines {
            let mut engine = CpuEngine::with_instruction_set(instructions, threads)?;
            let count = count(&mut engine, &lap)?;
            if count > 0 {
                let name = engine.name();
                return Err(format!("{name}, {scene}: {count} allocations").into());
            }
        }
    }
    Ok(())
}

fn same_again() -> Result<(), Failed> {
    in_every_scene(|engine, lap| {
        decide(engine, &lap[..1])?;
        decide(engine, &lap[..1])
    })
}

fn larger_decisions() -> Result<(), Failed> {
    in_every_scene(|engine, lap| {
        decide(engine, &lap[..2])?;
        decide(engine, &lap[2..])
    })
}

/// Takes decisions and counts their allocations.
fn decide(engine: &mut CpuEngine, problems: &[QuantizedProblem]) -> Result<usize, Failed> {
    let mut failed = None;
    let count = allocations(|| {
        for problem in problems {
            failed = failed.take().or(engine.evaluate(problem, Detail::Answer).err());
        }
    });
    failed.map_or(Ok(count), |error| Err(error.into()))
}

fn warm_planners() -> Result<(), Failed> {
    let field = roadway_field();
    let footprint = Footprint::round(0.3)?;
    let walker = |number: usize| MovingDisc {
        x: 9.0 + 0.5 * number as f64,
        y: 11.1,
        radius: 0.25,
        vx: 0.5,
        vy: 0.0,
    };
    let walkers: Vec<MovingDisc> = (0..5).map(walker).collect();
    let situation = |tick: usize| DecisionInput {
        field: &field,
        pose: Pose::new(6.5 + 0.01 * tick as f64, 9.6, 0.0),
        twist: Twist::new(0.5, 0.0),
        last_command: Twist::new(0.5, 0.01),
        // Sometimes fewer obstacles: the memory must be kept.
        obstacles: &walkers[tick % 3..],
        target: Point::new(11.5, 10.2),
        key_node: Point::new(11.5, 10.2),
        limits: Limits::default(),
        footprint: &footprint,
        weights: LocalSettings::default().weights,
    };
    for threads in [1, 2] {
        let engine = Box::new(CpuEngine::with_threads(threads)?);
        let mut planner = LocalPlanner::new(engine, LocalSettings::default());
        let mut lap = || {
            let mut commands = 0;
            let count = allocations(|| {
                for tick in 0..LAP {
                    let chosen = planner.decide(&situation(tick));
                    commands += usize::from(chosen.is_ok_and(|(command, _)| command.is_some()));
                }
            });
            (count, commands)
        };
        lap();
        let (count, commands) = lap();
        if count > 0 || commands < LAP / 2 {
            let counts = format!("{count} allocations, {commands} commands of {LAP}");
            return Err(format!("{threads} threads: {counts}").into());
        }
    }
    Ok(())
}

fn quantizing_again() -> Result<(), Failed> {
    let field = roadway_field();
    for (scene, problem) in SCENES {
        let (first, second) = (problem(&field, 0), problem(&field, 1));
        let mut quantized = None;
        let fresh = allocations(|| quantized = QuantizedProblem::new(&first).ok());
        let first = quantized.ok_or("within the ranges")?;
        let mut quantized = None;
        let again = allocations(|| quantized = first.requantized(&second).ok());
        // One list each for forward speeds, profiles, segments and discs, and one for obstacles if there are any.
        let lists = if second.obstacles.is_empty() { 4 } else { 5 };
        if (fresh, again) != (lists, 0) {
            return Err(format!("{scene}: {fresh} allocations, and {again} again").into());
        }
        let again = quantized.ok_or("within the ranges")?;
        let fresh = QuantizedProblem::new(&second)?;
        if format!("{again:?}") != format!("{fresh:?}") {
            return Err(format!("{scene}: quantized again it is another problem").into());
        }
    }
    Ok(())
}

fn warm_searchers() -> Result<(), Failed> {
    let obstacles = roadway_obstacles();
    let space = FreeSpace::new(&obstacles, 0.3);
    let costs = ClearanceCosts::new(&obstacles, 1.0, 2.0);
    let mut random = Pcg64Mcg::seed_from_u64(5);
    let mut any = |_| {
        let [x, y] = [(); 2].map(|()| random.random_range(0.0..20.0));
        space.nearest_free(&Point::new(x, y))
    };
    let ends: Option<Vec<Cell>> = (0..=LAP).map(&mut any).collect();
    let ends = ends.ok_or("free cells")?;
    let mut searcher = Searcher::default();
    let mut lap = || {
        let mut found = 0;
        let count = allocations(|| {
            for (&start, &goal) in ends.iter().zip(&ends[1..]) {
                for heuristic in [Heuristic::Octile, Heuristic::default()] {
                    for costs in [None, Some(&costs)] {
                        let outcome = searcher.astar(&space, start, goal, heuristic, costs);
                        found += usize::from(outcome.is_ok());
                    }
                }
                found += usize::from(searcher.jump_points(&space, start, goal).is_ok());
            }
        });
        (count, found)
    };
    let (growth, _) = lap();
    let (count, found) = lap();
    if growth == 0 || count > 0 || found < 4 * LAP {
        return Err(format!("{growth}, then {count} allocations for {found} paths").into());
    }
    Ok(())
}

/// Scans of a robot that drives with a known pose.
fn warm_localizers() -> Result<(), Failed> {
    let scene = roadway();
    let obstacles = scene.map.obstacles(UnknownPolicy::Blocked);
    let world = World::new(obstacles.clone());
    let settings = LocalizationSettings::default();
    let mut localizer = Localizer::new(&obstacles, settings, &scene.start)?;
    let mut random = Pcg64Mcg::seed_from_u64(5);
    let looks =
        |laps: core::ops::Range<usize>, random: &mut Pcg64Mcg| -> Vec<(f64, Pose, TimedScan)> {
            let look = |tick: usize| {
                let time_s = 0.1 * tick as f64;
                let pose = scene.start.after(&Twist::new(0.5, 0.05), time_s);
                let sweep = Lidar::default().sweep(&world, |_| pose, time_s, random);
                (time_s, pose, sweep)
            };
            laps.map(look).collect()
        };
    let mut lap = |looks: &[(f64, Pose, TimedScan)]| {
        let mut tracked = 0;
        let count = allocations(|| {
            for (time_s, pose, sweep) in looks {
                localizer.predict(*time_s, pose);
                tracked +=
                    usize::from(localizer.update(sweep).status == LocalizationStatus::Tracking);
            }
        });
        (count, tracked)
    };
    let (growth, _) = lap(&looks(0..LAP, &mut random));
    let (count, tracked) = lap(&looks(LAP..2 * LAP, &mut random));
    if growth == 0 || count > 0 || tracked < LAP {
        return Err(format!("{growth}, then {count} allocations, {tracked} tracked").into());
    }
    Ok(())
}

/// A node without a goal looks up its transforms at each tick. It allocates for a message, such as that of `diagnostics` once a
/// second.
fn idle_node() -> Result<(), Failed> {
    const START_S: f64 = 100.0;
    let header =
        |frame: &str| Header { stamp: Time::from_seconds(START_S), frame_id: frame.to_owned() };
    let transform = |parent: &str, child: &str| TransformStamped {
        header: header(parent),
        child_frame_id: child.to_owned(),
        transform: Transform::from(&Pose::new(0.1, 0.0, 0.2)),
    };
    let info = MapMetaData { resolution: 0.1, width: 10, height: 10, ..MapMetaData::default() };
    let odometry = Odometry {
        header: header("odom"),
        child_frame_id: "base_link".to_owned(),
        ..Odometry::default()
    };
    let scan = LaserScan {
        header: header("laser"),
        angle_max: 5.0,
        angle_increment: 0.1,
        range_max: 12.0,
        ranges: vec![5.0; 51],
        ..LaserScan::default()
    };
    let mounts = vec![transform("base_link", "mast"), transform("mast", "laser")];
    let places = vec![transform("map", "odom")];
    let messages = [
        IncomingMessage::Map(OccupancyGrid { header: header("map"), info, data: vec![0; 100] }),
        IncomingMessage::StaticTransforms(TFMessage { transforms: mounts }),
        IncomingMessage::Transforms(TFMessage { transforms: places }),
        IncomingMessage::Odometry(Box::new(odometry)),
        IncomingMessage::Scan(scan),
    ];
    let engine = Box::new(CpuEngine::single_threaded());
    let mut node = NodeCore::new(NodeSettings::default(), engine)?;
    messages.iter().for_each(|message| node.receive(START_S, message));
    let mut tick = |number: u32| node.tick(START_S + 0.05 * f64::from(number), &mut || 0.0);
    let diagnostics = tick(0).diagnostics.ok_or("no diagnostics")?;
    if !diagnostics.status.iter().any(|status| status.message == "all inputs are received") {
        return Err(format!("{diagnostics:?}").into());
    }
    let count = allocations(|| (1..5).for_each(|number| drop(black_box(tick(number)))));
    if count > 0 { Err(format!("{count} allocations").into()) } else { Ok(()) }
}

/// The counter works: for memory of this thread, of other threads, and of a decision with its samples.
fn allocations_are_counted() -> Result<(), Failed> {
    let field = roadway_field();
    let problem = QuantizedProblem::new(&Roadway::default().problem(&field, 0))?;
    let mut engine = CpuEngine::with_threads(2)?;
    engine.evaluate(&problem, Detail::Samples)?;
    let samples = allocations(|| {
        black_box(engine.evaluate(&problem, Detail::Samples).is_ok());
    });
    let larger =
        Window { vx: Axis::new(0.0, 1.0, 200), ..Roadway::default().problem(&field, 0).window };
    let wider = QuantizedProblem::new(&Problem {
        window: larger,
        ..Roadway::default().problem(&field, 0)
    })?;
    let growth = allocations(|| {
        black_box(engine.evaluate(&wider, Detail::Answer).is_ok());
    });
    let elsewhere = std::thread::spawn(|| allocations(|| drop(black_box(vec![1_u8; 100]))));
    let elsewhere = elsewhere.join().map_err(|_| "the thread panicked")?;
    if samples == 0 || growth == 0 || elsewhere != 1 {
        let counts = format!("{samples} for samples, {growth} to grow, {elsewhere} elsewhere");
        return Err(counts.into());
    }
    Ok(())
}
