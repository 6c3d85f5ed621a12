//! Clearance costs: the paper's safety distance (section 3.1) as a soft preference.

use crate::geometry::Point;
use crate::map::{Cell, DistanceField, GridFrame, ObstacleGrid};

/// Additional cost of cells near obstacles, one byte per cell.
///
/// Below the preferred clearance `D`, a metre at clearance `d` costs as much as `1 + weight (1 - d / D)` metres of open
/// space, in sixteenths, rounded down. `d` is the distance between the cell's centre and the nearest obstacle cell's, less
/// half a cell.
#[derive(Clone, Debug, PartialEq)]
pub struct ClearanceCosts {
    frame: GridFrame,
    /// Additional cost of each cell, in sixteenths.
    extra: Vec<u8>,
}

/// Largest weight that fits in a byte of sixteenths, rounded down.
pub(crate) const MAX_CLEARANCE_WEIGHT: f64 = 15.0;

/// Units of cost per open cell.
const PARTS: u64 = 16;

impl ClearanceCosts {
    /// Computes the costs for a preferred clearance in metres, above zero, and a weight. The weight is clamped to 0 to 15.
    #[must_use]
    pub fn new(obstacles: &ObstacleGrid, preferred_m: f64, weight: f64) -> Self {
        let frame = *obstacles.frame();
        let field = DistanceField::new(obstacles);
        let full = weight.clamp(0.0, MAX_CLEARANCE_WEIGHT) * PARTS as f64;
        let extra = |cell| {
            let clearance_m = field.distance_m(cell) - frame.resolution_m / 2.0;
            (full * (1.0 - clearance_m.max(0.0) / preferred_m)).max(0.0) as u8
        };
        Self { frame, extra: frame.cells().map(extra).collect() }
    }

    /// The cost, including clearance, of a move with a base cost to the cell at an index.
    #[inline]
    pub(super) fn price(&self, index: usize, cost: u64) -> u64 {
        cost + cost * u64::from(self.extra[index]) / PARTS
    }

    /// The equivalent length, in cells of open space, of a straight segment. Both ends are in cell units, inside the grid.
    pub(super) fn equivalent_length(&self, from: &Point, to: &Point) -> f64 {
        let whole = to - from;
        let length = whole.norm();
        let (from, whole): ([f64; 2], [f64; 2]) = ((*from).into(), whole.into());
        let mut costs = 0.0;
        let mut entered = 0.0;
        let mut cell = from.map(f64::floor);
        while entered < 1.0 {
            // The fraction of the segment at which it leaves the cell along each axis.
            let leaves = [0, 1].map(|axis| {
                let line = cell[axis] + if whole[axis] > 0.0 { 1.0 } else { 0.0 };
                if whole[axis] == 0.0 { f64::INFINITY } else { (line - from[axis]) / whole[axis] }
            });
            let axis = usize::from(leaves[1] < leaves[0]);
            let left = leaves[axis].clamp(entered, 1.0);
            costs += (left - entered) * self.factor(&cell);
            cell[axis] += whole[axis].signum();
            entered = if leaves[axis] >= 1.0 { 1.0 } else { left };
        }
        costs * length
    }

    /// The cost factor of a cell; outside the grid, that of the nearest cell.
    fn factor(&self, [x, y]: &[f64; 2]) -> f64 {
        let inside = |at: f64, side: i32| (at as i32).clamp(0, side - 1);
        let cell = Cell::new(inside(*x, self.frame.width), inside(*y, self.frame.height));
        1.0 + f64::from(self.extra[self.frame.index(cell)]) / PARTS as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::map::{OccupancyGrid, UnknownPolicy};

    fn costs(rows: &[&str], preferred_m: f64, weight: f64) -> ClearanceCosts {
        let map = OccupancyGrid::from_rows(rows, 0.5, Pose::default()).expect("rows of text");
        ClearanceCosts::new(&map.obstacles(UnknownPolicy::Blocked), preferred_m, weight)
    }

    #[test]
    fn clearance_costs_decrease_with_distance() {
        let costs = costs(&["#........"], 2.0, 3.0);
        // Clearances of 0, 0.25, 0.75, 1.25, 1.75 and 2.25 m; the maximum is 48 sixteenths.
        assert_eq!(costs.extra[..6], [48, 42, 30, 18, 6, 0]);
        assert_eq!(costs.price(1, 1600), 1600 + 4200);
    }

    #[test]
    fn equivalent_length_equals_the_sampled_sum() {
        let costs = costs(&["......", "#....."], 2.0, 15.0);
        let ends = [(5.3, 1.9), (1.1, 0.2), (1.0, 1.0), (3.0, 0.0), (2.5, 1.5), (2.5, 0.5)];
        let points = ends.map(|(x, y)| Point::new(x, y));
        for from in &points {
            for to in &points {
                let steps = 100_000;
                let at =
                    |step: i32| from + (to - from) * ((f64::from(step) + 0.5) / f64::from(steps));
                let factors = (0..steps).map(|step| costs.factor(&[at(step).x, at(step).y]));
                let expected = factors.sum::<f64>() / f64::from(steps) * (to - from).norm();
                let found = costs.equivalent_length(from, to);
                assert!(
                    (found - expected).abs() < 1e-3,
                    "{from:?} to {to:?}: {found}, not {expected}"
                );
            }
        }
    }
}
