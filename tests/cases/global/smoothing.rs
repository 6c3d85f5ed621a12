//! Smoothed paths: few points, no turns, sharp vertices only where there is no clearance.

use inbye::geometry::{Point, Pose};
use inbye::global::{Curvature, Path, is_clear, smooth};
use inbye::map::{Cell, FreeSpace, GridFrame, ObstacleGrid};

/// Free space of 40 m by 40 m in cells of 0.1 m, with rectangular obstacles: columns, rows.
fn ground(rock: &[[core::ops::Range<i32>; 2]]) -> FreeSpace {
    let frame = GridFrame { width: 400, height: 400, resolution_m: 0.1, origin: Pose::default() };
    let mut obstacles = ObstacleGrid::filled(frame, false);
    for [columns, rows] in rock {
        for column in columns.clone() {
            rows.clone().for_each(|row| obstacles.set(Cell::new(column, row), true));
        }
    }
    FreeSpace::new(&obstacles, 0.0)
}

fn zigzag() -> Path {
    let vertices = [(2.0, 2.0), (18.0, 2.0), (18.0, 18.0), (36.0, 20.0), (36.0, 38.0)];
    Path::new(vertices.map(|(x, y)| Point::new(x, y)).to_vec())
}

#[test]
fn smoothed_path_has_no_turns_and_few_points() {
    let space = ground(&[]);
    for degree in 2..=9 {
        let smoothed = smooth(&space, &zigzag(), degree).0;
        assert_eq!(smoothed.turns(), 0, "degree {degree}");
        assert!(smoothed.length_m() < 0.98 * zigzag().length_m(), "degree {degree}");
        assert!(smoothed.points().len() < 500, "{}", smoothed.points().len());
    }
}

#[test]
fn only_the_vertex_next_to_an_obstacle_is_tight() {
    let open = smooth(&ground(&[]), &zigzag(), 3).0;
    // An obstacle inside the first corner, one cell off the path.
    let space = ground(&[[100..178, 22..100]]);
    let smoothed = smooth(&space, &zigzag(), 3).0;
    assert!(smoothed.points().windows(2).all(|chord| is_clear(&space, &chord[0], &chord[1])));
    let off_m = |path: &Path, x, y| path.project(&Point::new(x, y)).distance_m;
    assert!(off_m(&smoothed, 18.0, 2.0) < 0.3, "tight at the obstacle");
    for (x, y) in [(18.0, 18.0), (36.0, 20.0)] {
        assert!((off_m(&smoothed, x, y) - off_m(&open, x, y)).abs() < 0.1, "wide at ({x}, {y})");
        assert!(off_m(&smoothed, x, y) > 1.0);
    }
}

#[test]
fn vertex_without_clearance_is_kept_sharp() {
    // Passages one cell wide; the path almost touches the obstacle inside the bend.
    let space = ground(&[[0..180, 21..400], [0..400, 0..20], [181..400, 0..400]]);
    let vertices = [(2.05, 2.0999), (18.0001, 2.0999), (18.0001, 18.05)];
    let path = Path::new(vertices.map(|(x, y)| Point::new(x, y)).to_vec());
    let smoothed = smooth(&space, &path, 3).0;
    assert!(smoothed.points().windows(2).all(|chord| is_clear(&space, &chord[0], &chord[1])));
    assert!(smoothed.project(&path.points()[1]).distance_m < 1e-9);
    let (_, spline) = smooth(&space, &path, 3);
    assert_eq!(Curvature::of([&spline]).sharp_turns, 1);
}

#[test]
fn spline_curvature_equals_that_of_its_chords() {
    for degree in [2, 3, 5] {
        let (smoothed, spline) = smooth(&ground(&[]), &zigzag(), degree);
        let curvature = Curvature::of([&spline]);
        assert_eq!(curvature.sharp_turns, 0);
        // Turn angle over mean chord length; on long chords this is an average.
        let by_chords = smoothed.points().windows(3).map(|triple| {
            let (one, other) = (triple[1] - triple[0], triple[2] - triple[1]);
            let turn_rad = libm::atan2(one.perp(&other), one.dot(&other)).abs();
            turn_rad / f64::midpoint(one.norm(), other.norm())
        });
        let ratio = by_chords.fold(0.0, f64::max) / curvature.max_per_m();
        assert!((0.9..1.01).contains(&ratio), "{ratio} at degree {degree}");
        let (straight, all) = (curvature.fraction_within(0.0), curvature.fraction_within(1e9));
        assert!(straight < 0.8 && all == 1.0, "{straight} at degree {degree}");
    }
}

#[test]
fn start_next_to_a_blocked_cell_keeps_other_vertices_smooth() {
    // The start lies on the border of the blocked cell, so only lines of sight within its own cell are clear.
    let space = ground(&[[9..10, 10..11]]);
    let corner = [(1.0, 1.05), (4.0, 1.05), (4.0, 6.0)].map(|(x, y)| Point::new(x, y));
    let path = Path::new(corner.to_vec());
    assert_eq!(smooth(&space, &path, 3).0, smooth(&ground(&[]), &path, 3).0);
}
