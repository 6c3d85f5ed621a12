//! The motion of the body from now to its standstill, and the returns that it would touch.

use super::raw_scan::RawPoint;
use crate::geometry::{Point, Pose, Twist, nearest_on_segment};
use crate::robot::{Footprint, Limits};

/// Most steps of a motion: a braking base stands long before.
const MAX_STEPS: usize = 1000;

/// Distance by which a return within the margin may seem to come nearer while the body slides past it, metres: the noise of
/// a range.
const SLIDE_M: f64 = 0.01;

/// Share of the margin that a body keeps while it slides.
const HARD_MARGIN_SHARE: f64 = 0.7;

/// Rounding of a distance, metres.
const ROUNDING_M: f64 = 1e-6;

/// How the base follows a command.
#[derive(Clone, Copy, Debug)]
pub(super) struct MotionModel {
    /// Accelerations; the deceleration is the identified one.
    pub limits: Limits,
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
    pose: Pose,
    end_s: f64,
}

/// The stopping motion of the body, from now to its standstill, in its present frame.
#[derive(Clone, Debug)]
pub(super) struct StoppingMotion<'a> {
    body: &'a Footprint,
    /// The end of each step, seconds, and the centres of the discs at its start and at its end.
    sweeps: Vec<(f64, Vec<(Point, Point)>)>,
    /// Radius around the origin that contains the whole motion, metres.
    reach_m: f64,
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
}

impl MotionModel {
    /// The motion of a body that moves with `start` and follows the commands that were sent already, each from its time of
    /// effect, seconds; then the command, then brakes.
    pub fn motion<'a>(
        &self,
        body: &'a Footprint,
        start: &Twist,
        sent: &[(f64, Twist)],
        command: &Twist,
    ) -> StoppingMotion<'a> {
        let mut steps = vec![Step { pose: Pose::default(), end_s: 0.0 }];
        let (mut pose, mut twist, mut time_s) = (Pose::default(), *start, 0.0);
        let in_force = |time_s: f64| {
            let newest = sent.iter().rev().find(|(from_s, _)| *from_s <= time_s);
            newest.map_or(*start, |(_, twist)| *twist)
        };
        let command_s = self.delay_s + self.hold_s;
        while steps.len() < MAX_STEPS {
            let is_delay = time_s < self.delay_s;
            let is_hold = time_s < command_s;
            let phase_end_s = if is_delay { self.delay_s } else { command_s };
            let step_s = if is_hold { self.step_s.min(phase_end_s - time_s) } else { self.step_s };
            (pose, twist) = if is_delay {
                self.limits.advance(&pose, &twist, &in_force(time_s), step_s)
            } else if is_hold {
                self.limits.advance(&pose, &twist, command, step_s)
            } else {
                self.limits.advance_braking(&pose, &twist, step_s)
            };
            // The end of a phase is exact: a rest of a step must not become a step of its own.
            time_s = if is_hold && step_s < self.step_s { phase_end_s } else { time_s + step_s };
            steps.push(Step { pose, end_s: time_s });
            if !is_hold && twist == Twist::STOP {
                break;
            }
        }
        StoppingMotion::new(body, &steps)
    }
}

impl<'a> StoppingMotion<'a> {
    fn new(body: &'a Footprint, steps: &[Step]) -> Self {
        let centers = |step: &Step| body.at(&step.pose).map(|(center, _)| center).collect();
        let mut from: Vec<Point> = steps.first().map(centers).unwrap_or_default();
        let mut sweeps = Vec::with_capacity(steps.len());
        for step in steps.iter().skip(1) {
            let to: Vec<Point> = centers(step);
            sweeps.push((step.end_s, from.iter().copied().zip(to.iter().copied()).collect()));
            from = to;
        }
        let farthest = |pose: &Pose| pose.position().to_vector().norm();
        let travel_m = steps.iter().map(|step| farthest(&step.pose)).fold(0.0, f64::max);
        Self { body, sweeps, reach_m: travel_m + body.circumscribed_radius_m() }
    }

    /// The nearest of enough returns that the motion would bring within the margin of the body; none if there are too few.
    ///
    /// A return within the margin counts only if the body comes nearer to it than it slides past; a return within the body
    /// counts unless the body moves away from it.
    pub fn first_touched(&self, points: &[RawPoint], clearance: &Clearance) -> Option<RawPoint> {
        let end_s = self.sweeps.last().map_or(0.0, |(end_s, _)| *end_s);
        let grown_m = clearance.approach_speed_m_s * (end_s + clearance.age_s);
        let touched = points.iter().filter(|point| {
            let far_m = self.reach_m + clearance.margin_m + if point.moves { grown_m } else { 0.0 };
            point.place.to_vector().norm_squared() <= far_m * far_m
                && self.touches(point, clearance)
        });
        let mut count = 0;
        let mut nearest: Option<RawPoint> = None;
        for point in touched {
            count += 1;
            if nearest.is_none_or(|before| point.gap_m < before.gap_m) {
                nearest = Some(*point);
            }
        }
        nearest.filter(|_| count >= clearance.min_points)
    }

    fn touches(&self, point: &RawPoint, clearance: &Clearance) -> bool {
        let margin_m = clearance.margin_m;
        self.body.discs().iter().enumerate().any(|(index, disc)| {
            let now = Point::new(disc.x, disc.y);
            let gap_m = (point.place - now).norm() - disc.radius;
            let radius_m = disc.radius + kept_m(gap_m, margin_m);
            self.sweeps.iter().any(|(end_s, discs)| {
                let Some((from, to)) = discs.get(index) else {
                    return false;
                };
                let nearest = nearest_on_segment(from, to, &point.place);
                let away_m = (point.place - nearest).norm();
                if away_m < radius_m {
                    return true;
                }
                // A moving return may reach the body at any motion of the robot. Only its motion against that of the body counts: the
                // robot itself closes that gap.
                let grown_m = clearance.approach_speed_m_s * (end_s + clearance.age_s);
                let share = closing_share(from, to, &point.place);
                point.moves && share > 0.0 && away_m < disc.radius + margin_m + grown_m * share
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
        let far_m = self.reach_m + distance_m;
        let near = points.iter().filter(|point| {
            point.place.to_vector().norm_squared() <= far_m * far_m
                && self.passes_within(point, distance_m)
                && !self.ends_nearer(point)
        });
        let near: Vec<&RawPoint> = near.take(min_points).collect();
        near.first().filter(|_| near.len() >= min_points).map(|point| **point)
    }

    fn passes_within(&self, point: &RawPoint, distance_m: f64) -> bool {
        self.sweeps.iter().any(|(_, discs)| {
            discs.iter().zip(self.body.discs()).any(|((from, to), disc)| {
                let comes_nearer = (to - from).dot(&(point.place - from)) > ROUNDING_M;
                let nearest = nearest_on_segment(from, to, &point.place);
                comes_nearer && (point.place - nearest).norm() < disc.radius + distance_m
            })
        })
    }

    /// Whether the motion ends nearer to a return than it begins: then the return lies ahead.
    fn ends_nearer(&self, point: &RawPoint) -> bool {
        let Some((_, discs)) = self.sweeps.last() else {
            return false;
        };
        let pairs = discs.iter().zip(self.body.discs());
        let end_m = pairs
            .map(|((_, to), disc)| (point.place - *to).norm() - disc.radius)
            .fold(f64::INFINITY, f64::min);
        end_m < point.gap_m - SLIDE_M
    }

    /// The first of some directions from the origin, in radians, into which the motion brings the body beyond its present
    /// outline.
    pub fn first_entered(&self, mut directions: impl Iterator<Item = f64>) -> Option<f64> {
        directions.find(|direction| {
            let (sin, cos) = libm::sincos(*direction);
            let extent = |center: &Point, radius: f64| {
                let across = center.y * cos - center.x * sin;
                let half = radius * radius - across * across;
                if half < 0.0 { 0.0 } else { center.x * cos + center.y * sin + libm::sqrt(half) }
            };
            let present = self.body.discs().iter();
            let present = present
                .map(|disc| extent(&Point::new(disc.x, disc.y), disc.radius))
                .fold(0.0, f64::max);
            self.sweeps.iter().any(|(_, discs)| {
                let mut swept = discs.iter().zip(self.body.discs());
                swept.any(|((_, to), disc)| extent(to, disc.radius) > present + SLIDE_M)
            })
        })
    }
}

/// Share of a motion that closes the gap to a place: the cosine of the angle between both; zero where the gap grows.
fn closing_share(from: &Point, to: &Point, place: &Point) -> f64 {
    let (step, towards) = (to - from, place - from);
    let closing = step.dot(&towards);
    if closing > ROUNDING_M { closing / (step.norm() * towards.norm()) } else { 0.0 }
}

/// Distance that the body keeps to a return which is now at a gap from it, metres: the margin, or hardly less than
/// the present gap where that is within the margin.
fn kept_m(gap_m: f64, margin_m: f64) -> f64 {
    let hard_m = margin_m * HARD_MARGIN_SHARE;
    if gap_m <= hard_m {
        return gap_m - ROUNDING_M;
    }
    (gap_m - SLIDE_M).clamp(hard_m, margin_m)
}
