//! Returns on ground that was free a moment before: whatever entered it moves, and may be a person. The same holds for what
//! comes into sight from behind something else, until it has stayed for half a second.
//!
//! A track needs about half a second to establish a motion, and the legs of a fast walker often never become one: each stands,
//! then swings at twice the speed of the body. For the speed limit it suffices that something entered free ground.

use super::super::scan_visibility::Earlier;
use super::cluster::Return;
use crate::geometry::Point;

/// Returns within this distance of each other belong to one person, metres: a long step.
const TOGETHER_M: f64 = 0.6;
/// A single return may be dust.
const MIN_RETURNS: usize = 2;
/// A person may stand or hide one leg behind the other for this long, seconds.
const KEPT_S: f64 = 0.5;
/// What stays within this distance, metres, for this long, seconds, has come and stands.
const STAYS_M: f64 = 0.2;
const STAYS_S: f64 = 0.5;
/// Largest number of places. The nearest are kept.
const MAX_PLACES: usize = 16;

/// Places that something entered.
#[derive(Debug, Default)]
pub(super) struct EnteredPlaces(Vec<Place>);

/// Returns of a scan that belong to one person.
pub(super) struct Group {
    count: usize,
    pub center: Point,
    /// Range of the nearest, metres.
    range_m: f64,
}

/// The groups of returns, in the order of their beams.
pub(super) fn groups_of<'a>(returns: impl Iterator<Item = &'a Return>) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for one in returns {
        let near = |group: &&mut Group| (one.point - group.center).norm() < TOGETHER_M;
        match groups.iter_mut().find(near) {
            Some(group) => {
                group.count += 1;
                group.center = group.center + (one.point - group.center) / group.count as f64;
                group.range_m = group.range_m.min(one.range_m);
            }
            None => groups.push(Group { count: 1, center: one.point, range_m: one.range_m }),
        }
    }
    groups
}

#[derive(Debug)]
struct Place {
    center: Point,
    /// Range of its nearest return, metres.
    range_m: f64,
    /// Time of the last scan that showed it, seconds.
    seen_s: f64,
    /// Where it has stayed, since a time, seconds.
    stays_at: Point,
    stays_since_s: f64,
    /// When it stood last, seconds.
    stood_s: Option<f64>,
}

impl Place {
    /// Whether a return that no earlier scan explains may be what came here, now nearer to the lidar. What approaches ends the
    /// beams that would show that its next ground is free. One that has stood may be next to a post.
    fn approaches(&self, one: &Return) -> bool {
        one.is_candidate
            && self.stood_s.is_none()
            && one.range_m < self.range_m
            && (one.point - self.center).norm() < TOGETHER_M
    }
}

impl EnteredPlaces {
    /// Updates the places with the unexplained returns of a scan at a time, seconds, in the order of their beams.
    pub fn update(&mut self, time_s: f64, returns: &[Return]) {
        self.0.retain(|place| (0.0..=KEPT_S).contains(&(time_s - place.seen_s)));
        let is_of_person = |one: &&Return| {
            one.earlier != Earlier::Unknown || self.0.iter().any(|place| place.approaches(one))
        };
        let groups = groups_of(returns.iter().filter(is_of_person));
        for Group { count, center, range_m } in groups {
            let known = self.0.iter_mut().find(|place| (center - place.center).norm() < TOGETHER_M);
            if let Some(place) = known {
                (place.center, place.seen_s, place.range_m) = (center, time_s, range_m);
                if (center - place.stays_at).norm() > STAYS_M {
                    (place.stays_at, place.stays_since_s) = (center, time_s);
                }
                if time_s - place.stays_since_s >= STAYS_S {
                    place.stood_s = Some(time_s);
                }
            } else if count >= MIN_RETURNS {
                let (stays_at, stays_since_s) = (center, time_s);
                self.0.push(Place {
                    center,
                    range_m,
                    seen_s: time_s,
                    stays_at,
                    stays_since_s,
                    stood_s: None,
                });
            }
        }
        if self.0.len() > MAX_PLACES {
            self.0.sort_by(|one, other| one.range_m.total_cmp(&other.range_m));
            self.0.truncate(MAX_PLACES);
        }
    }

    /// Forgets all places.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// The places at a time, seconds, each with the time since what came stood there: zero if it stood in the last scan that showed it,
    /// `None` before it has stood.
    pub fn places(&self, time_s: f64) -> impl Iterator<Item = (Point, Option<f64>)> + '_ {
        let since_s = move |place: &Place| {
            let stood_s = place.stood_s?;
            Some(if stood_s < place.seen_s { time_s - stood_s } else { 0.0 })
        };
        self.0.iter().map(move |place| (place.center, since_s(place)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn returns(points: &[(f64, f64)], earlier: Earlier) -> Vec<Return> {
        let at = |&(x, y): &(f64, f64)| {
            let point = Point::new(x, y);
            let range_m = point.to_vector().norm();
            Return { range_m, earlier, ..Return::candidate(point) }
        };
        points.iter().map(at).collect()
    }

    /// The beams of the scans before end at a person who walks towards the lidar, in front of a post.
    #[test]
    fn person_who_approaches_is_followed_without_free_ground_until_it_has_stayed() {
        let mut entered = EnteredPlaces::default();
        entered.update(0.0, &returns(&[(3.0, 0.0), (3.0, 0.1)], Earlier::Hidden));
        let post = (3.2, 0.2);
        let mut at = |tick: u32, x: f64| {
            let time_s = f64::from(tick) * 0.1;
            entered.update(time_s, &returns(&[(x, 0.0), (x, 0.1), post], Earlier::Unknown));
            entered.places(time_s).map(|(center, _)| center).collect::<Vec<_>>()
        };
        for tick in 1..=10 {
            let x = 3.0 - 0.15 * f64::from(tick);
            let places = at(tick, x);
            assert_eq!(places.len(), 1, "{places:?}");
            assert!((places[0] - Point::new(x, 0.05)).norm() < 1e-9, "{places:?}");
        }
        // It stands: nothing shows that it is no post.
        assert_eq!((11..=17).map(|tick| at(tick, 1.5).len()).sum::<usize>(), 5);
    }

    /// A person comes around a corner, and a post that the corner hid comes into sight.
    #[test]
    fn what_comes_out_of_hiding_may_be_a_person_until_it_has_stayed() {
        let mut entered = EnteredPlaces::default();
        for tick in 0..=5 {
            let posts = [(2.0, 1.0), (2.0, 1.1)];
            let time_s = f64::from(tick) * 0.1;
            entered.update(time_s, &returns(&posts, Earlier::Hidden));
            let stood: Vec<_> = entered.places(time_s).map(|(_, since_s)| since_s).collect();
            assert_eq!(stood, [(tick == 5).then_some(0.0)], "after {tick} ticks");
        }
        entered.update(0.6, &returns(&[(2.0, 1.0), (2.0, 1.1)], Earlier::Unknown));
        assert_eq!(entered.places(0.6).count(), 1, "seen a moment ago");
    }

    #[test]
    fn two_legs_on_free_ground_are_one_place_for_half_a_second() {
        let mut entered = EnteredPlaces::default();
        let legs = [(2.0, 0.1), (2.2, -0.1), (5.0, 5.0)];
        entered.update(0.0, &returns(&legs, Earlier::Free));
        let centers: Vec<Point> = entered.places(0.0).map(|(center, _)| center).collect();
        assert_eq!(centers.len(), 1, "dust has one return: {centers:?}");
        assert!((centers[0] - Point::new(2.1, 0.0)).norm() < 1e-9, "{centers:?}");
        // One leg hides the other, then both stand.
        entered.update(0.1, &returns(&[(1.9, 0.0)], Earlier::Free));
        assert_eq!(entered.places(0.1).next(), Some((Point::new(1.9, 0.0), None)));
        entered.update(0.5, &returns(&legs, Earlier::Unknown));
        assert_eq!(entered.places(0.5).count(), 1);
        entered.update(0.7, &returns(&legs, Earlier::Unknown));
        assert_eq!(entered.places(0.7).count(), 0);
    }

    /// Two legs that come, stand for a second, and go on.
    #[test]
    fn what_stays_for_half_a_second_stands_until_it_leaves() {
        let mut entered = EnteredPlaces::default();
        let mut at = |time_s: f64, x: f64| {
            entered.update(time_s, &returns(&[(x, 0.1), (x, -0.1)], Earlier::Free));
            let (_, since_stood_s) = entered.places(time_s).next().expect("a place");
            since_stood_s
        };
        for tick in 0..10 {
            let walks = at(f64::from(tick) * 0.1, 3.0 - 0.15 * f64::from(tick));
            assert_eq!(walks, None, "walking at 1.5 m/s");
        }
        assert_eq!(at(1.2, 1.65), None);
        assert_eq!(at(1.5, 1.67), Some(0.0));
        assert_eq!(at(2.0, 1.62), Some(0.0));
        for (time_s, x, since_s) in [(2.1, 1.3, 0.1), (2.3, 1.0, 0.3)] {
            let since_stood_s = at(time_s, x).expect("it stood");
            assert!((since_stood_s - since_s).abs() < 1e-9, "it goes on: {since_stood_s} s");
        }
    }

    #[test]
    fn people_apart_are_places_of_their_own_in_the_middle_of_their_returns() {
        let mut entered = EnteredPlaces::default();
        let people = [(2.0, 0.0), (2.1, 0.0), (2.5, 0.0), (2.0, 3.0), (2.0, 3.2)];
        entered.update(0.0, &returns(&people, Earlier::Free));
        let centers: Vec<Point> = entered.places(0.0).map(|(center, _)| center).collect();
        assert_eq!(centers.len(), 2, "{centers:?}");
        assert!((centers[0] - Point::new(2.2, 0.0)).norm() < 1e-9, "{centers:?}");
        assert!((centers[1] - Point::new(2.0, 3.1)).norm() < 1e-9, "{centers:?}");
    }

    /// Many posts come into sight at once, and after them, in the order of the beams, a person.
    #[test]
    fn nearest_places_are_kept_among_many() {
        let mut entered = EnteredPlaces::default();
        let at = |x: f64, y: f64, range_m: f64| {
            let one = Return { earlier: Earlier::Hidden, ..Return::candidate(Point::new(x, y)) };
            [Return { range_m, ..one }, Return { range_m, ..one }]
        };
        let mut all: Vec<Return> = (0..23).flat_map(|post| at(7.0, f64::from(post), 7.0)).collect();
        all.extend(at(2.0, 0.0, 2.0));
        entered.update(0.0, &all);
        assert_eq!(entered.places(0.0).count(), MAX_PLACES);
        assert!(entered.places(0.0).any(|(place, _)| place == Point::new(2.0, 0.0)));
    }
}
