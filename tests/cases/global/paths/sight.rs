//! Line of sight and clearance, compared with exact integers and brute force.

use inbye::geometry::{Point, Pose};
use inbye::global::{Path, PathClearance, is_clear};
use inbye::map::{Cell, FreeSpace, GridFrame, ObstacleGrid};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::lattice_sight::{self, LatticePoint, STEPS};
use crate::support::{gap, random_grid};

/// A grid with exact float arithmetic: powers of two, at the origin.
fn exact_grid(random: &mut Pcg64Mcg, density: f64) -> FreeSpace {
    let frame = GridFrame {
        width: random.random_range(1..60),
        height: random.random_range(1..60),
        resolution_m: [0.25, 1.0][random.random_range(0..2)],
        origin: Pose::default(),
    };
    FreeSpace::new(&ObstacleGrid::from_fn(frame, |_| random.random_bool(density)), 0.0)
}

fn point(space: &FreeSpace, (x, y): LatticePoint) -> Point {
    let step_m = space.frame().resolution_m / STEPS as f64;
    Point::new(x as f64 * step_m, y as f64 * step_m)
}

fn compare(space: &FreeSpace, from: LatticePoint, to: LatticePoint) -> bool {
    let expected = lattice_sight::is_clear(space, from, to);
    let (a, b) = (point(space, from), point(space, to));
    assert_eq!(is_clear(space, &a, &b), expected, "{from:?} to {to:?}");
    assert_eq!(is_clear(space, &b, &a), expected, "{to:?} to {from:?}");
    expected
}

#[test]
fn line_of_sight_equals_the_integer_reference() {
    let mut random = Pcg64Mcg::seed_from_u64(31);
    let mut clear = [0; 4];
    for _ in 0..400 {
        let density = [0.0, 0.01, 0.1, 0.4][random.random_range(0..4)];
        let space = exact_grid(&mut random, density);
        let (width, height) = (space.frame().width, space.frame().height);
        for case in 0..200 {
            let place = |random: &mut Pcg64Mcg, side: i32, grain: i64| {
                // Includes points slightly outside the grid.
                random.random_range(-1..=(i64::from(side) * STEPS) / grain + 1) * grain
            };
            // Any points, cell halves, cell corners, segments along lines, single points.
            let grain = [1, STEPS / 2, STEPS, STEPS][case % 4];
            let from = (place(&mut random, width, grain), place(&mut random, height, grain));
            let mut to = (place(&mut random, width, grain), place(&mut random, height, grain));
            if case % 4 == 3 {
                match random.random_range(0..3) {
                    0 => to.0 = from.0,
                    1 => to.1 = from.1,
                    _ => to = from,
                }
            }
            clear[case % 4] += i32::from(compare(&space, from, to));
        }
    }
    assert!(clear.iter().all(|&count| count > 500), "{clear:?}");
}

#[test]
fn line_of_sight_distinguishes_passing_from_touching_on_long_segments() {
    let mut random = Pcg64Mcg::seed_from_u64(32);
    let frame = GridFrame { width: 200, height: 200, resolution_m: 0.25, origin: Pose::default() };
    let mut outcomes = [0, 0];
    for _ in 0..2000 {
        let cell = Cell::new(random.random_range(60..140), random.random_range(60..140));
        let mut obstacles = ObstacleGrid::filled(frame, false);
        obstacles.set(cell, true);
        let space = FreeSpace::new(&obstacles, 0.0);
        // Through a corner of the obstacle, or a lattice step next to it.
        let corner = (
            i64::from(cell.column + random.random_range(0..2)) * STEPS,
            i64::from(cell.row + random.random_range(0..2)) * STEPS,
        );
        let offset = (random.random_range(-2_400..2_400), random.random_range(-2_400..2_400));
        let by = (random.random_range(-1..=1), random.random_range(-1..=1));
        let from = (corner.0 + offset.0 + by.0, corner.1 + offset.1 + by.1);
        let to = (corner.0 - offset.0 + by.0, corner.1 - offset.1 + by.1);
        outcomes[usize::from(compare(&space, from, to))] += 1;
    }
    assert!(outcomes.iter().all(|&count| count > 300), "{outcomes:?}");
}

#[test]
fn line_of_sight_is_blocked_for_ends_off_the_grid_or_not_finite() {
    let frame = GridFrame { width: 8, height: 8, resolution_m: 1.0, origin: Pose::default() };
    let space = FreeSpace::new(&ObstacleGrid::new(frame, vec![false; 64]), 0.0);
    let inside = Point::new(3.2, 4.4);
    assert!(is_clear(&space, &inside, &inside));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, -1e-3, 8.0] {
        for place in [Point::new(bad, 4.4), Point::new(3.2, bad), Point::new(bad, bad)] {
            assert!(!is_clear(&space, &inside, &place), "{place:?}");
            assert!(!is_clear(&space, &place, &inside), "{place:?}");
            assert!(!is_clear(&space, &place, &place), "{place:?}");
        }
    }
}

#[test]
fn clearance_equals_the_minimum_over_small_steps() {
    const STEP: f64 = 4e-3;
    let mut random = Pcg64Mcg::seed_from_u64(33);
    let mut near = 0;
    for case in 0..300 {
        let mut obstacles = random_grid::obstacles(&mut random, 30);
        let frame = *obstacles.frame();
        if case % 3 == 0 {
            // A single obstacle, far from most of the path.
            obstacles = ObstacleGrid::filled(frame, false);
            obstacles.set(random_grid::cell(&mut random, &frame), true);
        }
        let mut place = |_| {
            let along =
                |random: &mut Pcg64Mcg, side: i32| f64::from(side) * random.random_range(-0.3..1.3);
            let (x, y) = (along(&mut random, frame.width), along(&mut random, frame.height));
            frame.from_cell_units(&Point::new(x, y))
        };
        let points: Vec<Point> = (0..[1, 2, 3, 6][case % 4]).map(&mut place).collect();
        let found = PathClearance::new(&obstacles).min_m(&Path::new(points.clone()));
        let everywhere_m = 100.0 * frame.resolution_m;
        let stepped = gap::smallest_gap_m(&points, &obstacles, everywhere_m, STEP);
        let slack = STEP / 2.0 * frame.resolution_m;
        if stepped.is_infinite() {
            assert!(found.is_infinite(), "case {case}: {found}");
        } else {
            assert!(found <= stepped + 1e-9, "case {case}: {found} over {stepped}");
            assert!(found >= stepped - slack, "case {case}: {found} under {stepped}");
            near += u32::from(found > 0.0);
        }
    }
    assert!(near > 80, "only {near} paths kept clear of everything");
}
