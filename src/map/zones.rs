//! Zones of a map in which a robot must not drive, or only slowly.
//!
//! They say nothing about surfaces: a lidar sees through them, and people may walk there. The sources are masks in the form of
//! maps, as those of Nav2's keepout and speed filters.

use core::ops::RangeInclusive;

use super::{Cell, GridFrame, ObstacleGrid, OccupancyGrid};
use crate::geometry::Point;

/// The value of a cell in which the robot must not drive.
const KEEPOUT: i8 = 100;
/// Two grids of the same cells differ by rounding: a smaller overlap of two cells is none, in cells.
const ROUNDING: f64 = 1e-6;

/// For each cell of a map whether it is closed, or how fast the robot may drive there.
#[derive(Clone, Debug, PartialEq)]
pub struct Zones {
    grid: OccupancyGrid,
    has_speed_limits: bool,
}

impl Zones {
    /// No zones on a map.
    #[must_use]
    pub fn new(map: &GridFrame) -> Self {
        Self { grid: OccupancyGrid::filled(*map, 0), has_speed_limits: false }
    }

    /// The zones of [`Self::grid`]; other values are no zones.
    #[must_use]
    pub fn from_grid(grid: &OccupancyGrid) -> Self {
        let grid = grid.map(|&value| value.max(0));
        let has_speed_limits = grid.cells().iter().any(|cell| (1..KEEPOUT).contains(cell));
        Self { grid, has_speed_limits }
    }

    /// The zones as a map: 0 for no zone, 1 to 99 for a speed in percent of the robot's largest, 100 for a closed cell.
    #[must_use]
    pub const fn grid(&self) -> &OccupancyGrid {
        &self.grid
    }

    /// Size and pose of the map.
    #[must_use]
    pub const fn frame(&self) -> &GridFrame {
        self.grid.frame()
    }

    /// Closes every cell that an occupied cell of a mask touches: those of 100 percent, as in Nav2's keepout filter.
    pub fn close(&mut self, mask: &OccupancyGrid) {
        self.mark(mask, |value| (value >= KEEPOUT).then_some(KEEPOUT));
    }

    /// Limits the speed in every cell that a cell of a mask touches; of several limits the lowest counts. `percent` is the limit for a
    /// value of the mask, in percent of the robot's largest speed, rounded down to whole percents but at least one; none, zero and 100
    /// or more are no limit.
    pub fn limit_speed(&mut self, mask: &OccupancyGrid, percent: impl Fn(i8) -> Option<f64>) {
        let limit = |value: i8| {
            let percent = percent(value).filter(|percent| *percent > 0.0 && *percent < 100.0)?;
            Some((percent as i8).max(1))
        };
        self.mark(mask, limit);
        self.has_speed_limits |= self.grid.cells().iter().any(|cell| (1..KEEPOUT).contains(cell));
    }

    /// Adds the zones of the same map.
    ///
    /// # Panics
    /// Panics if they belong to another grid.
    pub fn add(&mut self, other: &Self) {
        let cells = other.grid.cells();
        assert_eq!(self.frame(), other.frame(), "zones of the same map");
        for (index, &new) in cells.iter().enumerate().filter(|(_, new)| **new != 0) {
            self.add_to(self.frame().cell_at(index), new);
        }
        self.has_speed_limits |= other.has_speed_limits;
    }

    /// Adds a value to a cell, if it is on the map: a closed cell stays closed, and of two limits the lower stays.
    fn add_to(&mut self, cell: Cell, new: i8) {
        let is_stricter = |&before: &i8| before == 0 || new == KEEPOUT || new < before;
        let is_open = |before: &&i8| **before != KEEPOUT;
        if self.grid.get(cell).filter(is_open).is_some_and(is_stricter) {
            self.grid.set(cell, new);
        }
    }

    /// Adds values to the cells that a mask touches.
    fn mark(&mut self, mask: &OccupancyGrid, new: impl Fn(i8) -> Option<i8>) {
        let by_value: Vec<Option<i8>> = (i8::MIN..=i8::MAX).map(new).collect();
        for (index, &value) in mask.cells().iter().enumerate() {
            let Some(new) = by_value[(i16::from(value) - i16::from(i8::MIN)) as usize] else {
                continue;
            };
            let (columns, rows) = self.touched(mask.frame(), mask.frame().cell_at(index));
            for row in rows {
                for column in columns.clone() {
                    self.add_to(Cell::new(column, row), new);
                }
            }
        }
    }

    /// Columns and rows of the map that a cell of a mask touches: those of its bounding box.
    fn touched(&self, mask: &GridFrame, cell: Cell) -> (RangeInclusive<i32>, RangeInclusive<i32>) {
        let (x, y) = (f64::from(cell.column), f64::from(cell.row));
        let corners = [(x, y), (x + 1.0, y), (x + 1.0, y + 1.0), (x, y + 1.0)]
            .map(|(x, y)| self.frame().to_cell_units(&mask.from_cell_units(&Point::new(x, y))));
        let range = |along: fn(&Point) -> f64, cells: i32| {
            let low = corners.iter().map(along).fold(f64::INFINITY, f64::min);
            let high = corners.iter().map(along).fold(f64::NEG_INFINITY, f64::max);
            let first = (low + ROUNDING).floor().max(0.0) as i32;
            let last = (high - ROUNDING).floor().min(f64::from(cells - 1)) as i32;
            first..=last
        };
        let GridFrame { width, height, .. } = *self.frame();
        (range(|point| point.x, width), range(|point| point.y, height))
    }

    /// Whether no cell is closed.
    #[must_use]
    pub fn is_open(&self) -> bool {
        !self.grid.cells().contains(&KEEPOUT)
    }

    /// Whether a cell has a speed limit.
    #[must_use]
    pub const fn has_speed_limits(&self) -> bool {
        self.has_speed_limits
    }

    /// The closed cells.
    #[must_use]
    pub fn closed(&self) -> ObstacleGrid {
        self.grid.map(|&cell| cell == KEEPOUT)
    }

    /// The obstacles of the map together with the closed cells.
    ///
    /// # Panics
    /// Panics if the obstacles belong to another grid.
    #[must_use]
    pub fn with_obstacles(&self, obstacles: &ObstacleGrid) -> ObstacleGrid {
        let cells = self.grid.cells();
        assert_eq!(obstacles.frame(), self.frame(), "zones of the same map");
        let is_blocked = |(&cell, &blocked): (&i8, &bool)| blocked || cell == KEEPOUT;
        let blocked = cells.iter().zip(obstacles.cells()).map(is_blocked);
        ObstacleGrid::new(*self.frame(), blocked.collect())
    }

    /// The speed limit at a place, m/s, for a robot with this largest speed; none without a limit.
    #[must_use]
    pub fn speed_limit(&self, place: &Point, max_speed: f64) -> Option<f64> {
        let cell = *self.grid.get(self.frame().cell_of(place)?)?;
        (1..KEEPOUT).contains(&cell).then(|| f64::from(cell) / 100.0 * max_speed)
    }

    /// The largest speed, m/s, from which a robot at a place keeps every speed limit, whatever direction it takes, if it brakes by
    /// this, m/s²; `max_speed` where no limit is near.
    #[must_use]
    pub fn fastest(&self, place: &Point, max_speed: f64, braking_m_s2: f64) -> f64 {
        if !self.has_speed_limits {
            return max_speed;
        }
        let GridFrame { width, height, resolution_m, .. } = *self.frame();
        let at = self.frame().to_cell_units(place);
        let reach = max_speed * max_speed / (2.0 * braking_m_s2 * resolution_m);
        let range = |at: f64, cells: i32| {
            let last = f64::from(cells - 1);
            ((at - reach).floor().max(0.0) as i32)..=((at + reach).floor().min(last) as i32)
        };
        let columns = range(at.x, width);
        let mut least2 = max_speed * max_speed;
        for row in range(at.y, height) {
            for column in columns.clone() {
                let Some(&cell) = self.grid.get(Cell::new(column, row)) else { continue };
                if !(1..KEEPOUT).contains(&cell) {
                    continue;
                }
                let (x, y) = (f64::from(column), f64::from(row));
                let nearest = Point::new(at.x.clamp(x, x + 1.0), at.y.clamp(y, y + 1.0));
                let limit = f64::from(cell) / 100.0 * max_speed;
                let distance_m = resolution_m * (nearest - at).norm();
                least2 = least2.min(limit * limit + 2.0 * braking_m_s2 * distance_m);
            }
        }
        least2.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;

    fn frame(width: i32, height: i32, resolution_m: f64, origin: Pose) -> GridFrame {
        GridFrame::new(width, height, resolution_m, origin).expect("a frame")
    }

    /// A mask whose only cell with a value is the given one.
    fn mask(frame: GridFrame, cell: Cell, value: i8) -> OccupancyGrid {
        let mut mask = OccupancyGrid::filled(frame, 0);
        mask.set(cell, value);
        mask
    }

    fn closed_cells(zones: &Zones) -> Vec<(i32, i32)> {
        let closed = zones.closed();
        let all = closed.frame().cells();
        all.filter(|cell| closed.is_blocked(*cell)).map(|cell| (cell.column, cell.row)).collect()
    }

    #[test]
    fn mask_of_the_same_cells_closes_exactly_these() {
        for origin in [Pose::default(), Pose::new(-3.17, 12.4, 0.7)] {
            let map = frame(20, 10, 0.05, origin);
            let mut zones = Zones::new(&map);
            zones.close(&mask(map, Cell::new(7, 3), 100));
            assert_eq!(closed_cells(&zones), [(7, 3)]);
        }
    }

    #[test]
    fn mask_of_other_cells_closes_all_that_it_touches() {
        let map = frame(20, 10, 0.1, Pose::new(1.0, 2.0, 0.0));
        // Cells of 0.25 m: the one from (1.25, 2.0) to (1.5, 2.25).
        let coarse = frame(8, 4, 0.25, Pose::new(1.0, 2.0, 0.0));
        let mut zones = Zones::new(&map);
        zones.close(&mask(coarse, Cell::new(1, 0), 100));
        let expected = (0..3).flat_map(|row| (2..5).map(move |column| (column, row)));
        assert_eq!(closed_cells(&zones), expected.collect::<Vec<_>>());
        // A thin line that misses the centres.
        let fine = frame(200, 100, 0.01, Pose::new(1.0, 2.0, 0.0));
        let mut zones = Zones::new(&map);
        zones.close(&mask(fine, Cell::new(31, 58), 100));
        assert_eq!(closed_cells(&zones), [(3, 5)]);
        // A mask that lies elsewhere, and values below 100.
        let mut zones = Zones::new(&map);
        zones.close(&mask(frame(3, 3, 0.1, Pose::new(50.0, 2.0, 0.0)), Cell::new(1, 1), 100));
        zones.close(&mask(map, Cell::new(1, 1), 99));
        zones.close(&mask(map, Cell::new(1, 1), -1));
        assert!(zones.is_open());
    }

    #[test]
    fn lowest_limit_stays_and_closed_cells_stay_closed() {
        let map = frame(4, 1, 1.0, Pose::default());
        let values = OccupancyGrid::new(map, vec![0, 40, 100, -1]);
        let percent = |value: i8| (value >= 0).then(|| f64::from(value));
        let mut zones = Zones::new(&map);
        zones.limit_speed(&values, percent);
        zones.limit_speed(&OccupancyGrid::new(map, vec![60, 60, 0, 0]), percent);
        let limit = |zones: &Zones, x: f64| zones.speed_limit(&Point::new(x, 0.5), 2.0);
        assert_eq!(
            [0.5, 1.5, 2.5, 3.5].map(|x| limit(&zones, x)),
            [Some(1.2), Some(0.8), None, None]
        );
        zones.close(&OccupancyGrid::new(map, vec![0, 100, 0, 0]));
        zones.limit_speed(&values, percent);
        assert_eq!(closed_cells(&zones), [(1, 0)]);
        assert_eq!(limit(&zones, 1.5), None);
        assert_eq!(Zones::from_grid(zones.grid()), zones);
        let obstacles = ObstacleGrid::new(map, vec![true, false, false, false]);
        assert_eq!(zones.with_obstacles(&obstacles).cells(), [true, true, false, false]);
    }

    /// A robot that drives at the largest permitted speed at each place and brakes by the limit keeps it.
    #[test]
    fn fastest_speed_keeps_a_limit_ahead() {
        let map = frame(100, 3, 0.1, Pose::default());
        let mut zones = Zones::new(&map);
        zones.limit_speed(&mask(map, Cell::new(80, 1), 30), |value| Some(f64::from(value)));
        let fastest = |x: f64| zones.fastest(&Point::new(x, 0.15), 1.0, 0.5);
        assert_eq!(fastest(1.0), 1.0);
        assert!((fastest(7.5) - (0.09_f64 + 0.5).sqrt()).abs() < 1e-9, "{}", fastest(7.5));
        assert!((fastest(8.05) - 0.3).abs() < 1e-9);
        assert!((fastest(8.6) - fastest(7.5)).abs() < 1e-9, "behind the zone as before it");
        assert_eq!(zones.fastest(&Point::new(f64::NAN, 0.0), 1.0, 0.5), 1.0);
    }
}
