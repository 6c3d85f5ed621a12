//! Tracks moving obstacles from scans alone: discs with a velocity.
//!
//! Returns that the map does not explain form clusters of neighbours. A disc is fitted to each cluster, and a filter of constant
//! velocity tracks each disc. Motion needs evidence that no static obstacle gives, however the robot moves: points of the
//! cluster fall on ground that an earlier scan saw through, or the present scan sees through ground where its points were.
//! Corners that come into view, walls behind a doorway and posts that merge into one do neither.

mod cluster;
mod entered;
mod filter;
mod free_standing;
mod standing;
mod track;
mod walkers;

use nalgebra::Matrix2;

use super::obstacle_model::ReturnOrigin;
use super::scan_visibility::{Earlier, History, proves_free, sees_beyond, shows_free};
use crate::geometry::{Point, Pose, bearing};
use crate::map::{MovingDisc, Scan};
use cluster::{Cluster, LONGEST_M, Owner, Return, ScanReturns};
use entered::EnteredPlaces;
use filter::Fit;
use free_standing::FreeStandingObjects;
use standing::StandingPeople;
use track::Track;
use walkers::Walkers;

/// Returns from beyond this distance do not count, metres: a person has no three beams of 1 degree there.
pub(super) const FARTHEST_M: f64 = 12.0;
/// Returns that a new track needs, and that a track continues with.
const MIN_NEW_RETURNS: usize = 3;
const MIN_RETURNS: usize = 2;
/// A cluster belongs to a track if it is within this many squared deviations of the expected place, and within this distance,
/// metres.
const GATE: f64 = 16.0;
const GATE_M: f64 = 0.6;
/// The same distance for a track that never moved, metres: 3 m/s for a tenth of a second.
const FIRST_GATE_M: f64 = 0.35;
/// Additional variance of the place, square metres on each axis: a walking person may turn and stop at once.
const SUDDEN_M2: f64 = 0.1 * 0.1;
/// Returns within this distance of the outline of an expected disc belong to it, metres.
const OWN_M: f64 = 0.15;
/// Returns on free ground within this distance of a moving disc belong to it, metres.
const ENTERED_M: f64 = 0.4;
/// Largest number of points of a cluster that are checked for free ground.
const MAX_CHECKED: usize = 24;
/// Two scans further apart than this say nothing about motion, seconds.
const LONGEST_GAP_S: f64 = 1.0;

/// A cluster that may belong to a track.
#[derive(Clone, Copy, Debug)]
struct Pair {
    cost: f64,
    track: usize,
    cluster: usize,
    fit: Fit,
}

/// Tracks everything that the map does not explain, and finds what moves.
///
/// It has no clock and no random numbers: the same scans give the same discs.
#[derive(Debug, Default)]
pub(super) struct Tracker {
    last_s: Option<f64>,
    tracks: Vec<Track>,
    history: History,
    /// Obstacles that move or moved, and have not left their place since, in the map frame at the time of the last scan.
    pub moving: Vec<MovingDisc>,
    standing: StandingPeople,
    /// Discs that a moving obstacle covered, and the begin of its track, seconds.
    pub swept: Vec<(MovingDisc, f64)>,
    entered: EnteredPlaces,
    walkers: Walkers,
    free_standing: FreeStandingObjects,
    /// Whether what comes out of hiding may be a person.
    pub hides_people: bool,
    returns: Vec<Return>,
    clusters: Vec<Cluster>,
    pairs: Vec<Pair>,
    /// For each cluster the track that it belongs to.
    taken: Vec<Option<usize>>,
}

impl Tracker {
    /// Updates the tracks with a scan made at a time, seconds, from a pose in the map frame; `origin` returns what a return at a
    /// point belongs to.
    pub fn update(
        &mut self,
        time_s: f64,
        pose: &Pose,
        scan: &Scan,
        origin: impl Fn(&Point) -> ReturnOrigin,
    ) {
        let gap_s = self.last_s.map_or(0.0, |last_s| time_s - last_s);
        if !(0.0..=LONGEST_GAP_S).contains(&gap_s) {
            self.tracks.clear();
            self.history.clear();
            self.entered.clear();
            self.walkers.clear();
            self.standing.clear();
            self.free_standing.clear();
        } else if gap_s > 0.0 {
            for track in &mut self.tracks {
                track.predict(gap_s);
            }
        }
        self.last_s = Some(time_s);
        self.history.select(time_s, pose);
        self.swept.clear();
        self.collect(pose, scan, &origin);
        self.entered.update(time_s, &self.returns);
        self.walkers.update(time_s, &self.returns);
        let returns = ScanReturns { pose, scan, returns: &self.returns };
        returns.find_clusters(&mut self.clusters);
        let narrow = returns.narrow_objects(free_standing::WIDEST_M);
        self.free_standing.update(time_s, scan.angle_increment, &narrow);
        self.standing.sight_pairs(time_s, &narrow);
        self.associate(pose, scan);
        self.update_tracks((time_s, gap_s), pose, scan);
        self.drop_lost(time_s, pose, scan, &origin);
        self.start_tracks(time_s, pose, scan);
        self.moving.clear();
        for track in self.tracks.iter().filter(|track| track.is_moving) {
            self.moving.push(track.disc());
            self.swept.push((track.disc(), track.born_s));
        }
        let is_free = |point: &Point| shows_free(pose, scan, point);
        self.standing.update((time_s, gap_s), &self.clusters, &mut self.returns, is_free);
        self.moving.extend(self.standing.discs());
        self.history.push(time_s, pose, scan);
    }

    /// Places that something entered, or where it came out of hiding, within the last half second, each with the time since it last
    /// stood, seconds. A tracked disc that is wider than a leg explains them: the velocity of a leg is not that of its person.
    pub fn entered(&self) -> impl Iterator<Item = (Point, Option<f64>)> + '_ {
        let explains = |track: &Track, place: &Point| {
            let within_m = track.radius.radius_m + ENTERED_M;
            track.is_moving && !track.is_leg() && (track.center() - place).norm() < within_m
        };
        let is_explained =
            move |place: &Point| self.tracks.iter().any(|track| explains(track, place));
        let places = self.last_s.into_iter().flat_map(|time_s| self.entered.places(time_s));
        places.filter(move |(place, _)| !is_explained(place))
    }

    /// People who walk straight, by their legs alone, as discs of a radius, metres, and the bodies that are no such people.
    pub fn walkers(&self, bodies: &[MovingDisc], radius_m: f64) -> Vec<MovingDisc> {
        let time_s = self.last_s.unwrap_or_default();
        let walking: Vec<_> = self.walkers.walking(time_s, radius_m).collect();
        let explains = |walker: &MovingDisc, body: &MovingDisc| {
            (walker.center() - body.center()).norm() < walker.radius + body.radius
        };
        let is_other = |body: &&MovingDisc| !walking.iter().any(|walker| explains(walker, body));
        let others: Vec<_> = bodies.iter().filter(is_other).copied().collect();
        [walking, others].concat()
    }

    /// Pairs of narrow objects, which may be people who have stood there all the time.
    pub fn pairs_of_legs(&self) -> impl Iterator<Item = MovingDisc> + '_ {
        self.standing.pairs()
    }

    /// Objects as narrow as a person that stand alone: each may be a person who has stood there all the time.
    pub fn free_standing(&self) -> impl Iterator<Item = Point> + '_ {
        self.free_standing.places()
    }

    /// The returns of the last scan, up to a distance, that neither the map nor a person who stands explains.
    pub fn points(&self) -> impl Iterator<Item = Point> + '_ {
        self.returns.iter().filter(|one| !one.is_of_standing).map(|one| one.point)
    }

    fn collect(&mut self, pose: &Pose, scan: &Scan, origin: impl Fn(&Point) -> ReturnOrigin) {
        self.returns.clear();
        let lidar = pose.transform(&scan.origin);
        for (beam, &range_m) in scan.ranges.iter().enumerate() {
            if !(scan.is_return(range_m) && range_m <= FARTHEST_M) {
                continue;
            }
            let point = scan.end_from(&lidar, pose.yaw, beam);
            let origin = origin(&point);
            if origin == ReturnOrigin::Mapped {
                continue;
            }
            let owner = owner(&self.tracks, &point);
            let is_candidate = origin == ReturnOrigin::New || owner.is_some();
            self.returns.push(Return {
                beam,
                range_m,
                point,
                is_candidate,
                owner,
                earlier: if is_candidate {
                    self.history.of(&point, self.hides_people)
                } else {
                    Earlier::Unknown
                },
                is_of_standing: false,
            });
        }
    }

    /// Assigns each cluster to the nearest track that it may belong to.
    fn associate(&mut self, pose: &Pose, scan: &Scan) {
        let lidar = pose.transform(&scan.origin);
        self.pairs.clear();
        for (place, cluster) in self.clusters.iter().enumerate() {
            if cluster.count < MIN_RETURNS || cluster.length_m > LONGEST_M {
                continue;
            }
            for (number, track) in self.tracks.iter().enumerate() {
                let radius_m = track.radius.radius_m;
                let gate_m = if track.has_moved { GATE_M } else { FIRST_GATE_M };
                let rough = cluster.rough_center(&lidar, radius_m, scan.angle_increment);
                if (rough - track.center()).norm() > gate_m {
                    continue;
                }
                let fit = cluster.fit(&self.returns, &lidar, radius_m, scan.angle_increment);
                let sudden = if track.has_moved { SUDDEN_M2 } else { 0.0 };
                let cost = track.filter.squared_deviations(&Fit {
                    covariance: fit.covariance + Matrix2::identity() * sudden,
                    ..fit
                });
                if cost < GATE && (fit.center - track.center()).norm() < gate_m {
                    self.pairs.push(Pair { cost, track: number, cluster: place, fit });
                }
            }
        }
        // A tie goes to the older track, then to the earlier beam.
        self.pairs.sort_unstable_by(|one, other| {
            let by_age = (one.track, one.cluster).cmp(&(other.track, other.cluster));
            one.cost.total_cmp(&other.cost).then(by_age)
        });
        self.taken.clear();
        self.taken.resize(self.clusters.len(), None);
        let mut updated = vec![false; self.tracks.len()];
        let taken = &mut self.taken;
        self.pairs.retain(|pair| {
            let is_best = taken[pair.cluster].is_none() && !updated[pair.track];
            if is_best {
                taken[pair.cluster] = Some(pair.track);
                updated[pair.track] = true;
            }
            is_best
        });
    }

    /// Updates each track with its cluster and with the evidence of motion.
    fn update_tracks(&mut self, (time_s, gap_s): (f64, f64), pose: &Pose, scan: &Scan) {
        let lidar = pose.transform(&scan.origin);
        for pair in &self.pairs {
            let cluster = &self.clusters[pair.cluster];
            let track = &mut self.tracks[pair.track];
            let distance_m = (pair.fit.center - lidar).norm() - track.radius.radius_m;
            let seen = cluster.radius(distance_m, scan.angle_increment);
            let sample = cluster.sample(&self.returns);
            track.update((time_s, gap_s), &pair.fit, seen, &lidar, sample);
            // A cluster connected to a settled mark is a part of it, even if its ends seem to move.
            let stands_alone = cluster.joins == [false, false];
            let evidence = if stands_alone && track.seems_moving() {
                let stride = cluster.count.div_ceil(MAX_CHECKED);
                let members = cluster.returns(&self.returns, stride);
                let entered = members.filter(|one| one.earlier == Earlier::Free).count();
                let left = track
                    .earlier_points(time_s)
                    .filter(|(point, seen_s)| {
                        proves_free(pose, scan, point, &self.history.motion_since(*seen_s))
                    })
                    .count();
                (entered + left) as u32
            } else {
                0
            };
            let was_moving = track.is_moving;
            if track.update_motion(time_s, evidence) {
                let since_s = track.born_s;
                let discs = track.earlier_discs().map(|disc| (disc, since_s));
                self.swept.extend(discs);
            }
            if was_moving && !track.is_moving && track.is_leg() {
                self.standing.add(time_s, &track.center());
            }
        }
    }

    /// Drops tracks that were not seen for too long, and those that are expected within an obstacle of the map.
    fn drop_lost(
        &mut self,
        time_s: f64,
        pose: &Pose,
        scan: &Scan,
        origin: impl Fn(&Point) -> ReturnOrigin,
    ) {
        let lidar = pose.transform(&scan.origin);
        let mut number = 0;
        let Self { pairs, standing, tracks, .. } = self;
        tracks.retain(|track| {
            let is_updated = pairs.iter().any(|pair| pair.track == number);
            number += 1;
            if is_updated {
                return true;
            }
            let distance = (track.center() - lidar).norm();
            let half_angle = libm::atan2(track.radius.radius_m / 2.0, distance);
            let direction = bearing(&lidar, &track.center());
            let is_gone = sees_beyond(pose, scan, direction, half_angle, distance);
            let is_in_wall = origin(&track.center()) == ReturnOrigin::Mapped;
            let is_over = is_in_wall || track.is_over(time_s, is_gone);
            if is_over && track.is_moving && track.is_leg() {
                // A person does not walk into a wall: this one stopped or turned before.
                let place = if is_in_wall { track.seen_at } else { track.center() };
                standing.add(time_s, &place);
            }
            !is_over
        });
    }

    /// Starts a track for each cluster that belongs to none.
    fn start_tracks(&mut self, time_s: f64, pose: &Pose, scan: &Scan) {
        let lidar = pose.transform(&scan.origin);
        for (cluster, taken) in self.clusters.iter().zip(&self.taken) {
            let may_be_disc = cluster.joins != [true, true]
                && cluster.count >= MIN_NEW_RETURNS
                && cluster.length_m <= LONGEST_M;
            if taken.is_some() || !may_be_disc {
                continue;
            }
            let increment = scan.angle_increment;
            let radius = Track::first_radius(cluster.radius(cluster.near_m, increment));
            let fit = cluster.fit(&self.returns, &lidar, radius.radius_m, increment);
            self.tracks.push(Track::new(time_s, &fit, radius, cluster.sample(&self.returns)));
        }
    }
}

/// The moving track whose expected disc covers a point: the nearest one if several do.
fn owner(tracks: &[Track], point: &Point) -> Option<Owner> {
    tracks
        .iter()
        .enumerate()
        .filter_map(|(number, track)| {
            let beyond_m = (point - track.center()).norm() - track.radius.radius_m;
            (track.claims_returns() && beyond_m < OWN_M).then_some((number, beyond_m))
        })
        .min_by(|one, other| one.1.total_cmp(&other.1))
        .map(|(track, _)| Owner { track, is_moving: tracks[track].is_moving })
}

#[cfg(test)]
mod tests {
    use core::f64::consts::{PI, TAU};

    use super::*;

    /// The horizon, which the map explains, metres.
    const HORIZON_M: f64 = 9.0;

    /// Discs by place and radius, seen from the origin.
    fn scan_of(discs: &[(f64, f64, f64)]) -> Scan {
        let range = |beam: i32| {
            let (sin, cos) = libm::sincos(f64::from(beam) * TAU / 1440.0);
            let to_disc = |&(x, y, radius): &(f64, f64, f64)| {
                let (along, across) = (x * cos + y * sin, y * cos - x * sin);
                let half = radius * radius - across * across;
                if half >= 0.0 && along > 0.0 { along - half.sqrt() } else { HORIZON_M }
            };
            discs.iter().map(to_disc).fold(HORIZON_M, f64::min)
        };
        Scan {
            angle_min: -PI,
            angle_increment: TAU / 1440.0,
            range_max: 10.0,
            ranges: (-720..720).map(range).collect(),
            ..Scan::default()
        }
    }

    /// Updates a tracker with the tick of a lidar of 10 Hz. The map explains what is at the horizon or nearer than 1.5 m.
    fn see(tracker: &mut Tracker, tick: u32, discs: &[(f64, f64, f64)]) -> usize {
        let origin = |point: &Point| {
            let range_m = point.to_vector().norm();
            let is_new = (1.5..=HORIZON_M - 0.1).contains(&range_m);
            if is_new { ReturnOrigin::New } else { ReturnOrigin::Mapped }
        };
        tracker.update(f64::from(tick) * 0.1, &Pose::default(), &scan_of(discs), origin);
        tracker.entered().count()
    }

    /// A pillar that hides a person until it is gone.
    const PILLAR: (f64, f64, f64) = (0.0, -1.2, 0.2);
    const PERSON: (f64, f64, f64) = (0.0, -3.0, 0.2);

    #[test]
    fn person_out_of_hiding_has_entered_if_people_may_hide() {
        for hides_people in [true, false] {
            let mut tracker = Tracker { hides_people, ..Tracker::default() };
            for tick in 0..5 {
                assert_eq!(see(&mut tracker, tick, &[PILLAR, PERSON]), 0, "hidden");
            }
            assert_eq!(see(&mut tracker, 5, &[PERSON]), usize::from(hides_people));
        }
    }

    /// The velocity of a leg is not that of its person.
    #[test]
    fn moving_leg_does_not_explain_what_entered_and_a_moving_body_does() {
        for (radius, explained) in [(0.05, false), (0.2, true)] {
            let mut tracker = Tracker::default();
            let mut entered = 0;
            for tick in 0..25 {
                let y = 1.5 - 0.1 * f64::from(tick);
                entered = see(&mut tracker, tick, &[(2.5, y, radius)]);
            }
            assert_eq!(tracker.moving.len(), 1, "radius {radius}");
            assert_eq!(entered, usize::from(!explained), "radius {radius}");
        }
    }

    /// A leg walks behind a pillar and towards a wall, which begins at y = 0.
    #[test]
    fn hidden_leg_does_not_walk_into_a_wall() {
        let mut tracker = Tracker::default();
        let origin = |point: &Point| {
            let is_new = point.y > 0.0 && point.to_vector().norm() < HORIZON_M - 0.1;
            if is_new { ReturnOrigin::New } else { ReturnOrigin::Mapped }
        };
        let mut walked = 0;
        for tick in 0..30 {
            let leg = (5.0, 1.8 - 0.1 * f64::from(tick.min(17)), 0.05);
            let scan = scan_of(&[(2.5, 0.0, 0.2), leg]);
            tracker.update(f64::from(tick) * 0.1, &Pose::default(), &scan, origin);
            walked += tracker.moving.iter().filter(|disc| disc.vy < -0.5).count();
            assert!(tracker.moving.iter().all(|disc| disc.y > -0.1), "{:?}", tracker.moving);
        }
        assert!(walked > 3, "{walked}");
    }

    type Disc = (f64, f64, f64);

    /// One leg, two legs that the robot saw from the beginning, a whole body, and a pillar that is wider than a person.
    #[test]
    fn object_as_narrow_as_a_person_that_stands_alone_may_be_one() {
        const LEG: Disc = (2.5, 0.0, 0.05);
        let legs: &[Disc] = &[LEG, (2.5, 0.3, 0.05)];
        let at_wall: &[Disc] = &[LEG, (2.5, 0.4, 0.4), (2.5, -0.4, 0.4)];
        let objects: [(&[Disc], usize); 5] = [
            (&[LEG], 1),
            (legs, 2),
            (&[(2.5, 0.0, 0.29)], 1),
            (&[(2.5, 0.0, 0.4)], 0),
            (at_wall, 0),
        ];
        // In front of the robot, and behind it across the first beam of the turn.
        let sides =
            [1.0, -1.0].map(|side| objects.map(|(discs, expected)| (side, discs, expected)));
        for (side, discs, expected) in sides.concat() {
            let discs: Vec<Disc> = discs.iter().map(|&(x, y, r)| (side * x, y, r)).collect();
            let mut tracker = Tracker::default();
            for tick in 0..60 {
                see(&mut tracker, tick, &discs);
                let found: Vec<Point> = tracker.free_standing().collect();
                let expected = if tick == 0 { 0 } else { expected };
                assert_eq!(found.len(), expected, "{discs:?} at tick {tick}: {found:?}");
                let near = |one: &Point| (one - Point::new(side * 2.5, 0.0)).norm() < 0.35;
                assert!(found.iter().all(near), "{discs:?}: {found:?}");
            }
        }
    }

    #[test]
    fn moving_body_does_not_explain_a_person_away_from_it() {
        let mut tracker = Tracker { hides_people: true, ..Tracker::default() };
        let walker = |tick: u32| (2.5, 1.5 - 0.1 * f64::from(tick), 0.2);
        for tick in 0..30 {
            see(&mut tracker, tick, &[walker(tick), PILLAR, PERSON]);
        }
        assert_eq!(tracker.moving.len(), 1);
        assert_eq!(see(&mut tracker, 30, &[walker(30), PERSON]), 1);
    }
}
