//! Grid frames, occupancy grids and obstacle grids.

use serde::Serialize;

use super::MapError;
use crate::geometry::{Point, Pose, point_to_unit_square};

/// Column and row of a grid cell. Cell (0, 0) is the lower-left cell in the grid's own frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
pub struct Cell {
    /// Along the grid's x axis.
    pub column: i32,
    /// Along the grid's y axis.
    pub row: i32,
}

impl Cell {
    /// Creates a cell from its column and row.
    #[must_use]
    pub const fn new(column: i32, row: i32) -> Self {
        Self { column, row }
    }

    /// The cell's lower left corner, in cell units from the grid's corner.
    #[must_use]
    pub fn corner(self) -> Point {
        Point::new(f64::from(self.column), f64::from(self.row))
    }

    /// The cell's centre, in cell units from the grid's corner.
    #[must_use]
    pub fn center(self) -> Point {
        Point::new(f64::from(self.column) + 0.5, f64::from(self.row) + 0.5)
    }

    /// The cell and the eight around it. They may lie outside a grid.
    pub(crate) fn with_neighbours(self) -> impl Iterator<Item = Self> {
        let row = move |up| (-1..=1).map(move |right| (right, up));
        (-1..=1).flat_map(row).map(move |(right, up)| Self::new(self.column + right, self.row + up))
    }
}

/// Size and pose of a grid. Two grids may be combined if their frames are equal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridFrame {
    /// Number of columns, 1..=32767.
    pub width: i32,
    /// Number of rows, 1..=32767.
    pub height: i32,
    /// Side of a cell, metres, above zero and at most [`MAX_RESOLUTION_M`].
    pub resolution_m: f64,
    /// Pose of the lower-left corner of cell (0, 0) in the map frame.
    pub origin: Pose,
}

/// The largest number of columns or rows of a grid.
pub const MAX_GRID_SIDE: i32 = 32_767;

/// The largest number of cells of a grid.
pub const MAX_GRID_CELLS: usize = 100_000_000;

/// The largest side of a cell, metres: far larger than any robot. A larger value is a mistake of units.
pub const MAX_RESOLUTION_M: f64 = 100.0;

impl GridFrame {
    /// Creates a validated frame.
    ///
    /// # Errors
    /// Returns an error if a side is not in 1..=[`MAX_GRID_SIDE`], the number of cells exceeds [`MAX_GRID_CELLS`], the
    /// resolution is not above zero and at most [`MAX_RESOLUTION_M`], or the origin is not finite.
    pub fn new(width: i32, height: i32, resolution_m: f64, origin: Pose) -> Result<Self, MapError> {
        check_size(i64::from(width), i64::from(height))?;
        if !(resolution_m > 0.0 && resolution_m <= MAX_RESOLUTION_M) {
            return Err(MapError::BadResolution { resolution_m });
        }
        if !origin.is_finite() {
            let Pose { x, y, yaw } = origin;
            return Err(MapError::BadOrigin { x, y, yaw });
        }
        Ok(Self { width, height, resolution_m, origin })
    }

    /// Number of cells.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Whether the grid has no cells; never true for a frame from [`Self::new`].
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether the cell lies inside the grid.
    #[must_use]
    pub const fn contains(&self, cell: Cell) -> bool {
        cell.column >= 0 && cell.row >= 0 && cell.column < self.width && cell.row < self.height
    }

    /// Index of a cell in row-major storage, lowest row first. The cell must lie inside the grid.
    #[must_use]
    pub const fn index(&self, cell: Cell) -> usize {
        debug_assert!(self.contains(cell));
        cell.row as usize * self.width as usize + cell.column as usize
    }

    /// All cells, in the order of their indices.
    #[must_use]
    pub fn cells(self) -> impl DoubleEndedIterator<Item = Cell> {
        (0..self.len()).map(move |index| self.cell_at(index))
    }

    /// The cell at a row-major index.
    #[must_use]
    pub const fn cell_at(&self, index: usize) -> Cell {
        Cell::new((index % self.width as usize) as i32, (index / self.width as usize) as i32)
    }

    /// Converts a point from the map frame to cell units: cell (c, r) covers [c, c+1) x [r, r+1).
    #[must_use]
    pub fn to_cell_units(&self, point: &Point) -> Point {
        let local = self.origin.inverse_transform(point);
        Point::new(local.x / self.resolution_m, local.y / self.resolution_m)
    }

    /// Converts a point from cell units to the map frame.
    #[must_use]
    pub fn from_cell_units(&self, units: &Point) -> Point {
        let local = Point::new(units.x * self.resolution_m, units.y * self.resolution_m);
        self.origin.transform(&local)
    }

    /// The four corners in the map frame, counter-clockwise, starting with that of cell (0, 0).
    #[must_use]
    pub fn corners(&self) -> [Point; 4] {
        let (width, height) = (f64::from(self.width), f64::from(self.height));
        [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)]
            .map(|(x, y)| self.from_cell_units(&Point::new(x, y)))
    }

    /// The cell that covers a point of the map frame; none if it is outside the grid or not finite.
    #[must_use]
    pub fn cell_of(&self, point: &Point) -> Option<Cell> {
        self.cell_at_units(&self.to_cell_units(point))
    }

    /// The cell that covers a point in cell units; none if it is outside the grid or not finite.
    pub(crate) fn cell_at_units(&self, units: &Point) -> Option<Cell> {
        let inside = units.x >= 0.0
            && units.y >= 0.0
            && units.x < f64::from(self.width)
            && units.y < f64::from(self.height);
        inside.then(|| Cell::new(units.x as i32, units.y as i32))
    }

    /// The smallest distance of a cell of the grid from the edge of the grid, cells: zero for a cell at the edge.
    pub(crate) fn cells_to_edge(&self, cell: Cell) -> i32 {
        let columns = cell.column.min(self.width - 1 - cell.column);
        columns.min(cell.row).min(self.height - 1 - cell.row)
    }

    /// The centre of a cell in the map frame. The cell may lie outside the grid.
    #[must_use]
    pub fn center_of(&self, cell: Cell) -> Point {
        self.from_cell_units(&cell.center())
    }

    /// The cells of the grid that touch a square around a point, row by row. The square extends this far to each side along the
    /// grid's axes, metres.
    pub(crate) fn cells_around(
        self,
        center: &Point,
        half_m: f64,
    ) -> impl Iterator<Item = Cell> + use<> {
        self.cells_in_square(self.to_cell_units(center), half_m / self.resolution_m)
    }

    /// The cells of the grid whose centres lie within a distance of a point, metres.
    pub(crate) fn cells_within(
        self,
        center: &Point,
        distance_m: f64,
    ) -> impl Iterator<Item = Cell> + use<> {
        let (units, reach) = (self.to_cell_units(center), distance_m / self.resolution_m);
        let is_near = move |cell: &Cell| (cell.center() - units).norm() <= reach;
        self.cells_in_square(units, reach).filter(is_near)
    }

    /// Whether the square of a cell is nearer to a point than a distance, metres.
    pub(crate) fn is_touched(&self, cell: &Cell, center: &Point, distance_m: f64) -> bool {
        let reach = distance_m / self.resolution_m;
        point_to_unit_square(&self.to_cell_units(center), &cell.corner()) < reach * reach
    }

    /// [`Self::cells_around`] for a point and a reach in cell units.
    fn cells_in_square(self, units: Point, reach: f64) -> impl Iterator<Item = Cell> {
        let span = move |at: f64, cells: i32| {
            let past = ((at + reach).floor() as i32).saturating_add(1);
            (at - reach).floor().max(0.0) as i32..past.min(cells)
        };
        let row = move |row| span(units.x, self.width).map(move |column| Cell::new(column, row));
        span(units.y, self.height).flat_map(row)
    }
}

/// Checks the side lengths of a grid. Readers call this with the size from a file's header, before they allocate memory.
pub(super) fn check_size(width: i64, height: i64) -> Result<(), MapError> {
    let side = 1..=i64::from(MAX_GRID_SIDE);
    if side.contains(&width) && side.contains(&height) && width * height <= MAX_GRID_CELLS as i64 {
        Ok(())
    } else {
        Err(MapError::BadGridSize { width, height })
    }
}

/// How unknown cells are treated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum UnknownPolicy {
    /// Unknown cells are obstacles. The default, since unobserved terrain is not safe to drive on.
    #[default]
    Blocked,
    /// Unknown cells are free.
    Free,
}

/// One value for each cell of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid<T> {
    frame: GridFrame,
    cells: Vec<T>,
}

impl<T> Grid<T> {
    /// Creates a grid from its cells, row-major with the lowest row first.
    ///
    /// # Panics
    /// Panics if the number of cells differs from the frame's.
    #[must_use]
    pub fn new(frame: GridFrame, cells: Vec<T>) -> Self {
        assert_eq!(cells.len(), frame.len(), "one value for each cell of the frame");
        Self { frame, cells }
    }

    /// Creates a grid from the value at each cell.
    #[must_use]
    pub fn from_fn(frame: GridFrame, value: impl FnMut(Cell) -> T) -> Self {
        Self { frame, cells: frame.cells().map(value).collect() }
    }

    /// Creates a grid with the same value at all cells.
    #[must_use]
    pub fn filled(frame: GridFrame, value: T) -> Self
    where
        T: Clone,
    {
        Self { frame, cells: vec![value; frame.len()] }
    }

    /// The grid of the values that a function makes of these.
    #[must_use]
    pub fn map<U>(&self, value: impl FnMut(&T) -> U) -> Grid<U> {
        Grid { frame: self.frame, cells: self.cells.iter().map(value).collect() }
    }

    /// Size and pose of the grid.
    #[must_use]
    pub const fn frame(&self) -> &GridFrame {
        &self.frame
    }

    /// All values, row-major, lowest row first.
    #[must_use]
    pub fn cells(&self) -> &[T] {
        &self.cells
    }

    /// The value at a cell; none outside the grid.
    #[must_use]
    pub fn get(&self, cell: Cell) -> Option<&T> {
        self.frame.contains(cell).then(|| &self.cells[self.frame.index(cell)])
    }

    /// Sets the value at a cell. A cell outside the grid is ignored.
    pub fn set(&mut self, cell: Cell, value: T) {
        if self.frame.contains(cell) {
            let index = self.frame.index(cell);
            self.cells[index] = value;
        }
    }
}

/// A ROS occupancy grid: a probability of 0 to 100 percent for each cell, or [`UNKNOWN`].
pub type OccupancyGrid = Grid<i8>;

/// A boolean per cell: whether an obstacle covers it.
pub type ObstacleGrid = Grid<bool>;

/// The value of an unknown cell.
pub const UNKNOWN: i8 = -1;

/// Smallest occupancy, in percent, of an obstacle (Nav2's lethal threshold).
pub const OCCUPIED_THRESHOLD: i8 = 65;

impl OccupancyGrid {
    /// Creates a grid from cells of unknown origin, row-major with the lowest row first.
    ///
    /// # Errors
    /// Returns an error if the number of cells differs from the frame's, or a cell is neither [`UNKNOWN`] nor 0 to 100 percent.
    pub fn from_cells(frame: GridFrame, cells: Vec<i8>) -> Result<Self, MapError> {
        if cells.len() != frame.len() {
            let GridFrame { width, height, .. } = frame;
            return Err(MapError::WrongCellCount { found: cells.len(), width, height });
        }
        let is_bad = |value: &i8| *value != UNKNOWN && !(0..=100).contains(value);
        if let Some(index) = cells.iter().position(is_bad) {
            return Err(MapError::BadCell { index, value: cells[index] });
        }
        Ok(Self::new(frame, cells))
    }

    /// Creates a grid from cells in image order, highest row first.
    pub(super) fn from_top_down(frame: GridFrame, cells: &[i8]) -> Self {
        let lowest_first = cells.chunks_exact(frame.width as usize).rev();
        Self::new(frame, lowest_first.flatten().copied().collect())
    }

    /// The obstacles: cells of at least [`OCCUPIED_THRESHOLD`] percent, and unknown cells according to the policy.
    #[must_use]
    pub fn obstacles(&self, unknown: UnknownPolicy) -> ObstacleGrid {
        self.map(|&value| match value {
            UNKNOWN => unknown == UnknownPolicy::Blocked,
            value => value >= OCCUPIED_THRESHOLD,
        })
    }
}

impl ObstacleGrid {
    /// Whether an obstacle covers the cell. True outside the grid.
    #[must_use]
    pub fn is_blocked(&self, cell: Cell) -> bool {
        !self.frame.contains(cell) || self.cells[self.frame.index(cell)]
    }

    /// Sets every cell whose centre lies within a disc, metres in the map frame.
    pub fn fill_disc(&mut self, center: &Point, radius_m: f64) {
        self.frame.cells_within(center, radius_m).for_each(|cell| self.set(cell, true));
    }
}
