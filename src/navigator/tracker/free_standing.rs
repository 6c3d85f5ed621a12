//! Objects as narrow as a person that stand alone, and that the map does not show. Each may be a person who has stood there all
//! the time, and who may start to walk at any moment. A post looks the same.

use super::cluster::NarrowObject;
use crate::geometry::Point;

/// A person is at most this wide, metres: two legs that stand apart, or a whole body.
pub(super) const WIDEST_M: f64 = 0.6;
/// Objects farther away than this do not limit a robot of up to 1.5 m/s, metres.
const FARTHEST_M: f64 = 5.0;
/// Least width of a leg, metres. What has fewer returns than a leg at its distance is no leg.
const LEG_M: f64 = 0.05;
/// Objects within this distance of each other in two scans are the same, metres: the middle of one leg or of both.
const SAME_M: f64 = 0.2;
/// An object counts after this many scans: a single return may be dust.
const MIN_SIGHTINGS: u32 = 2;
/// An object is kept for this long, seconds: one that a scan does not show as standing alone is most likely still there.
const KEPT_S: f64 = 0.5;
/// Largest number of objects. The nearest are kept.
const MAX_OBJECTS: usize = 24;

/// The objects of the last scans.
#[derive(Debug, Default)]
pub(super) struct FreeStandingObjects(Vec<Object>);

#[derive(Debug)]
struct Object {
    place: Point,
    /// Time of the last scan that showed it, seconds, and the number of scans that did.
    seen_s: f64,
    sightings: u32,
}

impl FreeStandingObjects {
    /// Updates the objects with those of a scan at a time, seconds, with an angle between two beams, radians.
    pub fn update(&mut self, time_s: f64, increment: f64, narrow: &[NarrowObject]) {
        self.0.retain(|object| (0.0..=KEPT_S).contains(&(time_s - object.seen_s)));
        let may_be_leg = |object: &&NarrowObject| {
            // An object as wide as a leg has at least this many returns.
            let returns = (LEG_M / (object.range_m * increment)).floor();
            object.range_m < FARTHEST_M && object.count as f64 >= returns
        };
        let mut near: Vec<&NarrowObject> = narrow.iter().filter(may_be_leg).collect();
        near.sort_by(|one, other| one.range_m.total_cmp(&other.range_m));
        near.truncate(MAX_OBJECTS);
        for NarrowObject { center, .. } in near {
            let is_same = |object: &&mut Object| (object.place - center).norm() < SAME_M;
            if let Some(object) = self.0.iter_mut().find(is_same) {
                if object.seen_s < time_s {
                    object.sightings += 1;
                }
                (object.place, object.seen_s) = (*center, time_s);
            } else {
                self.0.push(Object { place: *center, seen_s: time_s, sightings: 1 });
            }
        }
    }

    /// Forgets all objects.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// The places of the objects.
    pub fn places(&self) -> impl Iterator<Item = Point> + '_ {
        self.0.iter().filter(|object| object.sightings >= MIN_SIGHTINGS).map(|object| object.place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INCREMENT: f64 = 0.014;

    fn object(x: f64, y: f64, count: usize) -> NarrowObject {
        let center = Point::new(x, y);
        NarrowObject { middle: center, center, range_m: libm::hypot(x, y), width_m: 0.05, count }
    }

    /// A leg has one return at 2 m, and three at 1 m.
    #[test]
    fn dust_and_what_is_narrower_than_a_leg_do_not_count() {
        for (x, count, is_leg) in [(2.0, 1, true), (1.0, 3, true), (1.0, 2, false), (5.5, 3, false)]
        {
            let mut objects = FreeStandingObjects::default();
            objects.update(0.0, INCREMENT, &[object(x, 0.0, count)]);
            assert_eq!(objects.places().count(), 0, "in one scan");
            objects.update(0.1, INCREMENT, &[object(x, 0.1, count)]);
            assert_eq!(objects.places().count(), usize::from(is_leg), "{count} at {x} m");
        }
    }

    #[test]
    fn object_is_kept_for_half_a_second() {
        let mut objects = FreeStandingObjects::default();
        objects.update(0.0, INCREMENT, &[object(2.0, 0.0, 3)]);
        objects.update(0.1, INCREMENT, &[object(2.0, 0.0, 3)]);
        for (time_s, expected) in [(0.5, 1), (0.7, 0)] {
            objects.update(time_s, INCREMENT, &[]);
            assert_eq!(objects.places().count(), expected, "at {time_s} s");
        }
    }

    #[test]
    fn nearest_objects_are_kept_among_many() {
        let mut objects = FreeStandingObjects::default();
        let mut all: Vec<_> =
            (0..40).map(|post| object(3.0, f64::from(post) * 0.3 - 3.0, 3)).collect();
        all.push(object(1.0, 0.0, 3));
        objects.update(0.0, INCREMENT, &all);
        objects.update(0.1, INCREMENT, &all);
        assert_eq!(objects.places().count(), MAX_OBJECTS);
        assert!(objects.places().any(|place| place == Point::new(1.0, 0.0)));
    }
}
