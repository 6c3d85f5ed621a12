//! Cylinders as cells: exactly the cells that a cylinder covers are solid.

use inbye::experiment::barn::{
    Course, Cylinder, TRUTH_RESOLUTION_M, barn_config, empty_map, truth,
};
use inbye::geometry::{Point, Pose};
use inbye::map::{Cell, ObstacleGrid};

use super::Test;

pub const TESTS: &[Test] = &[
    ("a cell is occupied where a cylinder covers any part of it", exact),
    ("a cylinder of the wrong size on the grid is detected", faults),
    ("the grid has free space around the cylinders and both ends", room),
    ("the robot's discs cover its footprint closely", discs_cover_the_footprint),
];

/// Checks the cells of a cylinder point by point; returns what is wrong with them.
fn fault(grid: &ObstacleGrid, cylinder: &Cylinder) -> Option<String> {
    let axis = Point::new(cylinder.x_m, cylinder.y_m);
    let frame = grid.frame();
    // Points all over the disc and just inside its edge must be solid.
    for turn in 0..720 {
        let (sin, cos) = libm::sincos((f64::from(turn) * 0.5).to_radians());
        for share in [0.0, 0.3, 0.7, 0.999_999] {
            let reach = cylinder.radius_m * share;
            let point = Point::new(axis.x + reach * cos, axis.y + reach * sin);
            if !frame.cell_of(&point).is_some_and(|cell| grid.is_blocked(cell)) {
                return Some(format!("{point:?} of the cylinder is free"));
            }
        }
    }
    // Some point of each solid cell must be within the disc. The nearest point of a fine lattice on the cell is off by
    // less than the lattice's spacing.
    let pieces = 50;
    for index in 0..frame.len() {
        let cell = frame.cell_at(index);
        if !grid.is_blocked(cell) {
            continue;
        }
        let corner = |column: i32, row: i32| {
            let (x, y) = (f64::from(column), f64::from(row));
            let pieces = f64::from(pieces);
            frame.from_cell_units(&Point::new(
                f64::from(cell.column) + x / pieces,
                f64::from(cell.row) + y / pieces,
            ))
        };
        let lattice = (0..=pieces).flat_map(|row| (0..=pieces).map(move |column| (column, row)));
        let nearest_m = lattice
            .map(|(column, row)| (corner(column, row) - axis).norm())
            .fold(f64::INFINITY, f64::min);
        if nearest_m > cylinder.radius_m + frame.resolution_m / f64::from(pieces) {
            return Some(format!("{cell:?} is {nearest_m} m from the axis"));
        }
    }
    None
}

fn cylinders() -> impl Iterator<Item = Cylinder> {
    // Positions on the benchmark's lattice, and arbitrary offsets within a cell.
    let offsets = [0.0, 0.075, 0.001, 0.004_999, 0.005, 0.009_3];
    offsets.into_iter().flat_map(move |x| {
        offsets.into_iter().flat_map(move |y| {
            [0.075, 0.02, 0.003].map(|radius_m| Cylinder { x_m: x - 2.0, y_m: y + 7.0, radius_m })
        })
    })
}

fn exact() {
    for cylinder in cylinders() {
        let grid = truth(&[cylinder], &Course::BARN).expect("a small world");
        assert_eq!(fault(&grid, &cylinder), None, "{cylinder:?}");
    }
}

fn faults() {
    let cylinder = Cylinder { x_m: -2.0, y_m: 7.0, radius_m: 0.075 };
    for off_m in [-TRUTH_RESOLUTION_M, 2.0 * TRUTH_RESOLUTION_M] {
        let drawn = Cylinder { radius_m: cylinder.radius_m + off_m, ..cylinder };
        let grid = truth(&[drawn], &Course::BARN).expect("a small world");
        assert!(fault(&grid, &cylinder).is_some(), "{off_m} m were not seen");
    }
}

fn room() {
    let far = Cylinder { x_m: 6.0, y_m: -1.0, radius_m: 0.5 };
    let grid = truth(&[far], &Course::BARN).expect("a small world");
    let map = empty_map(&[far], &Course::BARN).expect("as above");
    assert!(map.cells().iter().all(|&cell| cell == 0));
    let [start, goal] = [Course::BARN.start.position(), Course::BARN.goal];
    for frame in [grid.frame(), map.frame()] {
        for end in [start, goal, Point::new(far.x_m + 0.5, far.y_m - 0.5)] {
            for offset in [[2.9, 0.0], [-2.9, 0.0], [0.0, 2.9], [0.0, -2.9]] {
                let place = Point::new(end.x + offset[0], end.y + offset[1]);
                assert!(frame.cell_of(&place).is_some(), "{place:?}");
            }
        }
    }
    assert!(grid.is_blocked(Cell::new(-1, 0)), "the border is solid");
}

fn discs_cover_the_footprint() {
    let footprint = barn_config(2.0).robot.footprint;
    for step_x in 0..=84 {
        for step_y in 0..=66 {
            let (x, y) = (f64::from(step_x) * 0.005, f64::from(step_y) * 0.005);
            let point = Point::new(x - 0.21, y - 0.165);
            let gap_m = footprint.gap_to_disc_m(&Pose::default(), &point, 0.0);
            assert!(gap_m <= 1e-12, "{point:?} is {gap_m} m outside");
        }
    }
    assert!(footprint.circumscribed_radius_m() < libm::hypot(0.21, 0.165) + 0.001);
}
