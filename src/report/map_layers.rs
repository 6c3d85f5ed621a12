//! What lies under everything else on a map: the ground, and the global path through its stages.

use std::ops::Range;

use maud::{Markup, html};

use super::figure::{area_mark, line_mark};
use super::number::coordinate;
use super::panel::points_attribute;
use super::raster::Raster;
use super::simplify::simplify;
use super::viewport::Viewport;
use crate::geometry::Point;
use crate::map::{GridFrame, OccupancyGrid, UNKNOWN};

/// A global path through its three stages; each may be empty.
#[derive(Clone, Copy)]
pub(super) struct Stages<'a> {
    pub(super) searched: &'a [Point],
    pub(super) pruned: &'a [Point],
    pub(super) smoothed: &'a [Point],
}

impl<'a> Stages<'a> {
    /// The points of all stages.
    pub(super) fn points(&self) -> impl Iterator<Item = Point> + use<'a> {
        [self.searched, self.pruned, self.smoothed]
            .into_iter()
            .flatten()
            .copied()
    }
}

/// The grid's own area in the colour of free ground, and on it the raster of what is not free, whose longer side has
/// at most so many pixels.
pub(super) fn ground(map: &OccupancyGrid, view: &Viewport, raster_side: i32) -> Markup {
    let frame = map.frame();
    let at = |column: i32, row: i32| {
        view.at(&frame.from_cell_units(&Point::new(f64::from(column), f64::from(row))))
    };
    let area = frame.corners().map(|corner| view.at(&corner));
    let (columns, rows) = cells_in_view(frame, view);
    // Cells that can be seen singly have sharp edges; smaller ones run together as in a photograph.
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

/// The columns and rows that a view may show, within the grid.
fn cells_in_view(frame: &GridFrame, view: &Viewport) -> (Range<i32>, Range<i32>) {
    let units = view.corners().map(|corner| frame.to_cell_units(&corner));
    let range = |values: [f64; 4], end: i32| {
        let low = values.into_iter().fold(f64::INFINITY, f64::min);
        let high = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
        (low.floor() as i32).clamp(0, end)..(high.ceil() as i32).clamp(0, end)
    };
    (
        range(units.map(|unit| unit.x), frame.width),
        range(units.map(|unit| unit.y), frame.height),
    )
}

/// What the ground is made of: marks in boxes of 28 by 14 units, and their meanings.
pub(super) fn ground_keys(map: &OccupancyGrid, view: &Viewport) -> Vec<(Markup, String)> {
    let has_unknown = map.cells().contains(&UNKNOWN);
    let beyond = |corner: &Point| map.frame().cell_of(corner).is_none();
    let has_outside = view.shrunk().corners().iter().any(beyond);
    [
        (true, "rock", "obstacle"),
        (has_unknown, "unknown", "unknown"),
        (has_outside, "outside", "outside the map"),
    ]
    .into_iter()
    .filter(|(is_there, ..)| *is_there)
    .map(|(_, class, meaning)| (area_mark(class), meaning.to_owned()))
    .collect()
}

/// The path as searched, without redundant nodes, and smoothed; drawn to a tolerance in drawing units. The smoothed one
/// is a band, with the others and the nodes on it.
pub(super) fn stages(view: &Viewport, of: &Stages, tolerance: f64) -> Markup {
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

/// What the stages are: marks in boxes of 28 by 14 units, and their meanings.
pub(super) fn stage_keys() -> Vec<(Markup, String)> {
    let pruned = html! {
        (line_mark("pruned"))
        rect class="node" x="10.5" y="3.5" width="7" height="7" {}
    };
    vec![
        (line_mark("searched"), "path as searched".to_owned()),
        (pruned, "redundant nodes removed".to_owned()),
        (line_mark("smoothed"), "smoothed".to_owned()),
    ]
}

/// A planned path, its finite points only.
pub(super) fn path(view: &Viewport, class: &str, points: &[Point], tolerance: f64) -> Markup {
    let drawn: Vec<[f64; 2]> = points
        .iter()
        .filter(|point| point.x.is_finite() && point.y.is_finite())
        .map(|point| view.at(point))
        .collect();
    html! {
        @if drawn.len() > 1 {
            polyline class=(class) points=(points_attribute(&simplify(&drawn, tolerance))) {}
        }
    }
}
