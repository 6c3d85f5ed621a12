//! Consistency of lidar beams with the map at a pose: each beam ends on a mapped surface, before one, or beyond one.

use crate::geometry::{Point, Pose};

use super::DeskewedScan;
use super::signed_distance_field::SignedDistanceField;

/// A beam enters an obstacle at this fraction of a cell below its surface, and leaves it the same distance above.
const SURFACE_MARGIN_CELLS: f64 = 0.2;

/// Shortest step along a beam, cells, and the fraction of the distance to the surface used for longer steps.
const MIN_STEP_CELLS: f64 = 0.3;
const STEP_FRACTION: f64 = 0.9;

/// Largest share of the beams that does not count, since they end on narrow objects that the map does not show. If more of them hide
/// the map, too few are left that could contradict the pose.
const MAX_ALONE: f64 = 1.0 / 3.0;

/// Number of directions checked for mapped surfaces when the lidar has few returns.
const CHECKED_DIRECTIONS: u32 = 64;

/// Numbers of beams of a revolution that match the map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Agreement {
    /// Beams with a return, or with nothing within range.
    pub beams: u32,
    /// Beams that end on a mapped surface with none before it, or reach the full range in free space.
    pub matching: u32,
    /// Beams that pass through a mapped obstacle or end deep inside one, which contradicts the pose.
    pub through_walls: u32,
    /// Beams that end in free space on an object as narrow as a person that stands alone.
    pub alone: u32,
    /// Beams that leave the map through free space: it says nothing about them.
    pub off_map: u32,
}

impl Agreement {
    /// Beams that end in free space: on a person or an unmapped object.
    #[must_use]
    pub const fn unmapped(&self) -> u32 {
        self.beams - self.matching - self.through_walls - self.off_map
    }

    /// Fraction of matching beams, 0 to 1, of those that end on the map; zero without any. Those that end on people and posts, which the
    /// map does not show, do not count, up to a third of all.
    #[must_use]
    pub fn matching_fraction(&self) -> f64 {
        let beams = f64::from(self.beams - self.off_map);
        let counted = beams - f64::from(self.alone).min(MAX_ALONE * beams);
        f64::from(self.matching) / counted.max(1.0)
    }

    /// Fraction of all beams that match, 0 to 1; zero without beams. A part of a wall that another one hides looks like a person: places of
    /// the map are compared by all beams.
    pub(super) fn matching_of_all(&self) -> f64 {
        f64::from(self.matching) / f64::from(self.beams.max(1))
    }

    /// Fraction of beams that pass through mapped obstacles, 0 to 1.
    #[must_use]
    pub fn through_walls_fraction(&self) -> f64 {
        f64::from(self.through_walls) / f64::from(self.beams.max(1))
    }

    /// Counts the beams of a scan from a pose in the grid's frame. Beams that end within the tolerance of a surface, metres,
    /// match it.
    pub(super) fn of(
        map: &SignedDistanceField,
        scan: &DeskewedScan,
        pose: &Pose,
        tolerance_m: f64,
    ) -> Self {
        let mut counts = Self::default();
        let (sin, cos) = libm::sincos(pose.yaw);
        let to_grid = |point: &Point| {
            Point::new(
                pose.x + cos * point.x - sin * point.y,
                pose.y + sin * point.x + cos * point.y,
            )
        };
        let is_blocked = |from: &Point, end: &Point, distance_m: Option<f64>| {
            distance_m.is_some_and(|distance_m| distance_m < -tolerance_m)
                || passes_through(map, from, end, tolerance_m)
        };
        for hit in &scan.hits {
            let (from, end) = (to_grid(&hit.from), to_grid(&hit.end));
            let distance_m = map.sample(end.x, end.y).map(|sample| sample.distance_m);
            counts.beams += 1;
            match distance_m {
                _ if is_blocked(&from, &end, distance_m) => counts.through_walls += 1,
                None => counts.off_map += 1,
                Some(distance_m) if distance_m <= tolerance_m => counts.matching += 1,
                Some(_) => counts.alone += u32::from(hit.is_alone),
            }
        }
        for ray in &scan.open {
            let (from, end) =
                (to_grid(&ray.from), to_grid(&(ray.from + ray.direction * scan.range_max)));
            let distance_m = map.cell_distance_m(end.x, end.y);
            counts.beams += 1;
            match distance_m {
                _ if is_blocked(&from, &end, distance_m) => counts.through_walls += 1,
                None => counts.off_map += 1,
                Some(_) => counts.matching += 1,
            }
        }
        counts
    }
}

/// Whether a beam enters an obstacle, and leaves it or the map before its end. The last `before_end_m` metres are excluded, since
/// surfaces there belong to the end itself.
fn passes_through(map: &SignedDistanceField, from: &Point, end: &Point, before_end_m: f64) -> bool {
    let margin_m = SURFACE_MARGIN_CELLS * map.frame.resolution_m;
    let mut is_inside = false;
    let mut has_left = false;
    let is_on_map = march(map, from, end, before_end_m, |distance_m| {
        has_left = is_inside && distance_m > margin_m;
        is_inside |= distance_m < -margin_m;
        has_left
    });
    has_left || is_inside && !is_on_map
}

/// Steps from a point towards another, up to `before_end_m` metres before it, until `stop` returns true for the signed
/// distance or the map ends. Returns whether all these points are on the map.
fn march(
    map: &SignedDistanceField,
    from: &Point,
    end: &Point,
    before_end_m: f64,
    mut stop: impl FnMut(f64) -> bool,
) -> bool {
    let segment = end - from;
    let length_m = segment.norm();
    let min_step_m = MIN_STEP_CELLS * map.frame.resolution_m;
    let mut at_m = 0.0;
    while at_m < length_m - before_end_m {
        let point = from + segment * (at_m / length_m);
        let Some(sample) = map.sample(point.x, point.y) else {
            return false;
        };
        if stop(sample.distance_m) {
            break;
        }
        at_m += (STEP_FRACTION * sample.distance_m.abs()).max(min_step_m);
    }
    true
}

/// The fraction of all directions in which the map has a surface within a range, metres, of a pose in the grid's frame.
pub(super) fn walled_fraction(map: &SignedDistanceField, pose: &Pose, range_m: f64) -> f64 {
    let mut walled = 0;
    for direction in 0..CHECKED_DIRECTIONS {
        let angle = core::f64::consts::TAU * f64::from(direction) / f64::from(CHECKED_DIRECTIONS);
        let (sin, cos) = libm::sincos(angle);
        let from = pose.position();
        let end = Point::new(from.x + range_m * cos, from.y + range_m * sin);
        let mut is_walled = false;
        march(map, &from, &end, 0.0, |distance_m| {
            is_walled = distance_m <= 0.0;
            is_walled
        });
        walled += u32::from(is_walled);
    }
    f64::from(walled) / f64::from(CHECKED_DIRECTIONS)
}
