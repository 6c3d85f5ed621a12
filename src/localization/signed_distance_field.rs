//! Signed distance to the mapped obstacle surfaces, with subcell interpolation.

use crate::geometry::Pose;
use crate::map::{DistanceField, GridFrame, ObstacleGrid};

/// Steps of a stored distance per cell.
const STEPS_PER_CELL: f64 = 256.0;

/// Largest stored distance, cells, limited by the integer type.
const MAX_CELLS: f64 = 127.0;

/// Signed distance to the obstacle surface, positive in free space.
///
/// The exact distance field measures between cell centres, but an obstacle's surface is half a cell before the centre of its
/// first cell. Half a cell is therefore subtracted from the distance of a free cell to the nearest obstacle cell, and from
/// the depth of an obstacle cell below the nearest free one. Between a free and an obstacle cell the value crosses zero at
/// the common edge with slope one on both sides, so a beam that ends on the surface has no bias and a smooth gradient.
#[derive(Clone, Debug)]
pub(crate) struct SignedDistanceField {
    pub frame: GridFrame,
    /// In 1/256 of a cell, row-major, lowest row first.
    signed: Vec<i16>,
}

/// The interpolated field at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DistanceSample {
    /// Signed distance, metres.
    pub distance_m: f64,
    /// Gradient along both axes of the grid, without unit.
    pub gradient: [f64; 2],
}

impl SignedDistanceField {
    pub fn new(obstacles: &ObstacleGrid) -> Self {
        let frame = *obstacles.frame();
        let width = frame.width as usize;
        let mut signed = vec![0; frame.len()];
        let stored = |squared: u32| {
            let cells = (f64::from(squared).sqrt() - 0.5).clamp(-0.5, MAX_CELLS);
            (cells * STEPS_PER_CELL).round() as i16
        };
        for (grid, sign) in [(obstacles, 1), (&obstacles.map(|blocked| !blocked), -1)] {
            DistanceField::for_each_row(grid, |row, squared| {
                for (out, &squared) in signed[row * width..].iter_mut().zip(squared) {
                    // A blocked cell of a grid has distance zero to itself, and its value comes from the other grid.
                    if squared > 0 {
                        *out = sign * stored(squared);
                    }
                }
            });
        }
        Self { frame, signed }
    }

    /// Converts a pose from the map frame to the grid's frame, whose axes lie along the cells, in metres from the corner.
    pub fn to_grid(&self, pose: &Pose) -> Pose {
        self.frame.origin.inverse_transform_pose(pose)
    }

    /// Converts a pose from the grid's frame to the map frame.
    pub fn to_map(&self, pose: &Pose) -> Pose {
        self.frame.origin.transform_pose(pose)
    }

    /// The field at a point of the grid's frame, metres, by bilinear interpolation of the four nearest cells. None if one of
    /// them is outside the map or the point is not finite.
    #[inline]
    pub fn sample(&self, x: f64, y: f64) -> Option<DistanceSample> {
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
        Some(DistanceSample {
            distance_m: (lower + (upper - lower) * up) / STEPS_PER_CELL * resolution,
            gradient: [
                ((b - a) * (1.0 - up) + (d - c) * up) / STEPS_PER_CELL,
                (upper - lower) / STEPS_PER_CELL,
            ],
        })
    }

    /// The distance of the cell with this index, metres.
    #[inline]
    pub fn of_cell_m(&self, index: usize) -> f64 {
        f64::from(self.signed[index]) / STEPS_PER_CELL * self.frame.resolution_m
    }

    /// Whether the cell with this index is an obstacle of the map.
    #[inline]
    pub fn is_mapped(&self, index: usize) -> bool {
        self.signed[index] < 0
    }

    /// The number of whole cells up to a finite coordinate of the grid's frame, metres: a column or a row.
    #[inline]
    pub fn cells_to(&self, coordinate: f64) -> i32 {
        let cells = coordinate / self.frame.resolution_m;
        // As `floor`, which is a function call on processors without an instruction for it.
        let whole = cells as i32;
        whole - i32::from(cells < f64::from(whole))
    }

    /// The distance of a cell, metres; none outside the map.
    #[inline]
    pub fn distance_in_cell_m(&self, column: i32, row: i32) -> Option<f64> {
        let inside =
            (column as u32) < self.frame.width as u32 && (row as u32) < self.frame.height as u32;
        inside.then(|| self.of_cell_m(row as usize * self.frame.width as usize + column as usize))
    }

    /// The distance of the cell at a finite point, metres, without interpolation: faster, with an error of up to a cell.
    #[inline]
    pub fn cell_distance_m(&self, x: f64, y: f64) -> Option<f64> {
        self.distance_in_cell_m(self.cells_to(x), self.cells_to(y))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::Cell;

    /// Free space from 1 m to 3 m along both axes, surrounded by obstacles, in cells of 0.1 m.
    fn room(origin: Pose) -> SignedDistanceField {
        let frame = GridFrame { width: 40, height: 40, resolution_m: 0.1, origin };
        let mut obstacles = ObstacleGrid::filled(frame, true);
        for row in 10..30 {
            for column in 10..30 {
                obstacles.set(Cell::new(column, row), false);
            }
        }
        SignedDistanceField::new(&obstacles)
    }

    #[test]
    fn signed_distance_is_zero_on_cell_edges() {
        let field = room(Pose::default());
        for (x, expected) in [
            (1.0, 0.0),
            (1.03, 0.03),
            (0.97, -0.03),
            (1.5, 0.5),
            (0.8, -0.2),
            (2.98, 0.02),
            (3.1, -0.1),
        ] {
            let sample = field.sample(x, 2.0).expect("on the map");
            assert!((sample.distance_m - expected).abs() < 1e-3, "{x}: {sample:?}");
            let outward = if x < 2.0 { 1.0 } else { -1.0 };
            assert!((sample.gradient[0] - outward).abs() < 1e-2, "{x}: {sample:?}");
            assert!(sample.gradient[1].abs() < 1e-9);
        }
        assert_eq!(field.sample(0.01, 2.0), None);
        assert_eq!(field.sample(f64::NAN, 2.0), None);
        assert_eq!(field.cell_distance_m(-0.01, 2.0), None);
        assert!((field.cell_distance_m(1.05, 2.0).expect("on the map") - 0.05).abs() < 1e-3);
    }

    #[test]
    fn grid_pose_round_trips_on_a_rotated_map() {
        let field = room(Pose::new(5.0, -3.0, 0.7));
        let pose = Pose::new(6.0, -1.0, 3.0);
        let back = field.to_map(&field.to_grid(&pose));
        assert!((back.position() - pose.position()).norm() < 1e-12);
        assert!((back.yaw - pose.yaw).abs() < 1e-12);
    }

    #[test]
    fn signed_distance_is_flat_without_surfaces() {
        let frame = GridFrame { width: 9, height: 9, resolution_m: 0.1, origin: Pose::default() };
        for blocked in [false, true] {
            let field = SignedDistanceField::new(&ObstacleGrid::new(frame, vec![blocked; 81]));
            let sample = field.sample(0.45, 0.45).expect("on the map");
            assert_eq!(sample.gradient, [0.0, 0.0]);
            assert!((sample.distance_m > 1.0) != blocked, "{sample:?}");
        }
    }
}
