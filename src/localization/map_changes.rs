//! Changes of a map: cells, areas, and the map with them.

use std::collections::BTreeSet;

use serde::Serialize;

use crate::geometry::Point;
use crate::map::{Cell, GridFrame, OCCUPIED_THRESHOLD, OccupancyGrid, UNKNOWN};

/// An area of cells that touch, in the map frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ChangedArea {
    /// Middle of its bounding box along x and y, metres.
    pub x: f64,
    /// See `x`.
    pub y: f64,
    /// Sides of its bounding box along the axes of the grid, metres.
    pub width_m: f64,
    /// See `width_m`.
    pub height_m: f64,
    /// Number of its cells.
    pub cells: usize,
}

/// Cells of a map that scans contradicted for minutes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MapChanges {
    /// Free cells of the map with an obstacle, in the order of their indices.
    pub appeared: Vec<Cell>,
    /// Occupied cells of the map without one.
    pub vanished: Vec<Cell>,
}

impl MapChanges {
    /// The changes among cells that scans contradicted. An unknown cell of the map is no change.
    pub(super) fn of(map: &OccupancyGrid, cells: &[u32]) -> Self {
        let mut changes = Self { appeared: Vec::new(), vanished: Vec::new() };
        for &index in cells {
            let cell = map.frame().cell_at(index as usize);
            match map.cells()[index as usize] {
                UNKNOWN => {}
                value if value >= OCCUPIED_THRESHOLD => changes.vanished.push(cell),
                _ => changes.appeared.push(cell),
            }
        }
        changes
    }

    /// Whether there are none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.appeared.is_empty() && self.vanished.is_empty()
    }

    /// Longest side of the areas in which other changes differ from these, metres; zero where they are the same.
    #[cfg(feature = "sim")]
    pub(crate) fn largest_difference_m(&self, other: &Self, frame: &GridFrame) -> f64 {
        let lists = [(&self.appeared, &other.appeared), (&self.vanished, &other.vanished)];
        let areas = lists.into_iter().flat_map(|(one, other)| {
            let [one, other] =
                [one, other].map(|cells| cells.iter().copied().collect::<BTreeSet<Cell>>());
            let cells: Vec<Cell> = one.symmetric_difference(&other).copied().collect();
            areas(&cells, frame)
        });
        areas.map(|area| area.width_m.max(area.height_m)).fold(0.0, f64::max)
    }

    /// The map with the changes: occupied where an obstacle appeared, free where one vanished.
    ///
    /// # Panics
    /// Panics if the map is smaller than that of the changes.
    #[must_use]
    pub fn applied_to(&self, map: &OccupancyGrid) -> OccupancyGrid {
        let frame = *map.frame();
        let mut cells = map.cells().to_vec();
        for (changed, value) in [(&self.appeared, 100), (&self.vanished, 0)] {
            for cell in changed {
                cells[frame.index(*cell)] = value;
            }
        }
        OccupancyGrid::new(frame, cells)
    }

    /// The areas of obstacles that appeared and of those that vanished, the largest first.
    #[must_use]
    pub fn areas(&self, frame: &GridFrame) -> [Vec<ChangedArea>; 2] {
        [areas(&self.appeared, frame), areas(&self.vanished, frame)]
    }
}

/// Groups of cells that touch at edges or corners.
fn areas(cells: &[Cell], frame: &GridFrame) -> Vec<ChangedArea> {
    let mut left: BTreeSet<Cell> = cells.iter().copied().collect();
    let mut areas = Vec::new();
    while let Some(first) = left.pop_first() {
        let (mut low, mut high, mut count) = (first, first, 0);
        let mut open = vec![first];
        while let Some(cell) = open.pop() {
            count += 1;
            low = Cell::new(low.column.min(cell.column), low.row.min(cell.row));
            high = Cell::new(high.column.max(cell.column), high.row.max(cell.row));
            for (right, up) in (-1..=1).flat_map(|up| (-1..=1).map(move |right| (right, up))) {
                let neighbour = Cell::new(cell.column + right, cell.row + up);
                if left.remove(&neighbour) {
                    open.push(neighbour);
                }
            }
        }
        let middle = |low: i32, high: i32| f64::midpoint(f64::from(low), f64::from(high + 1));
        let center = Point::new(middle(low.column, high.column), middle(low.row, high.row));
        let Point { x, y } = frame.from_cell_units(&center);
        let side_m = |low: i32, high: i32| f64::from(high - low + 1) * frame.resolution_m;
        areas.push(ChangedArea {
            x,
            y,
            width_m: side_m(low.column, high.column),
            height_m: side_m(low.row, high.row),
            cells: count,
        });
    }
    areas.sort_by_key(|area| std::cmp::Reverse(area.cells));
    areas
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;

    #[test]
    fn areas_are_cells_that_touch_and_the_map_has_them() {
        let frame = GridFrame::new(8, 4, 0.5, Pose::new(10.0, 0.0, 0.0)).expect("a frame");
        let mut cells = vec![0; frame.len()];
        cells[frame.index(Cell::new(7, 3))] = 100;
        cells[frame.index(Cell::new(0, 3))] = UNKNOWN;
        let map = OccupancyGrid::new(frame, cells);
        let at = |column: i32, row: i32| frame.index(Cell::new(column, row)) as u32;
        let contradicted = [at(1, 0), at(2, 1), at(5, 1), at(0, 3), at(7, 3)];
        let changes = MapChanges::of(&map, &contradicted);
        assert_eq!(changes.vanished, [Cell::new(7, 3)]);
        let [appeared, vanished] = changes.areas(&frame);
        let area = |x, y, width_m, height_m, cells| ChangedArea { x, y, width_m, height_m, cells };
        assert_eq!(appeared, [area(11.0, 0.5, 1.0, 1.0, 2), area(12.75, 0.75, 0.5, 0.5, 1)]);
        assert_eq!(vanished, [area(13.75, 1.75, 0.5, 0.5, 1)]);
        let updated = changes.applied_to(&map);
        let value = |column: i32, row: i32| updated.cells()[frame.index(Cell::new(column, row))];
        assert_eq!([value(1, 0), value(5, 1), value(7, 3), value(0, 3)], [100, 100, 0, UNKNOWN]);
    }
}
