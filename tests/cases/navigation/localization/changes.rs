//! What scans contradict in the map for minutes.

use inbye::geometry::{Point, Pose};
use inbye::localization::{LocalizationSettings, LocalizationStatus, Localizer, MapChanges};
use inbye::map::{Cell, MovingDisc, ObstacleGrid, OccupancyGrid, TimedScan};
use inbye::sim::World;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use super::room::{ROOM, ground, lidar};

/// The map as its robot has it.
fn known(obstacles: &ObstacleGrid) -> OccupancyGrid {
    obstacles.map(|&blocked| if blocked { 100 } else { 0 })
}

/// Where the robot is on its round through the room.
fn place(time_s: f64) -> Pose {
    let (sin, cos) = libm::sincos(0.15 * time_s);
    Pose::new(5.0 + 1.5 * cos, 5.0 + 0.9 * sin, 0.3 * time_s)
}

/// The changes after a drive through a room that differs from its map, among people.
fn changes_after(
    time_s: f64,
    pose: impl Fn(f64) -> Pose,
    change: impl FnOnce(&mut ObstacleGrid),
    people: impl Fn(f64) -> Vec<MovingDisc>,
) -> (OccupancyGrid, MapChanges) {
    let map = ground(Pose::default(), &ROOM);
    let mut truth = map.clone();
    change(&mut truth);
    let (mut world, mut rng) = (World::new(truth), Pcg64Mcg::seed_from_u64(5));
    let settings = LocalizationSettings::default();
    let mut localizer = Localizer::new(&map, settings, &pose(0.0)).expect("a valid pose");
    for tick in 0..=(10.0 * time_s) as u32 {
        let now_s = 0.1 * f64::from(tick);
        world.moving = people(now_s);
        localizer.predict(now_s, &pose(now_s));
        let seen = lidar().scan(&world, &pose(now_s), &mut rng);
        let status = localizer.update(&TimedScan::from_scan(&seen.scan, now_s, 0.0)).status;
        assert!(status != LocalizationStatus::Uncertain || now_s < 1.0, "{status:?} at {now_s}");
    }
    let grid = known(&map);
    let changes = localizer.map_changes(&grid);
    (grid, changes)
}

fn fill(obstacles: &mut ObstacleGrid, [left, low, right, high]: [f64; 4], blocked: bool) {
    let cell = |metres: f64| (metres / 0.05).round() as i32;
    for row in cell(low)..cell(high) {
        for column in cell(left)..cell(right) {
            obstacles.set(Cell::new(column, row), blocked);
        }
    }
}

/// A box of 0.6 by 0.4 m next to the lower wall, and a niche of 0.8 by 0.5 m broken into the right one.
const BOX: [f64; 4] = [4.6, 3.0, 5.2, 3.4];
const NICHE: [f64; 4] = [8.0, 4.6, 8.5, 5.4];

fn rebuild(obstacles: &mut ObstacleGrid) {
    fill(obstacles, BOX, true);
    fill(obstacles, NICHE, false);
}

/// Number of cells that lie within a rectangle, and of those that do not.
fn within(cells: &[Cell], [left, low, right, high]: [f64; 4]) -> (usize, usize) {
    let is_in = |cell: &&Cell| {
        let Point { x, y } = cell.center();
        (left..right).contains(&(0.05 * x)) && (low..high).contains(&(0.05 * y))
    };
    let inside = cells.iter().filter(is_in).count();
    (inside, cells.len() - inside)
}

#[test]
fn box_and_niche_are_reported_after_a_minute() {
    let (grid, changes) = changes_after(90.0, place, rebuild, |_| Vec::new());
    // The sides of the box that face the room: 12 cells ahead and 8 on each side.
    let (seen, elsewhere) = within(&changes.appeared, [4.5, 2.9, 5.3, 3.5]);
    assert!(seen >= 20 && elsewhere == 0, "{seen} {elsewhere}");
    // 10 by 16 cells, but for those up to 0.15 m before its walls.
    let (open, elsewhere) = within(&changes.vanished, NICHE);
    assert!(open >= 80 && elsewhere == 0, "{open} {elsewhere}");
    let [appeared, vanished] = changes.areas(grid.frame());
    assert_eq!((appeared.len(), vanished.len()), (1, 1));
    let (found, open) = (appeared[0], vanished[0]);
    assert!((found.x - 4.9).abs() < 0.1 && (found.width_m - 0.6).abs() < 0.11, "{found:?}");
    assert!((open.x - 8.25).abs() < 0.1 && (open.height_m - 0.8).abs() < 0.16, "{open:?}");
    let updated = changes.applied_to(&grid);
    let changed = updated.cells().iter().zip(grid.cells()).filter(|(new, old)| new != old);
    assert_eq!(changed.count(), changes.appeared.len() + changes.vanished.len());
    // Not yet after half a minute.
    let (_, early) = changes_after(40.0, place, rebuild, |_| Vec::new());
    assert!(early.is_empty(), "{early:?}");
}

#[test]
fn room_as_mapped_has_no_changes_whatever_people_do() {
    let walking = |time_s: f64| {
        let (sin, cos) = libm::sincos(0.4 * time_s);
        // One walks around, one stands for half a minute.
        let walks =
            MovingDisc { x: 5.0 + 2.2 * cos, y: 5.0 + 1.6 * sin, radius: 0.2, vx: 0.0, vy: 0.0 };
        let stands = MovingDisc { x: 2.5, y: 3.5, radius: 0.2, vx: 0.0, vy: 0.0 };
        let mut people = vec![walks];
        people.extend((20.0..50.0).contains(&time_s).then_some(stands));
        people
    };
    let (_, changes) = changes_after(150.0, place, |_| (), walking);
    assert!(changes.is_empty(), "{changes:?}");
    // A robot that stands near a wall sees along it for minutes.
    let corner = |_| Pose::new(2.4, 3.4, 0.7);
    let (_, changes) = changes_after(150.0, corner, |_| (), |_| Vec::new());
    assert!(changes.is_empty(), "{changes:?}");
}

/// A box that is taken away again is no change.
#[test]
fn what_is_as_mapped_again_is_no_change() {
    let person = MovingDisc { x: 3.0, y: 6.0, radius: 0.25, vx: 0.0, vy: 0.0 };
    let stands_until =
        |end_s: f64| move |time_s: f64| if time_s < end_s { vec![person] } else { Vec::new() };
    let (_, changes) = changes_after(90.0, place, |_| (), stands_until(90.0));
    assert!(!changes.appeared.is_empty());
    let (_, changes) = changes_after(150.0, place, |_| (), stands_until(90.0));
    assert!(changes.is_empty(), "{changes:?}");
}
