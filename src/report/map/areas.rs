//! Areas of a map: zones that are closed or have a speed limit, and what has changed.

use std::fmt::Write;

use maud::{Markup, html};

use super::viewport::Viewport;
use crate::geometry::Point;
use crate::localization::MapChanges;
use crate::map::{GridFrame, OccupancyGrid, Zones};
use crate::report::number::coordinate;
use crate::report::svg::LegendEntry;

/// A kind of areas: its class, its legend, and the least and greatest value of its cells.
type Kind = (&'static str, &'static str, [i8; 2]);

const ZONES: [Kind; 2] =
    [("slow-zone", "zone with a speed limit", [1, 99]), ("closed-zone", "closed zone", [100, 100])];
const CHANGES: [Kind; 2] = [
    ("appeared", "appeared, not on the map", [1, 1]),
    ("vanished", "vanished, still on the map", [2, 2]),
];

/// A rectangle of cells: columns and rows, the upper ends exclusive.
type Rectangle = [i32; 4];

/// Areas of two kinds.
pub(crate) struct Areas {
    cells: Option<OccupancyGrid>,
    kinds: [Kind; 2],
}

impl Areas {
    /// Zones that are closed or have a speed limit.
    pub(crate) fn of_zones(zones: Option<&Zones>) -> Self {
        Self { cells: zones.map(|zones| zones.grid().clone()), kinds: ZONES }
    }

    /// What has changed on a map.
    pub(crate) fn of_changes(changes: Option<&MapChanges>, frame: &GridFrame) -> Self {
        let cells = changes.map(|changes| {
            let mut cells = OccupancyGrid::filled(*frame, 0);
            for (changed, value) in [(&changes.appeared, 1), (&changes.vanished, 2)] {
                changed.iter().for_each(|cell| cells.set(*cell, value));
            }
            cells
        });
        Self { cells, kinds: CHANGES }
    }

    /// The areas of each kind.
    pub(crate) fn draw(&self, view: &Viewport) -> Markup {
        html! {
            @if let Some(cells) = &self.cells {
                @for (class, _, values) in self.kinds {
                    @let outline = outline(cells, values, view);
                    @if !outline.is_empty() { path class=(class) d=(outline) {} }
                }
            }
        }
    }

    /// The legend of the kinds that occur.
    pub(crate) fn legend(&self) -> Vec<LegendEntry> {
        let cells = self.cells.as_ref().map_or(&[][..], OccupancyGrid::cells);
        let occurs =
            |(.., [low, high]): &&Kind| cells.iter().any(|cell| (low..=high).contains(&cell));
        let occurring = self.kinds.iter().filter(occurs);
        occurring.map(|(class, text, _)| LegendEntry::area(class, *text)).collect()
    }
}

/// The rectangles of cells with these values as one path.
fn outline(grid: &OccupancyGrid, values: [i8; 2], view: &Viewport) -> String {
    let frame = grid.frame();
    let mut path = String::new();
    for [left, low, right, high] in rectangles(grid, values) {
        for (command, x, y) in
            [('M', left, low), ('L', right, low), ('L', right, high), ('L', left, high)]
        {
            let [x, y] = view.at(&frame.from_cell_units(&Point::new(f64::from(x), f64::from(y))));
            // Writing to a string never fails.
            let _ = write!(path, "{command}{} {}", coordinate(x), coordinate(y));
        }
        path.push('Z');
    }
    path
}

/// Runs of cells of a row, joined with equal runs of the rows below.
fn rectangles(grid: &OccupancyGrid, [low, high]: [i8; 2]) -> Vec<Rectangle> {
    let width = grid.frame().width as usize;
    let mut finished = Vec::new();
    let mut open: Vec<Rectangle> = Vec::new();
    for (row, cells) in (0..).zip(grid.cells().chunks_exact(width)) {
        let mut next = Vec::new();
        let mut column = 0;
        while column < width {
            let run = cells[column..].iter().take_while(|cell| (low..=high).contains(cell)).count();
            if run > 0 {
                let (left, right) = (column as i32, (column + run) as i32);
                let below = open.iter().position(|it| it[0] == left && it[2] == right);
                let from = below.map_or(row, |index| open.swap_remove(index)[1]);
                next.push([left, from, right, row + 1]);
            }
            column += run.max(1);
        }
        finished.append(&mut open);
        open = next;
    }
    finished.append(&mut open);
    finished
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::map::GridFrame;

    #[test]
    fn cells_are_covered_once_by_few_rectangles() {
        let frame = GridFrame::new(6, 4, 1.0, Pose::default()).expect("a frame");
        #[rustfmt::skip]
        let cells = vec![
            0, 7, 7, 0, 0, 0,
            0, 7, 7, 0, 0, 9,
            7, 7, 7, 0, 0, 100,
            7, 7, 7, 0, 0, 0,
        ];
        let grid = OccupancyGrid::new(frame, cells);
        let mut slow = rectangles(&grid, [1, 99]);
        slow.sort_unstable();
        assert_eq!(slow, [[0, 2, 3, 4], [1, 0, 3, 2], [5, 1, 6, 2]]);
        assert_eq!(rectangles(&grid, [100, 100]), [[5, 2, 6, 3]]);
    }
}
