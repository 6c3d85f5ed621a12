//! Looking for a lost robot: the poses about a place where a revolution fits the map.

use core::f64::consts::TAU;

use nalgebra::{Matrix3, Vector3};

use super::scan_matcher::{Matched, matched, tolerance_m};
use super::signed_distance_field::SignedDistanceField;
use super::{Agreement, DeskewedScan, LocalizationSettings};
use crate::geometry::{Pose, wrap_angle};

/// Distance of the poses that are tried, metres and radians.
const STEP_M: f64 = 0.2;
const YAWS: u32 = 48;

/// Beams by which they are tried, evenly taken from the revolution.
const BEAMS: usize = 40;

/// A beam is worth something up to this distance from a wall, metres.
const NEAR_M: f64 = 0.3;

/// So many of them, the best at least so far apart, are laid on the map.
const REFINED: usize = 8;
const APART_M: f64 = 0.5;
const APART_RAD: f64 = 0.3;

/// How well a pose that is tried is known, metres and radians.
const SIGMA_M: f64 = 0.2;
const SIGMA_RAD: f64 = 0.1;

/// The best must agree in this much larger a share of the beams than any other place.
const BETTER_BY: f64 = 0.1;

/// The one pose within a distance of a place of the grid's frame at which the view agrees with the map as well as a found robot's must;
/// none where there is none, or more than one.
pub(super) fn find(
    walls: &SignedDistanceField,
    view: &DeskewedScan,
    about: &Pose,
    settings: &LocalizationSettings,
) -> Option<Pose> {
    let refined = best_of_lattice(walls, view, about, settings)
        .into_iter()
        .map(|pose| {
            let pose = refine(walls, view, &pose, settings).pose;
            let tolerance_m = tolerance_m(walls, settings);
            (Agreement::of(walls, view, &pose, tolerance_m), pose)
        });
    let all: Vec<(Agreement, Pose)> = refined.collect();
    // The first of equals, so that the answer is one.
    let best = all.iter().reduce(|best, other| {
        if other.0.matching_fraction() > best.0.matching_fraction() {
            other
        } else {
            best
        }
    })?;
    let (agreement, pose) = best;
    let rival = all
        .iter()
        .filter(|(_, other)| is_apart(other, pose))
        .map(|(agreement, _)| agreement.matching_fraction())
        .fold(0.0, f64::max);
    let is_good = agreement.matching_fraction() >= settings.relocalized_agreement
        && agreement.through_walls_fraction() <= settings.max_through_walls / 2.0
        && agreement.matching_fraction() >= rival + BETTER_BY;
    is_good.then_some(*pose)
}

fn is_apart(one: &Pose, other: &Pose) -> bool {
    (one.position() - other.position()).norm() > APART_M
        || wrap_angle(one.yaw - other.yaw).abs() > APART_RAD
}

fn refine(
    walls: &SignedDistanceField,
    view: &DeskewedScan,
    pose: &Pose,
    settings: &LocalizationSettings,
) -> Matched {
    let sigmas = Vector3::new(SIGMA_M, SIGMA_M, SIGMA_RAD);
    let certainty = Matrix3::from_diagonal(&sigmas.map(|sigma| 1.0 / (sigma * sigma)));
    matched(walls, &view.hits, pose, &certainty, 0.5 * SIGMA_M, settings)
}

/// The best poses of a lattice, no two near one another, best first; of equals the first.
fn best_of_lattice(
    walls: &SignedDistanceField,
    view: &DeskewedScan,
    about: &Pose,
    settings: &LocalizationSettings,
) -> Vec<Pose> {
    let hits = &view.hits;
    let every = hits.len().div_ceil(BEAMS).max(1);
    let steps = (settings.relocalization_radius_m / STEP_M).floor() as i32;
    let mut tried: Vec<(f64, Pose)> = Vec::new();
    let mut ends = Vec::with_capacity(BEAMS);
    for turn in 0..YAWS {
        let yaw = wrap_angle(about.yaw + TAU * f64::from(turn) / f64::from(YAWS));
        let (sin, cos) = libm::sincos(yaw);
        ends.clear();
        ends.extend(hits.iter().step_by(every).map(|hit| {
            let end = &hit.end;
            (cos * end.x - sin * end.y, sin * end.x + cos * end.y)
        }));
        for row in -steps..=steps {
            for column in -steps..=steps {
                if column * column + row * row > steps * steps {
                    continue;
                }
                let (x, y) = (
                    about.x + STEP_M * f64::from(column),
                    about.y + STEP_M * f64::from(row),
                );
                // A robot stands in the open.
                if walls.rough_m(x, y).is_none_or(|off_m| off_m <= 0.0) {
                    continue;
                }
                let worth = |(along, up): &(f64, f64)| {
                    let off_m = walls.rough_m(x + along, y + up).map_or(NEAR_M, f64::abs);
                    (1.0 - off_m / NEAR_M).max(0.0)
                };
                let sum: f64 = ends.iter().map(worth).sum();
                if sum >= 0.3 * ends.len() as f64 {
                    tried.push((sum, Pose::new(x, y, yaw)));
                }
            }
        }
    }
    // A stable sort, so that equals stay in the order of the lattice.
    tried.sort_by(|one, other| other.0.total_cmp(&one.0));
    let mut best: Vec<Pose> = Vec::with_capacity(REFINED);
    for (_, pose) in &tried {
        if best.iter().all(|other| is_apart(other, pose)) {
            best.push(*pose);
            if best.len() == REFINED {
                break;
            }
        }
    }
    best
}
