//! The navigator: one decision for each observation.

use std::collections::BTreeMap;

use super::behaviours::Behaviours;
use super::deadline::Deadline;
use super::inflated_bodies::InflatedBodies;
use super::observation::ObservationValidator;
use super::replanning::Replanner;
use super::route::ProgressChecker;
use super::state::{PredictedState, RobotModel, State};
use super::waypoints::WaypointQueue;
use super::{
    DeadlineStats, Decision, Fault, Goal, Mode, NavigatorSettings, Observation, ObservationFault,
    ObstacleModel, Route, RoutePlanner, Waypoints,
};
use crate::geometry::Twist;
use crate::global::Plan;
use crate::local::{LocalPlanner, LocalSettings};
use crate::map::ObstacleGrid;

/// Clearance that the local window shows beyond the ends of the longest trajectories, metres. The cost of a window's distance
/// field grows with the square of its side.
const WINDOW_CLEARANCE_M: f64 = 1.5;

/// Follows global paths to its goals among obstacles that are not in the map.
pub struct Navigator {
    settings: NavigatorSettings,
    robot: RobotModel,
    /// Control period, seconds.
    period_s: f64,
    /// Half the side of the local window, metres.
    window_half_m: f64,
    validator: ObservationValidator,
    obstacles: ObstacleModel,
    waypoints: WaypointQueue,
    route: Route,
    plans: Vec<Plan>,
    progress: ProgressChecker,
    replanner: Replanner,
    behaviours: Behaviours,
    mode: Mode,
    last_command: Twist,
    deadline: Option<Deadline>,
    fault: Option<Fault>,
}

impl Navigator {
    /// Plans a path to every goal. Times the planner's stages by `clock`, in seconds.
    ///
    /// # Errors
    /// When there is no path to a goal, or the planning thread does not start.
    pub fn new(
        known: ObstacleGrid,
        waypoints: &Waypoints,
        robot: RobotModel,
        planner: LocalPlanner,
        mut route_planner: RoutePlanner,
        settings: NavigatorSettings,
        clock: &mut dyn FnMut() -> f64,
    ) -> Result<Self, Fault> {
        let (waypoints, plan) = WaypointQueue::planned(waypoints, |from, to| {
            route_planner.plan(&known, from, to, clock)
        })?;
        let is_tracking = settings.features.tracking;
        let new_model =
            if is_tracking { ObstacleModel::new } else { ObstacleModel::without_tracking };
        let deadline = settings
            .deadline_s
            .map(|limit_s| Deadline::new(limit_s, planner.settings(), &robot.limits));
        Ok(Self {
            period_s: planner.settings().control_period_s,
            window_half_m: window_half_m(&settings, planner.settings(), &robot),
            validator: ObservationValidator::default(),
            obstacles: new_model(known.clone()),
            waypoints,
            route: Route::new(&plan, &settings),
            plans: vec![plan],
            progress: ProgressChecker::default(),
            replanner: Replanner::new(known, route_planner)?,
            behaviours: Behaviours::new(planner),
            mode: Mode::Driving,
            last_command: Twist::STOP,
            deadline,
            fault: None,
            settings,
            robot,
        })
    }

    /// Every global plan so far; the robot follows the last one.
    #[must_use]
    pub fn plans(&self) -> &[Plan] {
        &self.plans
    }

    /// Number of answers received from the planning thread so far, plans and failures.
    #[must_use]
    pub const fn plans_received(&self) -> u64 {
        self.replanner.received
    }

    /// Sets whether the next step receives the plan that is due, for the replay of a recorded run. Without `wait_for_plans`
    /// the arrival of a plan depends on the load of the machine.
    pub const fn replay_plan_arrival(&mut self, arrives: bool) {
        self.replanner.replayed_arrival = Some(arrives);
    }

    /// Why the mission failed, if it did.
    #[must_use]
    pub const fn fault(&self) -> Option<&Fault> {
        self.fault.as_ref()
    }

    /// The goal that the robot drives to or stands at.
    #[must_use]
    pub const fn goal(&self) -> &Goal {
        &self.waypoints.goal
    }

    /// Number of goals that the robot has left behind.
    #[must_use]
    pub const fn goals_passed(&self) -> usize {
        self.waypoints.passed
    }

    /// Obstacles that are not in the map.
    #[must_use]
    pub const fn obstacle_model(&self) -> &ObstacleModel {
        &self.obstacles
    }

    /// Number of faulty observations by kind.
    #[must_use]
    pub const fn observation_faults(&self) -> &BTreeMap<ObservationFault, u64> {
        &self.validator.counts
    }

    /// What is wrong with the last observation; `None` where it is valid.
    #[must_use]
    pub const fn observation_fault(&self) -> Option<ObservationFault> {
        self.validator.fault
    }

    /// The local planner.
    #[must_use]
    pub const fn planner(&self) -> &LocalPlanner {
        self.behaviours.planner()
    }

    /// How many decisions met the deadline; `None` without a deadline.
    #[must_use]
    pub fn deadline_stats(&self) -> Option<DeadlineStats> {
        self.deadline.as_ref().map(Deadline::stats)
    }

    /// Decides what to do now. The command is within the robot's limits, and the robot reaches it within one control period
    /// unless it is too fast already. After the last goal, or after a fault, the robot brakes and stands.
    pub fn step(&mut self, observation: &Observation) -> Decision {
        let mut decision = self.decide(observation);
        decision.command = self.robot.limits.clamp(&decision.command);
        self.last_command = decision.command;
        decision
    }

    /// Decides as [`Self::step`] does, and returns the decision with its duration by a clock, both in seconds. With a
    /// `deadline_s` in the settings, a late decision's command is replaced by a decayed earlier one, and the next ticks
    /// sample less densely.
    pub fn step_by(
        &mut self,
        observation: &Observation,
        clock: &mut dyn FnMut() -> f64,
    ) -> (Decision, f64) {
        let began_s = clock();
        let mut decision = self.step(observation);
        let took_s = clock() - began_s;
        if let Some(deadline) = &mut self.deadline {
            decision.command = deadline.settle(observation.time_s, took_s, decision.command);
            self.behaviours.planner_mut().set_sampling(deadline.stats().last);
            self.last_command = decision.command;
        }
        (decision, took_s)
    }

    fn decide(&mut self, observation: &Observation) -> Decision {
        let limits = &self.robot.limits;
        let validated =
            self.validator.validate(observation, &self.last_command, limits, &self.settings);
        let has_new_scan = match validated {
            Ok(has_new_scan) => has_new_scan,
            Err(fault) => return self.brake_without_observation(fault),
        };
        let Observation { time_s, pose, twist, scan, lost: _, scan_s: _ } = observation;
        if has_new_scan && !self.is_over() {
            self.obstacles.update(*time_s, pose, scan);
        }
        let now = PredictedState::new(
            (*time_s, pose, twist),
            self.obstacles.moving(),
            &self.last_command,
            &self.robot.limits,
            self.settings.actuation_delay_s,
        );
        if self.is_over() {
            return self.brake_from(&now.twist);
        }
        if self.mode == Mode::AtWaypoint {
            self.leave_waypoint(now.time_s);
            return self.brake_from(&now.twist);
        }
        match self.drive(&now) {
            Ok(decision) => {
                self.mode = decision.mode;
                decision
            }
            Err(fault) => {
                self.fail(fault);
                self.brake_from(&now.twist)
            }
        }
    }

    const fn is_over(&self) -> bool {
        matches!(self.mode, Mode::Arrived | Mode::Failed)
    }

    fn fail(&mut self, fault: Fault) {
        self.fault = Some(fault);
        self.mode = Mode::Failed;
    }

    /// Brakes from the last command, since pose and speed are unknown; fails when that lasts. Otherwise the present mode
    /// continues after the fault.
    fn brake_without_observation(&mut self, fault: ObservationFault) -> Decision {
        let count = self.validator.faults_in_a_row;
        let mut decision = self.brake_from(&self.last_command);
        if self.is_over() {
            return decision;
        }
        decision.mode = Mode::SensorFault;
        let patience_s = match fault {
            ObservationFault::Lost(_) => self.settings.localization_patience_s,
            _ => self.settings.sensor_fault_patience_s,
        };
        if f64::from(count) * self.period_s > patience_s {
            self.fail(Fault::FaultyObservation { fault, count });
            decision.mode = Mode::Failed;
        }
        decision
    }

    /// Brakes from a velocity, in the present mode.
    fn brake_from(&self, twist: &Twist) -> Decision {
        let command = self.robot.limits.brake(twist, self.period_s);
        Decision::new(command, self.mode, self.goal().position)
    }

    /// Starts the next leg when the pause is over.
    fn leave_waypoint(&mut self, now_s: f64) {
        if let Some(plan) = self.waypoints.next(now_s) {
            self.replanner.cancel();
            self.route = Route::new(&plan, &self.settings);
            self.plans.push(plan);
            self.progress = ProgressChecker::default();
            self.behaviours.start_leg();
            self.mode = Mode::Driving;
        }
    }

    /// Checks progress, replans, and lets the behaviours decide.
    fn drive(&mut self, now: &PredictedState) -> Result<Decision, Fault> {
        let robot = now.pose.position();
        let off_path_m = self.route.advance(&robot);
        let field = self
            .obstacles
            .window(&robot, self.window_half_m)
            .map_err(|error| Fault::Choose(error.into()))?;
        let mut new_route = None;
        let mut state = State {
            settings: &self.settings,
            robot: &self.robot,
            period_s: self.period_s,
            now,
            field: &field,
            inflated: InflatedBodies::new(&self.robot.footprint, &self.settings, &field, now),
            goal: &self.waypoints.goal,
            route: &self.route,
            off_path_m,
            local_target: robot,
            heading_error: 0.0,
            mode: self.mode,
            is_at_goal: false,
            stuck_s: 0.0,
            speed_limit: f64::INFINITY,
        };
        state.follow(&self.route);
        state.is_at_goal = self.behaviours.is_at_goal(&state);
        if !state.is_at_goal {
            let left_m = state.route.left_m();
            let radius_m = self.settings.required_movement_radius;
            let stuck_s = self.progress.stuck_s(now.time_s, left_m, radius_m);
            if stuck_s > self.settings.movement_time_allowance {
                return Err(self.why_stuck(stuck_s));
            }
            state.stuck_s = stuck_s;
            if self.settings.features.replanning {
                if let Some(plan) = self.replanner.receive(&state, &mut self.obstacles) {
                    let route = new_route.insert(Route::new(&plan, &self.settings));
                    self.plans.push(plan);
                    self.progress.rebase(route.left_m());
                    state.follow(route);
                }
                self.replanner.request(&state, &self.obstacles);
            }
        }
        let decided = self.behaviours.decide(state);
        if let Some(route) = new_route {
            self.route = route;
        }
        let mut decision = decided?;
        if decision.mode == Mode::Arrived && self.waypoints.has_next() {
            self.waypoints.pause_until_s = now.time_s + self.settings.waypoint_pause_s;
            decision.mode = Mode::AtWaypoint;
        }
        Ok(decision)
    }

    fn why_stuck(&self, stuck_s: f64) -> Fault {
        let left_m = self.route.left_m();
        if let Some(error) = &self.replanner.no_path {
            return Fault::Plan(error.clone());
        }
        if matches!(self.mode, Mode::Blocked | Mode::Escaping) {
            return Fault::NoControl { stuck_s, left_m };
        }
        Fault::NoProgress { stuck_s, radius_m: self.settings.required_movement_radius, left_m }
    }
}

/// Half the side of the local window, metres: the reach of the longest trajectory and some clearance beyond.
fn window_half_m(settings: &NavigatorSettings, local: &LocalSettings, robot: &RobotModel) -> f64 {
    let limits = &robot.limits;
    let fastest = limits.max_vel_x.max(-limits.min_vel_x).max(settings.escape_speed);
    fastest * local.sim_time_s
        + local.max_clearance_m.min(WINDOW_CLEARANCE_M)
        + robot.footprint.circumscribed_radius_m()
}
