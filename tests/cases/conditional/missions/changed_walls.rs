//! Drives by scans in worlds whose walls are no longer where the map shows them.

use inbye::geometry::Pose;
use inbye::local::CpuEngine;
use inbye::map::{Cell, DistanceField, ObstacleGrid, UnknownPolicy};
use inbye::navigator::ObservationFault;
use inbye::runtime::{Config, PoseSource};
use inbye::sim::{Scene, Simulation, crossing, mine, roadway};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::Test;
use super::driving::{story, try_drive};

pub const TESTS: &[Test] =
    &[("localisation survives a fifth of the walls changed", survives_changed_walls)];

/// Share of the walls that have changed, in pieces of this length, metres.
const SHARE: f64 = 0.2;
const PIECE_M: f64 = 1.0;
/// How far a wall was built out or broken off, metres, and the clearance that must remain.
const OUT_M: f64 = 0.3;
const BACK_M: f64 = 0.5;
const ROOM_M: f64 = 1.0;

/// The obstacles with changed walls, and the share of the surface cells that changed.
fn changed(map: &ObstacleGrid, seed: u64) -> (ObstacleGrid, f64) {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let frame = *map.frame();
    let to_wall = DistanceField::new(map);
    let free = map.map(|blocked| !blocked);
    let to_room = DistanceField::new(&free);
    let piece = (PIECE_M / frame.resolution_m).round() as i32;
    let columns = frame.width / piece + 1;
    // For each square of the map: out, back or as it was.
    let squares = (columns * (frame.height / piece + 1)) as usize;
    let kinds: Vec<f64> = (0..squares).map(|_| rng.random::<f64>() / SHARE).collect();
    let mut world = map.clone();
    let (mut surface, mut moved) = (0_u32, 0_u32);
    for index in 0..frame.len() {
        let cell = frame.cell_at(index);
        let kind = kinds[(cell.row / piece * columns + cell.column / piece) as usize];
        let is_surface =
            map.is_blocked(cell) && to_room.distance_m(cell) <= 1.5 * frame.resolution_m;
        surface += u32::from(is_surface);
        if kind >= 1.0 {
            continue;
        }
        moved += u32::from(is_surface);
        if kind < 0.5 && to_wall.distance_m(cell) <= OUT_M && has_room(&to_wall, cell) {
            world.set(cell, true);
        }
        let is_inner = cell.column > 0 && cell.row > 0;
        if kind >= 0.5 && map.is_blocked(cell) && to_room.distance_m(cell) <= BACK_M && is_inner {
            world.set(cell, false);
        }
    }
    (world, f64::from(moved) / f64::from(surface))
}

/// Whether a place near this free cell is so far from all walls that the robot still passes.
fn has_room(to_wall: &DistanceField, cell: Cell) -> bool {
    let cells = |metres: f64| (metres / to_wall.frame().resolution_m).ceil() as i32;
    let reach = cells(ROOM_M);
    let at = |right: i32, up: i32| Cell::new(cell.column + right, cell.row + up);
    let wide = |cell: Cell| to_wall.frame().contains(cell) && to_wall.distance_m(cell) > ROOM_M;
    (-reach..=reach).any(|up| (-reach..=reach).any(|right| wide(at(right, up))))
}

#[expect(clippy::print_stdout, reason = "the figures are the result")]
fn survives_changed_walls() {
    let mut config = Config::default();
    config.pose_source = PoseSource::Scans;
    let (mut drives, mut lost, mut worst_m, mut shares) = (0, Vec::new(), 0.0_f64, Vec::new());
    let scenes: [fn() -> Scene; 3] = [roadway, crossing, mine];
    for (scene, seed) in scenes.iter().flat_map(|scene| (1..=2).map(move |seed| (scene(), seed))) {
        let (world, share) = changed(&scene.map.obstacles(UnknownPolicy::Blocked), seed);
        shares.push(share);
        let task = Simulation { truth: Some(world), seed, ..Simulation::new(scene.mission(400.0)) };
        let engine = Box::new(CpuEngine::single_threaded());
        let result = try_drive(&task, &config, engine).expect("a path");
        let error_m = |(one, other): (Pose, Pose)| (one.position() - other.position()).norm();
        let errors = result.trace.rows.iter().map(|row| error_m((row.belief, row.pose)));
        let largest_m = errors.fold(0.0, f64::max);
        let losses = result.observation_faults.iter();
        let losses = losses.filter(|(fault, _)| matches!(fault, ObservationFault::Lost(_)));
        let losses: u64 = losses.map(|(_, count)| count).sum();
        println!(
            "{} {seed}: {:.0} % of the walls changed, {} lost ticks, largest error {largest_m:.3} m, {}",
            scene.name,
            100.0 * share,
            losses,
            story(&result)
        );
        drives += 1;
        worst_m = worst_m.max(largest_m);
        if losses > 0 || !result.reached {
            lost.push((scene.name, seed));
        }
    }
    assert!(lost.is_empty() && worst_m < 0.15, "{lost:?} of {drives}, {worst_m}");
    assert!(shares.iter().all(|share| (0.1..0.4).contains(share)), "{shares:?}");
}
