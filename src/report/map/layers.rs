//! Layers of a map: the occupancy grid, the global path in its stages, the track, the trails of obstacles, and the contacts.

use std::ops::Range;

use maud::{Markup, html};

use super::decorations::node_mark;
use super::encounters::distance_m;
use super::raster::Raster;
use super::viewport::{MAP_WIDTH, Viewport};
use crate::geometry::Point;
use crate::map::{GridFrame, OccupancyGrid, UNKNOWN};
use crate::report::number::coordinate;
use crate::report::svg::{LegendEntry, TOLERANCE, points_attribute, polyline};
use crate::runtime::{Trace, TraceRow};

/// Most pixels of the longer side of a grid on a page: pages hold several maps.
pub(crate) const PAGE_RASTER: i32 = 900;

/// Most pixels of the longer side of a grid on a page with a player, which zooms into the same image: one pixel for each
/// cell of 200 m at 5 cm.
pub(crate) const PLAYER_RASTER: i32 = 4096;

/// Most pixels of the longer side of a grid in a standalone picture: twice a picture width of 1440, so every cell of a
/// large mine has a pixel.
pub(crate) const STANDALONE_RASTER: i32 = 2880;

/// Speed above which an obstacle has jumped from the end of its route to the start, m/s.
const JUMP_M_S: f64 = 15.0;

/// Number of speed classes with their own colour.
const SPEED_CLASSES: f64 = 4.0;

/// Distance from a class boundary, in classes, at which the colour changes. It prevents stripes in the track from noise.
const HYSTERESIS: f64 = 0.12;

/// A global path in its three stages; each may be empty. Points that are not finite are left out.
#[derive(Clone, Copy, Debug, Default)]
pub struct PathStages<'a> {
    /// The path as the search returned it.
    pub searched: &'a [Point],
    /// The path without redundant nodes.
    pub pruned: &'a [Point],
    /// The smoothed path.
    pub smoothed: &'a [Point],
}

impl<'a> PathStages<'a> {
    /// The points of all stages.
    pub(crate) fn points(&self) -> impl Iterator<Item = Point> + use<'a> {
        [self.searched, self.pruned, self.smoothed].into_iter().flatten().copied()
    }
}

/// The background: the area outside the grid, the grid in the colour of free cells, and on it the raster of all other
/// cells. The longer side of the raster has at most `raster_side` pixels.
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
        rect class="outside" width=(MAP_WIDTH) height=(coordinate(view.height())) {}
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
pub(crate) fn stages(view: &Viewport, of: &PathStages, tolerance: f64) -> Markup {
    html! {
        (path(view, "smoothed", of.smoothed, tolerance))
        (path(view, "searched", of.searched, tolerance))
        (path(view, "pruned", of.pruned, tolerance))
        @for node in of.pruned.iter().filter(|node| view.shows(node)) {
            (node_mark(view.at(node), 7.0))
        }
    }
}

/// The legend of the stages.
pub(crate) fn stage_legend() -> [LegendEntry; 3] {
    let pruned = html! {
        line class="pruned" x1="1" x2="27" y1="7" y2="7" {}
        (node_mark([14.0, 7.0], 7.0))
    };
    [
        LegendEntry::line("searched", "searched path"),
        LegendEntry::new(pruned, "pruned path"),
        LegendEntry::line("smoothed", "smoothed path"),
    ]
}

/// The finite points of a path as a line.
pub(crate) fn path(view: &Viewport, class: &str, points: &[Point], tolerance: f64) -> Markup {
    let finite: Vec<[f64; 2]> =
        points.iter().filter(|point| point.is_finite()).map(|point| view.at(point)).collect();
    html! {
        @if finite.len() > 1 {
            (polyline(class, &finite, tolerance))
        }
    }
}

/// The highest true speed of a run, m/s.
pub(crate) fn top_speed(rows: &[TraceRow]) -> f64 {
    rows.iter()
        .map(|row| row.twist.linear.abs())
        .filter(|speed| speed.is_finite())
        .fold(0.0, f64::max)
}

/// The track of the robot, coloured by speed.
pub(crate) fn track(rows: &[TraceRow], view: &Viewport) -> Markup {
    let top = top_speed(rows).max(1e-9);
    let mut class = 0.0;
    let mut stretches: Vec<(u8, Vec<[f64; 2]>)> = Vec::new();
    for row in rows.iter().filter(|row| row.pose.is_finite()) {
        let position = view.at(&row.pose.position());
        let speed = row.twist.linear.abs() / top * SPEED_CLASSES;
        if speed < class - HYSTERESIS || speed > class + 1.0 + HYSTERESIS {
            class = libm::floor(speed).min(SPEED_CLASSES - 1.0);
        }
        if let Some((_, stretch)) = stretches.last_mut() {
            stretch.push(position);
        }
        if stretches.last().is_none_or(|&(last, _)| last != class as u8) {
            stretches.push((class as u8, vec![position]));
        }
    }
    html! {
        @for (class, stretch) in &stretches {
            (polyline(&format!("track speed-{class}"), stretch, TOLERANCE))
        }
    }
}

/// The legend of the track.
pub(crate) fn track_legend(text: String) -> LegendEntry {
    let mark = html! {
        line class="track speed-0" x1="1" x2="8" y1="7" y2="7" {}
        line class="track speed-1" x1="8" x2="14" y1="7" y2="7" {}
        line class="track speed-2" x1="14" x2="20" y1="7" y2="7" {}
        line class="track speed-3" x1="20" x2="27" y1="7" y2="7" {}
    };
    LegendEntry::new(mark, text)
}

/// The legend of the trails; none if no moving obstacle is in the viewport at any tick.
pub(crate) fn trail_legend(trace: &Trace, view: &Viewport) -> Option<LegendEntry> {
    let mut centers = trace.rows.iter().flat_map(|row| row.moving.iter().flatten());
    let has_trails = centers.any(|center| view.shows(center));
    has_trails.then(|| LegendEntry::line("trail", "trail of a moving obstacle"))
}

/// The trails of the moving obstacles inside the viewport.
pub(crate) fn trails(trace: &Trace, view: &Viewport) -> Markup {
    let trails = (0..trace.moving_radii.len()).flat_map(|obstacle| {
        let centers: Vec<(f64, Point)> = trace
            .rows
            .iter()
            .filter_map(|row| Some((row.time_s, (*row.moving.get(obstacle)?)?)))
            .collect();
        centers
            .chunk_by(|(earlier, from), (later, to)| {
                view.shows(from)
                    && view.shows(to)
                    && distance_m(from, to) <= JUMP_M_S * (later - earlier)
            })
            .map(|trail| trail.iter().map(|(_, center)| view.at(center)).collect())
            .collect::<Vec<Vec<[f64; 2]>>>()
    });
    html! {
        @for trail in trails.filter(|trail| trail.len() > 1) {
            (polyline("trail", &trail, TOLERANCE))
        }
    }
}

/// A cross at the first tick of each contact.
pub(crate) fn contacts(rows: &[TraceRow], view: &Viewport) -> Markup {
    let touches = |row: &TraceRow| row.gap_m <= 0.0;
    let first_rows = rows
        .chunk_by(|a, b| touches(a) == touches(b))
        .filter_map(|stretch| stretch.first())
        .filter(|row| touches(row) && view.shows(&row.pose.position()));
    html! {
        @for row in first_rows {
            @let [x, y] = view.at(&row.pose.position());
            path class="contact-mark" d=(format!("M{} {}l12 12m0 -12l-12 12", coordinate(x - 6.0), coordinate(y - 6.0))) {}
        }
    }
}
