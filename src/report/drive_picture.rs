//! A drive as one picture, to be looked at without a page.

use maud::{Markup, html};

use super::figure::line_mark;
use super::map_furniture::{goal_mark, labels, start_mark};
use super::map_layers::{ground, ground_keys, path};
use super::map_motion::{contacts, has_trails, top_speed, track, trails};
use super::number::{coordinate, fixed};
use super::sheet::{RASTER_SIDE, Sheet, TOLERANCE};
use super::viewport::{MAP_WIDTH, Viewport};
use crate::geometry::{Point, Pose};
use crate::map::OccupancyGrid;
use crate::runtime::Trace;

const OWN_STYLE: &str = ".planned { stroke: var(--path); stroke-width: 1.2; opacity: .35; } \
    .track { stroke-width: 2.5; } .speed-0 { stroke: var(--speed-0); } .speed-1 { stroke: var(--speed-1); } \
    .speed-2 { stroke: var(--speed-2); } .speed-3 { stroke: var(--speed-3); } \
    .trail { stroke: var(--moving); stroke-width: 1.5; opacity: .45; } \
    .contact-mark { fill: none; stroke: var(--bad); stroke-width: 3; }";

/// A drive as its picture shows it. Points that are not finite are left out.
#[derive(Clone, Debug)]
pub struct DriveView<'a> {
    /// Headline. It may hold any characters; it is escaped, and cut where it is too long.
    pub title: &'a str,
    /// What came of it, in a line.
    pub caption: &'a str,
    /// The ground.
    pub map: &'a OccupancyGrid,
    /// Where the robot started.
    pub start: Pose,
    /// Where it was to go.
    pub goal: Point,
    /// What happened.
    pub trace: &'a Trace,
}

/// An SVG file: the ground, every path that was planned, the track driven, its colour the speed, and a legend.
#[must_use]
pub fn drive_svg(drive: &DriveView) -> String {
    let rows = &drive.trace.rows;
    let driven = rows.iter().map(|row| row.pose.position());
    let points = driven
        .chain(drive.trace.paths.iter().flatten().copied())
        .chain([drive.start.position(), drive.goal]);
    let view = Viewport::around(points, drive.map.frame());
    Sheet {
        title: drive.title,
        caption: drive.caption,
        style: OWN_STYLE,
        map: map(drive, &view),
        keys: keys(drive, &view),
    }
    .svg(&view)
}

fn map(drive: &DriveView, view: &Viewport) -> Markup {
    let trace = drive.trace;
    html! {
        rect class="outside" width=(MAP_WIDTH) height=(coordinate(view.height())) {}
        (ground(drive.map, view, RASTER_SIDE))
        (trails(trace, view))
        @for planned in &trace.paths { (path(view, "planned", planned, TOLERANCE)) }
        (track(&trace.rows, view))
        (contacts(&trace.rows, view))
        (start_mark(view.at(&drive.start.position()), drive.start.yaw))
        (goal_mark(view.at(&drive.goal)))
        (labels(view, &drive.start.position(), &drive.goal))
    }
}

fn keys(drive: &DriveView, view: &Viewport) -> Vec<(Markup, String)> {
    let trace = drive.trace;
    let fastest = fixed(top_speed(&trace.rows), 2);
    let mut keys = vec![
        (start_mark([12.0, 7.0], 0.0), "start".to_owned()),
        (goal_mark([14.0, 7.0]), "goal".to_owned()),
        (line_mark("planned"), "planned".to_owned()),
        (
            line_mark("track speed-0"),
            "driven, slowest quarter".to_owned(),
        ),
        (
            line_mark("track speed-3"),
            format!("driven, up to {fastest} m/s"),
        ),
    ];
    if has_trails(trace, view) {
        keys.push((line_mark("trail"), "way of a moving obstacle".to_owned()));
    }
    keys.extend(ground_keys(drive.map, view));
    keys
}
