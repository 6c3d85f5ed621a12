//! One thing followed through the scans, and the proof that it moves.

use std::collections::VecDeque;

use super::disc_fit::{Fit, RADII_M, Radius};
use super::filter::Filter;
use super::history::{AGES_S, INTERVAL_S, KEPT};
use crate::geometry::{Point, Vector};
use crate::map::MovingDisc;

/// Noise of acceleration, m^2/s^3, of something that walks on, and of something that turns or stops.
const STEADY_NOISE: f64 = 0.05;
const TURNING_NOISE: f64 = 2.0;
/// Noise of acceleration, m^2/s^3, that explains a measurement out of the ordinary: a turn from one scan to the next.
const SUDDEN_NOISE: f64 = 4.0;
/// Squared deviations of a measurement from which something turned or stopped, and those smoothed over two scans; two
/// are usual.
const SUDDEN: f64 = 14.0;
const SURPRISE: f64 = 6.0;
/// A radius not yet seen whole, metres, and the variance of all radii.
const USUAL_RADIUS_M: f64 = 0.3;
const RADIUS_VARIANCE: f64 = 0.15 * 0.15;
/// Growth of the variance of a radius with each look: nobody is quite round.
const RADIUS_NOISE: f64 = 0.002 * 0.002;

/// Slower than this is standing, m/s; faster, and by so many deviations, may be moving.
const STANDING: f64 = 0.1;
const WALKING: f64 = 0.15;
const SURE_DEVIATIONS: f64 = 2.5;
/// Something moving has moved this far, metres, within the last two seconds.
const LEAST_WAY_M: f64 = 0.12;
/// Nobody walks faster, m/s.
const FASTEST: f64 = 3.5;
/// Over the last so many seconds, or two, it moved as its velocity says, but for this share of the way.
const STRAIGHT_FOR_S: f64 = 0.65;
const MOST_ASTRAY: f64 = 0.5;
/// It has been looked at so often.
const LEAST_LOOKS: u32 = 4;
/// Points of it that fell on free ground, or left it free: so many prove that it moves, at most so many in a scan.
const PROOF: u32 = 5;
const MOST_PROOF_OF_SCAN: u32 = 3;
const MOST_PROOF: u32 = 8;
/// What moved goes on as moving without a further proof for so long, seconds.
const PROOF_HOLDS_S: f64 = 1.5;
/// All that holds for so long, seconds, before it counts as moving.
const SEEMS_FOR_S: f64 = 0.09;
/// What stopped stays a disc for so long, seconds, before it becomes marks; unless it was taken to move for less than
/// the second number: that was a mistake.
const STANDS_FOR_S: f64 = 2.0;
const WALKED_FOR_S: f64 = 0.5;
/// A track ends after so long, seconds, without a look at it: where its place was seen free, where it never moved,
/// and where it moved and is hidden.
const GONE_AFTER_S: f64 = 0.25;
const FORGOTTEN_AFTER_S: f64 = 0.35;
const HIDDEN_FOR_S: f64 = 1.0;

/// Where a track was, and some points of it that were seen then.
#[derive(Clone, Copy, Debug)]
struct Step {
    time_s: f64,
    center: Point,
    points: [Point; 3],
}

/// What a scan says of a track's motion.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Proof {
    /// Points of it on ground that was seen free.
    pub entered: u32,
    /// Points where it was, on ground that is seen free.
    pub left: u32,
}

/// One thing that is followed.
#[derive(Clone, Debug)]
pub(super) struct Track {
    filter: Filter,
    radius: Radius,
    pub born_s: f64,
    seen_s: f64,
    looks: u32,
    surprise: f64,
    proof: u32,
    proved_s: f64,
    /// Since when it meets every condition, if it does.
    seems_since_s: Option<f64>,
    /// Since when it is taken to move.
    moves_since_s: f64,
    /// Since when it stands, if it does.
    stands_since_s: Option<f64>,
    pub is_moving: bool,
    pub has_moved: bool,
    /// The oldest first.
    trail: VecDeque<Step>,
}

impl Track {
    /// Something seen for the first time, with its radius if both its edges were seen.
    pub fn new(time_s: f64, fit: &Fit, radius: Radius, points: [Point; 3]) -> Self {
        let mut track = Self {
            filter: Filter::new(&fit.center, &fit.covariance),
            radius,
            born_s: time_s,
            seen_s: time_s,
            looks: 1,
            surprise: 0.0,
            proof: 0,
            proved_s: time_s,
            seems_since_s: None,
            moves_since_s: time_s,
            stands_since_s: None,
            is_moving: false,
            has_moved: false,
            trail: VecDeque::with_capacity(KEPT),
        };
        track.remember(time_s, points);
        track
    }

    /// The radius that a first look gives.
    pub fn first_radius(seen: Option<Radius>) -> Radius {
        let usual = Radius {
            radius_m: USUAL_RADIUS_M,
            variance: RADIUS_VARIANCE,
        };
        seen.map_or(usual, |seen| merged(usual, seen))
    }

    /// Moves on by a time, seconds.
    pub fn predict(&mut self, time_s: f64) {
        let noise = if self.surprise > SURPRISE {
            TURNING_NOISE
        } else {
            STEADY_NOISE
        };
        self.filter.predict(time_s, noise);
    }

    pub fn center(&self) -> Point {
        self.filter.center()
    }

    pub fn radius_m(&self) -> f64 {
        self.radius.radius_m
    }

    /// See [`Filter::squared_deviations`].
    pub fn squared_deviations(&self, fit: &Fit) -> f64 {
        self.filter.squared_deviations(&fit.center, &fit.covariance)
    }

    /// Takes in a look at it by a robot at a place, at a time and so long after the last scan, seconds.
    pub fn look(
        &mut self,
        (time_s, gap_s): (f64, f64),
        fit: &Fit,
        seen: Option<Radius>,
        robot: &Point,
        points: [Point; 3],
    ) {
        let deviations = self.squared_deviations(fit);
        self.surprise = self.surprise.midpoint(deviations);
        if self.has_moved && deviations > SUDDEN {
            self.filter.loosen(gap_s, SUDDEN_NOISE);
        }
        self.filter.measure(&fit.center, &fit.covariance);
        if let Some(seen) = seen {
            // Its near side is where it was seen; a greater radius puts its centre further off, which is no motion.
            let before_m = self.radius.radius_m;
            self.radius.variance += RADIUS_NOISE;
            self.radius = merged(self.radius, seen);
            let away = self.center() - robot;
            if let Some(direction) = away.try_normalize(1e-6) {
                let shift = direction * (self.radius.radius_m - before_m);
                self.filter.shift(&shift);
                for step in &mut self.trail {
                    step.center += shift;
                }
            }
        }
        self.seen_s = time_s;
        self.looks += 1;
        self.remember(time_s, points);
    }

    fn remember(&mut self, time_s: f64, points: [Point; 3]) {
        if self
            .trail
            .back()
            .is_some_and(|last| time_s - last.time_s < INTERVAL_S)
        {
            return;
        }
        if self.trail.len() == KEPT {
            self.trail.pop_front();
        }
        self.trail.push_back(Step {
            time_s,
            center: self.center(),
            points,
        });
    }

    /// Whether it goes as if it moved, and a proof is worth looking for.
    pub fn seems_moving(&self) -> bool {
        self.is_moving || self.filter.velocity().norm() > STANDING
    }

    /// Whether it moved, or there is some proof that it does: what is seen where it is expected is taken for its own, so that
    /// two that pass close by each other are not lost in one.
    pub fn stands_out(&self) -> bool {
        self.has_moved || self.proof > 0 && self.looks >= LEAST_LOOKS && self.is_sure_to_move()
    }

    /// Whether its velocity is that of something that moves, and known well enough.
    fn is_sure_to_move(&self) -> bool {
        let speed = self.filter.velocity().norm();
        (WALKING..FASTEST).contains(&speed)
            && speed > SURE_DEVIATIONS * self.filter.speed_deviation()
    }

    /// Points of it that were seen at the ages that are asked for, and their ages, seconds.
    pub fn earlier_points(&self, time_s: f64) -> impl Iterator<Item = (Point, f64)> + '_ {
        let mut last = None;
        AGES_S.into_iter().flat_map(move |age_s| {
            let place = self
                .trail
                .iter()
                .rposition(|step| time_s - step.time_s >= age_s);
            let fresh = place.filter(|_| place != last);
            last = place;
            fresh.into_iter().flat_map(move |place| {
                let step = &self.trail[place];
                step.points.map(|point| (point, time_s - step.time_s))
            })
        })
    }

    /// Decides anew whether it moves. Answers whether it just began to.
    pub fn judge(&mut self, time_s: f64, proof: Proof) -> bool {
        let found = (proof.entered + proof.left).min(MOST_PROOF_OF_SCAN);
        if found > 0 {
            self.proof = (self.proof + found).min(MOST_PROOF);
            self.proved_s = time_s;
        } else {
            self.proof = self.proof.saturating_sub(1);
        }
        let speed = self.filter.velocity().norm();
        if self.is_moving {
            self.judge_standing(time_s, speed);
            return false;
        }
        let moves = self.proof >= PROOF
            && self.looks >= LEAST_LOOKS
            && self.is_sure_to_move()
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

    /// Whether it has gone a way, and at the velocity that it is taken to have: what jumps about has not.
    fn has_gone_straight(&self, time_s: f64) -> bool {
        let velocity = self.filter.velocity();
        let is_at_velocity = |step: &Step| {
            let way = self.center() - step.center;
            let expected = velocity * (time_s - step.time_s);
            way.norm() > LEAST_WAY_M
                && (way - expected).norm() < MOST_ASTRAY * expected.norm().max(way.norm())
        };
        let recent = |step: &&Step| time_s - step.time_s < STRAIGHT_FOR_S;
        let first = self.trail.iter().find(recent);
        first.is_some_and(is_at_velocity) || self.trail.front().is_some_and(is_at_velocity)
    }

    fn judge_standing(&mut self, time_s: f64, speed: f64) {
        if speed > STANDING {
            self.stands_since_s = None;
            if time_s - self.proved_s > PROOF_HOLDS_S {
                self.settle();
            }
            return;
        }
        let since_s = *self.stands_since_s.get_or_insert(time_s);
        let has_walked = since_s - self.moves_since_s > WALKED_FOR_S;
        if !has_walked || time_s - since_s > STANDS_FOR_S {
            self.settle();
        }
    }

    /// From now on it stands; to move again it must go a way from here.
    fn settle(&mut self) {
        self.is_moving = false;
        self.seems_since_s = None;
        self.stands_since_s = None;
        self.proof = 0;
        while self.trail.len() > 1 {
            self.trail.pop_front();
        }
    }

    /// Whether it is given up, not having been seen at this time; `is_gone` where its place was seen free.
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

    /// The disc as it moves; one that stands has no velocity.
    pub fn disc(&self) -> MovingDisc {
        let velocity = self.filter.velocity();
        let velocity = if velocity.norm() > STANDING {
            velocity
        } else {
            Vector::zeros()
        };
        self.disc_at(&self.center(), &velocity)
    }

    /// The disc where it was in the last two seconds.
    pub fn earlier_discs(&self) -> impl Iterator<Item = MovingDisc> + '_ {
        self.trail
            .iter()
            .map(|step| self.disc_at(&step.center, &Vector::zeros()))
    }

    fn disc_at(&self, center: &Point, velocity: &Vector) -> MovingDisc {
        MovingDisc {
            x: center.x,
            y: center.y,
            radius: self.radius.radius_m,
            vx: velocity.x,
            vy: velocity.y,
        }
    }
}

/// The best guess of two.
fn merged(one: Radius, other: Radius) -> Radius {
    let share = one.variance / (one.variance + other.variance);
    let radius_m = one.radius_m + share * (other.radius_m - one.radius_m);
    Radius {
        radius_m: radius_m.clamp(RADII_M.0, RADII_M.1),
        variance: (1.0 - share) * one.variance,
    }
}
