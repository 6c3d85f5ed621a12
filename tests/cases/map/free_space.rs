//! Free space: obstacles dilated by an exact distance.

use inbye::geometry::Pose;
use inbye::map::{Cell, FreeSpace, GridFrame, ObstacleGrid};

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
                let near = chosen.iter().any(|&other| gap(other) < distance);
                let expected = !near && !chosen.contains(&index);
                assert_eq!(space.is_free(cell), expected, "{cell:?} at {distance}");
            }
        }
    }
}

#[test]
fn dilation_by_nan_leaves_no_free_cell() {
    assert_eq!(free_space(70, 3, &[], f64::NAN).count(), 0);
    assert_eq!(free_space(70, 3, &[], 1e9).count(), 210);
}
