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
/// Largest number of places.
const MAX_PLACES: usize = 16;

/// The last places of lost tracks that moved, and of legs that came to ground that was free. A place is kept as long as a scan
/// shows something unexplained there.
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

    /// Updates the places with the clusters and returns of a scan, and with what moves; `was_free` returns whether an earlier
    /// scan saw through a point.
    pub fn update(
        &mut self,
        clusters: &[Cluster],
        returns: &[Return],
        moving: &[MovingDisc],
        was_free: impl Fn(&Point) -> bool,
    ) {
        let came = |cluster: &Cluster| {
            let free = cluster.points(returns, 1).filter(|point| was_free(point)).count();
            2 * free > cluster.count
        };
        for cluster in clusters.iter().filter(|cluster| may_be_legs(cluster) && came(cluster)) {
            let Point { x, y } = returns[(cluster.first + cluster.count / 2) % returns.len()].point;
            let person = MovingDisc { x, y, radius: LEGS_WIDTH_M / 2.0, vx: 0.0, vy: 0.0 };
            if !self.0.iter().any(|known| is_near(known, &person.center(), SAME_M)) {
                self.add(&person);
            }
        }
        self.0.retain_mut(|place| {
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

    /// The places.
    pub fn discs(&self) -> &[MovingDisc] {
        &self.0
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

    /// Objects at places, of this width with three returns each.
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
                });
            }
        }
        (clusters, returns)
    }

    #[test]
    fn two_legs_are_one_person_until_they_are_gone() {
        let mut standing = StandingPeople::default();
        let (clusters, returns) = scan(&[(1.0, 0.0), (1.0, 0.3)], 0.06);
        standing.update(&clusters, &returns, &[], |_| true);
        assert_eq!(standing.discs().len(), 1);
        let center = standing.discs()[0].center();
        assert!((center - Point::new(1.0, 0.15)).norm() < 1e-9, "{center:?}");
        // One leg hides the other, and shows too little to be new.
        standing.update(&[], &returns[..1], &[], |_| true);
        assert_eq!(standing.discs().len(), 1);
        standing.update(&[], &[], &[], |_| true);
        assert_eq!(standing.discs().len(), 0);
        let (clusters, returns) = scan(&[(1.0, 0.0)], 0.06);
        standing.update(&clusters, &returns, &[], |_| false);
        assert_eq!(standing.discs().len(), 0, "a post");
        let (clusters, returns) = scan(&[(1.0, 0.0)], 0.4);
        standing.update(&clusters, &returns, &[], |_| true);
        assert_eq!(standing.discs().len(), 0, "a box");
    }

    #[test]
    fn place_of_a_lost_track_is_kept_until_it_moves_again() {
        let mut standing = StandingPeople::default();
        let disc = MovingDisc { x: 1.0, y: 0.0, radius: 0.1, vx: 0.5, vy: 0.0 };
        standing.add(&disc);
        let (clusters, returns) = scan(&[(1.2, 0.0)], 0.06);
        standing.update(&clusters, &returns, &[], |_| true);
        let place = standing.discs()[0];
        assert_eq!((place.vx, place.radius), (0.0, 0.1));
        assert!((place.x - 1.2).abs() < 1e-9, "{place:?}");
        standing.update(&clusters, &returns, &[MovingDisc { x: 1.3, ..disc }], |_| true);
        assert_eq!(standing.discs(), []);
    }
}
