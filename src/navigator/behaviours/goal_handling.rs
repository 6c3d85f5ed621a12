//! Parks the robot at its goal: at the position to the centimetre, and at the yaw.
//!
//! The dynamic window evaluates where a trajectory ends after seconds; to stand at a station the distance itself counts. Near
//! its goal the robot turns towards it, drives straight to it, forwards or backwards, and turns to the goal's yaw. A tracked
//! base can do all three.

use core::f64::consts::FRAC_PI_2;

use super::super::state::State;
use super::super::{Decision, Fault, Goal, Mode, NavigatorSettings};
use super::rotate_in_place::{RATE_PER_RAD, rotation};
use super::{Behaviour, Override, Proposal};
use crate::geometry::{Pose, Twist, wrap_angle};
use crate::robot::Limits;

/// A robot that parks leaves its goal at this many times the goal's tolerance, and drives there again.
const LEAVES_GOAL: f64 = 2.0;
/// Time within which the parking tolerance grows by itself, seconds: a robot must not chase a pose that it does not know so
/// well.
const TOLERANCE_GROWTH_S: f64 = 10.0;
/// Speed for each metre left, 1/s. Slow enough for a base that answers within 0.2 s.
const SPEED_PER_M: f64 = 1.5;
/// The robot stops to aim where the goal lies this far off its nose or tail, radians, and drives on below the second angle.
const AIM_FROM: f64 = 0.35;
const AIM_UNTIL: f64 = 0.05;
/// A robot below this speed stands, m/s or rad/s.
const STANDING: f64 = 0.02;
/// After the final turn the robot approaches the position again if it is this many times the tolerance away, at most this
/// often.
const OFF_AGAIN: f64 = 1.5;
const MAX_RETURNS: u32 = 3;
/// Time and time step of the collision check, seconds: longer than the robot takes to stop.
const HORIZON_S: f64 = 1.0;
const STEP_S: f64 = 0.1;

/// Parks at the goal.
#[derive(Clone, Debug, Default)]
pub(super) struct GoalHandling {
    /// Begin of parking, seconds.
    since_s: Option<f64>,
    is_aiming: bool,
    is_at_position: bool,
    returns: u32,
}

impl Behaviour for GoalHandling {
    fn propose(&mut self, state: &State<'_>) -> Result<Option<Proposal>, Fault> {
        if !state.is_at_goal {
            return Ok(None);
        }
        let (now, goal, settings) = (state.now, state.goal, state.settings);
        let arrived = || Proposal::Decide(state.stand(Mode::Arrived), Override::Never);
        let lasted_s = self.lasted_s(now.time_s);
        if lasted_s > settings.parking_timeout_s {
            let off_m = (goal.position - now.pose.position()).norm();
            let off_rad = goal.yaw.map_or(0.0, |yaw| wrap_angle(yaw - now.pose.yaw));
            if off_m <= settings.xy_goal_tolerance && off_rad.abs() <= settings.yaw_goal_tolerance {
                return Ok(Some(arrived()));
            }
            if lasted_s > settings.parking_timeout_s + settings.movement_time_allowance {
                return Err(Fault::NoProgress {
                    stuck_s: lasted_s,
                    radius_m: settings.xy_parking_tolerance,
                    left_m: off_m,
                });
            }
        }
        let limits = &state.robot.limits;
        let next = self.next((&now.pose, &now.twist), goal, now.time_s, settings, limits);
        let Some(wanted) = next else {
            return Ok(Some(arrived()));
        };
        let command = state.safe_towards(&wanted);
        let standing = state.stand(Mode::Parking);
        let decision =
            if is_clear(&command, state) { Decision { command, ..standing } } else { standing };
        Ok(Some(Proposal::Decide(decision, Override::ByEvasion)))
    }
}

impl GoalHandling {
    /// Whether the robot is near enough to its goal to park, or parks and has not left it since.
    pub fn is_at_goal(&self, state: &State<'_>) -> bool {
        let (goal, pose) = (state.goal, &state.now.pose);
        let away_m = (pose.position() - goal.position).norm();
        let tolerance_m = state.settings.xy_goal_tolerance;
        let near_m = if self.since_s.is_some() { LEAVES_GOAL * tolerance_m } else { tolerance_m };
        away_m <= near_m
            || can_begin(pose, goal, state.settings) && state.is_straight_clear_to(&goal.position)
    }

    /// Seconds since parking began; it begins with the first call.
    fn lasted_s(&mut self, now_s: f64) -> f64 {
        now_s - *self.since_s.get_or_insert(now_s)
    }

    /// The velocity to drive towards, before the limits of acceleration; `None` for a robot that is parked.
    fn next(
        &mut self,
        (pose, twist): (&Pose, &Twist),
        goal: &Goal,
        now_s: f64,
        settings: &NavigatorSettings,
        limits: &Limits,
    ) -> Option<Twist> {
        let away_m = (goal.position - pose.position()).norm();
        let lasted_s = self.lasted_s(now_s);
        let tolerance_m = settings.xy_parking_tolerance * (1.0 + lasted_s / TOLERANCE_GROWTH_S);
        if self.is_at_position && away_m > OFF_AGAIN * tolerance_m && self.returns < MAX_RETURNS {
            self.is_at_position = false;
            self.returns += 1;
        }
        self.is_at_position |= away_m <= tolerance_m;
        if !self.is_at_position {
            return Some(self.approach(pose, goal, limits));
        }
        let error = goal.yaw.map_or(0.0, |yaw| wrap_angle(yaw - pose.yaw));
        if error.abs() > settings.yaw_parking_tolerance {
            return Some(rotation(error, limits));
        }
        let stands = twist.linear.abs() < STANDING && twist.angular.abs() < STANDING;
        (!stands).then_some(Twist::STOP)
    }

    /// Straight to the position, nose or tail first, whichever is nearer to it.
    fn approach(&mut self, pose: &Pose, goal: &Goal, limits: &Limits) -> Twist {
        let to_goal = pose.inverse_transform(&goal.position);
        let away_m = to_goal.to_vector().norm();
        let off_nose = libm::atan2(to_goal.y, to_goal.x);
        let reverses = off_nose.abs() > FRAC_PI_2 && limits.min_vel_x < 0.0;
        let error = if reverses { libm::atan2(-to_goal.y, -to_goal.x) } else { off_nose };
        let aim_from = if self.is_aiming { AIM_UNTIL } else { AIM_FROM };
        self.is_aiming = error.abs() > aim_from;
        if self.is_aiming {
            return rotation(error, limits);
        }
        let stops_in_time = (-limits.decel_lim_x * away_m).sqrt();
        let speed = (SPEED_PER_M * away_m).min(stops_in_time).min(limits.max_vel_x);
        let sign = if reverses { -1.0 } else { 1.0 };
        Twist::new(sign * speed, RATE_PER_RAD * error)
    }
}

/// Whether a goal lies near enough, and far enough ahead, to drive straight to it.
fn can_begin(pose: &Pose, goal: &Goal, settings: &NavigatorSettings) -> bool {
    let to_goal = pose.inverse_transform(&goal.position);
    let off_nose = libm::atan2(to_goal.y, to_goal.x);
    to_goal.to_vector().norm() <= settings.parking_distance_m && off_nose.abs() <= AIM_FROM
}

/// Whether a robot that keeps a velocity touches nothing within the horizon.
fn is_clear(command: &Twist, state: &State<'_>) -> bool {
    let steps = (HORIZON_S / STEP_S) as u32;
    *command == Twist::STOP
        || (1..=steps).all(|step| {
            let time_s = f64::from(step) * STEP_S;
            let there = state.now.pose.after(command, time_s);
            state.inflated.is_clear_at(state.field, &there, time_s)
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;

    /// Parks a base that follows commands within its limits, one tick late. Returns the last pose and the time, seconds.
    fn park(start: Pose, goal: Goal, limits: &Limits) -> (Pose, f64) {
        let settings = NavigatorSettings::default();
        let (mut pose, mut twist, mut parking) = (start, Twist::STOP, GoalHandling::default());
        let mut late = Twist::STOP;
        for tick in 0..600 {
            let time_s = f64::from(tick) * 0.1;
            let next = parking.next((&pose, &twist), &goal, time_s, &settings, limits);
            let Some(wanted) = next else {
                return (pose, time_s);
            };
            twist = limits.reachable(&twist, &late, 0.1);
            late = limits.clamp(&wanted);
            let heading = pose.yaw + twist.angular * 0.05;
            pose.x += twist.linear * 0.1 * libm::cos(heading);
            pose.y += twist.linear * 0.1 * libm::sin(heading);
            pose.yaw = wrap_angle(pose.yaw + twist.angular * 0.1);
        }
        panic!("not parked after 60 s: {pose:?}");
    }

    #[test]
    fn parking_reaches_position_and_yaw_from_all_directions() {
        let settings = NavigatorSettings::default();
        for (least, slowest_s) in [(-0.3, 15.0), (0.0, 25.0)] {
            let limits = Limits { min_vel_x: least, ..Limits::default() };
            for step in 0..48_u32 {
                let (around, yaw) = (f64::from(step) * 0.131, f64::from(step) * 0.77);
                let start = Pose::new(0.3 * libm::cos(around), 0.3 * libm::sin(around), yaw);
                let goal = Goal {
                    position: Point::new(0.0, 0.0),
                    yaw: (step % 3 > 0).then_some(wrap_angle(yaw + 2.0)),
                };
                let (end, took_s) = park(start, goal, &limits);
                let off_m = end.position().to_vector().norm();
                assert!(off_m <= OFF_AGAIN * settings.xy_parking_tolerance, "{step}: {off_m}");
                let off = goal.yaw.map_or(0.0, |yaw| wrap_angle(yaw - end.yaw));
                assert!(off.abs() <= settings.yaw_parking_tolerance, "{step}: {off}");
                assert!(took_s < slowest_s, "{step}: {took_s} s");
            }
        }
    }

    #[test]
    fn parking_reverses_to_a_goal_behind_if_the_base_can() {
        let goal = Goal { position: Point::new(-0.2, 0.0), yaw: None };
        for (least, backs) in [(-0.3, true), (0.0, false)] {
            let limits = Limits { min_vel_x: least, ..Limits::default() };
            let (end, _) = park(Pose::default(), goal, &limits);
            assert_eq!(end.yaw.abs() < 0.1, backs, "{end:?}");
        }
    }
}
