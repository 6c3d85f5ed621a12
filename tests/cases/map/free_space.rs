//! Free space: obstacles dilated by an exact distance.

use inbye::geometry::{Point, Pose};
use inbye::map::{Cell, FreeSpace, GridFrame, ObstacleGrid};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// The free space among some obstacle cells, in cells of one metre.
fn free_space(width: i32, height: i32, obstacles: &[i32], radius_m: f64) -> FreeSpace {
    let frame = GridFrame { width, height, resolution_m: 1.0, origin: Pose::default() };
    let blocked = (0..width * height).map(|index| obstacles.contains(&index)).collect();
    FreeSpace::new(&ObstacleGrid::new(frame, blocked), radius_m)
}

#[test]
fn dilation_includes_exactly_the_cells_below_the_distance() {
    for (width, height) in [(40, 30), (129, 5), (3, 90), (64, 9)] {
        let chosen = [3, 77, width * height / 2, width * height - 1];
        for distance in [-1.0, 0.0, 0.3, 1.0, 1.5, 2.0, 3.7, 5.0, 31.0, 1e3, f64::INFINITY] {
            let space = free_space(width, height, &chosen, distance);
            for index in 0..width * height {
                let cell = Cell::new(index % width, index / width);
                let gap = |other: i32| {
                    let apart = |one: i32, other: i32| f64::from(((one - other).abs() - 1).max(0));
                    libm::hypot(apart(cell.column, other % width), apart(cell.row, other / width))
                };
                let to_sides = [(cell.column, width), (cell.row, height)];
                let to_edge = to_sides.into_iter().map(|(at, size)| at.min(size - 1 - at)).min();
                let is_at_edge = to_edge.is_some_and(|to_edge| f64::from(to_edge) < distance);
                let near = is_at_edge || chosen.iter().any(|&other| gap(other) < distance);
                let expected = !near && !chosen.contains(&index);
                assert_eq!(space.is_free(cell), expected, "{cell:?} at {distance}");
            }
        }
    }
}

#[test]
fn dilation_by_nan_leaves_no_free_cell() {
    assert_eq!(free_space(70, 3, &[], f64::NAN).count(), 0);
    assert_eq!(free_space(70, 3, &[], 0.0).count(), 210);
}

/// The squared distance from such a point is the same for many cells, rounded.
#[test]
fn nearest_free_cell_of_a_far_point_is_beside_it() {
    let frame = GridFrame { width: 40, height: 30, resolution_m: 0.1, origin: Pose::default() };
    let space = FreeSpace::new(&ObstacleGrid::filled(frame, false), 0.0);
    for far in [1e7, 1e9, 1e12] {
        for (point, expected) in [
            (Point::new(far, 1.23), Cell::new(39, 12)),
            (Point::new(-far, 1.23), Cell::new(0, 12)),
            (Point::new(1.23, far), Cell::new(12, 29)),
            (Point::new(1.23, -far), Cell::new(12, 0)),
            (Point::new(far, far), Cell::new(39, 29)),
        ] {
            assert_eq!(space.nearest_free(&point), Some(expected), "{point:?}");
        }
    }
}

/// Points inside the grid, on the borders of cells, and outside; the nearest cell by a comparison of all.
#[test]
fn nearest_free_cell_is_that_of_all_cells() {
    let mut random = Pcg64Mcg::seed_from_u64(11);
    for (width, height) in [(40, 30), (129, 5), (3, 90), (64, 9), (1, 1)] {
        for share in [0.0, 0.5, 0.97, 1.0] {
            let frame = GridFrame { width, height, resolution_m: 1.0, origin: Pose::default() };
            let blocked = (0..frame.len()).map(|_| random.random_bool(share)).collect();
            let space = FreeSpace::new(&ObstacleGrid::new(frame, blocked), 0.0);
            for case in 0..60 {
                let mut place = |side: i32| {
                    let at = random.random_range(-20.0..f64::from(side) + 20.0);
                    if case % 3 == 0 { (2.0 * at).round() / 2.0 } else { at }
                };
                let point = Point::new(place(width), place(height));
                let squared = |cell: &Cell| (cell.center() - point).norm_squared();
                let free = (0..frame.len()).map(|index| frame.cell_at(index));
                let nearest = free
                    .filter(|cell| space.is_free(*cell))
                    .min_by(|one, other| squared(one).total_cmp(&squared(other)));
                assert_eq!(space.nearest_free(&point), nearest, "{point:?} of {width} x {height}");
            }
        }
    }
}
