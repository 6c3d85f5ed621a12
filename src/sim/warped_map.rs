//! A world whose walls are not exactly where the map shows them.

use core::f64::consts::{SQRT_2, TAU};

use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::{RngStream, generator};
use crate::map::{Cell, ObstacleGrid};

/// Shortest and longest wave of the displacement, metres: maps drift slowly, and bend at each loop that was closed.
const WAVE_M: core::ops::Range<f64> = 6.0..20.0;

/// Returns the obstacles of the world that a map shows with smooth errors up to a distance, metres. A wall is displaced, and so
/// are the widths of roadways. The border of the grid stays.
pub(super) fn warped(map: &ObstacleGrid, error_m: f64, seed: u64) -> ObstacleGrid {
    let frame = *map.frame();
    let mut rng = generator(seed, RngStream::Map);
    let (columns, rows) = (frame.width, frame.height);
    let mut axis = || {
        let (along_x, along_y) =
            (wave(&mut rng, columns, frame.resolution_m), wave(&mut rng, rows, frame.resolution_m));
        (along_x, along_y)
    };
    let (right, up) = (axis(), axis());
    // Each axis has the mean of two waves.
    let amplitude = error_m / SQRT_2 / frame.resolution_m / 2.0;
    let displaced = |cell: i32, cells: i32, [one, other]: [f64; 2]| {
        let shift = (amplitude * (one + other)).round() as i32;
        (cell + shift).clamp(0, cells - 1)
    };
    let mut blocked = Vec::with_capacity(frame.len());
    for row in 0..rows {
        for column in 0..columns {
            let at = |(along_x, along_y): &(Vec<f64>, Vec<f64>)| {
                [along_x[column as usize], along_y[row as usize]]
            };
            let source =
                Cell::new(displaced(column, columns, at(&right)), displaced(row, rows, at(&up)));
            let on_border = column == 0 || row == 0 || column == columns - 1 || row == rows - 1;
            let source = if on_border { Cell::new(column, row) } else { source };
            blocked.push(map.is_blocked(source));
        }
    }
    ObstacleGrid::new(frame, blocked)
}

/// The values of a random sine wave, -1 to 1, at this many cells.
fn wave(rng: &mut Pcg64Mcg, cells: i32, resolution_m: f64) -> Vec<f64> {
    let (length_m, phase) = (rng.random_range(WAVE_M), rng.random_range(0.0..TAU));
    let step = TAU * resolution_m / length_m;
    (0..cells).map(|cell| libm::sin(phase + step * f64::from(cell))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::map::{DistanceField, GridFrame};

    /// A roadway of 20 by 3 m with cells of 5 cm.
    fn roadway() -> ObstacleGrid {
        let frame = GridFrame::new(400, 100, 0.05, Pose::default()).expect("a valid size");
        ObstacleGrid::from_fn(frame, |Cell { column, row }| {
            !(20..80).contains(&row) || !(5..395).contains(&column)
        })
    }

    #[test]
    fn walls_are_displaced_by_at_most_the_error() {
        let map = roadway();
        let near_wall = DistanceField::new(&map);
        for (seed, error_m) in [(1, 0.1), (2, 0.2), (3, 0.05)] {
            let world = warped(&map, error_m, seed);
            let changed: Vec<usize> = (0..map.frame().len())
                .filter(|&index| map.cells()[index] != world.cells()[index])
                .collect();
            assert!(!changed.is_empty(), "{seed}");
            let is_far = |&&index: &&usize| {
                let cell = map.frame().cell_at(index);
                !map.is_blocked(cell) && near_wall.distance_m(cell) > error_m + 0.1
            };
            let far = changed.iter().filter(is_far);
            assert_eq!(far.count(), 0, "{seed}");
            assert_eq!(world, warped(&map, error_m, seed), "the same seed gives the same world");
        }
        assert_ne!(warped(&map, 0.1, 1), warped(&map, 0.1, 2));
        assert_eq!(warped(&map, 0.0, 1), map);
    }
}
