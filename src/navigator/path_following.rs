//! Following the path.

use std::sync::Arc;

use super::inflated_bodies::InflatedBodies;
use super::navigator::{Decision, Navigator};
use super::parking::turn;
use super::predicted_state::PredictedState;
use super::{Fault, Mode};
use crate::geometry::{Point, Pose, Twist, bearing, wrap_angle};
use crate::local::{ClearanceField, DecisionInput};
use crate::robot::{Footprint, Limits};

/// A robot faster than this does not begin to turn in place, m/s.
const TURNS_BELOW: f64 = 0.2;
/// A robot slower than this creeps, m/s; it turns in place until its target lies within so much of its heading, radians.
const CREEPS: f64 = 0.05;
const CREEPING_TURNS_UNTIL: f64 = 0.05;
/// The straight way to a key node is looked over at points so far apart, metres.
const LOOKS_EVERY_M: f64 = 0.1;
/// Near the goal the speed leaves this share of the braking distance unused.
const APPROACH: f64 = 0.6;
/// Clearance that the local window shows beyond the ends of the longest trajectories, metres: a window's distance field
/// is made anew at each tick, and its cost grows with the square of the side.
const CLEARANCE_SEEN_M: f64 = 1.5;

impl Navigator {
    /// The local decision: turn in place, back out, or follow the path.
    pub(super) fn drive(
        &mut self,
        now: &PredictedState,
        field: &Arc<ClearanceField>,
        stuck_s: f64,
    ) -> Result<Decision, Fault> {
        let target = self.local_target(now, field);
        if self.recovery.is_backing(now.time_s) {
            if let Some(decision) = self.evade(now, field) {
                return Ok(decision);
            }
            return Ok(self.get_out(now, field, target));
        }
        let kept = InflatedBodies::new(&self.robot.footprint, &self.settings, field, now);
        let error = wrap_angle(bearing(&now.pose.position(), &target) - now.pose.yaw);
        let recovers = self.settings.features.recovery;
        let turns_from = if self.mode == Mode::Rotating {
            self.turns_until
        } else {
            self.settings.rotate_in_place_from
        };
        let turn_away = (recovers && error.abs() > turns_from)
            .then(|| self.clear_turn(now, &kept, field, error))
            .flatten();
        // A moving robot first slows down: it may be avoiding something, or about to come round by itself.
        if let Some(angle) = turn_away
            && now.twist.linear.abs() < TURNS_BELOW
        {
            if let Some(decision) = self.evade(now, field) {
                return Ok(decision);
            }
            if self.mode != Mode::Rotating {
                self.turns_until = self.settings.rotate_in_place_until;
            }
            return Ok(self.turn_in_place(now, angle, target));
        }
        let situation = DecisionInput {
            field,
            pose: now.pose,
            twist: now.twist,
            obstacles: &kept.moving,
            target,
            key_node: target,
            limits: self.driving_limits(now, &kept, turn_away.is_some()),
            footprint: &kept.footprint,
            weights: self.planner.settings().weights,
        };
        let (command, evaluation) = self.planner.decide(&situation).map_err(Fault::Choose)?;
        // Beside something it can only creep, unless it first turns to where there is a way on.
        let creeps = now.twist.linear.abs() < CREEPS
            && command.is_none_or(|command| command.linear.abs() < CREEPS);
        // Who evades goes on with it, until going on or standing is safe.
        let may_be_hit = creeps || command.is_none();
        if may_be_hit && let Some(decision) = self.evade(now, field) {
            return Ok(decision);
        }
        if recovers
            && creeps
            && error.abs() > CREEPING_TURNS_UNTIL
            && let Some(angle) = self.clear_turn(now, &kept, field, error)
        {
            self.turns_until = CREEPING_TURNS_UNTIL;
            return Ok(self.turn_in_place(now, angle, target));
        }
        if recovers {
            self.recovery
                .drove(now, stuck_s, self.settings.stuck_patience_s);
        }
        self.mode = if command.is_some() {
            Mode::Driving
        } else {
            Mode::Blocked
        };
        Ok(Decision {
            command: command.unwrap_or_else(|| self.brake(now)),
            mode: self.mode,
            local_target: target,
            counts: Some(evaluation.counts),
        })
    }

    fn turn_in_place(&mut self, now: &PredictedState, angle: f64, target: Point) -> Decision {
        self.mode = Mode::Rotating;
        self.recovery.turned();
        Decision {
            command: self.safe_towards(now, &turn(angle, &self.robot.limits)),
            mode: self.mode,
            local_target: target,
            counts: None,
        }
    }

    /// The farthest key node that the robot could drive straight to, so that it does not cut a corner that it must drive
    /// round.
    fn local_target(&self, now: &PredictedState, field: &ClearanceField) -> Point {
        let robot = now.pose.position();
        let in_sight = |node: &Point| self.is_straight_clear(&robot, node, field);
        let (nearest_m, farthest_m) = (self.settings.min_lookahead_m, self.settings.lookahead_m);
        self.route.key_node(nearest_m, farthest_m, in_sight)
    }

    /// Whether the robot, as wide as its largest disc, could drive straight from one point to another, as far as the window
    /// shows.
    pub(super) fn is_straight_clear(
        &self,
        from: &Point,
        to: &Point,
        field: &ClearanceField,
    ) -> bool {
        let Ok(body) = Footprint::round(self.robot.footprint.max_disc_radius_m()) else {
            return false;
        };
        let way = to - from;
        let steps = (way.norm() / LOOKS_EVERY_M).ceil();
        (1..=steps as u32).all(|step| {
            let point = from + way * (f64::from(step) / steps);
            let there = Pose::new(point.x, point.y, 0.0);
            let clearance_m = field.clearance_m(&body, &there);
            clearance_m.is_none_or(|clearance_m| clearance_m > 0.0)
        })
    }

    /// Limits for driving: forwards only, so that the robot can stop at the goal, and slowly within a margin or while
    /// it faces away from its way: else it would circle about its target.
    fn driving_limits(
        &self,
        now: &PredictedState,
        kept: &InflatedBodies,
        faces_away: bool,
    ) -> Limits {
        let limits = &self.robot.limits;
        let to_goal_m = (now.pose.position() - self.tour.goal().position).norm();
        let stops_in_time = (-2.0 * APPROACH * limits.decel_lim_x * to_goal_m).sqrt();
        let mut fastest = stops_in_time.max(0.1);
        if kept.within_a_margin {
            fastest = fastest.min(self.settings.passing_speed);
        }
        if let Some(caution) = self.caution(now) {
            fastest = caution.fastest(fastest);
        }
        if faces_away {
            fastest = fastest.min(TURNS_BELOW / 2.0);
        }
        self.limits_between(0.0, fastest, now)
    }

    /// The robot's limits with forward speeds from `least` to `most`, and what braking needs to get there: so that
    /// every sample can be reached and is judged as it will be driven.
    fn limits_between(&self, least: f64, most: f64, now: &PredictedState) -> Limits {
        let limits = self.robot.limits;
        let in_reach = |speed: f64| self.towards(now, &Twist::new(speed, 0.0)).linear;
        let within = |speed: f64| speed.clamp(limits.min_vel_x, limits.max_vel_x);
        Limits {
            min_vel_x: within(least.min(in_reach(least))),
            max_vel_x: within(most.max(in_reach(most))),
            ..limits
        }
    }

    /// Half the side of the local window: as far as a trajectory can reach, and some clearance beyond.
    pub(super) fn window_half_m(&self) -> f64 {
        let settings = self.planner.settings();
        let limits = &self.robot.limits;
        let fastest = limits
            .max_vel_x
            .max(-limits.min_vel_x)
            .max(self.settings.escape_speed);
        fastest * settings.sim_time_s
            + settings.max_clearance_m.min(CLEARANCE_SEEN_M)
            + self.robot.footprint.circumscribed_radius_m()
    }
}
