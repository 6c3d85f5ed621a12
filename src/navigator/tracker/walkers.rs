//! Walking people: the two legs of each are one track of the body.
//!
//! A leg stands, then swings at twice the speed of the body. A filter of constant velocity that follows one leg loses it at each
//! step. The middle between both legs moves steadily. A walker is updated with the returns near its expected place: with the
//! middle of two legs, or with a single leg and a larger variance while one leg hides the other.

use nalgebra::Matrix2;

use super::super::scan_visibility::Earlier;
use super::cluster::Return;
use super::filter::{Filter, Fit};
use crate::geometry::{Point, Vector};

/// Returns within this distance of the expected middle between the legs belong to a walker, metres: half of a step of 0.8 m, and
/// the error of a place that was just found.
const REACH_M: f64 = 0.5;
/// Returns of two consecutive beams within this distance belong to one leg, metres.
const LEG_GAP_M: f64 = 0.12;
/// Variance of the middle between two legs, and of one leg as the place of its person, square metres on each axis.
const TWO_LEGS_M2: f64 = 0.08 * 0.08;
const ONE_LEG_M2: f64 = 0.18 * 0.18;
/// Noise of acceleration of people, m^2/s^3.
const WALKING_NOISE: f64 = 0.3;
/// A single return may be dust.
const MIN_RETURNS: usize = 2;
/// A walker needs this many updates, and this distance from where it was first seen, metres: what a wrong pose shows on free ground
/// stays where it is.
const MIN_UPDATES: u32 = 4;
const MIN_MOTION_M: f64 = 0.25;
/// A walker without returns ends after this time, seconds: a person may pass behind a post or another person.
const HIDDEN_FOR_S: f64 = 0.8;
/// Largest number of walkers.
const MAX_WALKERS: usize = 16;

/// A walking person, by the middle between the legs.
#[derive(Clone, Debug)]
pub(super) struct Walker {
    pub filter: Filter,
    first: Point,
    seen_s: f64,
    updates: u32,
    has_walked: bool,
}

/// The walkers, the oldest first.
#[derive(Debug, Default)]
pub(super) struct Walkers {
    walkers: Vec<Walker>,
    /// For each walker its legs in the present scan.
    legs: Vec<Vec<Leg>>,
}

/// Returns of consecutive beams on one leg.
#[derive(Clone, Copy, Debug)]
struct Leg {
    count: usize,
    sum: Vector,
    last: Point,
}

impl Leg {
    fn center(&self) -> Point {
        Point::default() + self.sum / self.count as f64
    }
}

impl Walkers {
    /// Forgets all walkers.
    pub fn clear(&mut self) {
        self.walkers.clear();
    }

    /// Those who have walked.
    pub fn iter(&self) -> impl Iterator<Item = &Walker> {
        self.walkers.iter().filter(|walker| walker.has_walked)
    }

    /// Updates with the unexplained returns of a scan, in the order of their beams, at a time and this long after the last scan,
    /// both in seconds.
    pub fn update(&mut self, (time_s, gap_s): (f64, f64), returns: &[Return]) {
        let Self { walkers, legs } = self;
        for walker in &mut *walkers {
            walker.filter.predict(gap_s, WALKING_NOISE);
        }
        legs.iter_mut().for_each(Vec::clear);
        legs.resize_with(walkers.len(), Vec::new);
        let mut new: Vec<(usize, Point)> = Vec::new();
        for one in returns.iter().filter(|one| one.is_candidate) {
            let far_m = |walker: &Walker| (walker.filter.center() - one.point).norm();
            let nearest = walkers
                .iter()
                .map(far_m)
                .enumerate()
                .filter(|(_, far_m)| *far_m < REACH_M)
                .min_by(|one, other| one.1.total_cmp(&other.1));
            if let Some((number, _)) = nearest {
                add(&mut legs[number], &one.point);
            } else if one.earlier == Earlier::Free {
                let near = |group: &&mut (usize, Point)| (one.point - group.1).norm() < REACH_M;
                match new.iter_mut().find(near) {
                    Some((count, center)) => {
                        *count += 1;
                        *center = *center + (one.point - *center) / *count as f64;
                    }
                    None => new.push((1, one.point)),
                }
            }
        }
        for (walker, legs) in walkers.iter_mut().zip(legs) {
            if let Some(fit) = fit(legs) {
                walker.filter.correct(&fit);
                walker.seen_s = time_s;
                walker.updates += 1;
                let moved_m = (walker.filter.center() - walker.first).norm();
                walker.has_walked |= walker.updates >= MIN_UPDATES && moved_m > MIN_MOTION_M;
            }
        }
        walkers.retain(|walker| (0.0..=HIDDEN_FOR_S).contains(&(time_s - walker.seen_s)));
        for (count, center) in new {
            if count >= MIN_RETURNS && walkers.len() < MAX_WALKERS {
                let covariance = Matrix2::identity() * ONE_LEG_M2;
                let filter = Filter::new(&Fit { center, covariance });
                let (first, updates) = (center, 1);
                let seen_s = time_s;
                walkers.push(Walker { filter, first, seen_s, updates, has_walked: false });
            }
        }
    }
}

/// Adds a return to the leg of the last one, or to a new leg.
fn add(legs: &mut Vec<Leg>, point: &Point) {
    let place = point.to_vector();
    match legs.last_mut() {
        Some(leg) if (*point - leg.last).norm() < LEG_GAP_M => {
            leg.count += 1;
            leg.sum = leg.sum + place;
            leg.last = *point;
        }
        _ => legs.push(Leg { count: 1, sum: place, last: *point }),
    }
}

/// The place of a person by the legs: the middle of the two with the most returns.
fn fit(legs: &mut [Leg]) -> Option<Fit> {
    legs.sort_by_key(|leg| core::cmp::Reverse(leg.count));
    let (center, variance) = match legs {
        [] => return None,
        [one] => (one.center(), ONE_LEG_M2),
        [one, other, ..] => {
            let (one, other) = (one.center(), other.center());
            (one + (other - one) * 0.5, TWO_LEGS_M2)
        }
    };
    Some(Fit { center, covariance: Matrix2::identity() * variance })
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 0.1;

    /// The returns of the legs of people who walk along y at a speed, m/s, at this distance, metres, after a time, seconds. A leg
    /// stands for one step of 0.6 m, then swings at twice the speed. `hides` leaves out the far leg of each person.
    fn legs(time_s: f64, speed: f64, places: &[f64], hides: bool) -> Vec<Return> {
        let body_m = speed * time_s;
        // From half a step ahead of the body to half a step behind it, and back.
        let phase = body_m / 1.2;
        let ahead_m = 0.3 * (4.0 * (phase - (phase + 0.5).floor()).abs() - 1.0);
        let mut returns = Vec::new();
        for &x in places {
            for (side, along_m) in [(-0.1, ahead_m), (0.1, -ahead_m)] {
                if hides && side > 0.0 {
                    continue;
                }
                for offset_m in [-0.03, 0.0, 0.03] {
                    let place = Point::new(x + side, body_m + along_m + offset_m);
                    returns.push(Return::candidate(place));
                }
            }
        }
        returns
    }

    fn walk(walkers: &mut Walkers, ticks: core::ops::Range<u32>, speed: f64, places: &[f64]) {
        for tick in ticks {
            let time_s = f64::from(tick) * PERIOD_S;
            walkers.update((time_s, PERIOD_S), &legs(time_s, speed, places, false));
        }
    }

    #[test]
    fn two_legs_are_one_walker_with_the_velocity_of_the_body() {
        for speed in [0.5, 1.0, 1.6] {
            let mut walkers = Walkers::default();
            walk(&mut walkers, 0..16, speed, &[3.0]);
            let found: Vec<&Walker> = walkers.iter().collect();
            assert_eq!(found.len(), 1, "{speed} m/s");
            let (center, velocity) = (found[0].filter.center(), found[0].filter.velocity());
            let error_m = (center - Point::new(3.0, 1.5 * speed)).norm();
            assert!(error_m < 0.1, "{speed} m/s: {error_m} m off");
            let error = (velocity - Vector::new(0.0, speed)).norm();
            assert!(error < 0.2, "{speed} m/s: {velocity:?}");
        }
    }

    #[test]
    fn two_people_next_to_each_other_are_two_walkers() {
        let mut walkers = Walkers::default();
        walk(&mut walkers, 0..16, 1.0, &[3.0, 4.0]);
        let mut across: Vec<f64> = walkers.iter().map(|walker| walker.filter.center().x).collect();
        across.sort_by(f64::total_cmp);
        assert_eq!(across.len(), 2, "{across:?}");
        assert!((across[0] - 3.0).abs() < 0.1 && (across[1] - 4.0).abs() < 0.1, "{across:?}");
    }

    /// The near leg hides the other for half a second, then both are hidden.
    #[test]
    fn walker_is_kept_while_legs_are_hidden_and_ends_after_a_while() {
        let mut walkers = Walkers::default();
        walk(&mut walkers, 0..16, 1.0, &[3.0]);
        for tick in 16..21 {
            let time_s = f64::from(tick) * PERIOD_S;
            walkers.update((time_s, PERIOD_S), &legs(time_s, 1.0, &[3.0], true));
        }
        let velocity = walkers.iter().next().map(|walker| walker.filter.velocity());
        assert!(
            velocity.is_some_and(|it| (it - Vector::new(0.0, 1.0)).norm() < 0.4),
            "{velocity:?}"
        );
        for (tick, count) in [(21, 1), (27, 1), (29, 0)] {
            walkers.update((f64::from(tick) * PERIOD_S, PERIOD_S), &[]);
            assert_eq!(walkers.iter().count(), count, "at tick {tick}");
        }
    }

    /// A post seems to stand on free ground by an error of the pose, and dust is a single return.
    #[test]
    fn what_stays_where_it_came_is_no_walker() {
        let mut walkers = Walkers::default();
        for tick in 0..20 {
            let post = [2.0, 2.05].map(|x| Return::candidate(Point::new(x, 0.0)));
            let dust = Return::candidate(Point::new(f64::from(tick), 5.0));
            let returns = [post[0], post[1], dust];
            walkers.update((f64::from(tick) * PERIOD_S, PERIOD_S), &returns);
        }
        assert_eq!(walkers.iter().count(), 0);
    }

    /// Legs on ground that was never seen free may have been there all the time.
    #[test]
    fn walker_begins_on_ground_that_was_free() {
        let mut walkers = Walkers::default();
        for tick in 0..16 {
            let time_s = f64::from(tick) * PERIOD_S;
            let mut returns = legs(time_s, 1.0, &[3.0], false);
            returns.iter_mut().for_each(|one| one.earlier = Earlier::Unknown);
            walkers.update((time_s, PERIOD_S), &returns);
        }
        assert_eq!(walkers.iter().count(), 0);
    }
}
