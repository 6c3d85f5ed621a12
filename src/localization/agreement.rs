//! Do the beams agree with the map at a pose? Each ends on a wall, before one, or beyond one.

use crate::geometry::{Point, Pose};

use super::DeskewedScan;
use super::signed_distance_field::SignedDistanceField;

/// A beam is inside a wall from this share of a cell below its surface on, and outside again from as much above it.
const SKIN_CELLS: f64 = 0.2;

/// Shortest step along a beam, cells, and the share of the distance to the wall that a longer one takes.
const LEAST_STEP_CELLS: f64 = 0.3;
const STEP_SHARE: f64 = 0.9;

/// Directions in which walls are looked for on the map where the lidar saw too few.
const LOOKED_AT: u32 = 64;

/// How many beams of a revolution agree with the map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Agreement {
    /// Beams that measured something, or that there is nothing within range.
    pub beams: u32,
    /// Those that end on a wall of the map, with nothing of it before, or go on to the end of range in the open.
    pub agree: u32,
    /// Those that pass through a wall of the map, or end deep inside one: the robot is elsewhere.
    pub through: u32,
}

impl Agreement {
    /// Beams that end in the open: on somebody, or on something that the map does not show.
    #[must_use]
    pub const fn unmapped(&self) -> u32 {
        self.beams - self.agree - self.through
    }

    /// Share of the beams that agree, 0 to 1; zero where there is no beam.
    #[must_use]
    pub fn matching_fraction(&self) -> f64 {
        f64::from(self.agree) / f64::from(self.beams.max(1))
    }

    /// Share of the beams that pass through walls, 0 to 1.
    #[must_use]
    pub fn through_walls_fraction(&self) -> f64 {
        f64::from(self.through) / f64::from(self.beams.max(1))
    }

    /// Of a view from a pose of the grid's frame. Ends within the tolerance of a wall, metres, are on it.
    pub(super) fn of(
        walls: &SignedDistanceField,
        view: &DeskewedScan,
        pose: &Pose,
        tolerance_m: f64,
    ) -> Self {
        let mut all = Self::default();
        let (sin, cos) = libm::sincos(pose.yaw);
        let turned = |point: &Point| {
            Point::new(
                pose.x + cos * point.x - sin * point.y,
                pose.y + sin * point.x + cos * point.y,
            )
        };
        for hit in &view.hits {
            let (from, end) = (turned(&hit.from), turned(&hit.end));
            let off_m = walls.level(end.x, end.y).map(|level| level.distance_m);
            all.beams += 1;
            // What lies off the map is nor open nor a wall of it.
            let Some(off_m) = off_m else {
                continue;
            };
            if off_m < -tolerance_m || passes_through(walls, &from, &end, tolerance_m) {
                all.through += 1;
            } else if off_m <= tolerance_m {
                all.agree += 1;
            }
        }
        for ray in &view.open {
            let (from, end) = (
                turned(&ray.from),
                turned(&(ray.from + view.range_max * ray.direction)),
            );
            let is_blocked = walls
                .rough_m(end.x, end.y)
                .is_none_or(|off_m| off_m < -tolerance_m)
                || passes_through(walls, &from, &end, tolerance_m);
            all.beams += 1;
            all.agree += u32::from(!is_blocked);
            all.through += u32::from(is_blocked);
        }
        all
    }
}

/// Whether a beam enters a wall and leaves it again before its end, metres before which walls are that of the end itself.
fn passes_through(
    walls: &SignedDistanceField,
    from: &Point,
    end: &Point,
    before_end_m: f64,
) -> bool {
    let skin_m = SKIN_CELLS * walls.resolution_m();
    let mut is_inside = false;
    let mut came_out = false;
    march(walls, from, end, before_end_m, |level_m| {
        came_out = is_inside && level_m > skin_m;
        is_inside |= level_m < -skin_m;
        came_out
    });
    came_out
}

/// Steps from a point towards another until so far before it, metres, as long as nothing is found and the way is on the map.
fn march(
    walls: &SignedDistanceField,
    from: &Point,
    end: &Point,
    before_end_m: f64,
    mut found: impl FnMut(f64) -> bool,
) {
    let way = end - from;
    let length_m = way.norm();
    let least_m = LEAST_STEP_CELLS * walls.resolution_m();
    let mut at_m = 0.0;
    while at_m < length_m - before_end_m {
        let point = from + way * (at_m / length_m);
        let Some(level) = walls.level(point.x, point.y) else {
            return;
        };
        if found(level.distance_m) {
            return;
        }
        at_m += (STEP_SHARE * level.distance_m.abs()).max(least_m);
    }
}

/// In how large a share of all directions the map has a wall within a range, metres, of a pose of the grid's frame.
pub(super) fn walled_share(walls: &SignedDistanceField, pose: &Pose, range_m: f64) -> f64 {
    let mut walled = 0;
    for direction in 0..LOOKED_AT {
        let angle = core::f64::consts::TAU * f64::from(direction) / f64::from(LOOKED_AT);
        let (sin, cos) = libm::sincos(angle);
        let from = pose.position();
        let end = Point::new(from.x + range_m * cos, from.y + range_m * sin);
        let mut is_walled = false;
        march(walls, &from, &end, 0.0, |level_m| {
            is_walled = level_m <= 0.0;
            is_walled
        });
        walled += u32::from(is_walled);
    }
    f64::from(walled) / f64::from(LOOKED_AT)
}
