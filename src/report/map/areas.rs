//! Areas of a map: zones that are closed or have a speed limit, and what has changed.

use std::fmt::Write;

use maud::{Markup, html};

use super::viewport::Viewport;
use crate::geometry::Point;
use crate::localization::MapChanges;
use crate::map::{GridFrame, OccupancyGrid, Zones};
use crate::report::number::coordinate;
use crate::report::svg::LegendEntry;

/// The classes of zones with their legends, and the values of their cells.
const KINDS: [(&str, &str, [i8; 2]); 2] =
    [("slow-zone", "zone with a speed limit", [1, 99]), ("closed-zone", "closed zone", [100, 100])];

/// A rectangle of cells: columns and rows, the upper ends exclusive.
type Rectangle = [i32; 4];

/// The areas of each kind.
pub(crate) fn zones(zones: Option<&Zones>, view: &Viewport) -> Markup {
    let grid = zones.map(Zones::to_grid);
    html! {
        @if let Some(grid) = &grid {
            @for (class, _, values) in KINDS {
                @let outline = outline(grid, values, view);
                @if !outline.is_empty() { path class=(class) d=(outline) {} }
            }
        }
    }
}

/// The legend of the zones.
pub(crate) fn zones_legend(zones: Option<&Zones>) -> Vec<LegendEntry> {
    let has = zones.map_or([false; 2], |zones| [zones.has_speed_limits(), !zones.is_open()]);
    let present = KINDS.iter().zip(has).filter(|(_, has)| *has);
    present.map(|((class, text, _), _)| LegendEntry::area(class, *text)).collect()
}

/// The classes of changed cells with their legends, and the values of such cells.
const CHANGES: [(&str, &str, i8); 2] =
    [("appeared", "appeared, not on the map", 1), ("vanished", "vanished, still on the map", 2)];

/// The cells of a map that have changed, with the values of [`CHANGES`].
fn changed_cells(changes: &MapChanges, frame: &GridFrame) -> OccupancyGrid {
    let mut cells = vec![0; frame.len()];
    for (changed, value) in [(&changes.appeared, 1), (&changes.vanished, 2)] {
        changed.iter().for_each(|cell| cells[frame.index(*cell)] = value);
    }
    OccupancyGrid::new(*frame, cells)
}

/// What has changed on a map.
pub(crate) fn map_changes(
    changes: Option<&MapChanges>,
    frame: &GridFrame,
    view: &Viewport,
) -> Markup {
    let grid = changes.filter(|it| !it.is_empty()).map(|changes| changed_cells(changes, frame));
    html! {
        @if let Some(grid) = &grid {
            @for (class, _, value) in CHANGES {
                path class=(class) d=(outline(grid, [value, value], view)) {}
            }
        }
    }
}

/// The legend of what has changed.
pub(crate) fn map_changes_legend(changes: Option<&MapChanges>) -> Vec<LegendEntry> {
    let has = |value: i8| {
        changes.is_some_and(|it| !if value == 1 { &it.appeared } else { &it.vanished }.is_empty())
    };
    let present = CHANGES.iter().filter(|(_, _, value)| has(*value));
    present.map(|(class, text, _)| LegendEntry::area(class, *text)).collect()
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
