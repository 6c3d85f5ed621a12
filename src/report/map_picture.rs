//! The map of a mission: the ground, the planned paths, the driven track and what moved.

use std::ops::Range;

use maud::{Markup, html};

use super::MissionView;
use super::encounters::Encounters;
use super::figure::{Figure, Table, area_key, key, line_key};
use super::gap_chart::closest;
use super::map_furniture::{goal_mark, labels, start_mark, strip};
use super::map_motion::{contacts, has_trails, top_speed, track, trails};
use super::number::{coordinate, fixed};
use super::panel::points_attribute;
use super::raster::Raster;
use super::simplify::{TOLERANCE, simplify};
use super::viewport::{MAP_WIDTH, Viewport};
use crate::geometry::Point;
use crate::map::{GridFrame, OccupancyGrid, UNKNOWN};

/// Height of the strip below the map with the scale bar and the axes.
pub(super) const STRIP: f64 = 44.0;

pub(super) fn figure(mission: &MissionView) -> Markup {
    let view = viewport(mission);
    let encounters = Encounters::of(mission, &view);
    Figure {
        title: "Where it went",
        picture: picture(mission, &view, &encounters),
        legend: legend(mission, &view, &encounters),
        caption: caption(&view, &encounters),
        table: table(mission),
    }
    .markup()
}

fn viewport(mission: &MissionView) -> Viewport {
    let driven = mission.trace.rows.iter().map(|row| row.pose.position());
    let planned = [mission.searched, mission.pruned, mission.smoothed];
    let points = driven
        .chain(planned.into_iter().flatten().copied())
        .chain(mission.trace.paths.iter().flatten().copied())
        .chain([mission.start.position(), mission.goal]);
    Viewport::around(points, mission.map.frame())
}

fn picture(mission: &MissionView, view: &Viewport, encounters: &Encounters) -> Markup {
    let trace = mission.trace;
    let height = view.height();
    html! {
        svg class="map-picture" xmlns="http://www.w3.org/2000/svg" role="img"
            aria-label=(alternative(mission)) viewBox=(format!("0 0 {MAP_WIDTH} {}", coordinate(height + STRIP))) {
            rect class="outside" width=(MAP_WIDTH) height=(coordinate(height)) {}
            (ground(mission.map, view))
            (trails(trace, view))
            (path(view, "searched", mission.searched))
            (path(view, "pruned", mission.pruned))
            @for node in mission.pruned.iter().filter(|node| view.shows(node)) {
                @let [x, y] = view.at(node);
                rect class="node" x=(coordinate(x - 3.5)) y=(coordinate(y - 3.5)) width="7" height="7" {}
            }
            (path(view, "smoothed", mission.smoothed))
            @for replanned in trace.paths.iter().skip(1) { (path(view, "replanned", replanned)) }
            (track(&trace.rows, view))
            (encounters.draw(mission.footprint, view))
            @if let Some(row) = closest(&trace.rows) {
                @let [x, y] = view.at(&row.pose.position());
                circle class="closest" cx=(coordinate(x)) cy=(coordinate(y)) r="6" {}
            }
            (contacts(&trace.rows, view))
            (start_mark(view.at(&mission.start.position()), mission.start.yaw))
            (goal_mark(view.at(&mission.goal)))
            (encounters.draw_numbers())
            (labels(view, &mission.start.position(), &mission.goal))
            (strip(view, height))
        }
    }
}

/// The grid's own area in the colour of free ground, and on it the raster of what is not free.
pub(super) fn ground(map: &OccupancyGrid, view: &Viewport) -> Markup {
    let frame = map.frame();
    let at = |column: i32, row: i32| {
        view.at(&frame.from_cell_units(&Point::new(f64::from(column), f64::from(row))))
    };
    let area = frame.corners().map(|corner| view.at(&corner));
    let (columns, rows) = cells_in_view(frame, view);
    html! {
        polygon class="free" points=(points_attribute(&area)) {}
        @if !columns.is_empty() && !rows.is_empty() {
            @let raster = Raster::new(map, columns.clone(), rows.clone());
            @let corner = at(columns.start, rows.start);
            @let along = at(columns.start + raster.block, rows.start);
            @let up = at(columns.start, rows.start + raster.block);
            image class=(if raster.block == 1 { "ground cells" } else { "ground" })
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

/// A planned path, its finite points only.
pub(super) fn path(view: &Viewport, class: &str, points: &[Point]) -> Markup {
    let drawn: Vec<[f64; 2]> = points
        .iter()
        .filter(|point| point.x.is_finite() && point.y.is_finite())
        .map(|point| view.at(point))
        .collect();
    html! {
        @if drawn.len() > 1 {
            polyline class=(class) points=(points_attribute(&simplify(&drawn, TOLERANCE))) {}
        }
    }
}

fn legend(mission: &MissionView, view: &Viewport, encounters: &Encounters) -> Vec<Markup> {
    let trace = mission.trace;
    let mut legend = vec![
        key(&start_mark([12.0, 7.0], 0.0), "start"),
        key(&goal_mark([14.0, 7.0]), "goal"),
        line_key("searched", "path as searched"),
        key(
            &html! {
                line class="pruned" x1="1" x2="27" y1="7" y2="7" {}
                rect class="node" x="10.5" y="3.5" width="7" height="7" {}
            },
            "redundant nodes removed",
        ),
        line_key("smoothed", "smoothed"),
    ];
    if trace.paths.len() > 1 {
        legend.push(line_key("replanned", "planned again on the way"));
    }
    if !trace.rows.is_empty() {
        legend.push(key(
            &html! {
                line class="track speed-0" x1="1" x2="8" y1="7" y2="7" {}
                line class="track speed-1" x1="8" x2="14" y1="7" y2="7" {}
                line class="track speed-2" x1="14" x2="20" y1="7" y2="7" {}
                line class="track speed-3" x1="20" x2="27" y1="7" y2="7" {}
            },
            &format!(
                "driven, from standing to {} m/s in quarters",
                fixed(top_speed(&trace.rows), 2)
            ),
        ));
    }
    legend.extend(encounters.legend());
    if has_trails(trace, view) {
        legend.push(line_key("trail", "way of a moving obstacle"));
    }
    if closest(&trace.rows).is_some() {
        legend.push(key(
            &html! { circle class="closest" cx="14" cy="7" r="6" {} },
            "smallest gap",
        ));
    }
    if trace.rows.iter().any(|row| row.gap_m <= 0.0) {
        legend.push(key(
            &html! { path class="contact-mark" d="M9 2l10 10m0 -10l-10 10" {} },
            "contact",
        ));
    }
    legend.push(area_key("rock", "obstacle"));
    if mission.map.cells().contains(&UNKNOWN) {
        legend.push(area_key("unknown", "unknown"));
    }
    let beyond = |corner: &Point| mission.map.frame().cell_of(corner).is_none();
    if view.shrunk().corners().iter().any(beyond) {
        legend.push(area_key("outside", "outside the map"));
    }
    legend
}

fn caption(view: &Viewport, encounters: &Encounters) -> String {
    let mut caption = format!(
        "Shown is x {} to {} m and y {} to {} m of the map frame.",
        fixed(view.low.x, 1),
        fixed(view.high.x, 1),
        fixed(view.low.y, 1),
        fixed(view.high.y, 1)
    );
    caption += &encounters.in_words();
    caption
}

fn alternative(mission: &MissionView) -> String {
    let outcome = &mission.outcome;
    format!(
        "Map with the planned paths and the driven track from ({}, {}) to the goal ({}, {}), metres. The goal was {}; \
         {}. {} moving obstacles, {} plans.",
        fixed(mission.start.x, 1),
        fixed(mission.start.y, 1),
        fixed(mission.goal.x, 1),
        fixed(mission.goal.y, 1),
        if outcome.reached {
            "reached"
        } else {
            "not reached"
        },
        if outcome.collided {
            "there was contact"
        } else {
            "there was no contact"
        },
        mission.trace.moving_radii.len(),
        mission.trace.paths.len().max(1)
    )
}

fn table(mission: &MissionView) -> Table<'static> {
    let heads = &[
        "time, s",
        "x, m",
        "y, m",
        "yaw, rad",
        "local target x, m",
        "local target y, m",
    ];
    Table::of_ticks("track", heads, &mission.trace.rows, |_, row| {
        vec![
            fixed(row.time_s, 2),
            fixed(row.pose.x, 3),
            fixed(row.pose.y, 3),
            fixed(row.pose.yaw, 3),
            fixed(row.local_target.x, 2),
            fixed(row.local_target.y, 2),
        ]
    })
}
