//! Gaps between a robot's body and the obstacles of a map, exact to rounding.

use core::f64::consts::SQRT_2;

use crate::geometry::{Point, Pose, point_to_unit_square, segment_to_unit_square};
use crate::map::{Cell, DistanceField, ObstacleGrid};
use crate::robot::{Footprint, Polygon};

/// Measures gaps to static obstacles.
///
/// Each obstacle cell is a solid square, and everything outside the grid is solid.
#[derive(Clone, Debug)]
pub struct ObstacleGap {
    obstacles: ObstacleGrid,
    field: DistanceField,
}

impl ObstacleGap {
    /// Prepares the obstacles of a map.
    #[must_use]
    pub fn new(obstacles: ObstacleGrid) -> Self {
        let field = DistanceField::new(&obstacles);
        Self { obstacles, field }
    }

    /// The obstacles.
    #[must_use]
    pub const fn obstacles(&self) -> &ObstacleGrid {
        &self.obstacles
    }

    /// The distance field of the obstacles.
    pub(crate) const fn field(&self) -> &DistanceField {
        &self.field
    }

    /// The smallest gap between the body at a pose and any obstacle, metres; contact at or below zero. A polygon that touches
    /// or overlaps an obstacle has a gap of zero. A disc with its centre inside an obstacle has a gap of minus its radius.
    #[must_use]
    pub fn gap_m(&self, footprint: &Footprint, pose: &Pose) -> f64 {
        if let Some(body) = footprint.body() {
            let frame = self.obstacles.frame();
            let body = body.mapped(|corner| frame.to_cell_units(&pose.transform(corner)));
            return self.polygon_gap_in_cells(&body) * frame.resolution_m;
        }
        self.disc_gap_m(footprint, pose)
    }

    /// As [`Self::gap_m`], by the discs of the footprint: at most that of the body, and faster.
    #[must_use]
    pub fn disc_gap_m(&self, footprint: &Footprint, pose: &Pose) -> f64 {
        footprint
            .at(pose)
            .map(|(center, radius)| self.distance_m(&center) - radius)
            .fold(f64::INFINITY, f64::min)
    }

    /// Whether every disc of the footprint is farther than a distance, metres, from any obstacle, as far as the distance field
    /// alone shows. It may say no where the gap is up to two cells larger.
    pub(crate) fn is_surely_farther(&self, footprint: &Footprint, pose: &Pose, gap_m: f64) -> bool {
        let frame = self.obstacles.frame();
        footprint.at(pose).all(|(center, radius)| {
            let free = frame.cell_of(&center).map_or(0.0, |cell| self.free_cells(cell));
            free * frame.resolution_m > radius + gap_m
        })
    }

    /// A lower bound, in cells, of the distance from any point of a cell to the nearest solid square and to the border of the
    /// grid.
    fn free_cells(&self, cell: Cell) -> f64 {
        let frame = self.obstacles.frame();
        let nearest = self.field.squared_cells()[frame.index(cell)];
        DistanceField::free_cells(nearest).min(f64::from(frame.cells_to_edge(cell)))
    }

    /// Distance in cells between a polygon, in cell units, and the nearest solid square.
    fn polygon_gap_in_cells(&self, body: &Polygon) -> f64 {
        let mut least = f64::INFINITY;
        for corner in body.corners() {
            let Some(cell) = self.obstacles.frame().cell_at_units(corner) else {
                return 0.0;
            };
            least = least.min(self.to_border(corner)).min(self.distance_in_cells(corner, cell));
        }
        if least > 0.0 && self.has_obstacle_inside(body) {
            return 0.0;
        }
        for (from, to) in body.edges() {
            least = self.segment_gap_in_cells((*from, *to), least);
        }
        least
    }

    /// The smaller of a value and the distance in cells between a segment and the nearest square.
    ///
    /// Divides the segment until a part is shorter than two cells, and leaves out the parts that are too far from any square.
    /// The distance to the border of the grid is least at an end.
    fn segment_gap_in_cells(&self, (from, to): (Point, Point), least: f64) -> f64 {
        let middle = from + (to - from) * 0.5;
        let half = (to - from).norm() / 2.0;
        let Some(cell) = self.obstacles.frame().cell_at_units(&middle) else {
            return least;
        };
        let nearest = self.field.squared_cells()[self.obstacles.frame().index(cell)];
        if DistanceField::free_cells(nearest) - half >= least {
            return least;
        }
        if half > 1.0 {
            let least = self.segment_gap_in_cells((from, middle), least);
            return self.segment_gap_in_cells((middle, to), least);
        }
        let mut squared = least * least;
        self.for_each_near(cell, least + half + SQRT_2, |square| {
            squared = squared.min(segment_to_unit_square(&from, &to, &square.corner()));
        });
        squared.sqrt()
    }

    /// Whether the middle of an obstacle's square is inside a polygon, which then need not touch the outline.
    fn has_obstacle_inside(&self, body: &Polygon) -> bool {
        let frame = self.obstacles.frame();
        let corners = body.corners();
        let low = corners.iter().fold(corners[0], |low, corner| low.min(corner));
        let high = corners.iter().fold(corners[0], |high, corner| high.max(corner));
        let span = |low: f64, high: f64, cells: i32| {
            (low.floor() as i32).max(0)..=(high.floor() as i32).min(cells - 1)
        };
        span(low.y, high.y, frame.height).any(|row| {
            span(low.x, high.x, frame.width).any(|column| {
                let cell = Cell::new(column, row);
                self.obstacles.cells()[frame.index(cell)] && body.contains(&cell.center())
            })
        })
    }

    /// Distance in cells from a point of the grid, in cell units, to the border of the grid.
    fn to_border(&self, units: &Point) -> f64 {
        let frame = self.obstacles.frame();
        (units.x.min(f64::from(frame.width) - units.x))
            .min(units.y.min(f64::from(frame.height) - units.y))
    }

    /// Distance from a point to the nearest solid square, metres; zero inside one.
    fn distance_m(&self, point: &Point) -> f64 {
        let frame = self.obstacles.frame();
        let Some(cell) = frame.cell_of(point) else {
            return 0.0;
        };
        let units = frame.to_cell_units(point);
        self.distance_in_cells(&units, cell).min(self.to_border(&units)) * frame.resolution_m
    }

    /// Distance in cells from a point, given in cell units, to the nearest square of the grid; infinite without obstacles.
    ///
    /// The field holds the distance from the cell's centre to the nearest obstacle's centre; no centre is nearer. The centre
    /// of the nearest square is farther by at most three half diagonals: two for the position of the point in its cell, one
    /// for the square.
    fn distance_in_cells(&self, point: &Point, cell: Cell) -> f64 {
        let nearest = self.field.squared_cells()[self.obstacles.frame().index(cell)];
        if nearest >= DistanceField::NO_OBSTACLE {
            return f64::INFINITY;
        }
        let mut best = f64::INFINITY;
        self.for_each_near(cell, f64::from(nearest).sqrt() + 1.5 * SQRT_2, |square| {
            best = best.min(point_to_unit_square(point, &square.corner()));
        });
        best.sqrt()
    }

    /// Visits the obstacle cells whose centre is within a distance, in cells, of a cell's centre; the cell has an obstacle
    /// somewhere. None is nearer than the field says, so only a ring of cells is searched.
    fn for_each_near(&self, cell: Cell, reach: f64, mut visit: impl FnMut(Cell)) {
        let frame = self.obstacles.frame();
        let nearest = f64::from(self.field.squared_cells()[frame.index(cell)]);
        let rows = reach.floor() as i32;
        let width = frame.width as usize;
        for row in (cell.row - rows).max(0)..=(cell.row + rows).min(frame.height - 1) {
            let offset = f64::from(row - cell.row);
            let first = (nearest - offset * offset).max(0.0).sqrt().ceil() as i32;
            let last = (reach * reach - offset * offset).max(0.0).sqrt() as i32;
            let left = (cell.column - last).max(0)..cell.column - first + 1;
            let right = cell.column + first..(cell.column + last + 1).min(frame.width);
            let cells = &self.obstacles.cells()[frame.index(Cell::new(0, row))..][..width];
            for span in [left, right].into_iter().filter(|span| !span.is_empty()) {
                let is_occupied = &cells[span.start as usize..span.end as usize];
                for (column, _) in span.zip(is_occupied).filter(|(_, is_occupied)| **is_occupied) {
                    visit(Cell::new(column, row));
                }
            }
        }
    }
}
