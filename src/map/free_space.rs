//! The free configuration space of a round robot.

use super::bit_grid::BitGrid;
use super::dilation::dilate;
use super::{Cell, GridFrame, ObstacleGrid};
use crate::geometry::Point;

/// The cells in which the centre of a round robot keeps its radius from every obstacle.
///
/// A cell is free if **every** point of its square is at least the radius away from **every** point of every obstacle
/// cell's square, and the cell itself is no obstacle. A curve that stays on free cells therefore keeps the radius from
/// all obstacles, at any point within the cells.
///
/// Uses three bits per cell, so that a search reads 64 cells at once along rows or columns.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeSpace {
    frame: GridFrame,
    radius_m: f64,
    free: BitGrid,
    /// `free` with rows and columns exchanged.
    free_by_column: BitGrid,
    obstacles: BitGrid,
}

impl FreeSpace {
    /// Computes the free cells for a robot of this radius in metres. A negative radius counts as zero; NaN leaves no cell
    /// free. The area outside the grid does not block, but cells outside the grid are never free, so no path leaves it.
    #[must_use]
    pub fn new(obstacles: &ObstacleGrid, radius_m: f64) -> Self {
        let [space] = Self::for_radii(obstacles, [radius_m]);
        space
    }

    /// Computes [`Self::new`] for several radii.
    #[must_use]
    pub fn for_radii<const N: usize>(obstacles: &ObstacleGrid, radii_m: [f64; N]) -> [Self; N] {
        let frame = *obstacles.frame();
        let GridFrame { width, height, .. } = frame;
        let obstacles = BitGrid::from_cells(width, height, obstacles.cells());
        radii_m.map(|radius_m| {
            let near = dilate(&obstacles, width, height, radius_m / frame.resolution_m);
            let free = near.nor(&obstacles);
            Self {
                frame,
                radius_m,
                free_by_column: free.transposed(),
                free,
                obstacles: obstacles.clone(),
            }
        })
    }

    /// Frees the cells that are free in `other` and whose centre is within a distance, metres, of a point. This lets a
    /// robot leave a place nearer to an obstacle than this space allows.
    ///
    /// # Panics
    /// Panics if the frames differ.
    pub fn free_cells_near(&mut self, other: &Self, center: &Point, distance_m: f64) {
        assert_eq!(self.frame, other.frame, "both spaces have the same frame");
        let frame = self.frame;
        let at = frame.to_cell_units(center);
        let reach = distance_m / frame.resolution_m;
        let span = |at: f64, side: i32| {
            (at - reach).floor().max(0.0) as i32..((at + reach).ceil() as i32).min(side)
        };
        for row in span(at.y, frame.height) {
            for column in span(at.x, frame.width) {
                let cell = Cell::new(column, row);
                if (cell.center() - at).norm() <= reach && other.is_free(cell) {
                    self.free.set(cell, true);
                    self.free_by_column.set(Cell::new(row, column), true);
                }
            }
        }
    }

    /// Size and pose of the grid.
    #[must_use]
    pub const fn frame(&self) -> &GridFrame {
        &self.frame
    }

    /// Whether the robot's centre may be anywhere in the cell. False outside the grid.
    #[must_use]
    pub fn is_free(&self, cell: Cell) -> bool {
        self.free.get(cell)
    }

    /// Distance kept from every obstacle, metres, except in cells freed by [`Self::free_cells_near`].
    #[must_use]
    pub const fn radius_m(&self) -> f64 {
        self.radius_m
    }

    /// Whether the cell itself is an obstacle. True outside the grid.
    #[must_use]
    pub fn is_obstacle(&self, cell: Cell) -> bool {
        !self.frame.contains(cell) || self.obstacles.get(cell)
    }

    /// The free cell whose centre is nearest to a point; the point may lie outside the grid. Ties go to the first cell in
    /// storage order. None if no cell is free.
    #[must_use]
    pub fn nearest_free(&self, point: &Point) -> Option<Cell> {
        let at = self.frame.to_cell_units(point);
        let squared = |cell: Cell| (cell.center() - at).norm_squared();
        self.free.cells().min_by(|&one, &other| squared(one).total_cmp(&squared(other)))
    }

    /// Number of free cells.
    #[must_use]
    pub fn count(&self) -> usize {
        self.free.count()
    }

    /// The free cells by rows, and the same by columns.
    pub(crate) const fn bits(&self) -> (&BitGrid, &BitGrid) {
        (&self.free, &self.free_by_column)
    }
}
