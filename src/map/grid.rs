//! Grids of cells laid over the ground: where a cell lies, and what is known of it.

use serde::Serialize;

use super::MapError;
use crate::geometry::{Point, Pose};

/// The place of a cell in its grid. Column 0, row 0 is the lower-left cell of the grid's own frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
pub struct Cell {
    /// Along the grid's x axis.
    pub column: i32,
    /// Along the grid's y axis.
    pub row: i32,
}

impl Cell {
    /// A cell from its column and row.
    #[must_use]
    pub const fn new(column: i32, row: i32) -> Self {
        Self { column, row }
    }

    /// The centre of its square, in cells from the grid's corner.
    #[must_use]
    pub fn center(self) -> Point {
        Point::new(f64::from(self.column) + 0.5, f64::from(self.row) + 0.5)
    }
}

/// Size and placement of a grid: every grid of this crate carries one, and two grids may be combined when
/// their frames are equal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridFrame {
    /// Number of columns, 1..=32767.
    pub width: i32,
    /// Number of rows, 1..=32767.
    pub height: i32,
    /// Side of a cell, metres, above zero.
    pub resolution_m: f64,
    /// Pose of the lower-left corner of cell (0, 0) in the map frame.
    pub origin: Pose,
}

/// The largest number of columns or rows of a grid.
pub const MAX_GRID_SIDE: i32 = 32_767;

/// The largest number of cells of a grid.
pub const MAX_GRID_CELLS: usize = 100_000_000;

impl GridFrame {
    /// A frame whose numbers have been checked.
    ///
    /// # Errors
    /// When a side is not 1..=[`MAX_GRID_SIDE`], the whole is more than [`MAX_GRID_CELLS`], the resolution in
    /// metres is not finite and above zero, or the origin is not finite.
    pub fn new(width: i32, height: i32, resolution_m: f64, origin: Pose) -> Result<Self, MapError> {
        check_size(i64::from(width), i64::from(height))?;
        if !(resolution_m.is_finite() && resolution_m > 0.0) {
            return Err(MapError::BadResolution { resolution_m });
        }
        if !origin.is_finite() {
            let Pose { x, y, yaw } = origin;
            return Err(MapError::BadOrigin { x, y, yaw });
        }
        Ok(Self {
            width,
            height,
            resolution_m,
            origin,
        })
    }

    /// Number of cells.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Whether the grid has no cell. Never true of a frame made by this crate.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether the cell lies inside the grid.
    #[must_use]
    pub const fn contains(&self, cell: Cell) -> bool {
        cell.column >= 0 && cell.row >= 0 && cell.column < self.width && cell.row < self.height
    }

    /// Position of a cell in row-major storage, lowest row first. The cell must lie inside the grid.
    #[must_use]
    pub const fn index(&self, cell: Cell) -> usize {
        debug_assert!(self.contains(cell));
        cell.row as usize * self.width as usize + cell.column as usize
    }

    /// The cell stored at a row-major position.
    #[must_use]
    pub const fn cell_at(&self, index: usize) -> Cell {
        Cell::new(
            (index % self.width as usize) as i32,
            (index / self.width as usize) as i32,
        )
    }

    /// A point of the map frame in cell units of the grid: cell (c, r) covers [c, c+1) x [r, r+1).
    #[must_use]
    pub fn to_cell_units(&self, point: &Point) -> Point {
        self.origin.inverse_transform(point) / self.resolution_m
    }

    /// A point given in cell units, in the map frame.
    #[must_use]
    pub fn from_cell_units(&self, units: &Point) -> Point {
        self.origin.transform(&(units * self.resolution_m))
    }

    /// The four corners of the grid in the map frame, counter-clockwise from that of cell (0, 0).
    #[must_use]
    pub fn corners(&self) -> [Point; 4] {
        let (width, height) = (f64::from(self.width), f64::from(self.height));
        [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)]
            .map(|(x, y)| self.from_cell_units(&Point::new(x, y)))
    }

    /// The cell that covers a point, or none outside the grid or for a point that is not finite.
    #[must_use]
    pub fn cell_of(&self, point: &Point) -> Option<Cell> {
        self.cell_at_units(&self.to_cell_units(point))
    }

    /// The cell that covers a point given in cell units, or none outside the grid or for a point that is not finite.
    #[must_use]
    pub fn cell_at_units(&self, units: &Point) -> Option<Cell> {
        let inside = units.x >= 0.0
            && units.y >= 0.0
            && units.x < f64::from(self.width)
            && units.y < f64::from(self.height);
        inside.then(|| Cell::new(units.x as i32, units.y as i32))
    }

    /// The centre of a cell in the map frame; the cell may lie outside the grid.
    #[must_use]
    pub fn center_of(&self, cell: Cell) -> Point {
        self.from_cell_units(&cell.center())
    }
}

/// Whether a grid may have these sides. Files state their size before their cells, so readers ask this first and
/// set aside no memory for a grid that is refused.
pub(super) fn check_size(width: i64, height: i64) -> Result<(), MapError> {
    let side = 1..=i64::from(MAX_GRID_SIDE);
    if side.contains(&width) && side.contains(&height) && width * height <= MAX_GRID_CELLS as i64 {
        Ok(())
    } else {
        Err(MapError::BadGridSize { width, height })
    }
}

/// What a map says of a cell it does not know.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum UnknownPolicy {
    /// Unknown ground is an obstacle. The default: a robot must not drive where nobody looked.
    #[default]
    Blocked,
    /// Unknown ground is free.
    Free,
}

/// Occupancy as ROS has it: a probability in percent for each cell, or unknown.
#[derive(Clone, Debug, PartialEq)]
pub struct OccupancyGrid {
    frame: GridFrame,
    cells: Vec<i8>,
}

/// The value of a cell that the map does not know.
pub const UNKNOWN: i8 = -1;

/// Occupancy, in percent, from which a cell counts as an obstacle (Nav2's lethal threshold).
pub const OCCUPIED_THRESHOLD: i8 = 65;

impl OccupancyGrid {
    /// A grid from its cells, row-major with the lowest row first; each is 0..=100 or [`UNKNOWN`].
    ///
    /// # Panics
    /// When the number of cells is not the frame's.
    #[must_use]
    pub fn new(frame: GridFrame, cells: Vec<i8>) -> Self {
        assert_eq!(
            cells.len(),
            frame.len(),
            "one value for each cell of the frame"
        );
        Self { frame, cells }
    }

    /// A grid from cells in the order of pictures and text, highest row first.
    pub(super) fn from_top_down(frame: GridFrame, cells: &[i8]) -> Self {
        let lowest_first = cells.chunks_exact(frame.width as usize).rev();
        Self::new(frame, lowest_first.flatten().copied().collect())
    }

    /// Size and placement.
    #[must_use]
    pub const fn frame(&self) -> &GridFrame {
        &self.frame
    }

    /// All values, row-major, lowest row first.
    #[must_use]
    pub fn cells(&self) -> &[i8] {
        &self.cells
    }

    /// Where the obstacles are: cells of at least [`OCCUPIED_THRESHOLD`] percent, and unknown ones as the policy says.
    #[must_use]
    pub fn obstacles(&self, unknown: UnknownPolicy) -> ObstacleGrid {
        let blocked = |&value: &i8| match value {
            UNKNOWN => unknown == UnknownPolicy::Blocked,
            value => value >= OCCUPIED_THRESHOLD,
        };
        ObstacleGrid::new(self.frame, self.cells.iter().map(blocked).collect())
    }
}

/// A yes or no for each cell: does an obstacle cover it?
#[derive(Clone, Debug, PartialEq)]
pub struct ObstacleGrid {
    frame: GridFrame,
    blocked: Vec<bool>,
}

impl ObstacleGrid {
    /// A grid from its cells, row-major with the lowest row first; `true` is an obstacle.
    ///
    /// # Panics
    /// When the number of cells is not the frame's.
    #[must_use]
    pub fn new(frame: GridFrame, blocked: Vec<bool>) -> Self {
        assert_eq!(
            blocked.len(),
            frame.len(),
            "one value for each cell of the frame"
        );
        Self { frame, blocked }
    }

    /// Size and placement.
    #[must_use]
    pub const fn frame(&self) -> &GridFrame {
        &self.frame
    }

    /// All cells, row-major, lowest row first; `true` is an obstacle.
    #[must_use]
    pub fn cells(&self) -> &[bool] {
        &self.blocked
    }

    /// Whether an obstacle covers the cell. Everything outside the grid is an obstacle.
    #[must_use]
    pub fn is_blocked(&self, cell: Cell) -> bool {
        !self.frame.contains(cell) || self.blocked[self.frame.index(cell)]
    }

    /// Marks or clears a cell; a cell outside the grid is left alone.
    pub fn set(&mut self, cell: Cell, blocked: bool) {
        if self.frame.contains(cell) {
            let index = self.frame.index(cell);
            self.blocked[index] = blocked;
        }
    }

    /// Marks every cell whose centre lies within a disc, metres in the map frame.
    pub fn fill_disc(&mut self, center: &Point, radius_m: f64) {
        let units = self.frame.to_cell_units(center);
        let reach = radius_m / self.frame.resolution_m;
        let cells = |at: f64| (at - reach).floor() as i32..=(at + reach).floor() as i32;
        for row in cells(units.y) {
            for column in cells(units.x) {
                let cell = Cell::new(column, row);
                if (self.frame.center_of(cell) - center).norm() <= radius_m {
                    self.set(cell, true);
                }
            }
        }
    }
}
