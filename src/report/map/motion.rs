//! Motion on a map: the track of the robot, the trails of the obstacles, and the contacts.

use maud::{Markup, html};

use super::encounters::distance_m;
use super::viewport::Viewport;
use crate::geometry::Point;
use crate::report::number::coordinate;
use crate::report::svg::{LegendEntry, TOLERANCE, points_attribute, simplify};
use crate::runtime::{Trace, TraceRow};

/// Speed above which an obstacle has jumped from the end of its route to the start, m/s.
const JUMP_M_S: f64 = 15.0;

/// Number of speed classes with their own colour.
const SPEED_CLASSES: f64 = 4.0;

/// Distance from a class boundary, in classes, at which the colour changes. It prevents stripes in the track from noise.
const HYSTERESIS: f64 = 0.12;

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
            polyline class=(format!("track speed-{class}"))
                points=(points_attribute(&simplify(stretch, TOLERANCE))) {}
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

/// Whether a moving obstacle is in the viewport at any tick.
pub(crate) fn has_trails(trace: &Trace, view: &Viewport) -> bool {
    trace.rows.iter().any(|row| row.moving.iter().flatten().any(|center| view.shows(center)))
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
            polyline class="trail" points=(points_attribute(&simplify(&trail, TOLERANCE))) {}
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
