//! What stands around the robot: the map, and what the lidar saw that the map does not show.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::Observation;
use crate::geometry::{Point, bearing, wrap_angle};
use crate::local::{ClearanceField, ProblemError};
use crate::map::{Cell, GridFrame, ObstacleGrid};

/// A lidar return this close to a tracked moving obstacle is that obstacle, metres.
const TRACKED_MARGIN_M: f64 = 0.2;

/// Known obstacles and the marks the lidar made among them.
pub struct LocalMap {
    known: ObstacleGrid,
    /// Cells, by row-major index, that the lidar saw occupied and the map shows free. Ordered, so that everything
    /// computed from them is the same at every run.
    marks: BTreeSet<usize>,
}

impl LocalMap {
    /// A local map over the known obstacles, without marks.
    #[must_use]
    pub const fn new(known: ObstacleGrid) -> Self {
        Self {
            known,
            marks: BTreeSet::new(),
        }
    }

    /// Marks what a scan hit and clears marks that it saw through.
    pub fn update(&mut self, observation: &Observation) {
        self.clear_seen_through(observation);
        for hit in observation.scan.hits(&observation.pose) {
            let tracked = observation
                .moving
                .iter()
                .any(|disc| (disc.center() - hit).norm() <= disc.radius + TRACKED_MARGIN_M);
            if tracked {
                continue;
            }
            if let Some(cell) = self.known.frame().cell_of(&hit)
                && !self.is_beside_known(cell)
            {
                self.marks.insert(self.known.frame().index(cell));
            }
        }
    }

    /// A hit on a known wall falls on one of its cells or, by noise, beside it.
    fn is_beside_known(&self, Cell { column, row }: Cell) -> bool {
        (row - 1..=row + 1)
            .flat_map(|row| (column - 1..=column + 1).map(move |column| Cell::new(column, row)))
            .any(|cell| self.known.is_blocked(cell))
    }

    fn clear_seen_through(&mut self, observation: &Observation) {
        let scan = &observation.scan;
        if scan.ranges.is_empty() {
            return;
        }
        let frame = *self.known.frame();
        let robot = observation.pose.position();
        self.marks.retain(|&index| {
            let center = frame.center_of(frame.cell_at(index));
            let distance = (center - robot).norm();
            let direction = bearing(&robot, &center) - observation.pose.yaw;
            let turned = wrap_angle(direction - scan.angle_min);
            let beam = libm::round(turned / scan.angle_increment);
            let beams = scan.ranges.len() as f64;
            let full_turn = core::f64::consts::TAU / scan.angle_increment;
            let beam = if beam < 0.0 {
                beam + libm::round(full_turn)
            } else {
                beam
            };
            if distance > scan.range_max || beam >= beams || beam < 0.0 {
                return true;
            }
            let range = scan.ranges[beam as usize];
            range.is_nan() || range <= distance + frame.resolution_m
        });
    }

    /// Centres of the marked cells.
    pub fn marks(&self) -> impl Iterator<Item = Point> + '_ {
        let frame = self.known.frame();
        self.marks
            .iter()
            .map(|&index| frame.center_of(frame.cell_at(index)))
    }

    /// The distance field of a square window about a point, `half_m` to each side, aligned with the map's cells. Ground
    /// off the map is an obstacle.
    ///
    /// # Errors
    /// When the map's resolution is out of range.
    pub fn window(&self, center: &Point, half_m: f64) -> Result<Arc<ClearanceField>, ProblemError> {
        let frame = *self.known.frame();
        let units = frame.to_cell_units(center);
        let half = (half_m / frame.resolution_m).ceil() as i32;
        let left = units.x.floor() as i32 - half;
        let bottom = units.y.floor() as i32 - half;
        let side = 2 * half + 1;
        let corner = frame.from_cell_units(&Point::new(f64::from(left), f64::from(bottom)));
        let origin = crate::geometry::Pose {
            x: corner.x,
            y: corner.y,
            ..frame.origin
        };
        let window = GridFrame {
            width: side,
            height: side,
            origin,
            ..frame
        };
        let in_map = |cell: Cell| Cell::new(cell.column + left, cell.row + bottom);
        let blocked = (0..window.len())
            .map(|index| self.known.is_blocked(in_map(window.cell_at(index))))
            .collect();
        let mut obstacles = ObstacleGrid::new(window, blocked);
        for &index in &self.marks {
            let Cell { column, row } = frame.cell_at(index);
            obstacles.set(Cell::new(column - left, row - bottom), true);
        }
        Ok(Arc::new(ClearanceField::new(&obstacles)?))
    }
}
