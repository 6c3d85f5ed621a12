//! Random grids and random cells.

use core::f64::consts::TAU;

use inbye::geometry::Pose;
use inbye::map::{Cell, GridFrame, ObstacleGrid};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

/// Cell sizes, metres, including that of a survey of a real mine.
const RESOLUTIONS_M: [f64; 5] = [0.05, 0.1, 0.1254, 0.5, 1.0];

/// A grid of up to `most_side` cells per side, at a random pose, with scattered obstacle cells or blocks.
pub fn obstacles(random: &mut Pcg64Mcg, most_side: i32) -> ObstacleGrid {
    let origin = match random.random_range(0..3) {
        0 => Pose::default(),
        1 => Pose::new(-3.7, 12.2, 0.0),
        _ => Pose::new(
            random.random_range(-500.0..500.0),
            random.random_range(-500.0..500.0),
            random.random_range(0.0..TAU),
        ),
    };
    let frame = GridFrame {
        width: random.random_range(2..=most_side),
        height: random.random_range(2..=most_side),
        resolution_m: RESOLUTIONS_M[random.random_range(0..RESOLUTIONS_M.len())],
        origin,
    };
    let mut obstacles = ObstacleGrid::filled(frame, false);
    if random.random_bool(0.5) {
        let share = random.random_range(0.0..0.35);
        for index in 0..frame.len() {
            let cell = frame.cell_at(index);
            obstacles.set(cell, random.random_bool(share));
        }
    } else {
        for _ in 0..random.random_range(0..frame.len() / 40 + 2) {
            let corner = cell(random, &frame);
            let (width, height) = (random.random_range(1..6), random.random_range(1..6));
            for column in corner.column..corner.column + width {
                for row in corner.row..corner.row + height {
                    obstacles.set(Cell::new(column, row), true);
                }
            }
        }
    }
    obstacles
}

/// A random cell of a grid.
pub fn cell(random: &mut Pcg64Mcg, frame: &GridFrame) -> Cell {
    Cell::new(random.random_range(0..frame.width), random.random_range(0..frame.height))
}
