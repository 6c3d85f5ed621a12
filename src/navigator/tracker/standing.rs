//! Standing people. A scan shows too little of them for a track.

use super::super::scan_visibility::Earlier;
use super::cluster::{Cluster, NarrowObject, Return};
use crate::geometry::{Point, Vector};
use crate::map::MovingDisc;

/// Two legs next to each other are at most this wide, metres, and have at least this many returns.
const LEGS_WIDTH_M: f64 = 0.3;
const LEGS_RETURNS: usize = 3;
/// New returns within this distance of a place are legs of the person there, metres.
const LEGS_REACH_M: f64 = 0.4;
/// Legs count as a person after this many scans. One scan is not enough: after an error of the pose, a post may seem to stand on
/// free ground for one scan.
const MIN_SIGHTINGS: u32 = 5;
/// Each of these is within this time of the previous one, seconds, or within as many intervals of the scans: two in a row may miss a leg.
const SIGHTED_S: f64 = 0.25;
const SIGHTED_INTERVALS: f64 = 2.5;
/// A person who stands shifts their weight by at most this, metres. Farther away, the returns are those of something else.
const SHIFTS_M: f64 = 0.4;
/// A person who is hidden stays for this long, seconds.
const HIDDEN_FOR_S: f64 = 5.0;
/// Two objects as narrow as a leg and at most this far apart may be a person who has stood there all the time, metres. A robot
/// fits between no such pair.
const LEG_WIDTH_M: f64 = 0.2;
const PAIR_M: f64 = 0.45;
/// Largest number of places.
const MAX_PLACES: usize = 16;

/// A place with its evidence.
#[derive(Debug)]
struct Place {
    disc: MovingDisc,
    /// Where it was sighted last.
    found: Point,
    sightings: u32,
    /// Time of the last sighting that counts, and of the last scan that showed anything there, seconds.
    seen_s: f64,
    shown_s: f64,
    /// Whether it is known as a pair of legs only: these are marks too, because posts look the same.
    is_pair: bool,
}

impl Place {
    fn new(time_s: f64, &Point { x, y }: &Point, sightings: u32) -> Self {
        let disc = MovingDisc { x, y, radius: LEGS_WIDTH_M / 2.0, vx: 0.0, vy: 0.0 };
        Self {
            disc,
            found: Point::new(x, y),
            sightings,
            seen_s: time_s,
            shown_s: time_s,
            is_pair: false,
        }
    }
}

/// The last places of leg tracks that moved, and of what came to ground that was free. A place is kept as long as scans show
/// something there that is new and does not belong to a moving track, or cannot see it.
#[derive(Debug, Default)]
pub(super) struct StandingPeople(Vec<Place>);

impl StandingPeople {
    /// Adds the place of a person who is known to stand there since a time, seconds.
    pub fn add(&mut self, time_s: f64, place: &Point) {
        self.sight(Place::new(time_s, place, MIN_SIGHTINGS));
    }

    /// Adds the pairs of legs among the narrow objects of a scan at a time, seconds.
    pub fn sight_pairs(&mut self, time_s: f64, narrow: &[NarrowObject]) {
        let may_be_leg =
            |one: &&NarrowObject| one.width_m <= LEG_WIDTH_M && one.count >= LEGS_RETURNS;
        let legs: Vec<Point> = narrow.iter().filter(may_be_leg).map(|one| one.middle).collect();
        for (number, one) in legs.iter().enumerate() {
            for other in legs[..number].iter().filter(|other| (**other - one).norm() <= PAIR_M) {
                let middle = *one + (*other - one) * 0.5;
                self.sight(Place { is_pair: true, ..Place::new(time_s, &middle, 1) });
            }
        }
    }

    /// Adds a sighting to the place of the same person, or as a new place.
    fn sight(&mut self, place: Place) {
        let center = place.disc.center();
        if let Some(known) =
            self.0.iter_mut().find(|known| is_near(&known.disc, &center, LEGS_REACH_M))
        {
            if known.seen_s < place.seen_s {
                known.sightings += place.sightings;
                (known.seen_s, known.found) = (place.seen_s, place.found);
            }
        } else if self.0.len() < MAX_PLACES {
            self.0.push(place);
        }
    }

    /// Forgets all places.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Updates the places with the clusters and returns of a scan at a time and this long after the last one, both in seconds;
    /// `is_free` returns whether the scan saw through a point.
    pub fn update(
        &mut self,
        (time_s, gap_s): (f64, f64),
        clusters: &[Cluster],
        returns: &mut [Return],
        is_free: impl Fn(&Point) -> bool,
    ) {
        let sighted_s = SIGHTED_S.max(SIGHTED_INTERVALS * gap_s);
        let is_recent = |place: &Place| (0.0..=sighted_s).contains(&(time_s - place.seen_s));
        self.0.retain(|place| place.sightings >= MIN_SIGHTINGS || is_recent(place));
        let came = |cluster: &Cluster| {
            let free =
                cluster.returns(returns, 1).filter(|one| one.earlier == Earlier::Free).count();
            2 * free > cluster.count
        };
        for cluster in clusters.iter().filter(|cluster| may_be_legs(cluster) && came(cluster)) {
            let [_, legs, _] = cluster.sample(returns);
            self.sight(Place::new(time_s, &legs, 1));
        }
        let mut shown = vec![(0_u32, Vector::ZERO); self.0.len()];
        for one in returns.iter_mut().filter(|one| !is_tracked(one)) {
            let away = |place: &Place| one.point - place.disc.center();
            let squared = |place: &Place| away(place).norm_squared();
            let nearest = self
                .0
                .iter()
                .enumerate()
                .min_by(|(_, one), (_, other)| squared(one).total_cmp(&squared(other)));
            if let Some((number, place)) = nearest
                && squared(place) < LEGS_REACH_M * LEGS_REACH_M
                && (one.is_candidate || place.is_pair)
            {
                let (count, sum) = shown[number];
                shown[number] = (count + 1, sum + away(place));
                one.is_of_standing = !place.is_pair;
            }
        }
        let mut shown = shown.into_iter();
        self.0.retain_mut(|Place { disc, found, shown_s, .. }| {
            let (count, sum) = shown.next().unwrap_or_default();
            if count == 0 {
                return time_s - *shown_s <= HIDDEN_FOR_S && !is_free(&disc.center());
            }
            // The middle between the legs.
            let shift = sum / f64::from(count);
            (disc.x, disc.y) = (disc.x + shift.x, disc.y + shift.y);
            *shown_s = time_s;
            is_near(disc, found, SHIFTS_M)
        });
    }

    /// The places where a person stands.
    pub fn discs(&self) -> impl Iterator<Item = MovingDisc> + '_ {
        self.sure().filter(|place| !place.is_pair).map(|place| place.disc)
    }

    /// The pairs of legs.
    pub fn pairs(&self) -> impl Iterator<Item = MovingDisc> + '_ {
        self.sure().filter(|place| place.is_pair).map(|place| place.disc)
    }

    fn sure(&self) -> impl Iterator<Item = &Place> {
        self.0.iter().filter(|place| place.sightings >= MIN_SIGHTINGS)
    }
}

/// Whether a cluster is as narrow as legs, and alone.
fn may_be_legs(cluster: &Cluster) -> bool {
    cluster.count >= LEGS_RETURNS
        && cluster.length_m <= LEGS_WIDTH_M
        && cluster.own_edges == [true, true]
        && cluster.joins == [false, false]
}

fn is_tracked(one: &Return) -> bool {
    one.owner.is_some_and(|owner| owner.is_moving)
}

fn is_near(disc: &MovingDisc, point: &Point, within_m: f64) -> bool {
    (disc.center() - point).norm() < within_m
}

#[cfg(test)]
mod tests {
    use super::super::cluster::Owner;
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
            let at = |offset_m| Point::new(x, y + offset_m * width_m);
            returns.extend([-0.5, 0.0, 0.5].map(|offset_m| Return::candidate(at(offset_m))));
        }
        (clusters, returns)
    }

    fn count(standing: &StandingPeople) -> usize {
        standing.discs().count()
    }

    #[test]
    fn two_legs_are_one_person_until_they_are_gone() {
        let mut standing = StandingPeople::default();
        let (clusters, mut returns) = scan(&[(1.0, 0.0), (1.0, 0.3)], 0.06);
        for (time_s, people) in [(0.0, 0), (0.1, 0), (0.2, 0), (0.3, 0), (0.4, 1)] {
            standing.update((time_s, 0.1), &clusters, &mut returns, |_| true);
            assert_eq!(count(&standing), people, "at {time_s} s");
        }
        assert!(returns.iter().all(|one| one.is_of_standing), "{returns:?}");
        let center = standing.discs().next().map(|disc| disc.center());
        assert!(center.is_some_and(|at| (at - Point::new(1.0, 0.15)).norm() < 1e-9), "{center:?}");
        // One leg hides the other, and shows too little to be new.
        standing.update((5.0, 0.1), &[], &mut returns[..1], |_| true);
        assert_eq!(count(&standing), 1);
        // An obstacle that was there before is no person.
        returns[0].is_candidate = false;
        standing.update((5.1, 0.1), &[], &mut returns[..1], |_| true);
        assert_eq!(count(&standing), 0);
    }

    #[test]
    fn two_people_next_to_each_other_keep_their_own_legs() {
        let mut standing = StandingPeople::default();
        let people = [(1.0, 0.0), (1.0, 0.5)];
        for (x, y) in people {
            standing.add(0.0, &Point::new(x, y));
        }
        standing.add(0.1, &Point::new(1.0, 0.1));
        let (clusters, mut returns) = scan(&people, 0.06);
        standing.update((0.1, 0.1), &clusters, &mut returns, |_| true);
        let found: Vec<f64> = standing.discs().map(|disc| disc.y).collect();
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found[0].abs() < 1e-9 && (found[1] - 0.5).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn pair_of_legs_that_was_there_all_the_time_is_a_person_and_a_mark() {
        // Two scans in a row miss the legs.
        for (apart_m, period_s, people) in [(0.3, 0.1, 1), (0.3, 0.2, 1), (0.6, 0.1, 0)] {
            let mut standing = StandingPeople::default();
            let (clusters, mut returns) = scan(&[(1.0, 0.0), (1.0, apart_m)], 0.06);
            for one in &mut returns {
                (one.is_candidate, one.earlier) = (false, Earlier::Unknown);
            }
            let legs = [0.0, apart_m].map(|y| NarrowObject {
                middle: Point::new(1.0, y),
                center: Point::new(1.03, y),
                range_m: 1.0,
                width_m: 0.06,
                count: 3,
            });
            for tick in 0..7 {
                let time_s = f64::from(tick) * period_s;
                standing.sight_pairs(time_s, if (4..6).contains(&tick) { &[] } else { &legs });
                standing.update((time_s, period_s), &clusters, &mut returns, |_| true);
            }
            assert_eq!(standing.pairs().count(), people, "{apart_m} m, {period_s} s");
            assert_eq!(count(&standing), 0, "{apart_m} m");
            assert!(returns.iter().all(|one| !one.is_of_standing), "{returns:?}");
        }
    }

    #[test]
    fn posts_and_boxes_are_no_people() {
        for (width_m, earlier, period_s) in
            [(0.06, Earlier::Unknown, 0.1), (0.4, Earlier::Free, 0.1), (0.06, Earlier::Free, 0.5)]
        {
            let mut standing = StandingPeople::default();
            let (clusters, mut returns) = scan(&[(1.0, 0.0)], width_m);
            returns.iter_mut().for_each(|one| one.earlier = earlier);
            for tick in 0..9 {
                standing
                    .update((f64::from(tick) * period_s, 0.1), &clusters, &mut returns, |_| true);
            }
            assert_eq!(count(&standing), 0, "{width_m} {earlier:?} {period_s}");
        }
    }

    /// A robot drives past chairs: what it sees next to the place is another chair each time.
    #[test]
    fn place_does_not_follow_other_returns_far_from_where_it_was_sighted() {
        for (is_sighted, people) in [(false, 0), (true, 1)] {
            let mut standing = StandingPeople::default();
            standing.add(0.0, &Point::new(1.0, 0.0));
            for tick in 1..=8 {
                let (time_s, y) = (f64::from(tick) * 0.1, f64::from(tick) * 0.06);
                let (clusters, mut returns) = scan(&[(1.0, y)], 0.06);
                if !is_sighted {
                    returns.iter_mut().for_each(|one| one.earlier = Earlier::Unknown);
                }
                standing.update((time_s, 0.1), &clusters, &mut returns, |_| false);
            }
            assert_eq!(count(&standing), people, "sighted: {is_sighted}");
        }
    }

    #[test]
    fn place_is_kept_until_a_track_moves_there() {
        let mut standing = StandingPeople::default();
        standing.add(0.0, &Point::new(1.0, 0.0));
        let (clusters, mut returns) = scan(&[(1.2, 0.0)], 0.06);
        standing.update((0.1, 0.1), &clusters, &mut returns, |_| true);
        let place = standing.discs().next().expect("a place");
        assert!((place.x - 1.2).abs() < 1e-9 && place.vx == 0.0, "{place:?}");
        // A walker passes in front; the person goes; a person is hidden.
        let owner = Some(Owner { track: 0, is_moving: true });
        returns.iter_mut().for_each(|one| one.owner = owner);
        standing.update((0.2, 0.1), &clusters, &mut returns, |_| false);
        assert_eq!(count(&standing), 1);
        standing.update((0.3, 0.1), &clusters, &mut returns, |_| true);
        assert_eq!(count(&standing), 0);
        standing.add(1.0, &Point::new(1.0, 0.0));
        standing.update((1.0 + HIDDEN_FOR_S + 0.1, 0.1), &[], &mut [], |_| false);
        assert_eq!(count(&standing), 0);
    }
}
