//! The motion of the body from now to its standstill, and the returns that it would touch.

use super::body::{Body, Part};
use super::obstacle::{nearest_obstacle_return, obstacle_return};
use super::ramp::Ramp;
use super::raw_scan::RawPoint;
use crate::geometry::{Point, Pose, Twist, Vector, wrap_angle};

/// Most steps of a motion. A longer one is cut, and counts as touching.
const MAX_STEPS: usize = 1000;

/// Distance by which a return within the margin may seem to come nearer while the body slides past it, metres: the noise of
/// a range.
const SLIDE_M: f64 = 0.01;

/// Share of the margin that a body keeps while it slides.
const HARD_MARGIN_SHARE: f64 = 0.7;

/// Least share of a motion that brings the body nearer to a return where the body moves at it, and not past it.
const HEAD_ON_SHARE: f64 = 0.7;

/// Rounding of a distance, metres.
const ROUNDING_M: f64 = 1e-6;

/// How the base follows a command.
#[derive(Clone, Copy, Debug)]
pub(super) struct MotionModel {
    /// The ramp of the sender; the deceleration is at most the identified one.
    pub ramp: Ramp,
    /// Time from a command to its effect, seconds.
    pub delay_s: f64,
    /// Time for which a command is kept before the base brakes, seconds.
    pub hold_s: f64,
    /// Length of a step, seconds.
    pub step_s: f64,
}

/// A pose of the stopping motion.
#[derive(Clone, Copy, Debug)]
struct Step {
    position: Point,
    /// Sine and cosine of the turn back to the body's frame.
    turn_back: (f64, f64),
    end_s: f64,
    /// No point of the body moves farther than this since the start, metres.
    travel_m: f64,
    /// Distance from a step's arc to its chord, as a share of the chord's length.
    bulge_share: f64,
}

/// The stopping motion of the body, from now to its standstill, in its present frame.
#[derive(Clone, Debug)]
pub(super) struct StoppingMotion<'a> {
    body: &'a Body,
    /// The poses, with the present one first.
    steps: Vec<Step>,
    /// Radius around the origin that contains the whole motion, metres.
    reach_m: f64,
    /// Whether the motion ends at a standstill; it is cut otherwise.
    stands: bool,
}

/// Distances and counts of a check.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clearance {
    /// Distance that the body keeps, metres.
    pub margin_m: f64,
    /// Returns that count as an obstacle.
    pub min_points: usize,
    /// Assumed speed of moving returns, m/s.
    pub approach_speed_m_s: f64,
    /// Age of the returns, seconds.
    pub age_s: f64,
    /// Whether the body was too near to something a moment ago: it moves at nothing near then. The noise of the ranges would let it
    /// creep nearer otherwise.
    pub was_too_near: bool,
}

/// Why a motion is not permitted.
#[derive(Clone, Copy, Debug)]
pub(super) enum Obstruction {
    /// The motion touches enough returns; this one is the nearest.
    Return(RawPoint),
    /// The base does not stand within this time, seconds.
    NoStandstill(f64),
}

impl MotionModel {
    /// The motion of a body that moves with `start` and follows the commands that were sent already, each from its time of
    /// effect, seconds; then the command, then brakes.
    pub fn motion<'a>(
        &self,
        body: &'a Body,
        start: &Twist,
        sent: &[(f64, Twist)],
        command: &Twist,
    ) -> StoppingMotion<'a> {
        let mut motion = StoppingMotion::new(body);
        let (mut pose, mut twist, mut time_s) = (Pose::default(), *start, 0.0);
        let in_force = |time_s: f64| {
            let newest = sent.iter().rev().find(|(from_s, _)| *from_s <= time_s);
            newest.map_or(*start, |(_, twist)| *twist)
        };
        let command_s = self.delay_s + self.hold_s;
        while !motion.stands && motion.steps.len() < MAX_STEPS {
            let is_delay = time_s < self.delay_s;
            let is_hold = time_s < command_s;
            let phase_end_s = if is_delay { self.delay_s } else { command_s };
            let step_s = if is_hold { self.step_s.min(phase_end_s - time_s) } else { self.step_s };
            let then = if is_delay {
                self.ramp.towards(&twist, &in_force(time_s), step_s)
            } else if is_hold {
                self.ramp.towards(&twist, command, step_s)
            } else {
                self.ramp.brake(&twist, step_s)
            };
            let next = pose.after(&twist.mean(&then), step_s);
            // The end of a phase is exact: a rest of a step must not become a step of its own.
            time_s = if is_hold && step_s < self.step_s { phase_end_s } else { time_s + step_s };
            motion.push(&pose, &next, time_s);
            (pose, twist) = (next, then);
            motion.stands = !is_hold && twist == Twist::STOP;
        }
        motion
    }
}

impl Step {
    /// A place in the frame of the body at this step.
    fn local(&self, place: &Point) -> Point {
        let Vector { x, y } = (place - self.position).rotated(self.turn_back);
        Point::new(x, y)
    }
}

impl<'a> StoppingMotion<'a> {
    /// A motion that has not begun.
    fn new(body: &'a Body) -> Self {
        let present = Step {
            position: Point::default(),
            turn_back: (0.0, 1.0),
            end_s: 0.0,
            travel_m: 0.0,
            bulge_share: 0.0,
        };
        Self { body, steps: vec![present], reach_m: body.radius_m, stands: false }
    }

    /// Adds the step from the last pose to the next one.
    fn push(&mut self, last: &Pose, next: &Pose, end_s: f64) {
        let position = next.position();
        let turn = wrap_angle(next.yaw - last.yaw).abs();
        let travel_m = (position - last.position()).norm() + turn * self.body.radius_m;
        let (sin, cos) = libm::sincos(next.yaw);
        self.steps.push(Step {
            position,
            turn_back: (-sin, cos),
            end_s,
            travel_m: self.steps.last().map_or(0.0, |step| step.travel_m) + travel_m,
            bulge_share: turn / 8.0,
        });
        self.reach_m = self.reach_m.max(position.to_vector().norm() + self.body.radius_m);
    }

    /// The nearest of enough returns that the motion would bring within the margin of the body; none if there are too few and the
    /// motion ends at a standstill.
    ///
    /// A return within the margin counts only if the body comes nearer to it than it slides past; a return within the body
    /// counts unless the body moves away from it.
    pub fn obstruction(&self, points: &[RawPoint], clearance: &Clearance) -> Option<Obstruction> {
        let touched = self.touched(points, clearance);
        let nearest = nearest_obstacle_return(touched, clearance.min_points);
        nearest
            .map(|point| Obstruction::Return(*point))
            .or_else(|| (!self.stands).then_some(Obstruction::NoStandstill(self.end_s())))
    }

    /// Whether there is an [`Self::obstruction`], without the nearest return.
    pub fn is_obstructed(&self, points: &[RawPoint], clearance: &Clearance) -> bool {
        !self.stands
            || obstacle_return(self.touched(points, clearance), clearance.min_points).is_some()
    }

    /// Time until the motion ends, seconds.
    fn end_s(&self) -> f64 {
        self.steps.last().map_or(0.0, |step| step.end_s)
    }

    /// The returns that the motion would bring within the margin of the body.
    fn touched<'p>(
        &'p self,
        points: &'p [RawPoint],
        clearance: &'p Clearance,
    ) -> impl Iterator<Item = &'p RawPoint> {
        let grown_m = clearance.approach_speed_m_s * (self.end_s() + clearance.age_s);
        points.iter().filter(move |point| {
            let more_m = if point.moves { grown_m.max(SLIDE_M) } else { SLIDE_M };
            self.may_come_within(point, clearance.margin_m + more_m)
                && self.touches(point, clearance, grown_m)
        })
    }

    /// Whether the motion may bring the body within a distance of a return, by two bounds: its length, and its reach.
    fn may_come_within(&self, point: &RawPoint, distance_m: f64) -> bool {
        let travel_m = self.steps.last().map_or(0.0, |step| step.travel_m);
        let far_m = self.reach_m + distance_m;
        point.gap_m - distance_m <= travel_m
            && point.place.to_vector().norm_squared() <= far_m * far_m
    }

    /// The steps in which a part of the body comes within a distance of a place, and more: each step as its two poses, and the
    /// place in the frame of the body at both.
    fn near_steps(
        &self,
        part: &Part,
        place: &Point,
        distance_m: f64,
    ) -> impl Iterator<Item = ((&Step, &Step), (Point, Point))> {
        let mut index = 0;
        core::iter::from_fn(move || {
            loop {
                let (from, to) = (self.steps.get(index)?, self.steps.get(index + 1)?);
                let local = from.local(place);
                // A circle is a lower bound of the distance, and faster.
                let circle_m = local.to_vector().norm() - self.body.radius_m;
                let gap_m = if circle_m > distance_m { circle_m } else { part.distance_m(&local) };
                // No part comes near before it has moved by the rest of the gap.
                let until_m = from.travel_m + gap_m - distance_m;
                if to.travel_m >= until_m {
                    index += 1;
                    return Some(((from, to), (local, to.local(place))));
                }
                let later = self.steps.get(index + 1..)?;
                index += later.partition_point(|step| step.travel_m < until_m);
            }
        })
    }

    fn touches(&self, point: &RawPoint, clearance: &Clearance, grown_m: f64) -> bool {
        let margin_m = clearance.margin_m;
        self.body.parts.iter().any(|part| {
            let gap_m = part.distance_m(&point.place);
            let kept_m = kept_m(gap_m, margin_m);
            let is_held = clearance.was_too_near && gap_m <= margin_m + SLIDE_M;
            let near_m = match (point.moves, is_held) {
                (true, _) => margin_m + grown_m,
                (false, true) => margin_m + SLIDE_M,
                (false, false) => kept_m,
            };
            let mut steps = self.near_steps(part, &point.place, near_m);
            steps.any(|((_, step), (from, to))| {
                if is_held && part.closing_share(&from, &to) > HEAD_ON_SHARE {
                    return true;
                }
                let away_m = part.distance_to_segment_m(&from, &to);
                // The chord of a turn must not seem to come nearer to a return that the body slides past.
                let bulge_m =
                    if gap_m <= margin_m { (to - from).norm() * step.bulge_share } else { 0.0 };
                if away_m < kept_m - bulge_m {
                    return true;
                }
                // A moving return may reach the body at any motion of the robot. Only its motion against that of the body counts: the
                // robot itself closes that gap.
                let grown_m = clearance.approach_speed_m_s * (step.end_s + clearance.age_s);
                let share = if point.moves { part.closing_share(&from, &to) } else { 0.0 };
                share > 0.0 && away_m < margin_m + grown_m * share
            })
        })
    }

    /// A return that the motion passes at less than the distance from some part of the body; none if there are too few. Returns
    /// that fall behind at once do not count, nor do returns ahead, where the motion ends nearer to them.
    pub fn passed_return(
        &self,
        points: &[RawPoint],
        distance_m: f64,
        min_points: usize,
    ) -> Option<RawPoint> {
        let near = points.iter().filter(|point| {
            self.may_come_within(point, distance_m)
                && self.passes_within(point, distance_m)
                && !self.ends_nearer(point)
        });
        obstacle_return(near, min_points).copied()
    }

    fn passes_within(&self, point: &RawPoint, distance_m: f64) -> bool {
        self.body.parts.iter().any(|part| {
            self.near_steps(part, &point.place, distance_m).any(|(_, (from, to))| {
                part.closing_share(&from, &to) > 0.0
                    && part.distance_to_segment_m(&from, &to) < distance_m
            })
        })
    }

    /// Whether the motion ends nearer to a return than it begins: then the return lies ahead.
    fn ends_nearer(&self, point: &RawPoint) -> bool {
        self.steps.last().is_some_and(|step| {
            self.body.distance_m(&step.local(&point.place)) < point.gap_m - SLIDE_M
        })
    }

    /// The direction of some from the origin, in radians, into which the motion brings the body the fastest beyond its present
    /// outline, and the speed of that as a share of the speed of the body's fastest point.
    pub fn fastest_entry(&self, directions: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
        let entry = |direction: f64| {
            let (sin, cos) = libm::sincos(direction);
            let ray = Vector::new(cos, sin);
            let share = |step: &Step| {
                let from = step.local(&Point::default());
                let extent_m = self.body.extent_m(&from, &ray.rotated(step.turn_back));
                let depth_m = self.body.distance_m(&(Point::default() + ray * extent_m));
                if depth_m > SLIDE_M { depth_m / step.travel_m } else { 0.0 }
            };
            (direction, self.steps.iter().map(share).fold(0.0, f64::max))
        };
        let entries = directions.map(entry).filter(|(_, share)| *share > 0.0);
        entries.max_by(|one, other| one.1.total_cmp(&other.1))
    }
}

/// Gap up to which the body is too near to a return, metres.
pub(super) const fn too_near_m(margin_m: f64) -> f64 {
    margin_m * HARD_MARGIN_SHARE
}

/// Distance that the body keeps to a return which is now at a gap from it, metres: the margin, or hardly less than
/// the present gap where that is within the margin.
fn kept_m(gap_m: f64, margin_m: f64) -> f64 {
    let hard_m = too_near_m(margin_m);
    if gap_m <= hard_m {
        return gap_m - ROUNDING_M;
    }
    (gap_m - SLIDE_M).clamp(hard_m, margin_m)
}
