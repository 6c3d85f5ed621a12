//! The cells that the robot's centre may be in.

use super::{Cell, DistanceField, GridFrame, ObstacleGrid};

/// Ground where the centre of a round robot keeps its radius from every obstacle.
///
/// A cell is free when **every** point of its square is at least the radius away from **every** point of every
/// obstacle cell's square, and the cell itself is no obstacle. So a curve that stays on free cells is proved clear
/// of walls by the radius, wherever in the cells it runs.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeSpace {
    frame: GridFrame,
    radius_m: f64,
    free: Vec<bool>,
    obstacle: Vec<bool>,
}

impl FreeSpace {
    /// The free cells among obstacles for a robot of this radius in metres. What lies outside the grid does not
    /// block: a curve cannot leave the grid, since cells outside it are not free.
    ///
    /// The distance between two cells' squares is the distance between the centre of one and the nearest centre of
    /// the other grown by one cell all round, so one distance field of the grown obstacles answers for all cells.
    #[must_use]
    pub fn new(obstacles: &ObstacleGrid, radius_m: f64) -> Self {
        let frame = *obstacles.frame();
        let grown = DistanceField::new(&grow_by_one_cell(obstacles));
        let radius_cells = radius_m.max(0.0) / frame.resolution_m;
        let least = radius_cells * radius_cells;
        let free = (0..frame.len())
            .map(|index| {
                !obstacles.cells()[index] && f64::from(grown.squared_cells()[index]) >= least
            })
            .collect();
        Self {
            frame,
            radius_m,
            free,
            obstacle: obstacles.cells().to_vec(),
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
        self.frame.contains(cell) && self.free[self.frame.index(cell)]
    }

    /// Distance kept from every obstacle, metres.
    #[must_use]
    pub const fn radius_m(&self) -> f64 {
        self.radius_m
    }

    /// Whether the cell itself is an obstacle, not merely near one. True outside the grid.
    #[must_use]
    pub fn is_obstacle(&self, cell: Cell) -> bool {
        !self.frame.contains(cell) || self.obstacle[self.frame.index(cell)]
    }

    /// The free cell whose centre is nearest to a cell's; of equally near ones, the first in storage. None where no cell
    /// is free.
    #[must_use]
    pub fn nearest_free(&self, cell: Cell) -> Option<Cell> {
        let squared = |other: &Cell| {
            let dx = i64::from(other.column - cell.column);
            let dy = i64::from(other.row - cell.row);
            dx * dx + dy * dy
        };
        let free = (0..self.free.len()).filter(|&index| self.free[index]);
        free.map(|index| self.frame.cell_at(index))
            .min_by_key(squared)
    }

    /// All cells, row-major, lowest row first; `true` is free.
    #[must_use]
    pub fn cells(&self) -> &[bool] {
        &self.free
    }
}

/// Obstacles together with their eight neighbours.
fn grow_by_one_cell(obstacles: &ObstacleGrid) -> ObstacleGrid {
    let frame = *obstacles.frame();
    let mut grown = obstacles.clone();
    for index in (0..frame.len()).filter(|&index| obstacles.cells()[index]) {
        let Cell { column, row } = frame.cell_at(index);
        for neighbour_row in row - 1..=row + 1 {
            for neighbour_column in column - 1..=column + 1 {
                grown.set(Cell::new(neighbour_column, neighbour_row), true);
            }
        }
    }
    grown
}
