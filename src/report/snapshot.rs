//! Moments of a run at which the map shows the robot and what moves near it.

use super::viewport::Viewport;
use crate::geometry::Point;
use crate::runtime::{Trace, TraceRow};

/// Moments shown, at most.
const MOST: usize = 6;

/// Moments spread evenly over the run, taken as far as there is room.
const EVEN: usize = 5;

/// Least distance between the robot at two moments, drawing units.
const APART: f64 = 34.0;

/// How far a moving obstacle may be from the robot's origin, metres, to be shown with it.
pub(super) const NEAR_M: f64 = 4.0;

/// Rows to show, in order of time: first those where a moving obstacle passed closest, each obstacle once, then
/// some spread over the run; none too near to another in the drawing.
pub(super) fn moments<'a>(trace: &'a Trace, view: &Viewport) -> Vec<&'a TraceRow> {
    let rows = &trace.rows;
    let even = (1..=EVEN).map(|part| rows.len() * part / (EVEN + 1));
    let mut chosen: Vec<usize> = Vec::new();
    for index in closest_passes(trace).into_iter().chain(even) {
        let Some(place) = rows.get(index).map(|row| row.pose.position()) else {
            continue;
        };
        let far = |&other: &usize| {
            distance_m(&rows[other].pose.position(), &place) * view.scale() >= APART
        };
        if chosen.len() < MOST && view.shows(&place) && chosen.iter().all(far) {
            chosen.push(index);
        }
    }
    chosen.sort_unstable();
    chosen.into_iter().map(|index| &rows[index]).collect()
}

/// For each moving obstacle that came near, the row where it was nearest; the nearest obstacle first.
fn closest_passes(trace: &Trace) -> Vec<usize> {
    let mut passes: Vec<(f64, usize)> = trace
        .moving_radii
        .iter()
        .enumerate()
        .filter_map(|(obstacle, radius)| {
            trace
                .rows
                .iter()
                .enumerate()
                .filter_map(|(index, row)| {
                    let center = row.moving.get(obstacle)?.as_ref()?;
                    let distance = distance_m(center, &row.pose.position()) - radius;
                    (distance <= NEAR_M).then_some((distance, index))
                })
                .min_by(|a, b| a.0.total_cmp(&b.0))
        })
        .collect();
    passes.sort_by(|a, b| a.0.total_cmp(&b.0));
    passes.into_iter().map(|(_, index)| index).collect()
}

/// The distance between two points, metres; NaN where one is not finite.
pub(super) fn distance_m(a: &Point, b: &Point) -> f64 {
    libm::hypot(a.x - b.x, a.y - b.y)
}
