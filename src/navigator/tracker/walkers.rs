//! People who walk straight, from their legs alone.
//!
//! Each leg stands, then swings at twice the speed of the body, and far away only some scans show it: legs become no track, or one
//! with a velocity that changes with each step. The middle of all returns of a person, over more than a step, lies on a line.

use std::collections::VecDeque;

use super::super::scan_visibility::Earlier;
use super::cluster::Return;
use super::entered::{Group, groups_of};
use crate::geometry::{Point, Vector};
use crate::map::MovingDisc;

/// The walk of a person continues within this distance of where it is expected, metres.
const GATE_M: f64 = 0.5;
/// A walk ends after this long without a return, seconds. Places of the last time, seconds, are on the line.
const UNSEEN_S: f64 = 0.6;
const LINE_S: f64 = 1.5;
/// The line needs this many places, and this time between the first and the last, seconds: more than a step.
const MIN_PLACES: usize = 6;
const MIN_SPAN_S: f64 = 0.7;
/// Largest root mean square distance of the places from where the line has them, metres: half of a step.
const MAX_ERROR_M: f64 = 0.2;
/// The last places are on the line too: the person has not turned. A shorter line, seconds, shows where a person walks after a turn.
const LAST_PLACES: usize = 3;
const TURNED_S: f64 = 0.85;
/// Speeds of people who walk, m/s.
const SPEEDS: (f64, f64) = (0.3, 2.2);
/// Largest number of walks.
const MAX_WALKS: usize = 16;

/// The walks of people.
#[derive(Debug, Default)]
pub(super) struct Walkers(Vec<Walk>);

/// Places of one person, with their times, seconds, the oldest first.
#[derive(Debug)]
struct Walk(VecDeque<(f64, Point)>);

/// A line through the places of a walk: where it is at a time, seconds, and its velocity, m/s.
#[derive(Clone, Copy, Debug)]
struct Line {
    time_s: f64,
    place: Point,
    velocity: Vector,
}

impl Line {
    fn at(&self, time_s: f64) -> Point {
        self.place + self.velocity * (time_s - self.time_s)
    }
}

/// A line of least squares through places with their times, seconds; `None` through places of one scan.
fn line_through(places: &[(f64, Point)]) -> Option<Line> {
    let count = places.len() as f64;
    let time_s = places.iter().map(|(time_s, _)| time_s).sum::<f64>() / count;
    let sum = places.iter().fold(Vector::ZERO, |sum, (_, place)| sum + place.to_vector());
    let middle = Point::default() + sum / count;
    let (mut spread, mut moment) = (0.0, Vector::ZERO);
    for (at_s, place) in places {
        spread += (at_s - time_s) * (at_s - time_s);
        moment = moment + (*place - middle) * (at_s - time_s);
    }
    (spread > 0.0).then(|| Line { time_s, place: middle, velocity: moment / spread })
}

/// The line of a person who walks through these places.
fn walked(places: &[(f64, Point)]) -> Option<Line> {
    let (first_s, last_s) = (places.first()?.0, places.last()?.0);
    if places.len() < MIN_PLACES || last_s - first_s < MIN_SPAN_S {
        return None;
    }
    let line = line_through(places)?;
    let error_m2 = |places: &[(f64, Point)]| {
        let squares = places.iter().map(|(time_s, place)| {
            let apart = line.at(*time_s) - *place;
            apart.dot(&apart)
        });
        squares.sum::<f64>() / places.len() as f64
    };
    let is_on = |places| error_m2(places) < MAX_ERROR_M * MAX_ERROR_M;
    let walks = (SPEEDS.0..SPEEDS.1).contains(&line.velocity.norm());
    (walks && is_on(places) && is_on(&places[places.len() - LAST_PLACES..])).then_some(line)
}

impl Walk {
    /// The line of the person, of the last second and a half, or after a turn of a shorter time.
    fn line(&self) -> Option<Line> {
        let (places, _) = self.0.as_slices();
        let recent = |(time_s, _): &(f64, Point)| {
            self.0.back().is_some_and(|(last_s, _)| last_s - time_s > TURNED_S)
        };
        walked(places).or_else(|| walked(&places[places.partition_point(recent)..]))
    }

    /// Where the person is expected at a time, seconds.
    fn expected(&self, time_s: f64) -> Option<Point> {
        let (seen_s, last) = self.0.back()?;
        let velocity = self.line().map_or(Vector::ZERO, |line| line.velocity);
        Some(*last + velocity * (time_s - seen_s))
    }
}

impl Walkers {
    /// Updates with the unexplained returns of a scan at a time, seconds.
    pub fn update(&mut self, time_s: f64, returns: &[Return]) {
        self.0.retain_mut(|walk| {
            while walk.0.front().is_some_and(|(seen_s, _)| time_s - seen_s > LINE_S) {
                walk.0.pop_front();
            }
            walk.0.back().is_some_and(|(seen_s, _)| (0.0..=UNSEEN_S).contains(&(time_s - seen_s)))
        });
        let expected: Vec<Option<Point>> =
            self.0.iter().map(|walk| walk.expected(time_s)).collect();
        let mut seen = vec![(0_u32, Vector::ZERO); self.0.len()];
        let mut new: Vec<&Return> = Vec::new();
        for one in returns.iter().filter(|one| one.is_candidate) {
            let nearest = expected
                .iter()
                .enumerate()
                .filter_map(|(walk, place)| Some((walk, (one.point - (*place)?).norm())))
                .filter(|(_, apart_m)| *apart_m < GATE_M)
                .min_by(|one, other| one.1.total_cmp(&other.1));
            if let Some((walk, _)) = nearest {
                seen[walk].0 += 1;
                seen[walk].1 = seen[walk].1 + one.point.to_vector();
            } else if one.earlier == Earlier::Free {
                new.push(one);
            }
        }
        for (walk, (count, sum)) in self.0.iter_mut().zip(seen) {
            if count > 0 {
                walk.0.push_back((time_s, Point::default() + sum / f64::from(count)));
                walk.0.make_contiguous();
            }
        }
        let begin = |group: Group| Walk(VecDeque::from([(time_s, group.center)]));
        self.0.extend(groups_of(new.into_iter()).into_iter().map(begin));
        self.0.truncate(MAX_WALKS);
    }

    /// Forgets all walks.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// The people who walk, at a time, seconds, as discs of a radius, metres.
    pub fn walking(&self, time_s: f64, radius: f64) -> impl Iterator<Item = MovingDisc> + '_ {
        self.0.iter().filter_map(Walk::line).map(move |line| {
            let (Point { x, y }, Vector { x: vx, y: vy }) = (line.at(time_s), line.velocity);
            MovingDisc { x, y, radius, vx, vy }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Updates with single returns on ground that was free, or that no earlier scan explains.
    fn see(walkers: &mut Walkers, tick: u32, points: &[(f64, f64)], earlier: Earlier) {
        let at = |&(x, y): &(f64, f64)| {
            let one = Return::candidate(Point::new(x, y));
            Return { earlier, ..one }
        };
        let returns: Vec<Return> = points.iter().map(at).collect();
        walkers.update(f64::from(tick) * 0.1, &returns);
    }

    /// The leg of a person at x that a scan shows: one leg and the other in turn, each up to 0.2 m ahead of the body or behind it.
    fn leg(tick: u32, x: f64) -> (f64, f64) {
        let side = if tick.is_multiple_of(2) { 1.0 } else { -1.0 };
        let phase = f64::from(tick % 10) / 10.0;
        (x + side * (0.2 - 0.4 * phase), side * 0.1)
    }

    #[test]
    fn legs_that_scans_show_in_turn_give_place_and_velocity_of_the_person() {
        let mut walkers = Walkers::default();
        let place_m = |tick: u32| 6.0 - 0.1 * f64::from(tick);
        let mut found = 0;
        for tick in 0..40 {
            // Every fifth scan shows neither leg. The beams before end at the person, who walks towards the lidar.
            if tick % 5 == 4 {
                see(&mut walkers, tick, &[], Earlier::Free);
                continue;
            }
            let earlier = if tick == 0 { Earlier::Free } else { Earlier::Unknown };
            see(&mut walkers, tick, &[leg(tick, place_m(tick))], earlier);
            for disc in walkers.walking(f64::from(tick) * 0.1, 0.3) {
                found += 1;
                // The first line is short.
                let error = if tick < 15 { 0.4 } else { 0.15 };
                assert!((disc.vx + 1.0).abs() < error && disc.vy.abs() < error, "{tick}: {disc:?}");
                let apart_m = (disc.center() - Point::new(place_m(tick), 0.0)).norm();
                assert!(apart_m < 0.25, "{tick}: {disc:?}");
            }
        }
        assert!(found > 15, "{found}");
    }

    #[test]
    fn person_who_turns_walks_the_other_way_after_the_time_of_the_line() {
        let mut walkers = Walkers::default();
        let walk = |tick: u32| 3.0 + 0.1 * (f64::from(tick) - 20.0).abs();
        for tick in 0..=35 {
            see(&mut walkers, tick, &[(walk(tick), 0.0), (walk(tick), 0.2)], Earlier::Free);
            let speeds: Vec<f64> =
                walkers.walking(f64::from(tick) * 0.1, 0.3).map(|disc| disc.vx).collect();
            match tick {
                10..=20 => assert!((speeds[0] + 1.0).abs() < 0.1, "{tick}: {speeds:?}"),
                35 => assert!((speeds[0] - 1.0).abs() < 0.1, "{speeds:?}"),
                _ => {}
            }
        }
        // The person is gone.
        see(&mut walkers, 42, &[], Earlier::Free);
        assert_eq!(walkers.walking(4.2, 0.3).count(), 0);
    }

    #[test]
    fn post_dust_and_a_person_who_stands_do_not_walk() {
        let mut walkers = Walkers::default();
        for tick in 0..40 {
            // A grain of dust somewhere, a person who shifts from foot to foot, and a post that no scan saw through.
            let grain = (f64::from(tick * 37 % 11) - 5.0, f64::from(tick * 53 % 7) + 2.0);
            let shifts = (4.0 + 0.05 * f64::from(tick % 3), -3.0);
            see(&mut walkers, tick, &[grain, shifts], Earlier::Free);
            assert_eq!(walkers.walking(f64::from(tick) * 0.1, 0.3).count(), 0, "{tick}");
        }
        let mut walkers = Walkers::default();
        for tick in 0..20 {
            let post = (2.0 + 0.1 * f64::from(tick), 0.0);
            see(&mut walkers, tick, &[post], Earlier::Unknown);
            assert_eq!(walkers.walking(f64::from(tick) * 0.1, 0.3).count(), 0, "{tick}");
        }
    }
}
