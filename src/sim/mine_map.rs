//! Builds maps of mine workings.

use crate::geometry::{Point, Pose, bearing, nearest_on_segment};
use crate::map::{Cell, GridFrame, OccupancyGrid};

/// Side of a cell, metres.
const RESOLUTION_M: f64 = 0.05;

/// Coarse and fine roughness of the walls: size and height of the bumps, metres.
const ROUGHNESS_M: [(f64, f64); 2] = [(1.1, 0.16), (0.3, 0.07)];

const FREE: i8 = 0;
const OCCUPIED: i8 = 100;

/// Builds a map by cutting workings out of solid rock. Coordinates are in metres from the lower-left corner.
pub(super) struct MineMapBuilder {
    frame: GridFrame,
    cells: Vec<i8>,
    seed: u64,
}

impl MineMapBuilder {
    /// Starts with solid rock. The seed determines the roughness of the walls.
    pub(super) fn solid(width_m: f64, height_m: f64, seed: u64) -> Self {
        let frame = GridFrame {
            width: (width_m / RESOLUTION_M).round() as i32,
            height: (height_m / RESOLUTION_M).round() as i32,
            resolution_m: RESOLUTION_M,
            origin: Pose::default(),
        };
        Self { frame, cells: vec![OCCUPIED; frame.len()], seed }
    }

    /// Cuts a roadway along a polyline, with round ends and walls that are rough by at most 0.23 m.
    pub(super) fn roadway(&mut self, width_m: f64, line: &[[f64; 2]]) {
        for leg in line.windows(2) {
            let (from, to) = (Point::from(leg[0]), Point::from(leg[1]));
            for index in 0..self.cells.len() {
                let center = self.frame.center_of(self.frame.cell_at(index));
                let reach = width_m / 2.0 + self.roughness(&center);
                if (center - nearest_on_segment(&from, &to, &center)).norm() < reach {
                    self.cells[index] = FREE;
                }
            }
        }
    }

    /// Adds a machine: a box with a heading, radians.
    pub(super) fn machine(
        &mut self,
        center: [f64; 2],
        heading_rad: f64,
        length_m: f64,
        width_m: f64,
    ) {
        let place = Pose::new(center[0], center[1], heading_rad);
        self.fill(|point| {
            let own = place.inverse_transform(point);
            own.x.abs() <= length_m / 2.0 && own.y.abs() <= width_m / 2.0
        });
    }

    /// Adds a heap of broken rock.
    pub(super) fn heap(&mut self, center: [f64; 2], radius_m: f64) {
        let center = Point::from(center);
        let seed = self.seed;
        self.fill(|point| {
            (point - center).norm() < radius_m + 0.2 * radius_m * noise(point, 0.25, seed ^ 1)
        });
    }

    /// Adds square props with sides of 0.2 m along a line, at equal distances of about `spacing_m`.
    pub(super) fn props(&mut self, from: [f64; 2], to: [f64; 2], spacing_m: f64) {
        let (from, to) = (Point::from(from), Point::from(to));
        let count = ((to - from).norm() / spacing_m).round().max(1.0);
        for prop in 0..=count as usize {
            let center = from + (to - from) * (prop as f64 / count);
            self.machine([center.x, center.y], bearing(&from, &to), 0.2, 0.2);
        }
    }

    /// Returns the map.
    pub(super) fn build(self) -> OccupancyGrid {
        OccupancyGrid::new(self.frame, self.cells)
    }

    fn fill(&mut self, inside: impl Fn(&Point) -> bool) {
        for index in 0..self.cells.len() {
            let cell: Cell = self.frame.cell_at(index);
            if inside(&self.frame.center_of(cell)) {
                self.cells[index] = OCCUPIED;
            }
        }
    }

    /// Offset of the wall from its nominal line, metres, outwards positive.
    fn roughness(&self, point: &Point) -> f64 {
        ROUGHNESS_M
            .iter()
            .zip(self.seed..)
            .map(|(&(size, height), seed)| height * noise(point, size, seed))
            .sum()
    }
}

/// Value noise from -1 to 1 on a lattice with a pitch in metres.
fn noise(point: &Point, size_m: f64, seed: u64) -> f64 {
    let (x, y) = (point.x / size_m, point.y / size_m);
    let (column, row) = (x.floor(), y.floor());
    let blend = |at: f64| at * at * (3.0 - 2.0 * at);
    let (right, up) = (blend(x - column), blend(y - row));
    let value = |dx: i64, dy: i64| lattice(column as i64 + dx, row as i64 + dy, seed);
    let low = value(0, 0) + (value(1, 0) - value(0, 0)) * right;
    let high = value(0, 1) + (value(1, 1) - value(0, 1)) * right;
    low + (high - low) * up
}

/// Pseudo-random value from -1 to 1 of a lattice point: coordinates and seed through the finalizer of Steele, Lea and
/// Flood's `SplitMix64` (2014).
fn lattice(column: i64, row: i64, seed: u64) -> f64 {
    let mut bits = seed;
    for part in [column, row] {
        bits = (bits ^ part as u64).wrapping_add(0x9E37_79B9_7F4A_7C15);
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        bits ^= bits >> 31;
    }
    // A double has 53 significant bits.
    (bits >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}
