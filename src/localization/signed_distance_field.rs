//! The surface of the map's walls: how far a point lies outside or inside of it, between the cells as well.

use crate::geometry::Pose;
use crate::map::{DistanceField, GridFrame, ObstacleGrid};

/// Steps of a stored distance in one cell.
const STEPS: f64 = 256.0;

/// The longest stored distance, cells: the longest that fits.
const FARTHEST: f64 = 127.0;

/// Signed distance to the walls' surface, positive in the open.
///
/// The exact distance field is that between cells' centres. A wall begins half a cell before the centre of its first cell, and the
/// last open centre is half a cell before that: so half a cell is taken off the distance of an open cell to the nearest wall, and
/// half a cell off the depth of a wall's cell below the nearest open one. Between a cell of each kind the value then crosses zero
/// where the two squares touch, with slope one on both sides, and a beam that ends on the surface has nor bias nor a kink.
#[derive(Clone, Debug)]
pub(super) struct SignedDistanceField {
    frame: GridFrame,
    /// In 1/256 of a cell, row-major, lowest row first.
    signed: Vec<i16>,
}

/// The distance at a place and how it changes along both axes of the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Level {
    /// Metres.
    pub distance_m: f64,
    /// Without unit.
    pub slope: [f64; 2],
}

impl SignedDistanceField {
    pub fn new(obstacles: &ObstacleGrid) -> Self {
        let frame = *obstacles.frame();
        let width = frame.width as usize;
        let mut signed = vec![0; frame.len()];
        let stored = |squared: u32| {
            let cells = (f64::from(squared).sqrt() - 0.5).clamp(-0.5, FARTHEST);
            (cells * STEPS).round() as i16
        };
        DistanceField::for_each_row(obstacles, |row, squared| {
            for (out, &squared) in signed[row * width..].iter_mut().zip(squared) {
                *out = stored(squared);
            }
        });
        let open = obstacles.cells().iter().map(|blocked| !blocked).collect();
        DistanceField::for_each_row(&ObstacleGrid::new(frame, open), |row, squared| {
            for (out, &squared) in signed[row * width..].iter_mut().zip(squared) {
                // An open cell is at zero distance from itself.
                if squared > 0 {
                    *out = -stored(squared);
                }
            }
        });
        Self { frame, signed }
    }

    pub const fn resolution_m(&self) -> f64 {
        self.frame.resolution_m
    }

    /// The pose of the map frame in that of the grid: axes along the cells, metres from the grid's corner.
    pub fn in_grid(&self, pose: &Pose) -> Pose {
        self.frame.origin.inverse_transform_pose(pose)
    }

    /// The inverse of [`Self::in_grid`].
    pub fn in_map(&self, pose: &Pose) -> Pose {
        self.frame.origin.transform_pose(pose)
    }

    /// Yaw of the grid in the map frame, radians.
    pub const fn grid_yaw(&self) -> f64 {
        self.frame.origin.yaw
    }

    /// The level at a point of the grid's frame, metres, blended between the four nearest cells; none where one of them lies off
    /// the map, or for a point that is not finite.
    #[inline]
    pub fn level(&self, x: f64, y: f64) -> Option<Level> {
        let resolution = self.frame.resolution_m;
        let (column, row) = (x / resolution - 0.5, y / resolution - 0.5);
        let (left, low) = (column.floor(), row.floor());
        let inside = left >= 0.0
            && low >= 0.0
            && left < f64::from(self.frame.width - 1)
            && low < f64::from(self.frame.height - 1);
        if !inside {
            return None;
        }
        let (along, up) = (column - left, row - low);
        let width = self.frame.width as usize;
        let corner = low as usize * width + left as usize;
        let at = |index: usize| f64::from(self.signed[index]);
        let (a, b) = (at(corner), at(corner + 1));
        let (c, d) = (at(corner + width), at(corner + width + 1));
        let (lower, upper) = (a + (b - a) * along, c + (d - c) * along);
        Some(Level {
            distance_m: (lower + (upper - lower) * up) / STEPS * resolution,
            slope: [
                ((b - a) * (1.0 - up) + (d - c) * up) / STEPS,
                (upper - lower) / STEPS,
            ],
        })
    }

    /// The distance at the cell of a point, metres, without blending: quick, and off by up to a cell.
    #[inline]
    pub fn rough_m(&self, x: f64, y: f64) -> Option<f64> {
        let resolution = self.frame.resolution_m;
        let (column, row) = (x / resolution, y / resolution);
        let inside = column >= 0.0
            && row >= 0.0
            && column < f64::from(self.frame.width)
            && row < f64::from(self.frame.height);
        let index = || row as usize * self.frame.width as usize + column as usize;
        inside.then(|| f64::from(self.signed[index()]) / STEPS * resolution)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::Cell;

    /// Open ground from 1 m to 3 m along both axes, walls about it, in cells of 0.1 m.
    fn room(origin: Pose) -> SignedDistanceField {
        let frame = GridFrame {
            width: 40,
            height: 40,
            resolution_m: 0.1,
            origin,
        };
        let mut obstacles = ObstacleGrid::new(frame, vec![true; frame.len()]);
        for row in 10..30 {
            for column in 10..30 {
                obstacles.set(Cell::new(column, row), false);
            }
        }
        SignedDistanceField::new(&obstacles)
    }

    #[test]
    fn the_surface_is_where_the_squares_touch() {
        let walls = room(Pose::default());
        for (x, expected) in [
            (1.0, 0.0),
            (1.03, 0.03),
            (0.97, -0.03),
            (1.5, 0.5),
            (0.8, -0.2),
            (2.98, 0.02),
            (3.1, -0.1),
        ] {
            let level = walls.level(x, 2.0).expect("on the map");
            assert!((level.distance_m - expected).abs() < 1e-3, "{x}: {level:?}");
            let outward = if x < 2.0 { 1.0 } else { -1.0 };
            assert!((level.slope[0] - outward).abs() < 1e-2, "{x}: {level:?}");
            assert!(level.slope[1].abs() < 1e-9);
        }
        assert_eq!(walls.level(0.01, 2.0), None);
        assert_eq!(walls.level(f64::NAN, 2.0), None);
        assert_eq!(walls.rough_m(-0.01, 2.0), None);
        assert!((walls.rough_m(1.05, 2.0).expect("on the map") - 0.05).abs() < 1e-3);
    }

    #[test]
    fn a_map_that_lies_turned_gives_poses_back() {
        let walls = room(Pose::new(5.0, -3.0, 0.7));
        let pose = Pose::new(6.0, -1.0, 3.0);
        let back = walls.in_map(&walls.in_grid(&pose));
        assert!((back.position() - pose.position()).norm() < 1e-12);
        assert!((back.yaw - pose.yaw).abs() < 1e-12);
    }

    #[test]
    fn ground_without_walls_and_walls_without_ground_have_no_slope() {
        let frame = GridFrame {
            width: 9,
            height: 9,
            resolution_m: 0.1,
            origin: Pose::default(),
        };
        for blocked in [false, true] {
            let walls = SignedDistanceField::new(&ObstacleGrid::new(frame, vec![blocked; 81]));
            let level = walls.level(0.45, 0.45).expect("on the map");
            assert_eq!(level.slope, [0.0, 0.0]);
            assert!((level.distance_m > 1.0) != blocked, "{level:?}");
        }
    }
}
