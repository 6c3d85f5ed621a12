//! The people of the last seconds around the robot, for turns in place.
//!
//! A walking person puts a foot on the ground for a whole step, while a lidar may not see the other leg. So the legs of a slow
//! walker seem to stand, and a place that something entered seems to be taken by a person who stands. A robot that drives by
//! slowly is ahead of such a person. A turn is not: it leads a corner of the body sideways, to where the person walks.

use crate::geometry::{Point, Pose, bearing};
use crate::map::{MovingDisc, Scan};

use super::passive_safety::obstacle_that_may_come;
use super::predicted_state::PredictedState;
use super::scan_visibility::seen_to_m;

/// A person who stays within the first distance, metres, for this long, seconds, stands. A step of 0.3 m takes a walker at 0.14 m/s 2.5 s,
/// with the increase of the step with the speed. Slower ones cannot reach the robot before it stops its turn.
const STAYS_M: f64 = 0.2;
const STOOD_S: f64 = 2.5;
/// A leg that hides behind the other one for this long belongs to the same stay, seconds.
const UNSEEN_S: f64 = 0.5;
/// An obstacle within this distance of the last one is the same person, metres: a long step.
const SAME_M: f64 = 0.6;

/// People around the robot, and where they stayed.
#[derive(Debug, Default)]
pub(super) struct RecentPeople {
    stays: Vec<Stay>,
    /// People who are lost, then those of the newest scan.
    seen: Vec<Seen>,
}

/// A place where a person stays.
#[derive(Clone, Copy, Debug)]
struct Stay {
    place: Point,
    since_s: f64,
    seen_s: f64,
}

/// A person, and when a scan last showed this one, seconds.
#[derive(Clone, Copy, Debug)]
struct Seen {
    disc: MovingDisc,
    time_s: f64,
}

impl RecentPeople {
    /// Updates with the people of the newest scan, at a time, seconds. `is_there` returns whether a lost person may still be at a
    /// place.
    pub fn update(
        &mut self,
        time_s: f64,
        people: &[MovingDisc],
        is_there: impl Fn(&MovingDisc) -> bool,
    ) {
        self.stays.retain(|stay| (0.0..=UNSEEN_S).contains(&(time_s - stay.seen_s)));
        for person in people {
            let place = person.center();
            let mut is_known = false;
            for stay in self.stays.iter_mut().filter(|stay| (place - stay.place).norm() < STAYS_M) {
                stay.seen_s = time_s;
                is_known = true;
            }
            if !is_known {
                self.stays.push(Stay { place, since_s: time_s, seen_s: time_s });
            }
        }
        let is_seen = |lost: &Seen| {
            people.iter().any(|person| (person.center() - lost.disc.center()).norm() < SAME_M)
        };
        self.seen.retain(|last| {
            let is_recent = (0.0..=STOOD_S).contains(&(time_s - last.time_s));
            is_recent && !is_seen(last) && is_there(&last.disc)
        });
        self.seen.extend(people.iter().map(|disc| Seen { disc: *disc, time_s }));
    }

    /// The people whom a turn may meet: those who are tracked, of whom the ones that seem to stand and have not stood for long may walk
    /// at a speed, m/s; those who entered free ground, whose velocity is not known, likewise; and those who are lost.
    pub fn near_turn(
        &self,
        now: &PredictedState,
        entered: &[MovingDisc],
        speed: f64,
    ) -> Vec<MovingDisc> {
        let time_s = now.time_s;
        let walking = |disc: &MovingDisc| obstacle_that_may_come(disc.center(), disc.radius, speed);
        let stood = |disc: &MovingDisc| {
            self.stays.iter().any(|stay| {
                (disc.center() - stay.place).norm() < STAYS_M && time_s - stay.since_s >= STOOD_S
            })
        };
        let unless_stood = |disc: &MovingDisc| if stood(disc) { *disc } else { walking(disc) };
        let tracked = now.moving.iter().map(|disc| {
            let seems_to_stand = disc.vx == 0.0 && disc.vy == 0.0;
            if seems_to_stand { unless_stood(disc) } else { *disc }
        });
        let lost = self.seen.iter().filter(|last| last.time_s < time_s);
        let lost = lost.map(|last| walking(&last.disc));
        tracked.chain(entered.iter().map(unless_stood)).chain(lost).collect()
    }
}

/// Whether a person may still be at a place: the scan from a pose did not see beyond it over its whole width.
pub(super) fn may_be_there(pose: &Pose, scan: &Scan, person: &MovingDisc) -> bool {
    let (lidar, center) = (pose.transform(&scan.origin), person.center());
    let distance_m = (center - lidar).norm();
    let half_angle = libm::asin((person.radius / distance_m).min(1.0));
    let seen_m = seen_to_m(pose, scan, bearing(&lidar, &center), half_angle);
    seen_m.is_none_or(|seen_m| seen_m < distance_m + person.radius)
}

#[cfg(test)]
mod tests {
    use core::f64::consts::TAU;

    use super::super::test_state::standing_at;
    use super::*;

    const WALKING: f64 = 1.6;

    fn person(x: f64, y: f64, speed: f64) -> MovingDisc {
        obstacle_that_may_come(Point::new(x, y), 0.3, speed)
    }

    /// The speeds of the people whom a turn may meet, after a tick with these people.
    fn speeds_at(people: &mut RecentPeople, time_s: f64, may_come: &[MovingDisc]) -> Vec<f64> {
        speeds(people, time_s, may_come, |_| true)
    }

    fn speeds(
        people: &mut RecentPeople,
        time_s: f64,
        may_come: &[MovingDisc],
        is_there: impl Fn(&MovingDisc) -> bool,
    ) -> Vec<f64> {
        people.update(time_s, may_come, is_there);
        let moving = may_come.to_vec();
        let now = PredictedState { time_s, moving, ..standing_at(Pose::default()) };
        people.near_turn(&now, &[], WALKING).iter().map(|disc| disc.vx).collect()
    }

    #[test]
    fn person_who_seems_to_stand_may_walk_until_this_one_has_stood_for_long() {
        let mut people = RecentPeople::default();
        for tick in 0..40 {
            let time_s = 0.1 * f64::from(tick);
            // One leg and both legs have different middles.
            let aside_m = if tick % 3 == 0 { 0.0 } else { 0.15 };
            let expected = if time_s < STOOD_S - 1e-9 { WALKING } else { 0.0 };
            let found = speeds_at(&mut people, time_s, &[person(1.0, aside_m, 0.0)]);
            assert_eq!(found, [expected], "after {time_s} s");
        }
        let moving = [person(1.0, 0.0, 0.5)];
        assert_eq!(speeds_at(&mut people, 4.0, &moving), [0.5], "it moves as tracked");
    }

    #[test]
    fn person_who_is_not_tracked_may_walk_until_this_one_has_stood_for_long() {
        let mut people = RecentPeople::default();
        for tick in 0..40 {
            let time_s = 0.1 * f64::from(tick);
            let entered = [person(1.0, 0.0, 0.2)];
            people.update(time_s, &entered, |_| true);
            let now = PredictedState { time_s, ..standing_at(Pose::default()) };
            let speed = people.near_turn(&now, &entered, WALKING)[0].vx;
            let expected = if time_s < STOOD_S - 1e-9 { WALKING } else { 0.2 };
            assert_eq!(speed, expected, "after {time_s} s");
        }
    }

    /// Its legs stand in turn.
    #[test]
    fn slow_walker_never_stands() {
        let mut people = RecentPeople::default();
        for tick in 0..100 {
            let time_s = 0.1 * f64::from(tick);
            let steps = (time_s * 0.25 / 0.3).floor();
            let found = speeds_at(&mut people, time_s, &[person(4.0 - 0.3 * steps, 0.0, 0.0)]);
            assert_eq!(found, [WALKING], "after {time_s} s");
        }
    }

    #[test]
    fn lost_person_may_come_until_a_scan_shows_that_this_one_has_left() {
        let one = [person(1.0, 0.0, 0.0)];
        for (leaves_s, lost_until_s) in [(f64::INFINITY, STOOD_S), (1.0, 0.95)] {
            let mut people = RecentPeople::default();
            speeds_at(&mut people, 0.0, &one);
            for tick in 1..40 {
                let time_s = 0.1 * f64::from(tick);
                let found = speeds(&mut people, time_s, &[], |_| time_s < leaves_s);
                let expected = if time_s <= lost_until_s { vec![WALKING] } else { Vec::new() };
                assert_eq!(found, expected, "after {time_s} s of {lost_until_s}");
            }
        }
        // A person who goes on is not lost.
        let mut people = RecentPeople::default();
        speeds_at(&mut people, 0.0, &one);
        assert_eq!(speeds_at(&mut people, 0.1, &[person(0.6, 0.0, 0.5)]), [0.5]);
    }

    /// Something at a range before a wall at 5 m, 0.24 m next to the middle of a person at 2 m.
    #[test]
    fn scan_shows_that_a_person_has_left_where_it_sees_beyond_the_whole_disc() {
        let (pose, one) = (Pose::default(), person(2.0, 0.0, 0.0));
        let may_be = |range_m: f64| {
            let mut ranges = vec![5.0; 720];
            ranges[14] = range_m;
            let scan = Scan {
                angle_min: 0.0,
                angle_increment: TAU / 720.0,
                range_max: 10.0,
                ranges,
                ..Scan::default()
            };
            may_be_there(&pose, &scan, &one)
        };
        assert!(may_be(2.0), "a leg");
        assert!(may_be(1.0), "hidden");
        assert!(may_be(f64::NAN), "not measured");
        assert!(!may_be(5.0), "nothing");
        assert!(!may_be(2.4), "something behind");
    }
}
