//! What moves, from scans alone: discs with a velocity.
//!
//! Returns that no map explains are cut into runs of neighbours, each run is fitted by a disc, and discs are followed by
//! filters of constant velocity. That something moves must be proved by what no standing thing does, however the robot
//! moves and whatever it sees of it: its points fall on ground that an earlier scan saw through, or the present scan sees
//! through ground where its points were. Corners that come into view, walls behind a doorway and posts that merge into
//! one do neither.

mod cluster;
mod disc_fit;
mod filter;
mod history;
mod track;

use nalgebra::Matrix2;

use super::local_map::Known;
use super::scan_visibility::{proves_free, seen_to_m};
use crate::geometry::{Point, Pose, Vector, bearing};
use crate::map::{MovingDisc, Scan};
use cluster::{Cluster, LONGEST_M, Return};
use disc_fit::Fit;
use history::{History, free_margin_m};
use track::{Proof, Track};

/// Returns from beyond this distance, metres, are left alone: a person shows no three beams of 1 degree there.
pub(super) const FARTHEST_M: f64 = 12.0;
/// Returns that a new track needs, and that it goes on with.
const LEAST_RETURNS: usize = 3;
const LEAST_TO_GO_ON: usize = 2;
/// A sighting belongs to a track if it lies within so many squared deviations of where that is expected, and metres.
const GATE: f64 = 16.0;
const GATE_M: f64 = 0.6;
/// The same for what never moved, metres: 3 m/s for a tenth of a second.
const FIRST_GATE_M: f64 = 0.35;
/// Variance of that, square metres on each axis, besides the noise: who walks may turn and stop at once.
const SUDDEN_M2: f64 = 0.1 * 0.1;
/// Returns within this of the outline of an expected disc, metres, are taken for its own.
const OWN_M: f64 = 0.15;
/// Points of a sighting that are asked whether they were free.
const MOST_ASKED: usize = 24;
/// Scans further apart than this, seconds, tell nothing of motion.
const LONGEST_GAP_S: f64 = 1.0;

/// A sighting that may belong to a track.
#[derive(Clone, Copy, Debug)]
struct Pair {
    cost: f64,
    track: usize,
    sighting: usize,
    fit: Fit,
}

/// Follows everything that the map does not explain, and tells what of it moves.
///
/// It holds no clock and no chance: the same scans give the same discs.
#[derive(Debug, Default)]
pub struct Tracker {
    last_s: Option<f64>,
    tracks: Vec<Track>,
    history: History,
    moving: Vec<MovingDisc>,
    /// Ground that something moved over, and since when its track is followed.
    moved_over: Vec<(MovingDisc, f64)>,
    returns: Vec<Return>,
    runs: Vec<(usize, usize)>,
    sightings: Vec<Cluster>,
    pairs: Vec<Pair>,
    taken: Vec<Option<usize>>,
}

impl Tracker {
    /// Takes in a scan made at a time, seconds, from a pose in the map frame; `known` tells what is known of a point.
    pub(super) fn update(
        &mut self,
        time_s: f64,
        pose: &Pose,
        scan: &Scan,
        known: impl Fn(&Point) -> Known,
    ) {
        let gap_s = self.last_s.map_or(0.0, |last_s| time_s - last_s);
        if !(0.0..=LONGEST_GAP_S).contains(&gap_s) {
            self.tracks.clear();
            self.history.clear();
        } else if gap_s > 0.0 {
            for track in &mut self.tracks {
                track.predict(gap_s);
            }
        }
        self.last_s = Some(time_s);
        self.history.look_back_from(time_s);
        self.moved_over.clear();
        self.collect(pose, scan, known);
        cluster::sightings(
            pose,
            scan,
            &self.returns,
            &mut self.runs,
            &mut self.sightings,
        );
        self.pair(pose, scan);
        self.follow((time_s, gap_s), pose, scan);
        self.bury(time_s, pose, scan);
        self.begin(time_s, pose, scan);
        self.history.push(time_s, pose, scan);
        self.moving.clear();
        for track in self.tracks.iter().filter(|track| track.is_moving) {
            self.moving.push(track.disc());
            self.moved_over.push((track.disc(), track.born_s));
        }
    }

    /// What moves, or moved until a moment ago, in the map frame at the time of the last scan.
    #[must_use]
    pub fn moving(&self) -> &[MovingDisc] {
        &self.moving
    }

    /// The returns of the last scan, from not too far off, that the map does not explain.
    pub(super) fn points(&self) -> impl Iterator<Item = Point> + '_ {
        self.returns.iter().map(|seen| seen.point)
    }

    /// Discs that something covered while it moved, and since when it is followed, seconds.
    pub(super) fn places_moved_over(&self) -> impl Iterator<Item = (MovingDisc, f64)> + '_ {
        self.moved_over.iter().copied()
    }

    fn collect(&mut self, pose: &Pose, scan: &Scan, known: impl Fn(&Point) -> Known) {
        self.returns.clear();
        for (beam, &range_m) in scan.ranges.iter().enumerate() {
            if !(0.0..=scan.range_max.min(FARTHEST_M)).contains(&range_m) {
                continue;
            }
            let (sin, cos) = libm::sincos(pose.yaw + scan.angle(beam));
            let point = pose.position() + Vector::new(cos, sin) * range_m;
            let known = known(&point);
            if known == Known::Mapped {
                continue;
            }
            let owner = nearest(&self.tracks, &point);
            self.returns.push(Return {
                beam,
                range_m,
                point,
                is_candidate: known == Known::Unknown || owner.is_some(),
                owner,
            });
        }
    }

    /// Finds which sightings may belong to which tracks, and gives each to the nearest.
    fn pair(&mut self, pose: &Pose, scan: &Scan) {
        let robot = pose.position();
        self.pairs.clear();
        for (place, sighting) in self.sightings.iter().enumerate() {
            if sighting.count < LEAST_TO_GO_ON || sighting.length_m > LONGEST_M {
                continue;
            }
            for (number, track) in self.tracks.iter().enumerate() {
                let radius_m = track.radius_m();
                let gate_m = if track.has_moved {
                    GATE_M
                } else {
                    FIRST_GATE_M
                };
                let rough = sighting.rough_center(&robot, radius_m, scan.angle_increment);
                if (rough - track.center()).norm() > gate_m {
                    continue;
                }
                let fit = sighting.fit(
                    &points(&self.returns, sighting, 1),
                    &robot,
                    radius_m,
                    scan.angle_increment,
                );
                let sudden = if track.has_moved { SUDDEN_M2 } else { 0.0 };
                let cost = track.squared_deviations(&Fit {
                    covariance: fit.covariance + Matrix2::identity() * sudden,
                    ..fit
                });
                if cost < GATE && (fit.center - track.center()).norm() < gate_m {
                    self.pairs.push(Pair {
                        cost,
                        track: number,
                        sighting: place,
                        fit,
                    });
                }
            }
        }
        // Ties go to the older track and the earlier beam.
        self.pairs.sort_unstable_by(|one, other| {
            one.cost
                .total_cmp(&other.cost)
                .then(one.track.cmp(&other.track))
                .then(one.sighting.cmp(&other.sighting))
        });
        self.taken.clear();
        self.taken.resize(self.sightings.len(), None);
        let mut followed = vec![false; self.tracks.len()];
        let taken = &mut self.taken;
        self.pairs.retain(|pair| {
            let is_best = taken[pair.sighting].is_none() && !followed[pair.track];
            if is_best {
                taken[pair.sighting] = Some(pair.track);
                followed[pair.track] = true;
            }
            is_best
        });
    }

    /// Lets each track take in its sighting, and judges whether it moves.
    fn follow(&mut self, (time_s, gap_s): (f64, f64), pose: &Pose, scan: &Scan) {
        let robot = pose.position();
        for pair in &self.pairs {
            let sighting = &self.sightings[pair.sighting];
            let track = &mut self.tracks[pair.track];
            let distance_m = (pair.fit.center - robot).norm() - track.radius_m();
            let seen = sighting.radius(distance_m, scan.angle_increment);
            let sample = sample(&self.returns, sighting);
            track.look((time_s, gap_s), &pair.fit, seen, &robot, sample);
            // What hangs together with something settled is a part of it, however its ends seem to shift.
            let stands_alone = sighting.joins == [false, false];
            let proof = if stands_alone && track.seems_moving() {
                let stride = sighting.count.div_ceil(MOST_ASKED);
                let entered = points(&self.returns, sighting, stride)
                    .filter(|point| self.history.was_free(point))
                    .count();
                let left = track
                    .earlier_points(time_s)
                    .filter(|(point, age_s)| proves_free(pose, scan, point, free_margin_m(*age_s)))
                    .count();
                Proof {
                    entered: entered as u32,
                    left: left as u32,
                }
            } else {
                Proof::default()
            };
            if track.judge(time_s, proof) {
                let since_s = track.born_s;
                let discs = track.earlier_discs().map(|disc| (disc, since_s));
                self.moved_over.extend(discs);
            }
        }
    }

    /// Ends tracks that were not seen for too long.
    fn bury(&mut self, time_s: f64, pose: &Pose, scan: &Scan) {
        let robot = pose.position();
        let mut number = 0;
        let pairs = &self.pairs;
        self.tracks.retain(|track| {
            let is_followed = pairs.iter().any(|pair| pair.track == number);
            number += 1;
            if is_followed {
                return true;
            }
            let distance = (track.center() - robot).norm();
            let half_angle = libm::atan2(track.radius_m() / 2.0, distance);
            let seen = seen_to_m(pose, scan, bearing(&robot, &track.center()), half_angle);
            let is_gone = seen.is_some_and(|seen| seen > distance);
            !track.is_over(time_s, is_gone)
        });
    }

    /// Begins a track for each sighting that no track explains.
    fn begin(&mut self, time_s: f64, pose: &Pose, scan: &Scan) {
        let robot = pose.position();
        for (sighting, taken) in self.sightings.iter().zip(&self.taken) {
            let may_be_disc = sighting.joins != [true, true]
                && sighting.count >= LEAST_RETURNS
                && sighting.length_m <= LONGEST_M;
            if taken.is_some() || !may_be_disc {
                continue;
            }
            let increment = scan.angle_increment;
            let radius = Track::first_radius(sighting.radius(sighting.near_m, increment));
            let points = points(&self.returns, sighting, 1);
            let fit = sighting.fit(&points, &robot, radius.radius_m, increment);
            let sample = sample(&self.returns, sighting);
            self.tracks.push(Track::new(time_s, &fit, radius, sample));
        }
    }
}

/// The track that moves, as far as is known, and whose expected disc covers a point, the nearest if several do.
fn nearest(tracks: &[Track], point: &Point) -> Option<usize> {
    tracks
        .iter()
        .enumerate()
        .filter(|(_, track)| track.stands_out())
        .map(|(number, track)| {
            let beyond_m = (point - track.center()).norm() - track.radius_m();
            (number, beyond_m)
        })
        .filter(|&(_, beyond_m)| beyond_m < OWN_M)
        .min_by(|one, other| one.1.total_cmp(&other.1))
        .map(|(number, _)| number)
}

/// Every so-manieth point of a sighting.
fn points<'a>(
    returns: &'a [Return],
    sighting: &Cluster,
    stride: usize,
) -> impl Iterator<Item = &'a Point> + Clone {
    let first = sighting.first;
    (0..sighting.count)
        .step_by(stride)
        .map(move |step| &returns[(first + step) % returns.len()].point)
}

/// The first, middle and last point of a sighting.
fn sample(returns: &[Return], sighting: &Cluster) -> [Point; 3] {
    [0, sighting.count / 2, sighting.count - 1]
        .map(|step| returns[(sighting.first + step) % returns.len()].point)
}
