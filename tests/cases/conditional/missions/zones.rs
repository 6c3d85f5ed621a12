//! Zones that the robot must not enter, or only slowly.

use std::env;
use std::sync::Arc;

use inbye::experiment::built_in_maps;
use inbye::experiment::missions::Rules;
use inbye::geometry::{Point, Pose};
use inbye::local::CpuEngine;
use inbye::map::{GridFrame, OccupancyGrid, UnknownPolicy, Zones};
use inbye::runtime::{Config, MissionResult, ObstacleGap, ZoneCompliance};
use inbye::sim::Simulation;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::Test;
use super::driving::{arrive, drive, mission, story, try_drive};
use super::ground::hall;

pub const TESTS: &[Test] = &[
    ("robot drives around a closed zone", around_a_closed_zone),
    ("robot slows down before a zone with a speed limit", before_a_slow_zone),
    ("a passage that a zone closes has no path", closed_passage),
    ("random missions keep their zones", random_missions),
];

/// Random missions in CI. `INBYE_ZONE_MISSIONS=1000` drives more.
const MISSIONS: u64 = 12;

/// Gap between a closed zone and the robot at its start and at its goal, metres.
const END_GAP_M: f64 = 0.1;

/// How far from the straight line random zones lie, metres.
const ASIDE_M: f64 = 3.0;

/// How far the speed of a robot may exceed a limit, m/s: noise of speed and pose.
const EXCESS: f64 = 0.06;

/// A mask with a value in a rectangle, metres.
fn mask(frame: &GridFrame, [left, low, right, high]: [f64; 4], value: i8) -> OccupancyGrid {
    OccupancyGrid::from_fn(*frame, |cell| {
        let Point { x, y } = frame.center_of(cell);
        let is_in = (left..right).contains(&x) && (low..high).contains(&y);
        if is_in { value } else { 0 }
    })
}

fn with_zones(mut task: Simulation, zones: Zones) -> Simulation {
    task.mission.zones = Some(Arc::new(zones));
    task
}

fn compliance(result: &MissionResult) -> ZoneCompliance {
    result.zones.expect("the mission has zones")
}

fn around_a_closed_zone() {
    let task = || mission(&hall(11.0, 6.0), [1.5, 2.0, 0.0], [10.5, 2.0]);
    let frame = *task().mission.map.frame();
    let mut zones = Zones::new(&frame);
    zones.close(&mask(&frame, [5.0, 0.0, 6.5, 4.0], 100));
    let result = arrive(&with_zones(task(), zones.clone()));
    let kept = compliance(&result);
    assert!(kept.intrusions == 0 && kept.min_gap_m > 0.0, "{kept:?}");
    // A robot that does not know the zone drives through it, which the same check shows.
    let result = arrive(&task());
    let footprint = &Config::default().robot.footprint;
    let through = ZoneCompliance::of(&result.trace, &zones, footprint, 1.0);
    assert!(through.intrusions > 10 && through.min_gap_m <= 0.0, "{through:?}");
}

fn before_a_slow_zone() {
    let task = || mission(&hall(11.0, 3.0), [1.5, 2.0, 0.0], [10.5, 2.0]);
    let frame = *task().mission.map.frame();
    let mut zones = Zones::new(&frame);
    let zone = mask(&frame, [5.0, 0.0, 7.0, 4.0], 40);
    zones.limit_speed(&zone, |value| (value > 0).then(|| f64::from(value)));
    let result = arrive(&with_zones(task(), zones.clone()));
    let kept = compliance(&result);
    // Two metres at 0.4 m/s.
    assert!(kept.limited_ticks >= 45 && kept.max_excess < EXCESS, "{kept:?}");
    let fastest = |from: f64, to: f64| {
        let rows = result.trace.rows.iter().filter(|row| (from..to).contains(&row.pose.x));
        rows.map(|row| row.twist.linear).fold(0.0, f64::max)
    };
    assert!(fastest(2.0, 4.0) > 0.9 && fastest(7.5, 9.0) > 0.9, "{}", story(&result));
    let heedless = arrive(&task());
    let footprint = &Config::default().robot.footprint;
    let through = ZoneCompliance::of(&heedless.trace, &zones, footprint, 1.0);
    assert!(through.max_excess > 0.4, "{through:?}");
}

fn closed_passage() {
    let ground = hall(9.0, 4.0).wall([4.5, 0.5, 5.0, 2.0]);
    let task = mission(&ground, [1.5, 1.5, 0.0], [8.5, 1.5]);
    let mut zones = Zones::new(task.mission.map.frame());
    zones.close(&mask(task.mission.map.frame(), [4.5, 2.0, 5.0, 4.6], 100));
    let engine = Box::new(CpuEngine::single_threaded());
    let refused = try_drive(&with_zones(task.clone(), zones), &Config::default(), engine);
    assert!(refused.is_err_and(|error| error.to_string().contains("NO_VALID_PATH")));
    assert!(drive(&task).reached);
}

/// Zones of random places and sizes that leave a path: up to three closed ones, and up to two with speed limits.
fn random_zones(simulation: &Simulation, config: &Config, rng: &mut Pcg64Mcg) -> Zones {
    let map = &simulation.mission.map;
    let obstacles = map.obstacles(UnknownPolicy::Blocked);
    let frame = *map.frame();
    let (start, goal) = (simulation.mission.start.position(), simulation.mission.goal.position);
    let goal_yaw = simulation.mission.goal.yaw.unwrap_or(0.0);
    let mut planner = config.route_planner(frame.resolution_m);
    let ends = [simulation.mission.start, Pose::new(goal.x, goal.y, goal_yaw)];
    let mut leaves_a_path = |zones: &Zones| {
        let gap = ObstacleGap::new(zones.closed());
        let is_apart = |end: &Pose| gap.gap_m(&config.robot.footprint, end) > END_GAP_M;
        let obstacles = zones.with_obstacles(&obstacles);
        ends.iter().all(is_apart) && planner.plan(&obstacles, start, goal, &mut || 0.0).is_ok()
    };
    let mut zones = Zones::new(&frame);
    let zone = |rng: &mut Pcg64Mcg, value: i8| {
        // Near the straight line, where zones matter.
        let at = start + (goal - start) * rng.random::<f64>();
        let center = Point::new(
            at.x + rng.random_range(-ASIDE_M..ASIDE_M),
            at.y + rng.random_range(-ASIDE_M..ASIDE_M),
        );
        let (width, height) = (rng.random_range(0.3..3.0), rng.random_range(0.3..3.0));
        mask(
            &frame,
            [
                center.x - width / 2.0,
                center.y - height / 2.0,
                center.x + width / 2.0,
                center.y + height / 2.0,
            ],
            value,
        )
    };
    for _ in 0..rng.random_range(1..=3) {
        let mut tried = zones.clone();
        tried.close(&zone(rng, 100));
        if leaves_a_path(&tried) {
            zones = tried;
        }
    }
    for _ in 0..rng.random_range(0..=2) {
        let percent = rng.random_range(20..80);
        zones.limit_speed(&zone(rng, percent), |value| (value > 0).then(|| f64::from(value)));
    }
    zones
}

#[expect(clippy::print_stdout, reason = "the figures are the result")]
fn random_missions() {
    let missions = env::var("INBYE_ZONE_MISSIONS").ok().and_then(|text| text.parse().ok());
    let missions = missions.unwrap_or(MISSIONS);
    let (config, worlds) = (Config::default(), built_in_maps(Rules::default()));
    let (mut reached, mut closed, mut limited) = (0, 0, 0);
    let (mut intruders, mut speeders) = (Vec::new(), Vec::new());
    let (mut min_gap_m, mut max_excess) = (f64::INFINITY, 0.0_f64);
    for seed in 1..=missions {
        let world = &worlds[seed as usize % worlds.len()];
        let simulation = world.simulation(seed, &config).expect("a mission").simulation;
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let zones = random_zones(&simulation, &config, &mut rng);
        closed += u64::from(!zones.is_open());
        let engine = Box::new(CpuEngine::single_threaded());
        let task = with_zones(simulation, zones);
        let result = try_drive(&task, &config, engine).expect("a path");
        let kept = compliance(&result);
        reached += u64::from(result.reached);
        limited += u64::from(kept.limited_ticks > 0);
        min_gap_m = min_gap_m.min(kept.min_gap_m);
        max_excess = max_excess.max(kept.max_excess);
        if kept.intrusions > 0 {
            intruders.push(seed);
        }
        if kept.max_excess > EXCESS {
            speeders.push((seed, kept.max_excess));
        }
    }
    println!(
        "{missions} missions, {reached} reached; {closed} with closed zones, smallest gap {min_gap_m:.3} m; {limited} with limits on \
         their way, largest excess {max_excess:.3} m/s; intruders {intruders:?}, speeders {speeders:?}"
    );
    assert!(intruders.is_empty(), "{intruders:?} of {missions}");
    assert!(reached * 100 >= missions * 90, "{reached} of {missions}");
}
