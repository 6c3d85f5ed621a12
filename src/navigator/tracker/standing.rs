//! People who stand: what a scan shows of them is too little for a track.

use super::cluster::{Cluster, Return};
use crate::geometry::{Point, Vector};
use crate::map::MovingDisc;

/// Two legs next to each other are at most this wide, metres, and have at least this many returns.
const LEGS_WIDTH_M: f64 = 0.3;
const LEGS_RETURNS: usize = 3;
/// Unexplained returns within this distance of a place show that a person is still there, metres.
const STILL_THERE_M: f64 = 0.4;
/// A moving disc within this distance of a place is that person, metres.
const SAME_M: f64 = 0.5;
/// Legs count as a person after this many scans, each within this time of the one before, seconds: by an error of the pose a
/// post may seem to stand on free ground for one scan.
const MIN_SIGHTINGS: u32 = 3;
const SIGHTED_S: f64 = 0.25;
/// Largest number of places.
const MAX_PLACES: usize = 16;

/// A place with its evidence.
#[derive(Debug)]
struct Place {
    disc: MovingDisc,
    sightings: u32,
    /// Time of the last sighting, seconds.
    seen_s: f64,
}

/// The last places of lost tracks that moved, and of legs that came to ground that was free. A place is kept as long as a scan
/// shows something unexplained there.
#[derive(Debug, Default)]
pub(super) struct StandingPeople(Vec<Place>);

impl StandingPeople {
    /// Adds the place of a track that was lost at a time, seconds.
    pub fn add(&mut self, time_s: f64, disc: &MovingDisc) {
        let disc = MovingDisc { vx: 0.0, vy: 0.0, ..*disc };
        self.push(Place { disc, sightings: MIN_SIGHTINGS, seen_s: time_s });
    }

    fn push(&mut self, place: Place) {
        if self.0.len() < MAX_PLACES {
            self.0.push(place);
        }
    }

    /// Forgets all places.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Updates the places with the clusters and returns of a scan at a time, seconds, and with what moves.
    pub fn update(
        &mut self,
        time_s: f64,
        clusters: &[Cluster],
        returns: &[Return],
        moving: &[MovingDisc],
    ) {
        let is_recent = |place: &Place| (0.0..=SIGHTED_S).contains(&(time_s - place.seen_s));
        self.0.retain(|place| place.sightings >= MIN_SIGHTINGS || is_recent(place));
        let came = |cluster: &Cluster| {
            let free = cluster.returns(returns, 1).filter(|one| one.was_free).count();
            2 * free > cluster.count
        };
        for cluster in clusters.iter().filter(|cluster| may_be_legs(cluster) && came(cluster)) {
            let [_, legs, _] = cluster.sample(returns);
            if let Some(known) = self.0.iter_mut().find(|it| is_near(&it.disc, &legs, SAME_M)) {
                known.sightings += u32::from(known.seen_s < time_s);
                known.seen_s = time_s;
            } else {
                let Point { x, y } = legs;
                let disc = MovingDisc { x, y, radius: LEGS_WIDTH_M / 2.0, vx: 0.0, vy: 0.0 };
                self.push(Place { disc, sightings: 1, seen_s: time_s });
            }
        }
        self.0.retain_mut(|place| {
            let place = &mut place.disc;
            let near = returns.iter().filter(|one| is_near(place, &one.point, STILL_THERE_M));
            let (count, sum) = near.fold((0_u32, Vector::ZERO), |(count, sum), one| {
                (count + 1, sum + (one.point - place.center()))
            });
            // The middle between the legs.
            let shift = sum / f64::from(count.max(1));
            (place.x, place.y) = (place.x + shift.x, place.y + shift.y);
            count > 0 && !moving.iter().any(|other| is_near(place, &other.center(), SAME_M))
        });
    }

    /// The places where a person stands.
    pub fn discs(&self) -> impl Iterator<Item = MovingDisc> + '_ {
        self.0.iter().filter(|place| place.sightings >= MIN_SIGHTINGS).map(|place| place.disc)
    }
}

/// Whether a cluster is as narrow as legs, and alone.
fn may_be_legs(cluster: &Cluster) -> bool {
    cluster.count >= LEGS_RETURNS
        && cluster.length_m <= LEGS_WIDTH_M
        && cluster.own_edges == [true, true]
        && cluster.joins == [false, false]
}

fn is_near(disc: &MovingDisc, point: &Point, within_m: f64) -> bool {
    (disc.center() - point).norm() < within_m
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Objects on ground that was free, at places, of this width with three returns each.
    fn scan(places: &[(f64, f64)], width_m: f64) -> (Vec<Cluster>, Vec<Return>) {
        let (mut clusters, mut returns) = (Vec::new(), Vec::new());
        for &(x, y) in places {
            clusters.push(Cluster {
                first: returns.len(),
                count: 3,
                near_m: 1.0,
                right: 0.0,
                spread: 0.1,
                own_edges: [true, true],
                joins: [false, false],
                length_m: width_m,
            });
            for offset_m in [-0.5, 0.0, 0.5] {
                returns.push(Return {
                    beam: returns.len(),
                    range_m: 1.0,
                    point: Point::new(x, y + offset_m * width_m),
                    is_candidate: true,
                    owner: None,
                    was_free: true,
                });
            }
        }
        (clusters, returns)
    }

    #[test]
    fn two_legs_are_one_person_until_they_are_gone() {
        let mut standing = StandingPeople::default();
        let count = |standing: &StandingPeople| standing.discs().count();
        let (clusters, returns) = scan(&[(1.0, 0.0), (1.0, 0.3)], 0.06);
        for (time_s, people) in [(0.0, 0), (0.1, 0), (0.2, 1)] {
            standing.update(time_s, &clusters, &returns, &[]);
            assert_eq!(count(&standing), people, "at {time_s} s");
        }
        let center = standing.discs().next().map(|disc| disc.center());
        assert!(center.is_some_and(|at| (at - Point::new(1.0, 0.15)).norm() < 1e-9), "{center:?}");
        // One leg hides the other, and shows too little to be new.
        standing.update(5.0, &[], &returns[..1], &[]);
        assert_eq!(count(&standing), 1);
        standing.update(5.1, &[], &[], &[]);
        assert_eq!(count(&standing), 0);
    }

    #[test]
    fn posts_and_boxes_are_no_people() {
        for (width_m, was_free, period_s) in
            [(0.06, false, 0.1), (0.4, true, 0.1), (0.06, true, 0.5)]
        {
            let mut standing = StandingPeople::default();
            let (clusters, mut returns) = scan(&[(1.0, 0.0)], width_m);
            returns.iter_mut().for_each(|one| one.was_free = was_free);
            for tick in 0..5 {
                let time_s = f64::from(tick) * period_s;
                standing.update(time_s, &clusters, &returns, &[]);
            }
            assert_eq!(standing.discs().count(), 0, "{width_m} {was_free} {period_s}");
        }
    }

    #[test]
    fn place_of_a_lost_track_is_kept_until_it_moves_again() {
        let mut standing = StandingPeople::default();
        let disc = MovingDisc { x: 1.0, y: 0.0, radius: 0.1, vx: 0.5, vy: 0.0 };
        standing.add(0.0, &disc);
        let (clusters, returns) = scan(&[(1.2, 0.0)], 0.06);
        standing.update(0.1, &clusters, &returns, &[]);
        let place = standing.discs().next().expect("a place");
        assert_eq!((place.vx, place.radius), (0.0, 0.1));
        assert!((place.x - 1.2).abs() < 1e-9, "{place:?}");
        let moving = [MovingDisc { x: 1.3, ..disc }];
        standing.update(0.2, &clusters, &returns, &moving);
        assert_eq!(standing.discs().count(), 0);
    }
}
