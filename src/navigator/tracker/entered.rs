//! Returns on ground that was free a moment before: whatever entered it moves, and may be a person.
//!
//! A track needs about half a second to establish a motion, and the legs of a fast walker often never become one: each stands,
//! then swings at twice the speed of the body. For the speed limit it suffices that something entered free ground.

use super::cluster::Return;
use crate::geometry::Point;

/// Returns within this distance of each other belong to one person, metres: a long step.
const TOGETHER_M: f64 = 0.6;
/// A single return may be dust.
const MIN_RETURNS: usize = 2;
/// A person may stand or hide one leg behind the other for this long, seconds.
const KEPT_S: f64 = 0.5;
/// Largest number of places.
const MAX_PLACES: usize = 16;

/// Places that something entered.
#[derive(Debug, Default)]
pub(super) struct EnteredPlaces {
    /// Each with the time of the last scan that showed it, seconds.
    places: Vec<(f64, Point)>,
}

impl EnteredPlaces {
    /// Updates the places with the unexplained returns of a scan at a time, seconds, in the order of their beams.
    pub fn update(&mut self, time_s: f64, returns: &[Return]) {
        self.places.retain(|(seen_s, _)| (0.0..=KEPT_S).contains(&(time_s - seen_s)));
        let mut groups: Vec<(usize, Point)> = Vec::new();
        for one in returns.iter().filter(|one| one.was_free) {
            let near =
                |(_, center): &&mut (usize, Point)| (one.point - *center).norm() < TOGETHER_M;
            match groups.iter_mut().find(near) {
                Some((count, center)) => {
                    *count += 1;
                    *center = *center + (one.point - *center) / *count as f64;
                }
                None => groups.push((1, one.point)),
            }
        }
        for (count, center) in groups {
            let known = self.places.iter().position(|(_, at)| (center - at).norm() < TOGETHER_M);
            if let Some(known) = known {
                self.places[known] = (time_s, center);
            } else if count >= MIN_RETURNS && self.places.len() < MAX_PLACES {
                self.places.push((time_s, center));
            }
        }
    }

    /// Forgets all places.
    pub fn clear(&mut self) {
        self.places.clear();
    }

    /// The places.
    pub fn centers(&self) -> impl Iterator<Item = Point> + '_ {
        self.places.iter().map(|(_, center)| *center)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn returns(points: &[(f64, f64)], was_free: bool) -> Vec<Return> {
        let one = |(beam, &(x, y)): (usize, &(f64, f64))| Return {
            beam,
            range_m: 1.0,
            point: Point::new(x, y),
            is_candidate: true,
            owner: None,
            was_free,
        };
        points.iter().enumerate().map(one).collect()
    }

    #[test]
    fn two_legs_on_free_ground_are_one_place_for_half_a_second() {
        let mut entered = EnteredPlaces::default();
        let legs = [(2.0, 0.1), (2.2, -0.1), (5.0, 5.0)];
        entered.update(0.0, &returns(&legs, true));
        let centers: Vec<Point> = entered.centers().collect();
        assert_eq!(centers.len(), 1, "dust has one return: {centers:?}");
        assert!((centers[0] - Point::new(2.1, 0.0)).norm() < 1e-9, "{centers:?}");
        // One leg hides the other, then both stand.
        entered.update(0.1, &returns(&[(1.9, 0.0)], true));
        assert_eq!(entered.centers().next(), Some(Point::new(1.9, 0.0)));
        entered.update(0.5, &returns(&legs, false));
        assert_eq!(entered.centers().count(), 1);
        entered.update(0.7, &returns(&legs, false));
        assert_eq!(entered.centers().count(), 0);
    }
}
