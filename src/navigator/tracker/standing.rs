//! People who stand: what a scan shows of them is too little for a track.

use super::cluster::{Cluster, Return};
use crate::geometry::Point;
use crate::map::MovingDisc;

/// A leg is at most this wide, metres, and has at least this many returns.
const LEG_WIDTH_M: f64 = 0.11;
const LEG_RETURNS: usize = 2;
/// Distance between the legs of a person, metres.
const LEGS_APART_M: core::ops::RangeInclusive<f64> = 0.08..=0.6;
/// Unexplained returns within this distance of a place show that a person is still there, metres.
const STILL_THERE_M: f64 = 0.3;
/// A moving disc within this distance of a place is that person, metres.
const SAME_M: f64 = 0.5;
/// Largest number of places.
const MAX_PLACES: usize = 16;

/// The last places of lost tracks that moved, and pairs of legs that never moved. A place is kept as long as a scan shows
/// something unexplained there.
#[derive(Debug, Default)]
pub(super) struct StandingPeople(Vec<MovingDisc>);

impl StandingPeople {
    /// Adds the place of a lost track.
    pub fn add(&mut self, disc: &MovingDisc) {
        if self.0.len() < MAX_PLACES {
            self.0.push(MovingDisc { vx: 0.0, vy: 0.0, ..*disc });
        }
    }

    /// Forgets all places.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Updates the places with the clusters and returns of a scan, and with what moves.
    pub fn update(&mut self, clusters: &[Cluster], returns: &[Return], moving: &[MovingDisc]) {
        let legs: Vec<Point> = clusters
            .iter()
            .filter(|cluster| {
                cluster.count >= LEG_RETURNS
                    && cluster.length_m <= LEG_WIDTH_M
                    && cluster.own_edges == [true, true]
            })
            .map(|cluster| returns[(cluster.first + cluster.count / 2) % returns.len()].point)
            .collect();
        for (index, one) in legs.iter().enumerate() {
            for other in &legs[index + 1..] {
                if LEGS_APART_M.contains(&(other - one).norm()) {
                    let Point { x, y } = *one + (other - one) * 0.5;
                    let person = MovingDisc { x, y, radius: LEG_WIDTH_M / 2.0, vx: 0.0, vy: 0.0 };
                    if !self.0.iter().any(|known| is_near(known, &person.center(), SAME_M)) {
                        self.add(&person);
                    }
                }
            }
        }
        self.0.retain(|place| {
            returns.iter().any(|one| is_near(place, &one.point, STILL_THERE_M))
                && !moving.iter().any(|other| is_near(place, &other.center(), SAME_M))
        });
    }

    /// The places.
    pub fn discs(&self) -> &[MovingDisc] {
        &self.0
    }
}

fn is_near(disc: &MovingDisc, point: &Point, within_m: f64) -> bool {
    (disc.center() - point).norm() < within_m
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns of legs at places, two for each leg.
    fn scan(legs: &[(f64, f64)]) -> (Vec<Cluster>, Vec<Return>) {
        let (mut clusters, mut returns) = (Vec::new(), Vec::new());
        for &(x, y) in legs {
            clusters.push(Cluster {
                first: returns.len(),
                count: 2,
                near_m: 1.0,
                right: 0.0,
                spread: 0.1,
                own_edges: [true, true],
                joins: [false, false],
                length_m: 0.06,
            });
            for offset_m in [-0.03, 0.03] {
                returns.push(Return {
                    beam: returns.len(),
                    range_m: 1.0,
                    point: Point::new(x, y + offset_m),
                    is_candidate: true,
                    owner: None,
                });
            }
        }
        (clusters, returns)
    }

    #[test]
    fn two_legs_are_a_person_until_they_are_gone() {
        let mut standing = StandingPeople::default();
        let (clusters, returns) = scan(&[(1.0, 0.0), (1.0, 0.3), (4.0, 0.0)]);
        standing.update(&clusters, &returns, &[]);
        assert_eq!(standing.discs().len(), 1, "one post is no person");
        assert!((standing.discs()[0].center() - Point::new(1.0, 0.18)).norm() < 0.05);
        // One leg hides the other.
        let (clusters, returns) = scan(&[(1.0, 0.0)]);
        standing.update(&clusters, &returns, &[]);
        assert_eq!(standing.discs().len(), 1);
        standing.update(&[], &[], &[]);
        assert_eq!(standing.discs().len(), 0);
    }

    #[test]
    fn place_of_a_lost_track_is_kept_until_it_moves_again() {
        let mut standing = StandingPeople::default();
        let disc = MovingDisc { x: 1.0, y: 0.0, radius: 0.1, vx: 0.5, vy: 0.0 };
        standing.add(&disc);
        let (clusters, returns) = scan(&[(1.2, 0.0)]);
        standing.update(&clusters, &returns, &[]);
        assert_eq!(standing.discs(), [MovingDisc { vx: 0.0, ..disc }]);
        standing.update(&clusters, &returns, &[MovingDisc { x: 1.3, ..disc }]);
        assert_eq!(standing.discs(), []);
    }
}
