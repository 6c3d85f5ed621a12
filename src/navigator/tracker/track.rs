//! A tracked object, and the evidence that it moves.

use std::collections::VecDeque;

use super::super::scan_visibility::{AGES_S, INTERVAL_S, KEPT};
use super::cluster::{RADII_M, Radius};
use super::filter::{Filter, Fit};
use crate::geometry::{Point, Vector};
use crate::map::MovingDisc;

/// Noise of acceleration, m^2/s^3, of steady motion, and of a turn or stop.
const STEADY_NOISE: f64 = 0.05;
const TURNING_NOISE: f64 = 2.0;
/// Noise of acceleration, m^2/s^3, that explains an unexpected measurement: a turn from one scan to the next.
const SUDDEN_NOISE: f64 = 4.0;
/// Squared deviations of a measurement that show a turn or stop, and the same smoothed over two scans; two are usual.
const SUDDEN: f64 = 14.0;
const SURPRISE: f64 = 6.0;
/// Radius of an object that is partly hidden, metres, and the variance of all radii.
const USUAL_RADIUS_M: f64 = 0.3;
const RADIUS_VARIANCE: f64 = 0.15 * 0.15;
/// Growth of the variance of a radius with each update: bodies are not round.
const RADIUS_NOISE: f64 = 0.002 * 0.002;

/// An object below the first speed stands, m/s; one above the second, and by this many deviations, may move.
const STANDING: f64 = 0.1;
const WALKING: f64 = 0.15;
const SURE_DEVIATIONS: f64 = 2.5;
/// A moving object has moved at least this far within the last two seconds, metres.
const MIN_MOTION_M: f64 = 0.12;
/// No tracked object is faster, m/s.
const FASTEST: f64 = 3.5;
/// Over this time, or two seconds, its motion agrees with its velocity except for this share of the distance.
const STRAIGHT_FOR_S: f64 = 0.65;
const MAX_DEVIATION: f64 = 0.5;
/// Least number of updates.
const MIN_UPDATES: u32 = 4;
/// Points that fell on free ground, or left it free: this many show motion; a scan adds at most the second number, and the sum
/// stays below the third.
const MIN_EVIDENCE: u32 = 5;
const MAX_EVIDENCE_OF_SCAN: u32 = 3;
const MAX_EVIDENCE: u32 = 8;
/// A moving object counts as moving without further evidence for this long, seconds.
const EVIDENCE_HOLDS_S: f64 = 1.5;
/// Every condition must hold for this long before an object counts as moving, seconds.
const SEEMS_FOR_S: f64 = 0.09;
/// A stopped object stays a disc for this long before it becomes marks, seconds, unless it moved for less than the second time:
/// that was an error.
const STANDS_FOR_S: f64 = 2.0;
/// An object with a smaller radius may be a leg, metres: it stays a disc as long as it is seen.
const LEG_RADIUS_M: f64 = 0.2;
const WALKED_FOR_S: f64 = 0.5;
/// A track ends after this long without an update, seconds: where a scan saw its place free, where it never moved, and where it
/// moved and is hidden.
const GONE_AFTER_S: f64 = 0.25;
const FORGOTTEN_AFTER_S: f64 = 0.35;
const HIDDEN_FOR_S: f64 = 1.0;

/// An earlier place of a track, with some of its points.
#[derive(Clone, Copy, Debug)]
struct Step {
    time_s: f64,
    center: Point,
    points: [Point; 3],
}

/// A tracked object.
#[derive(Clone, Debug)]
pub(super) struct Track {
    pub filter: Filter,
    pub radius: Radius,
    pub born_s: f64,
    seen_s: f64,
    /// Where it was seen last.
    pub seen_at: Point,
    updates: u32,
    surprise: f64,
    evidence: u32,
    /// Time of the last evidence, seconds.
    evidence_s: f64,
    /// Since when it meets every condition of motion.
    seems_since_s: Option<f64>,
    /// Since when it counts as moving.
    moves_since_s: f64,
    /// Since when it stands still.
    stands_since_s: Option<f64>,
    pub is_moving: bool,
    pub has_moved: bool,
    /// Earlier places, the oldest first.
    places: VecDeque<Step>,
}

impl Track {
    /// A track after its first cluster.
    pub fn new(time_s: f64, fit: &Fit, radius: Radius, points: [Point; 3]) -> Self {
        let mut track = Self {
            filter: Filter::new(fit),
            radius,
            born_s: time_s,
            seen_s: time_s,
            seen_at: fit.center,
            updates: 1,
            surprise: 0.0,
            evidence: 0,
            evidence_s: time_s,
            seems_since_s: None,
            moves_since_s: time_s,
            stands_since_s: None,
            is_moving: false,
            has_moved: false,
            places: VecDeque::with_capacity(KEPT),
        };
        track.remember(time_s, points);
        track
    }

    /// The first radius, from a measured one if both edges were visible.
    pub fn first_radius(seen: Option<Radius>) -> Radius {
        let usual = Radius { radius_m: USUAL_RADIUS_M, variance: RADIUS_VARIANCE };
        seen.map_or(usual, |seen| merged(usual, seen))
    }

    /// Predicts over a time, seconds.
    pub fn predict(&mut self, time_s: f64) {
        let noise = if self.surprise > SURPRISE { TURNING_NOISE } else { STEADY_NOISE };
        self.filter.predict(time_s, noise);
    }

    pub fn center(&self) -> Point {
        self.filter.center()
    }

    /// Updates with a fit from a lidar at a place, at a time and this long after the last scan, both in seconds.
    pub fn update(
        &mut self,
        (time_s, gap_s): (f64, f64),
        fit: &Fit,
        seen: Option<Radius>,
        lidar: &Point,
        points: [Point; 3],
    ) {
        let deviations = self.filter.squared_deviations(fit);
        self.surprise = self.surprise.midpoint(deviations);
        if self.has_moved && deviations > SUDDEN {
            self.filter.add_noise(gap_s, SUDDEN_NOISE);
        }
        self.filter.correct(fit);
        if let Some(seen) = seen {
            // The scan shows its near side. A larger radius moves its centre away, which is no motion.
            let before_m = self.radius.radius_m;
            self.radius.variance += RADIUS_NOISE;
            self.radius = merged(self.radius, seen);
            let away = self.center() - lidar;
            let distance = away.norm();
            if distance > 1e-6 {
                let shift = away / distance * (self.radius.radius_m - before_m);
                self.filter.shift(&shift);
                for step in &mut self.places {
                    step.center = step.center + shift;
                }
            }
        }
        (self.seen_s, self.seen_at) = (time_s, self.center());
        self.updates += 1;
        self.remember(time_s, points);
    }

    fn remember(&mut self, time_s: f64, points: [Point; 3]) {
        if self.places.back().is_some_and(|last| time_s - last.time_s < INTERVAL_S) {
            return;
        }
        if self.places.len() == KEPT {
            self.places.pop_front();
        }
        self.places.push_back(Step { time_s, center: self.center(), points });
    }

    /// Whether its velocity makes a search for evidence worthwhile.
    pub fn seems_moving(&self) -> bool {
        self.is_moving || self.filter.velocity().norm() > STANDING
    }

    /// Whether it moved, or there is some evidence that it does. Returns at its expected place then belong to it, so that two
    /// tracks that pass close to each other do not merge.
    pub fn claims_returns(&self) -> bool {
        self.has_moved
            || self.evidence > 0 && self.updates >= MIN_UPDATES && self.has_certain_velocity()
    }

    /// Whether its velocity is that of a moving object, and certain enough.
    fn has_certain_velocity(&self) -> bool {
        let speed = self.filter.velocity().norm();
        (WALKING..FASTEST).contains(&speed)
            && speed > SURE_DEVIATIONS * self.filter.speed_deviation()
    }

    /// Its points at the checked ages, with the times at which they were seen, seconds.
    pub fn earlier_points(&self, time_s: f64) -> impl Iterator<Item = (Point, f64)> + '_ {
        let mut last = None;
        AGES_S.into_iter().flat_map(move |age_s| {
            let place = self.places.iter().rposition(|step| time_s - step.time_s >= age_s);
            let fresh = place.filter(|_| place != last);
            last = place;
            fresh.into_iter().flat_map(move |place| {
                let step = &self.places[place];
                step.points.map(|point| (point, step.time_s))
            })
        })
    }

    /// Updates whether it moves, with the evidence of a scan: the number of its points on ground that was free, and of its
    /// earlier points on ground that is free now. Returns whether motion was just established.
    pub fn update_motion(&mut self, time_s: f64, evidence: u32) -> bool {
        let found = evidence.min(MAX_EVIDENCE_OF_SCAN);
        if found > 0 {
            self.evidence = (self.evidence + found).min(MAX_EVIDENCE);
            self.evidence_s = time_s;
        } else {
            self.evidence = self.evidence.saturating_sub(1);
        }
        let speed = self.filter.velocity().norm();
        if self.is_moving {
            self.update_standing(time_s, speed);
            return false;
        }
        let moves = self.evidence >= MIN_EVIDENCE
            && self.updates >= MIN_UPDATES
            && self.has_certain_velocity()
            && self.surprise < SURPRISE
            && self.has_gone_straight(time_s);
        if !moves {
            self.seems_since_s = None;
            return false;
        }
        let since_s = *self.seems_since_s.get_or_insert(time_s);
        self.is_moving = time_s - since_s > SEEMS_FOR_S;
        if self.is_moving {
            self.has_moved = true;
            self.moves_since_s = time_s;
        }
        self.is_moving
    }

    /// Whether it has moved some distance at its estimated velocity, without jumps.
    fn has_gone_straight(&self, time_s: f64) -> bool {
        let velocity = self.filter.velocity();
        let is_at_velocity = |step: &Step| {
            let moved = self.center() - step.center;
            let expected = velocity * (time_s - step.time_s);
            moved.norm() > MIN_MOTION_M
                && (moved - expected).norm() < MAX_DEVIATION * expected.norm().max(moved.norm())
        };
        let recent = |step: &&Step| time_s - step.time_s < STRAIGHT_FOR_S;
        let first = self.places.iter().find(recent);
        first.is_some_and(is_at_velocity) || self.places.front().is_some_and(is_at_velocity)
    }

    /// Whether it is as narrow as a leg.
    pub fn is_leg(&self) -> bool {
        self.radius.radius_m < LEG_RADIUS_M
    }

    fn update_standing(&mut self, time_s: f64, speed: f64) {
        if speed > STANDING {
            self.stands_since_s = None;
            if time_s - self.evidence_s > EVIDENCE_HOLDS_S {
                self.settle();
            }
            return;
        }
        let since_s = *self.stands_since_s.get_or_insert(time_s);
        let has_walked = since_s - self.moves_since_s > WALKED_FOR_S;
        // A person who stands is wider than the legs that a scan shows.
        if !has_walked || !self.is_leg() && time_s - since_s > STANDS_FOR_S {
            self.settle();
        }
    }

    /// Makes it stand; to move again it must move away from here.
    fn settle(&mut self) {
        self.is_moving = false;
        self.seems_since_s = None;
        self.stands_since_s = None;
        self.evidence = 0;
        self.places.drain(..self.places.len().saturating_sub(1));
    }

    /// Whether the track ends without an update at this time; `is_gone` where a scan saw its place free.
    pub fn is_over(&self, time_s: f64, is_gone: bool) -> bool {
        let limit_s = if is_gone {
            GONE_AFTER_S
        } else if self.has_moved {
            HIDDEN_FOR_S
        } else {
            FORGOTTEN_AFTER_S
        };
        time_s - self.seen_s > limit_s
    }

    /// The disc with its velocity; zero while it stands.
    pub fn disc(&self) -> MovingDisc {
        let velocity = self.filter.velocity();
        let velocity = if velocity.norm() > STANDING { velocity } else { Vector::ZERO };
        self.disc_at(&self.center(), &velocity)
    }

    /// The disc at its places of the last two seconds.
    pub fn earlier_discs(&self) -> impl Iterator<Item = MovingDisc> + '_ {
        self.places.iter().map(|step| self.disc_at(&step.center, &Vector::ZERO))
    }

    fn disc_at(&self, center: &Point, velocity: &Vector) -> MovingDisc {
        let radius = self.radius.radius_m;
        MovingDisc { x: center.x, y: center.y, radius, vx: velocity.x, vy: velocity.y }
    }
}

/// The estimate that combines two.
fn merged(one: Radius, other: Radius) -> Radius {
    let share = one.variance / (one.variance + other.variance);
    let radius_m = one.radius_m + share * (other.radius_m - one.radius_m);
    Radius {
        radius_m: radius_m.clamp(RADII_M.0, RADII_M.1),
        variance: (1.0 - share) * one.variance,
    }
}
