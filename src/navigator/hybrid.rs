//! The navigator: one decision for each observation.

use std::sync::Arc;

use super::kept_clear::KeptClear;
use super::local_map::LocalMap;
use super::recovery::{BACKING_WEIGHTS, Recovery};
use super::watch::ProgressWatch;
use super::{Fault, Goal, Journey, Mode, NavigatorSettings, Observation, Route, RoutePlanner};
use crate::geometry::{Point, Twist, bearing, wrap_angle};
use crate::global::Plan;
use crate::local::{ClearanceField, Counts, LocalPlanner, Situation};
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
    recovery: Recovery,
    next_replan_s: f64,
    fault: Option<Fault>,
}

/// A robot slower than this stands, m/s or rad/s.
const STANDING: f64 = 0.02;
/// A robot faster than this does not begin to turn in place, m/s.
const TURNS_BELOW: f64 = 0.2;
/// Near the goal the speed leaves this share of the braking distance unused.
const APPROACH: f64 = 0.6;
/// Beyond this distance from its path the robot plans anew, metres.
const OFF_PATH_M: f64 = 2.5;
/// Clearance that the local window shows beyond the ends of the longest trajectories, metres: a window's distance field
/// is made anew at each tick, and its cost grows with the square of the side.
const CLEARANCE_SEEN_M: f64 = 1.5;

impl Navigator {
    /// A navigator with a path from start to goal.
    ///
    /// # Errors
    /// When there is no path.
    pub fn new(
        known: ObstacleGrid,
        Journey { start, goal }: Journey,
        robot: RobotModel,
        planner: LocalPlanner,
        mut route_planner: RoutePlanner,
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
            recovery: Recovery::default(),
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

    /// Decides what to do now. After a goal is reached, or a mission given up, the answer is to stand. The command is
    /// within the robot's limits, and within what it reaches in one control period unless it is too fast already.
    pub fn step(&mut self, observation: &Observation) -> Decision {
        let mut decision = self.decide(observation);
        decision.command = self.robot.limits.nearest_allowed(&decision.command);
        decision
    }

    fn decide(&mut self, observation: &Observation) -> Decision {
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
        self.replan_if_needed(observation, off_path_m, stuck_s);
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
        if self.recovery.is_backing(observation.time_s) {
            return self.back_out(observation, &field, target);
        }
        let footprint = &self.robot.footprint;
        let kept = KeptClear::new(footprint, &self.settings, &field, observation);
        let error =
            wrap_angle(bearing(&observation.pose.position(), &target) - observation.pose.yaw);
        let turns_from = if self.mode == Mode::Turning {
            self.settings.turn_in_place_until
        } else {
            self.settings.turn_in_place_from
        };
        let faces_away = error.abs() > turns_from && kept.may_turn(&field, &observation.pose);
        // A moving robot first slows down: it may be avoiding something, or about to come round by itself.
        if faces_away && observation.twist.linear.abs() < TURNS_BELOW {
            self.mode = Mode::Turning;
            self.recovery.turned();
            return Ok(Decision {
                command: self.turn_by(observation, error),
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
            limits: self.driving_limits(observation, &kept, faces_away),
            footprint: &kept.footprint,
            weights: self.planner.settings().weights,
        };
        let (command, evaluation) = self.planner.choose(&situation).map_err(Fault::Choose)?;
        self.recovery
            .drove(observation, stuck_s, self.settings.patience_s);
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

    /// Moves slowly back to where it came from, even from within a margin.
    fn back_out(
        &mut self,
        observation: &Observation,
        field: &Arc<ClearanceField>,
        target: Point,
    ) -> Result<Decision, Fault> {
        let slow = self.settings.backing_speed;
        let limits = self.limits_between(-slow, slow / 2.0, observation);
        let footprint = &self.robot.footprint;
        let kept = KeptClear::to_get_away(footprint, &self.settings, field, observation);
        let situation = Situation {
            field,
            pose: observation.pose,
            twist: observation.twist,
            obstacles: &kept.moving,
            target,
            key_node: self.recovery.place_behind(observation),
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

    /// Limits for driving: forwards only, so that the robot can stop at the goal, and slowly within a margin or while
    /// it faces away from its way: else it would circle about its target.
    fn driving_limits(
        &self,
        observation: &Observation,
        kept: &KeptClear,
        faces_away: bool,
    ) -> Limits {
        let limits = &self.robot.limits;
        let to_goal_m = (observation.pose.position() - self.goal.position).norm();
        let stops_in_time = (-2.0 * APPROACH * limits.decel_lim_x * to_goal_m).sqrt();
        let mut fastest = stops_in_time.max(0.1);
        if kept.within_a_margin {
            fastest = fastest.min(self.settings.passing_speed);
        }
        if faces_away {
            fastest = fastest.min(TURNS_BELOW / 2.0);
        }
        self.limits_between(0.0, fastest, observation)
    }

    /// The robot's limits with forward speeds from `least` to `most`, and what braking needs to get there: so that
    /// every sample can be reached and is judged as it will be driven.
    fn limits_between(&self, least: f64, most: f64, observation: &Observation) -> Limits {
        let limits = self.robot.limits;
        let period_s = self.planner.settings().control_period_s;
        let in_reach = |speed: f64| {
            let wanted = Twist::new(speed, 0.0);
            limits
                .reachable(&observation.twist, &wanted, period_s)
                .linear
        };
        let within = |speed: f64| speed.clamp(limits.min_vel_x, limits.max_vel_x);
        Limits {
            min_vel_x: within(least.min(in_reach(least))),
            max_vel_x: within(most.max(in_reach(most))),
            ..limits
        }
    }

    /// Half the side of the local window: as far as a trajectory can reach, and some clearance beyond.
    fn window_half_m(&self) -> f64 {
        let settings = self.planner.settings();
        let limits = &self.robot.limits;
        let fastest = limits
            .max_vel_x
            .max(-limits.min_vel_x)
            .max(self.settings.backing_speed);
        fastest * settings.sim_time_s
            + settings.max_clearance_m.min(CLEARANCE_SEEN_M)
            + self.robot.footprint.circumscribed_radius_m()
    }

    /// Plans anew when the way ahead is blocked, the robot strayed, or it has stood for long behind something moving.
    ///
    /// A way round people may be as much longer as the robot could have driven while it waited for them: so waiting
    /// and the detour together never cost more than twice the better of the two.
    fn replan_if_needed(&mut self, observation: &Observation, off_path_m: f64, stuck_s: f64) {
        if observation.time_s < self.next_replan_s {
            return;
        }
        let radius_m = self.route_planner.least_radius_m();
        let ahead_m = self.settings.check_ahead_m;
        let blocked = self
            .map
            .marks()
            .any(|mark| self.route.is_near_ahead(&mark, radius_m, ahead_m));
        let strayed = off_path_m > OFF_PATH_M;
        let waited = self.mode == Mode::BackingUp;
        if !(blocked || strayed || waited) {
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
        let planned = self
            .route_planner
            .plan(&obstacles, start, self.goal.position, &mut || 0.0);
        let Ok(plan) = planned else { return };
        let longer_m = plan.smoothed.length_m() - self.route.left_m();
        let only_waited = !(blocked || strayed);
        if only_waited && longer_m > stuck_s * self.robot.limits.max_vel_x {
            return;
        }
        self.route = Route::new(&plan, self.settings.key_node_spacing_m);
        self.watch.rebase(self.route.left_m());
        self.plans.push(plan);
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
