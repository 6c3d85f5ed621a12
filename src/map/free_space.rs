//! The cells that the robot's centre may be in.

use super::bit_grid::BitGrid;
use super::dilation::nearer_than;
use super::{Cell, GridFrame, ObstacleGrid};
use crate::geometry::Point;

/// Ground where the centre of a round robot keeps its radius from every obstacle.
///
/// A cell is free when **every** point of its square is at least the radius away from **every** point of every
/// obstacle cell's square, and the cell itself is no obstacle. So a curve that stays on free cells is proved clear
/// of walls by the radius, wherever in the cells it runs.
///
/// Three bits a cell: a search reads 64 cells at once, along rows or along columns.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeSpace {
    frame: GridFrame,
    radius_m: f64,
    free: BitGrid,
    /// The same with rows and columns exchanged.
    free_by_column: BitGrid,
    obstacles: BitGrid,
}

impl FreeSpace {
    /// The free cells among obstacles for a robot of this radius in metres; one below zero counts as zero, and one that
    /// is not a number leaves no cell free. What lies outside the grid does not block: a curve cannot leave the grid,
    /// since cells outside it are not free.
    #[must_use]
    pub fn new(obstacles: &ObstacleGrid, radius_m: f64) -> Self {
        let [space] = Self::for_radii(obstacles, [radius_m]);
        space
    }

    /// [`Self::new`] for several radii.
    #[must_use]
    pub fn for_radii<const N: usize>(obstacles: &ObstacleGrid, radii_m: [f64; N]) -> [Self; N] {
        let frame = *obstacles.frame();
        let GridFrame { width, height, .. } = frame;
        let obstacles = BitGrid::from_cells(width, height, obstacles.cells());
        radii_m.map(|radius_m| {
            let near = nearer_than(&obstacles, width, height, radius_m / frame.resolution_m);
            let free = near.neither(&obstacles);
            Self {
                frame,
                radius_m,
                free_by_column: free.transposed(),
                free,
                obstacles: obstacles.clone(),
            }
        })
    }

    /// Frees the cells within a distance of a place, in metres to their centres, that are free in `other`, whose frame is
    /// the same: so that a robot which stands nearer to a wall than it likes may find its way out.
    ///
    /// # Panics
    /// When the frames differ.
    pub fn free_cells_near(&mut self, other: &Self, place: &Point, distance_m: f64) {
        assert_eq!(self.frame, other.frame, "both describe the same ground");
        let frame = self.frame;
        let at = frame.to_cell_units(place);
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

    /// Size and placement.
    #[must_use]
    pub const fn frame(&self) -> &GridFrame {
        &self.frame
    }

    /// Whether the robot's centre may be anywhere in the cell. False outside the grid.
    #[must_use]
    pub fn is_free(&self, cell: Cell) -> bool {
        self.free.get(cell)
    }

    /// Distance kept from every obstacle, metres, but for cells freed by [`Self::free_cells_near`].
    #[must_use]
    pub const fn radius_m(&self) -> f64 {
        self.radius_m
    }

    /// Whether the cell itself is an obstacle, not merely near one. True outside the grid.
    #[must_use]
    pub fn is_obstacle(&self, cell: Cell) -> bool {
        !self.frame.contains(cell) || self.obstacles.get(cell)
    }

    /// The free cell whose centre is nearest to a point, which may lie outside the grid; of equally near ones, the first in
    /// storage. None where no cell is free.
    #[must_use]
    pub fn nearest_free(&self, point: &Point) -> Option<Cell> {
        let at = self.frame.to_cell_units(point);
        let squared = |cell: Cell| (cell.center() - at).norm_squared();
        self.free
            .cells()
            .min_by(|&one, &other| squared(one).total_cmp(&squared(other)))
    }

    /// Number of free cells.
    #[must_use]
    pub fn count(&self) -> usize {
        self.free.count()
    }

    /// The free cells, row by row, and the same column by column.
    pub(crate) const fn bits(&self) -> (&BitGrid, &BitGrid) {
        (&self.free, &self.free_by_column)
    }
}
