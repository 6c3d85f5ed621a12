//! What moved on the map: the driven track, the ways of the obstacles, and where contacts began.

use maud::{Markup, html};

use super::number::coordinate;
use super::panel::points_attribute;
use super::simplify::{TOLERANCE, simplify};
use super::snapshot::distance_m;
use super::viewport::Viewport;
use crate::geometry::Point;
use crate::runtime::{Trace, TraceRow};

/// A faster obstacle, m/s, has jumped from the end of its way to the start.
const JUMP_M_S: f64 = 15.0;

/// Classes of speed that the track's colour tells apart.
const SPEED_CLASSES: f64 = 4.0;

/// How far, in classes, the speed must be past a border before the colour changes: noise must not stripe the track.
const HYSTERESIS: f64 = 0.12;

/// The highest true speed of a run, m/s.
pub(super) fn top_speed(rows: &[TraceRow]) -> f64 {
    rows.iter()
        .map(|row| row.twist.linear.abs())
        .filter(|speed| speed.is_finite())
        .fold(0.0, f64::max)
}

/// The driven track, its colour the speed.
pub(super) fn track(rows: &[TraceRow], view: &Viewport) -> Markup {
    let top = top_speed(rows).max(1e-9);
    let mut class = 0.0;
    let mut stretches: Vec<(u8, Vec<[f64; 2]>)> = Vec::new();
    for row in rows.iter().filter(|row| row.pose.is_finite()) {
        let place = view.at(&row.pose.position());
        let speed = row.twist.linear.abs() / top * SPEED_CLASSES;
        if speed < class - HYSTERESIS || speed > class + 1.0 + HYSTERESIS {
            class = libm::floor(speed).min(SPEED_CLASSES - 1.0);
        }
        if let Some((_, stretch)) = stretches.last_mut() {
            stretch.push(place);
        }
        if stretches
            .last()
            .is_none_or(|&(last, _)| last != class as u8)
        {
            stretches.push((class as u8, vec![place]));
        }
    }
    html! {
        @for (class, stretch) in &stretches {
            polyline class=(format!("track speed-{class}"))
                points=(points_attribute(&simplify(stretch, TOLERANCE))) {}
        }
    }
}

/// Whether any moving obstacle is ever in the picture.
pub(super) fn has_trails(trace: &Trace, view: &Viewport) -> bool {
    trace
        .rows
        .iter()
        .any(|row| row.moving.iter().flatten().any(|center| view.shows(center)))
}

/// The ways of the moving obstacles as far as the picture shows them.
pub(super) fn trails(trace: &Trace, view: &Viewport) -> Markup {
    let ways = (0..trace.moving_radii.len()).flat_map(|obstacle| {
        let seen: Vec<(f64, Point)> = trace
            .rows
            .iter()
            .filter_map(|row| Some((row.time_s, (*row.moving.get(obstacle)?)?)))
            .collect();
        seen.chunk_by(|(earlier, from), (later, to)| {
            view.shows(from)
                && view.shows(to)
                && distance_m(from, to) <= JUMP_M_S * (later - earlier)
        })
        .map(|way| way.iter().map(|(_, place)| view.at(place)).collect())
        .collect::<Vec<Vec<[f64; 2]>>>()
    });
    html! {
        @for way in ways.filter(|way| way.len() > 1) {
            polyline class="trail" points=(points_attribute(&simplify(&way, TOLERANCE))) {}
        }
    }
}

/// A cross where each contact begins.
pub(super) fn contacts(rows: &[TraceRow], view: &Viewport) -> Markup {
    let touches = |row: &TraceRow| row.gap_m <= 0.0;
    let begins = rows
        .chunk_by(|a, b| touches(a) == touches(b))
        .filter_map(|stretch| stretch.first())
        .filter(|row| touches(row) && view.shows(&row.pose.position()));
    html! {
        @for row in begins {
            @let [x, y] = view.at(&row.pose.position());
            path class="contact-mark" d=(format!("M{} {}l12 12m0 -12l-12 12", coordinate(x - 6.0), coordinate(y - 6.0))) {}
        }
    }
}
