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
    free: Vec<bool>,
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
        Self { frame, free }
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
