//! The navigator: one decision for each observation.

use std::sync::Arc;

use super::kept_clear::KeptClear;
use super::local_map::LocalMap;
use super::watch::{ProgressWatch, Since};
use super::{Fault, Goal, Mode, NavigatorSettings, Observation, Route, RoutePlanner};
use crate::geometry::{Point, Twist, bearing, wrap_angle};
use crate::global::Plan;
use crate::local::{ClearanceField, Counts, LocalPlanner, Situation, Weights};
use crate::map::ObstacleGrid;
use crate::robot::{Footprint, Limits};

/// What the navigator knows of the robot.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotModel {
    /// Its shape.
    pub footprint: Footprint,
    /// What its base can do.
    pub limits: Limits,
}

/// What to do at a tick.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// The velocity to send to the base.
    pub command: Twist,
    /// What the navigator is doing.
    pub mode: Mode,
    /// The key node it makes for.
    pub local_target: Point,
    /// Samples by outcome; none where the tick needed no sampling.
    pub counts: Option<Counts>,
}

/// Follows a global path to its goal among obstacles that the map does not show.
pub struct Navigator {
    settings: NavigatorSettings,
    robot: RobotModel,
    planner: LocalPlanner,
    route_planner: RoutePlanner,
    map: LocalMap,
    goal: Goal,
    route: Route,
    plans: Vec<Plan>,
    mode: Mode,
    watch: ProgressWatch,
    blocked: Since,
    backing_until_s: f64,
    next_recovery_s: f64,
    recoveries: u32,
    next_replan_s: f64,
    fault: Option<Fault>,
}

/// How long the first attempt to back out lasts, seconds; each further one twice as long, up to so many doublings.
const BACKING_S: f64 = 2.0;
const LONGEST_BACKING: u32 = 3;
/// Clearance counts most, then getting away backwards.
const BACKING_WEIGHTS: Weights = Weights {
    heading: 0.0,
    clearance: 0.6,
    velocity: 0.0,
    path: 0.4,
};
/// A robot slower than this stands, m/s or rad/s.
const STANDING: f64 = 0.02;
/// A robot faster than this does not begin to turn in place, m/s.
const TURNS_BELOW: f64 = 0.2;
/// Near the goal the speed leaves this share of the braking distance unused.
const APPROACH: f64 = 0.6;
/// Beyond this distance from its path the robot plans anew, metres.
const OFF_PATH_M: f64 = 2.5;

impl Navigator {
    /// A navigator with a path from start to goal.
    ///
    /// # Errors
    /// When there is no path.
    pub fn new(
        known: ObstacleGrid,
        start: Point,
        goal: Goal,
        robot: RobotModel,
        planner: LocalPlanner,
        route_planner: RoutePlanner,
        settings: NavigatorSettings,
        clock: &mut dyn FnMut() -> f64,
    ) -> Result<Self, Fault> {
        let plan = route_planner.plan(&known, start, goal.position, clock)?;
        Ok(Self {
            route: Route::new(&plan, settings.key_node_spacing_m),
            plans: vec![plan],
            map: LocalMap::new(known),
            settings,
            robot,
            planner,
            route_planner,
            goal,
            mode: Mode::Driving,
            watch: ProgressWatch::default(),
            blocked: Since::default(),
            backing_until_s: f64::NEG_INFINITY,
            next_recovery_s: f64::NEG_INFINITY,
            recoveries: 0,
            next_replan_s: f64::NEG_INFINITY,
            fault: None,
        })
    }

    /// Every global plan so far; the last is followed.
    #[must_use]
    pub fn plans(&self) -> &[Plan] {
        &self.plans
    }

    /// Why the mission was given up, if it was.
    #[must_use]
    pub const fn fault(&self) -> Option<&Fault> {
        self.fault.as_ref()
    }

    /// The local planner.
    #[must_use]
    pub const fn planner(&self) -> &LocalPlanner {
        &self.planner
    }

    /// Decides what to do now. After a goal is reached, or a mission given up, the answer is to stand.
    pub fn step(&mut self, observation: &Observation) -> Decision {
        if matches!(self.mode, Mode::Arrived | Mode::Failed) {
            return self.stand(observation, self.mode);
        }
        if !observation.is_sound() {
            return self.give_up(observation, Fault::BadObservation);
        }
        self.map.update(observation);
        let robot = observation.pose.position();
        let off_path_m = self.route.advance(&robot);
        if (robot - self.goal.position).norm() <= self.settings.xy_goal_tolerance {
            return self.park(observation);
        }
        self.replan_if_needed(observation, off_path_m);
        let stuck_s = self.watch.stuck_s(
            observation.time_s,
            self.route.left_m(),
            self.settings.required_movement_radius,
        );
        if stuck_s > self.settings.give_up_after_s {
            let fault = Fault::NoProgress {
                stuck_s,
                radius_m: self.settings.required_movement_radius,
                left_m: self.route.left_m(),
            };
            return self.give_up(observation, fault);
        }
        match self.drive(observation, stuck_s) {
            Ok(decision) => decision,
            Err(fault) => self.give_up(observation, fault),
        }
    }

    /// The local decision: turn in place, back out, or follow the path.
    fn drive(&mut self, observation: &Observation, stuck_s: f64) -> Result<Decision, Fault> {
        let half_m = self.window_half_m();
        let field = self
            .map
            .window(&observation.pose.position(), half_m)
            .map_err(|error| Fault::Choose(error.into()))?;
        let target = self.route.key_node(self.settings.lookahead_m);
        if observation.time_s < self.backing_until_s {
            return self.back_out(observation, &field, target);
        }
        let resolution_m = field.frame().resolution_m;
        let footprint = &self.robot.footprint;
        let kept = KeptClear::new(footprint, &self.settings, resolution_m, observation);
        if let Some(command) = self.turn_in_place(observation, &kept, &field, target) {
            self.mode = Mode::Turning;
            return Ok(Decision {
                command,
                mode: self.mode,
                local_target: target,
                counts: None,
            });
        }
        let situation = Situation {
            field: &field,
            pose: observation.pose,
            twist: observation.twist,
            obstacles: &kept.moving,
            target,
            key_node: target,
            limits: self.approach_limits(observation),
            footprint: &kept.footprint,
            weights: self.planner.settings().weights,
        };
        let (command, evaluation) = self.planner.choose(&situation).map_err(Fault::Choose)?;
        let blocked_s = self.blocked.update(observation.time_s, command.is_none());
        if stuck_s == 0.0 {
            self.recoveries = 0;
        }
        let wedged = blocked_s.max(stuck_s) > self.settings.patience_s
            && observation.twist.linear.abs() < STANDING;
        if wedged && observation.time_s >= self.next_recovery_s {
            // Each attempt in vain makes the next one longer, so that two that wait for one another part at last.
            let lasts_s = BACKING_S * f64::from(1_u32 << self.recoveries.min(LONGEST_BACKING));
            self.recoveries += 1;
            self.backing_until_s = observation.time_s + lasts_s;
            // The way found after backing out gets its chance before the next attempt.
            self.next_recovery_s = self.backing_until_s + 2.0 * self.settings.patience_s;
        }
        self.mode = if command.is_some() {
            Mode::Driving
        } else {
            Mode::Blocked
        };
        Ok(Decision {
            command: command.unwrap_or_else(|| self.brake(observation)),
            mode: self.mode,
            local_target: target,
            counts: Some(evaluation.counts),
        })
    }

    /// Moves away from whatever is nearest, slowly and backwards first of all, even from within a margin.
    fn back_out(
        &mut self,
        observation: &Observation,
        field: &Arc<ClearanceField>,
        target: Point,
    ) -> Result<Decision, Fault> {
        let limits = self.robot.limits;
        let slow = self.settings.backing_speed;
        let limits = Limits {
            min_vel_x: limits.min_vel_x.max(-slow),
            max_vel_x: limits.max_vel_x.min(slow / 2.0),
            ..limits
        };
        let footprint = &self.robot.footprint;
        let kept = KeptClear::what_is_left(footprint, &self.settings, field, observation);
        let behind = observation.pose.transform(&Point::new(-1.0, 0.0));
        let situation = Situation {
            field,
            pose: observation.pose,
            twist: observation.twist,
            obstacles: &kept.moving,
            target,
            key_node: behind,
            limits,
            footprint: &kept.footprint,
            weights: BACKING_WEIGHTS,
        };
        let (command, evaluation) = self.planner.choose(&situation).map_err(Fault::Choose)?;
        self.mode = Mode::BackingUp;
        Ok(Decision {
            command: command.unwrap_or_else(|| self.brake(observation)),
            mode: self.mode,
            local_target: target,
            counts: Some(evaluation.counts),
        })
    }

    /// A turn towards the target, when it lies far off the heading and the ground under the turning robot is clear.
    fn turn_in_place(
        &self,
        observation: &Observation,
        kept: &KeptClear,
        field: &ClearanceField,
        target: Point,
    ) -> Option<Twist> {
        let pose = &observation.pose;
        let error = wrap_angle(bearing(&pose.position(), &target) - pose.yaw);
        let turning = self.mode == Mode::Turning;
        let settings = &self.settings;
        let wanted = if turning {
            settings.turn_in_place_until
        } else {
            settings.turn_in_place_from
        };
        // A moving robot is avoiding something, or about to come round by itself.
        let may_begin = turning || observation.twist.linear.abs() < TURNS_BELOW;
        if !may_begin || error.abs() <= wanted || !kept.may_turn(field, &observation.pose) {
            return None;
        }
        Some(self.turn_by(observation, error))
    }

    /// At the goal: stop, turn to the yaw asked for, and be done when standing so.
    fn park(&mut self, observation: &Observation) -> Decision {
        let error = self
            .goal
            .yaw
            .map_or(0.0, |yaw| wrap_angle(yaw - observation.pose.yaw));
        let twist = &observation.twist;
        if error.abs() > self.settings.yaw_goal_tolerance {
            self.mode = Mode::Turning;
            let command = self.turn_by(observation, error);
            return Decision {
                command,
                ..self.stand(observation, self.mode)
            };
        }
        let standing = twist.linear.abs() < STANDING && twist.angular.abs() < STANDING;
        self.mode = if standing {
            Mode::Arrived
        } else {
            Mode::Driving
        };
        self.stand(observation, self.mode)
    }

    /// A turn on the spot by an angle, at the rate from which it can still stop in time, with some to spare.
    fn turn_by(&self, observation: &Observation, angle: f64) -> Twist {
        let limits = &self.robot.limits;
        let rate = (-limits.decel_lim_theta * angle.abs())
            .sqrt()
            .min(limits.max_vel_theta);
        let wanted = Twist::new(0.0, rate.copysign(angle));
        let period_s = self.planner.settings().control_period_s;
        limits.reachable(&observation.twist, &wanted, period_s)
    }

    /// Limits for driving: forwards only, and so that the robot can stop at the goal.
    fn approach_limits(&self, observation: &Observation) -> Limits {
        let limits = self.robot.limits;
        let to_goal_m = (observation.pose.position() - self.goal.position).norm();
        let stops_in_time = (-2.0 * APPROACH * limits.decel_lim_x * to_goal_m).sqrt();
        let min_vel_x = limits.min_vel_x.max(0.0).min(limits.max_vel_x);
        let max_vel_x = limits.max_vel_x.min(stops_in_time.max(0.1)).max(min_vel_x);
        Limits {
            min_vel_x,
            max_vel_x,
            ..limits
        }
    }

    /// Half the side of the local window: as far as a trajectory and the clearance along it can reach.
    fn window_half_m(&self) -> f64 {
        let settings = self.planner.settings();
        let limits = &self.robot.limits;
        let fastest = limits
            .max_vel_x
            .max(-limits.min_vel_x)
            .max(self.settings.backing_speed);
        fastest * settings.sim_time_s
            + settings.max_clearance_m.min(1.5)
            + self.robot.footprint.circumscribed_radius_m()
    }

    /// Plans anew when the way ahead is blocked, the robot strayed, or it has stood for long behind something moving.
    fn replan_if_needed(&mut self, observation: &Observation, off_path_m: f64) {
        let radius_m = self.route_planner.least_radius_m();
        let ahead_m = self.settings.check_ahead_m;
        let blocked = self.map.has_marks()
            && self
                .map
                .marks()
                .any(|mark| self.route.is_near_ahead(&mark, radius_m, ahead_m));
        let waited = self.mode == Mode::BackingUp;
        let wanted = blocked || off_path_m > OFF_PATH_M || waited;
        if !wanted || observation.time_s < self.next_replan_s {
            return;
        }
        self.next_replan_s = observation.time_s + self.settings.replan_period_s;
        // Moving things count as obstacles only for a robot that waited for them in vain.
        let discs: Vec<(Point, f64)> = if waited {
            observation
                .moving
                .iter()
                .map(|disc| (disc.center(), disc.radius))
                .collect()
        } else {
            Vec::new()
        };
        let obstacles = self.map.obstacles_with(&discs);
        let start = observation.pose.position();
        if let Ok(plan) =
            self.route_planner
                .plan(&obstacles, start, self.goal.position, &mut || 0.0)
        {
            self.route = Route::new(&plan, self.settings.key_node_spacing_m);
            self.watch.rebase(self.route.left_m());
            self.plans.push(plan);
        }
    }

    fn brake(&self, observation: &Observation) -> Twist {
        let period_s = self.planner.settings().control_period_s;
        self.robot
            .limits
            .reachable(&observation.twist, &Twist::STOP, period_s)
    }

    fn stand(&self, observation: &Observation, mode: Mode) -> Decision {
        let command = if observation.is_sound() {
            self.brake(observation)
        } else {
            Twist::STOP
        };
        Decision {
            command,
            mode,
            local_target: self.goal.position,
            counts: None,
        }
    }

    fn give_up(&mut self, observation: &Observation, fault: Fault) -> Decision {
        self.fault = Some(fault);
        self.mode = Mode::Failed;
        self.stand(observation, Mode::Failed)
    }
}
