//! Drives to a position and a yaw to the centimetre, on a base that does not execute small commands.
//!
//! The robot turns towards the position, drives straight to it, forwards or backwards, and turns to the yaw. Every command is
//! zero or above the least speed that moves the base. The robot begins to brake where braking ends at the goal. Short
//! motions of fixed length from standstill correct the rest: a base with latency cannot overshoot them.

use core::f64::consts::{FRAC_PI_2, TAU};

use super::super::condition_timer::ConditionTimer;
use super::super::{Goal, NavigatorSettings};
use super::rotate_in_place::{RATE_PER_RAD, rotation};
use crate::geometry::{Point, Pose, Twist, wrap_angle};
use crate::robot::Limits;

/// Time within which the tolerances grow by themselves, seconds: a robot must not chase a pose that it does not know so well.
const TOLERANCE_GROWTH_S: f64 = 10.0;
/// A robot that stands within this many times the tolerances, and within those of the goal, when parking begins may have parked
/// there before: it stays. If only its yaw differs, it turns first.
const STAYED_GROWTH: f64 = 4.0;
/// A moving robot brakes once it would stand within this share of the tolerances. The rest is for the noise of the pose.
const BRAKES_WITHIN: f64 = 0.5;
/// Speed for each metre left, 1/s. Slow enough for a base that answers within 0.2 s.
const SPEED_PER_M: f64 = 1.5;
/// The robot stops to aim where the goal lies this far off its nose or tail, radians, and drives on below the second angle.
pub(super) const AIM_FROM: f64 = 0.35;
const AIM_UNTIL: f64 = 0.05;
/// After the final turn the robot approaches the position again if it is this many times the tolerance away, at most this
/// often.
const OFF_AGAIN: f64 = 1.5;
const MAX_RETURNS: u32 = 3;
/// A correction from standstill lasts at most this many control periods at the least speed.
const MAX_PERIODS: f64 = 4.0;
/// A correction that moved the robot by less than this share of one period's motion raises the least speeds by the factor, up to
/// the limit. So does a robot that is steered and stands for this long, seconds.
const MOVED_SHARE: f64 = 0.25;
const UNMOVED_S: f64 = 1.0;
const RAISE: f64 = 1.5;
const MAX_RAISE: f64 = 4.0;

/// What the robot knows of its motion at a tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion<'a> {
    /// Time, seconds.
    pub time_s: f64,
    /// Pose when the command takes effect.
    pub pose: &'a Pose,
    /// Twist when the command takes effect.
    pub twist: &'a Twist,
    /// The twist that the base measured.
    pub measured: &'a Twist,
    /// The command of the last tick.
    pub sent: &'a Twist,
}

/// Parks at one goal.
#[derive(Clone, Debug)]
pub(super) struct Parking {
    since_s: Option<f64>,
    stood: ConditionTimer,
    unmoved: ConditionTimer,
    phase: Phase,
    is_aiming: bool,
    is_at_position: bool,
    returns: u32,
    /// Distance or angle of the present motion that is left until the robot brakes, metres or radians.
    left: f64,
    /// Whether the robot has stood without a command since parking began.
    has_stayed: bool,
    /// Factor of the least speeds: the base may need more than the settings say.
    raised: f64,
    precision: Precision,
    /// The sign of the shorter turn to the yaw, if the robot turns the other way round.
    turned_from: Option<f64>,
}

/// What parking must reach.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Precision {
    /// The tolerances of parking, which grow to those of the goal.
    Parking,
    /// The tolerances of the goal: people made the robot leave it, and may come again.
    Goal,
}

/// How the present motion ends.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    /// The pose decides at each tick.
    Steering,
    /// After a fixed time, seconds. It began at a pose.
    Correcting { command: Twist, until_s: f64, from: Pose },
    /// The robot brakes; the next motion starts from standstill. The last correction and its first pose are kept.
    Stopping(Option<(Twist, Pose)>),
}

impl Default for Parking {
    fn default() -> Self {
        Self {
            since_s: None,
            stood: ConditionTimer::default(),
            unmoved: ConditionTimer::default(),
            phase: Phase::Steering,
            is_aiming: false,
            is_at_position: false,
            returns: 0,
            left: 0.0,
            has_stayed: true,
            raised: 1.0,
            precision: Precision::Parking,
            turned_from: None,
        }
    }
}

/// What parking depends on, at a tick.
struct Context<'a> {
    motion: Motion<'a>,
    limits: &'a Limits,
    period_s: f64,
    least_speed: f64,
    least_rate: f64,
    is_at_rest: bool,
}

impl Parking {
    /// Parks as precisely as the settings want, or, `is_hurried`, within the goal's tolerances.
    pub fn new(is_hurried: bool) -> Self {
        let precision = if is_hurried { Precision::Goal } else { Precision::Parking };
        Self { precision, ..Self::default() }
    }

    /// Whether the goal's tolerances are enough.
    pub fn is_hurried(&self) -> bool {
        self.precision == Precision::Goal
    }

    /// Whether parking has begun.
    pub const fn has_begun(&self) -> bool {
        self.since_s.is_some()
    }

    /// Seconds since parking began; it begins with the first call.
    pub fn lasted_s(&mut self, now_s: f64) -> f64 {
        now_s - *self.since_s.get_or_insert(now_s)
    }

    /// Updates with the measured twist and returns whether the base has stood for long enough.
    pub fn stands(&mut self, motion: &Motion<'_>, settings: &NavigatorSettings) -> bool {
        let is_still = motion.measured.stands();
        // A timer that has just started has stood for no time.
        is_still & (self.stood.update(motion.time_s, is_still) >= settings.stopped_time_s)
    }

    /// The time after which a robot that keeps this command has moved as far as it is to move, with the way on which it brakes, seconds.
    pub fn ends_after_s(&self, command: &Twist, limits: &Limits) -> f64 {
        let (speed, deceleration) = if command.linear == 0.0 {
            (command.angular.abs(), -limits.decel_lim_theta)
        } else {
            (command.linear.abs(), -limits.decel_lim_x)
        };
        self.left.max(0.0) / speed + 0.5 * speed / deceleration
    }

    /// Whether the robot is at the position, and only the yaw is left.
    pub const fn is_at_position(&self) -> bool {
        self.is_at_position
    }

    /// Stays at the position where the robot is, which has no room to come nearer to that of the goal: only the yaw is left.
    pub fn keep_position(&mut self) {
        if !self.is_at_position {
            (self.is_at_position, self.returns) = (true, MAX_RETURNS);
            self.stop(None);
        }
    }

    /// Turns to the yaw of the goal the longer way round.
    pub fn turn_other_way(&mut self, goal: &Goal, pose: &Pose) {
        self.turned_from = goal.yaw.map(|yaw| wrap_angle(yaw - pose.yaw).signum());
    }

    /// The turn that is left to the yaw of the goal, radians, in the chosen direction.
    fn left_to_turn(&mut self, goal: &Goal, pose: &Pose) -> f64 {
        let error = goal.yaw.map_or(0.0, |yaw| wrap_angle(yaw - pose.yaw));
        // Halfway round, the same direction is the shorter one.
        self.turned_from = self.turned_from.filter(|sign| *sign == error.signum());
        error - self.turned_from.map_or(0.0, |sign| TAU * sign)
    }

    /// The velocity to drive towards, before the limits of acceleration; `None` for a robot that stands parked.
    pub fn next(
        &mut self,
        motion: Motion<'_>,
        goal: &Goal,
        (settings, limits, period_s): (&NavigatorSettings, &Limits, f64),
    ) -> Option<Twist> {
        let lasted_s = self.lasted_s(motion.time_s);
        let stands = self.stands(&motion, settings);
        let away_m = (goal.position - motion.pose.position()).norm();
        self.has_stayed &= motion.measured.stands() && *motion.sent == Twist::STOP;
        let growth =
            if self.has_stayed { STAYED_GROWTH } else { 1.0 + lasted_s / TOLERANCE_GROWTH_S };
        let stays_within_m =
            settings.xy_goal_tolerance.min(settings.xy_parking_tolerance * STAYED_GROWTH);
        if self.has_stayed && away_m <= stays_within_m {
            (self.phase, self.is_at_position) = (Phase::Stopping(None), true);
        }
        let is_unmoved = motion.measured.stands() && *motion.sent != Twist::STOP;
        let unmoved_s = self.unmoved.update(motion.time_s, is_unmoved);
        if self.phase == Phase::Steering && unmoved_s >= UNMOVED_S {
            self.raise();
        }
        if let Phase::Correcting { command, until_s, from } = self.phase {
            if motion.time_s < until_s {
                return Some(command);
            }
            let was_sent = *motion.sent != Twist::STOP;
            return Some(self.stop(was_sent.then_some((command, from))));
        }
        let is_at_rest = match self.phase {
            Phase::Stopping(_) if !stands => return Some(Twist::STOP),
            Phase::Stopping(correction) => {
                self.learn(correction, motion.pose, period_s);
                self.phase = Phase::Stopping(None);
                true
            }
            _ => false,
        };
        let context = Context {
            motion,
            limits,
            period_s,
            least_speed: self.raised * settings.min_approach_linear_velocity,
            least_rate: self.raised * settings.min_rotational_vel,
            is_at_rest,
        };
        let precision = self.precision;
        // A correction is not finer than the motion of one control period.
        let tolerance = |wanted: f64, least: f64, of_goal: f64| {
            let finest = wanted.max(0.5 * least * period_s);
            let coarsest = finest.max(of_goal);
            match precision {
                Precision::Parking => coarsest.min(finest * growth),
                Precision::Goal => coarsest,
            }
        };
        let (least_speed, least_rate) = (context.least_speed, context.least_rate);
        let tolerance_m =
            tolerance(settings.xy_parking_tolerance, least_speed, settings.xy_goal_tolerance);
        let ahead_m = braking(motion.twist.linear, limits.decel_lim_x);
        let ends_at = motion.pose.transform(&Point::new(ahead_m, 0.0));
        let ends_within = (goal.position - ends_at).norm() <= BRAKES_WITHIN * tolerance_m;
        if !is_at_rest && !self.is_at_position && ends_within {
            return Some(self.stop(None));
        }
        if is_at_rest {
            if !self.is_at_position {
                self.is_at_position = away_m <= tolerance_m;
            } else if away_m > OFF_AGAIN * tolerance_m && self.returns < MAX_RETURNS {
                self.is_at_position = false;
                self.returns += 1;
            }
        }
        if !self.is_at_position {
            return Some(self.approach(&context, goal));
        }
        let error = self.left_to_turn(goal, motion.pose);
        let tolerance_rad =
            tolerance(settings.yaw_parking_tolerance, least_rate, settings.yaw_goal_tolerance);
        let is_at_yaw = error.abs() <= tolerance_rad
            && !(self.has_stayed && error.abs() > settings.yaw_goal_tolerance);
        if is_at_rest && is_at_yaw {
            return None;
        }
        let left_rad = error - braking(motion.twist.angular, limits.decel_lim_theta);
        if !is_at_rest && left_rad.abs() <= BRAKES_WITHIN * tolerance_rad {
            return Some(self.stop(None));
        }
        Some(self.turn(&context, error))
    }

    /// Straight to the position, nose or tail first, whichever is nearer to it.
    fn approach(&mut self, context: &Context<'_>, goal: &Goal) -> Twist {
        let Context { motion, limits, .. } = *context;
        let to_goal = motion.pose.inverse_transform(&goal.position);
        let off_nose = libm::atan2(to_goal.y, to_goal.x);
        let reverses = off_nose.abs() > FRAC_PI_2 && limits.min_vel_x < 0.0;
        let sign = if reverses { -1.0 } else { 1.0 };
        let error = libm::atan2(sign * to_goal.y, sign * to_goal.x);
        let aim_from = if self.is_aiming { AIM_UNTIL } else { AIM_FROM };
        let is_moving = motion.twist.linear.abs() >= Twist::STANDING;
        // A moving robot with the goal to its side stops first: from there it need not turn far.
        let is_beside = error.abs() > FRAC_PI_2 || to_goal.to_vector().norm() < context.least_speed;
        if is_moving && is_beside && error.abs() > AIM_FROM {
            return self.stop(None);
        }
        self.is_aiming = error.abs() > aim_from;
        if self.is_aiming {
            return self.turn(context, error);
        }
        let fastest = if reverses { -limits.min_vel_x } else { limits.max_vel_x };
        let away_m = to_goal.to_vector().norm();
        let stops_in_time = (-limits.decel_lim_x * away_m).sqrt();
        let wanted = (SPEED_PER_M * away_m).min(stops_in_time).min(fastest);
        let left_m = sign * (to_goal.x - braking(motion.twist.linear, limits.decel_lim_x));
        let speed = self.speed(context, left_m, wanted, context.least_speed.min(fastest));
        let steers = self.phase == Phase::Steering;
        let command = Twist::new(sign * speed, if steers { RATE_PER_RAD * error } else { 0.0 });
        self.keep(context, command)
    }

    /// Turns in place by an angle.
    fn turn(&mut self, context: &Context<'_>, error: f64) -> Twist {
        let Context { motion, limits, .. } = *context;
        let wanted = rotation(error, limits).angular.abs();
        let braked = error - braking(motion.twist.angular, limits.decel_lim_theta);
        let left_rad = braked * error.signum();
        let least = context.least_rate.min(limits.max_vel_theta);
        let rate = self.speed(context, left_rad, wanted, least);
        self.keep(context, Twist::new(0.0, rate.copysign(error)))
    }

    /// The speed along an axis with this distance or angle left after braking; zero where braking must begin. Sets the phase.
    fn speed(&mut self, context: &Context<'_>, left: f64, wanted: f64, least: f64) -> f64 {
        self.left = left;
        let step = least * context.period_s;
        if context.is_at_rest && left <= MAX_PERIODS * step {
            let periods = (left / step).round().max(1.0);
            let until_s = context.motion.time_s + (periods - 0.5) * context.period_s;
            let from = *context.motion.pose;
            self.phase = Phase::Correcting { command: Twist::STOP, until_s, from };
            return (left / (periods * context.period_s)).max(least);
        }
        if left <= 0.5 * step {
            return self.stop(None).linear;
        }
        self.phase = Phase::Steering;
        wanted.max(least)
    }

    /// Keeps the command of a correction that begins.
    fn keep(&mut self, context: &Context<'_>, wanted: Twist) -> Twist {
        if let Phase::Correcting { command, .. } = &mut self.phase {
            debug_assert!(context.is_at_rest);
            *command = wanted;
        }
        wanted
    }

    /// Raises the least speeds after a correction that did not move the base.
    fn learn(&mut self, correction: Option<(Twist, Pose)>, pose: &Pose, period_s: f64) {
        let Some((command, from)) = correction else {
            return;
        };
        let moved_m = (pose.position() - from.position()).norm();
        let turned = wrap_angle(pose.yaw - from.yaw).abs();
        let has_moved = moved_m >= MOVED_SHARE * command.linear.abs() * period_s
            && turned >= MOVED_SHARE * command.angular.abs() * period_s;
        if !has_moved {
            self.raise();
        }
    }

    fn raise(&mut self) {
        self.raised = (self.raised * RAISE).min(MAX_RAISE);
        self.unmoved = ConditionTimer::default();
    }

    /// Begins to brake. The base may answer late: that it stood before does not count.
    fn stop(&mut self, correction: Option<(Twist, Pose)>) -> Twist {
        self.phase = Phase::Stopping(correction);
        self.stood = ConditionTimer::default();
        Twist::STOP
    }
}

/// The distance or angle that braking from a speed takes, in its direction. The deceleration is below zero.
fn braking(speed: f64, deceleration: f64) -> f64 {
    -speed * speed.abs() / (2.0 * deceleration)
}

#[cfg(test)]
mod tests;
