//! The lowest layers of a map: the occupancy grid, and the global path in its stages.

use std::ops::Range;

use maud::{Markup, html};

use super::raster::Raster;
use super::viewport::Viewport;
use crate::geometry::Point;
use crate::map::{GridFrame, OccupancyGrid, UNKNOWN};
use crate::report::number::coordinate;
use crate::report::svg::{LegendEntry, points_attribute, simplify};

/// Most pixels of the longer side of a grid on a page: pages hold several maps.
pub(crate) const PAGE_RASTER: i32 = 900;

/// Most pixels of the longer side of a grid in a standalone picture: twice a picture width of 1440, so every cell of a
/// large mine has a pixel.
pub(crate) const STANDALONE_RASTER: i32 = 2880;

/// A global path in its three stages; each may be empty.
#[derive(Clone, Copy)]
pub(crate) struct Stages<'a> {
    pub(crate) searched: &'a [Point],
    pub(crate) pruned: &'a [Point],
    pub(crate) smoothed: &'a [Point],
}

impl<'a> Stages<'a> {
    /// The points of all stages.
    pub(crate) fn points(&self) -> impl Iterator<Item = Point> + use<'a> {
        [self.searched, self.pruned, self.smoothed].into_iter().flatten().copied()
    }
}

/// The area of the grid in the colour of free cells, and on it the raster of all other cells. The longer side of the
/// raster has at most `raster_side` pixels.
pub(crate) fn ground(map: &OccupancyGrid, view: &Viewport, raster_side: i32) -> Markup {
    let frame = map.frame();
    let at = |column: i32, row: i32| {
        view.at(&frame.from_cell_units(&Point::new(f64::from(column), f64::from(row))))
    };
    let area = frame.corners().map(|corner| view.at(&corner));
    let (columns, rows) = cells_in_view(frame, view);
    // Visible cells have sharp edges; smaller ones are interpolated as in a photograph.
    let is_coarse = frame.resolution_m * view.scale() >= 1.0;
    html! {
        polygon class="free" points=(points_attribute(&area)) {}
        @if !columns.is_empty() && !rows.is_empty() {
            @let raster = Raster::new(map, columns.clone(), rows.clone(), raster_side);
            @let corner = at(columns.start, rows.start);
            @let along = at(columns.start + raster.block, rows.start);
            @let up = at(columns.start, rows.start + raster.block);
            image class=(if is_coarse { "ground cells" } else { "ground" })
                width=(raster.width) height=(raster.height) preserveAspectRatio="none" href=(raster.data_uri)
                transform=(format!(
                    "matrix({:.5} {:.5} {:.5} {:.5} {:.3} {:.3})",
                    along[0] - corner[0], along[1] - corner[1], up[0] - corner[0], up[1] - corner[1],
                    corner[0], corner[1]
                )) {}
        }
    }
}

/// The columns and rows of the grid that a viewport may show.
fn cells_in_view(frame: &GridFrame, view: &Viewport) -> (Range<i32>, Range<i32>) {
    let units = view.corners().map(|corner| frame.to_cell_units(&corner));
    let range = |values: [f64; 4], end: i32| {
        let low = values.into_iter().fold(f64::INFINITY, f64::min);
        let high = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
        (low.floor() as i32).clamp(0, end)..(high.ceil() as i32).clamp(0, end)
    };
    (range(units.map(|unit| unit.x), frame.width), range(units.map(|unit| unit.y), frame.height))
}

/// The legend of the grid.
pub(crate) fn ground_legend(map: &OccupancyGrid, view: &Viewport) -> Vec<LegendEntry> {
    let has_unknown = map.cells().contains(&UNKNOWN);
    let is_outside = |corner: &Point| map.frame().cell_of(corner).is_none();
    let has_outside = view.shrunk().corners().iter().any(is_outside);
    [
        (true, "rock", "obstacle"),
        (has_unknown, "unknown", "unknown"),
        (has_outside, "outside", "outside the map"),
    ]
    .into_iter()
    .filter(|(is_present, ..)| *is_present)
    .map(|(_, class, text)| LegendEntry::area(class, text))
    .collect()
}

/// The smoothed path as a band, and on it the searched path, the pruned path and its nodes. The tolerance is in drawing
/// units.
pub(crate) fn stages(view: &Viewport, of: &Stages, tolerance: f64) -> Markup {
    html! {
        (path(view, "smoothed", of.smoothed, tolerance))
        (path(view, "searched", of.searched, tolerance))
        (path(view, "pruned", of.pruned, tolerance))
        @for node in of.pruned.iter().filter(|node| view.shows(node)) {
            @let [x, y] = view.at(node);
            rect class="node" x=(coordinate(x - 3.5)) y=(coordinate(y - 3.5)) width="7" height="7" {}
        }
    }
}

/// The legend of the stages.
pub(crate) fn stage_legend() -> [LegendEntry; 3] {
    let pruned = html! {
        line class="pruned" x1="1" x2="27" y1="7" y2="7" {}
        rect class="node" x="10.5" y="3.5" width="7" height="7" {}
    };
    [
        LegendEntry::line("searched", "searched path"),
        LegendEntry::new(pruned, "pruned path"),
        LegendEntry::line("smoothed", "smoothed path"),
    ]
}

/// The finite points of a path as a line.
pub(crate) fn path(view: &Viewport, class: &str, points: &[Point], tolerance: f64) -> Markup {
    let finite: Vec<[f64; 2]> = points
        .iter()
        .filter(|point| point.x.is_finite() && point.y.is_finite())
        .map(|point| view.at(point))
        .collect();
    html! {
        @if finite.len() > 1 {
            polyline class=(class) points=(points_attribute(&simplify(&finite, tolerance))) {}
        }
    }
}
