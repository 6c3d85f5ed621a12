//! The navigator: one decision for each observation.

mod braking;
mod failure;
mod goal_update;
mod reading;

use std::mem::take;
use std::sync::Arc;

use super::base_response::BaseResponse;
use super::behaviours::Behaviours;
use super::controller_host::ControllerHost;
use super::deadline::Deadline;
use super::dust::DustFilter;
use super::first_problem::check_first_problem;
use super::inflated_bodies::InflatedBodies;
use super::mode_ticks::ModeTicks;
use super::narrow_passages::OVERLOOKED_M;
use super::observation::ObservationValidator;
use super::occlusion::standing_room;
use super::predicted_state::{Measured, PredictedState};
use super::progress::Progress;
use super::recent_people::{RecentPeople, may_be_there};
use super::replanning::Replanner;
use super::state::{RobotModel, State};
use super::visible_space::VisibleSpace;
use super::waypoints::WaypointQueue;
use super::{
    Controller, Decision, Fault, GlobalPlanner, Mode, NavigationMap, NavigatorSettings,
    Observation, ObstacleModel, Route, Waypoints,
};
use crate::geometry::Point;
use crate::global::Plan;
use crate::local::{LocalPlanner, LocalSettings, step_that_overlooks};
use crate::map::{FreeSpace, MovingDisc, ObstacleGrid, Zones};
use crate::robot::{Footprint, TickClock, TickTime};
use braking::FaultyTime;
pub use goal_update::PlannedGoals;
use goal_update::planned_goals;

/// Distance of the robot's circle from the space that a blind sector hides, metres: room to drive along it.
const UNSEEN_GAP_M: f64 = 0.4;

/// Clearance that the local window shows beyond the ends of the longest trajectories, metres. The cost of a window's distance
/// field grows with the square of its side.
const WINDOW_CLEARANCE_M: f64 = 1.5;

/// Follows global paths to its goals among obstacles that are not in the map.
pub struct Navigator {
    settings: NavigatorSettings,
    /// The robot with the identified acceleration and braking.
    pub(super) robot: RobotModel,
    /// The robot with the discs of narrow passages.
    slim: Footprint,
    /// Whether the robot was in a narrow passage, or near one, at the last tick.
    is_narrow: bool,
    /// Distance along the path to that passage, metres; `None` if the path has none here.
    to_narrow_m: Option<f64>,
    /// The key node to which the robot turned in place at the last tick.
    turning_to: Option<Point>,
    base: BaseResponse,
    tick_clock: TickClock,
    /// Time since the last tick, one period at least.
    pub(super) tick: TickTime,
    faulty: FaultyTime,
    /// Time between two checked poses of the local planner, seconds.
    step_s: f64,
    /// Half the side of the local window, metres.
    window_half_m: f64,
    validator: ObservationValidator,
    dust: DustFilter,
    pub(super) obstacles: ObstacleModel,
    people: RecentPeople,
    /// Where the map has room for a person; `None` if hidden people are not considered.
    pub(super) standing_room: Option<FreeSpace>,
    pub(super) zones: Option<Arc<Zones>>,
    /// Speed limit at every place, m/s.
    pub(super) speed_limit: Option<f64>,
    waypoints: WaypointQueue,
    route: Route,
    plans: Vec<Plan>,
    progress: Progress,
    stuck_ticks: ModeTicks,
    pub(super) replanner: Replanner,
    behaviours: Behaviours,
    /// Decides in place of the behaviours, if there is one.
    controller: Option<ControllerHost>,
    mode: Mode,
    deadline: Option<Deadline>,
    fault: Option<Fault>,
}

crate::settings::opaque_debug!(Navigator);

impl Navigator {
    /// Plans a path to every goal. Times the planner's stages by `clock`, in seconds.
    ///
    /// # Errors
    /// When a setting, a limit or a goal is out of range, there is no path to a goal, or the planning thread does not start.
    pub fn new(
        map: impl Into<NavigationMap>,
        waypoints: &Waypoints,
        robot: RobotModel,
        mut planner: LocalPlanner,
        mut global_planner: Box<dyn GlobalPlanner>,
        settings: NavigatorSettings,
        clock: &mut dyn FnMut() -> f64,
    ) -> Result<Self, Fault> {
        robot.limits.validate().map_err(|error| error.in_table("limits").in_table("robot"))?;
        planner.settings().validate().map_err(|error| error.in_table("local"))?;
        planner.permit_speeds_of(&robot.limits);
        settings.validate().map_err(|error| error.in_table("navigator"))?;
        let map = map.into();
        let period_s = planner.settings().control_period_s;
        let is_tracking = settings.features.tracking;
        let new_model =
            if is_tracking { ObstacleModel::new } else { ObstacleModel::without_tracking };
        let deadline = settings
            .deadline_s
            .map(|limit_s| Deadline::new(limit_s, planner.settings(), &robot.limits));
        let standing_room = standing_room(&map.obstacles, &settings);
        let zones = map.zones.clone();
        let mut obstacles = new_model(map);
        let (queue, plan) =
            planned_goals(waypoints, &obstacles, (&robot, &settings), &mut *global_planner, clock)?;
        let window_half_m = window_half_m(&settings, planner.settings(), &robot);
        let ground = (&obstacles, window_half_m);
        check_first_problem(waypoints.start, ground, &robot, (&settings, planner.settings()))?;
        let replanner = Replanner::new(obstacles.closed().clone(), global_planner)?;
        obstacles.set_hides_people(settings.features.occlusion_speed);
        Ok(Self {
            tick_clock: TickClock::new(period_s),
            tick: period_s.into(),
            faulty: FaultyTime::default(),
            step_s: planner.settings().sim_step_s,
            window_half_m,
            validator: ObservationValidator::default(),
            dust: DustFilter::default(),
            obstacles,
            people: RecentPeople::default(),
            standing_room,
            zones,
            speed_limit: None,
            waypoints: queue,
            route: Route::new(&plan, &settings),
            plans: vec![plan],
            progress: Progress::default(),
            stuck_ticks: ModeTicks::default(),
            replanner,
            behaviours: Behaviours::new(planner),
            controller: None,
            mode: Mode::Driving,
            deadline,
            fault: None,
            base: BaseResponse::new(robot.limits, &settings),
            settings,
            slim: robot.footprint.slim(),
            is_narrow: false,
            to_narrow_m: None,
            turning_to: None,
            robot,
        })
    }

    /// Lets a controller decide in place of the behaviours. The local planner is then not used.
    #[must_use]
    pub fn with_controller(mut self, controller: Box<dyn Controller>) -> Self {
        self.controller = Some(ControllerHost::new(controller, &self.route.path));
        self
    }

    /// Sets whether the next step receives the plan that is due, for the replay of a recorded run. Without `wait_for_plans`
    /// the arrival of a plan depends on the load of the machine.
    pub const fn replay_plan_arrival(&mut self, arrives: bool) {
        self.replanner.replayed_arrival = Some(arrives);
    }

    /// Decides what to do now. The command is within the robot's limits, and the robot reaches it within one control period
    /// unless it is too fast already; an observation that comes later than that after the one before lets it brake for the whole
    /// time between both. After the last goal, or after a fault, the robot brakes and stands.
    pub fn step(&mut self, observation: &Observation) -> Decision {
        let mut decision = self.decide(observation);
        let wanted = self.robot.limits.clamp(&decision.command);
        decision.command = self.base.corrected(&wanted);
        self.base.set_sent(observation.time_s, &decision.command);
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
            let (time_s, tick) = (observation.time_s, self.tick);
            decision.command = deadline.settle(time_s, tick, took_s, decision.command);
            self.behaviours.planner_mut().set_sampling(deadline.stats().last);
            self.base.set_sent(observation.time_s, &decision.command);
        }
        (decision, took_s)
    }

    /// Forgets the commands so far, after a pause of the program: the base has stopped by itself meanwhile.
    pub fn forget_commands(&mut self) {
        self.base.forget_commands();
    }

    /// Forgets the time without progress, and the attempts to escape and to park. Call it after each tick at which an operator
    /// keeps the robot standing: it is not stuck, and must not escape or give up.
    pub fn restart_progress(&mut self) {
        self.progress = Progress::default();
        self.behaviours.start_leg();
    }

    fn decide(&mut self, observation: &Observation) -> Decision {
        self.measure_tick(observation.time_s);
        self.base.record_sent(observation);
        if let Some(host) = &mut self.controller {
            host.start_tick();
        }
        let (robot, known) = (&self.robot, self.obstacles.rays());
        let last = &self.base.last_command;
        let has_new_scan =
            match self.validator.validate(observation, last, robot, &self.settings, known) {
                Ok(has_new_scan) => {
                    self.faulty = FaultyTime::default();
                    has_new_scan
                }
                Err(fault) => return self.brake_without_observation(fault),
            };
        if let Some(limits) = self.base.identify(observation) {
            self.robot.limits = limits;
        }
        let Observation { time_s, pose, twist, odometry_s, scan, scan_s, .. } = observation;
        // Marks of the time before may be at wrong places.
        if take(&mut self.validator.is_relocated) {
            self.obstacles.forget(*time_s, &pose.position());
            self.dust.forget();
            self.turning_to = None;
        }
        if has_new_scan && !self.is_over() {
            let masked = self.validator.health.masked(scan, &self.robot.footprint);
            let scan = masked.as_ref().unwrap_or(scan);
            let clear = self.dust.without_dust(*time_s, pose, scan);
            self.obstacles.update(*time_s, pose, clear.as_ref().unwrap_or(scan));
        }
        let moving = self.obstacles.bodies(&self.settings);
        let mut now = PredictedState::new(
            &Measured { time_s: *time_s, odometry_s: *odometry_s, scan_s: *scan_s, pose, twist },
            &moving,
            &self.base.in_flight,
            &self.robot.limits,
            self.base.delay_s(),
        );
        // The robot may have driven to a place where dust returned a beam.
        let is_outside =
            |body: &MovingDisc| self.robot.footprint.gap_to_disc_m(pose, &body.center(), 0.0) > 0.0;
        let entered: Vec<MovingDisc> =
            self.obstacles.entered_bodies(&self.settings).filter(is_outside).collect();
        now.may_come.extend(&entered);
        let walkers = self.obstacles.walkers(&moving, self.settings.pedestrian_radius_m);
        now.walkers = walkers.iter().map(|disc| disc.after(now.since_scan_s)).collect();
        now.may_start = self.obstacles.bodies_that_may_start(&self.settings);
        let seen = [&moving[..], &entered].concat();
        self.people.update(*time_s, &seen, |person| may_be_there(pose, scan, person));
        now.near_turn = self.people.near_turn(&now, &entered, self.settings.pedestrian_speed);
        if self.is_over() {
            return self.brake_from(&now.twist);
        }
        if self.mode == Mode::AtWaypoint {
            self.leave_waypoint(now.time_s);
            return self.brake_from(&now.twist);
        }
        if self.speed_limit == Some(0.0) {
            // The caller has paused the mission.
            self.restart_progress();
        }
        self.set_step();
        match self.drive(&now, observation) {
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

    /// Checks progress, replans, and lets the behaviours decide.
    fn drive(
        &mut self,
        now: &PredictedState,
        observation: &Observation,
    ) -> Result<Decision, Fault> {
        let robot = now.pose.position();
        let off_path_m = self.route.advance(&robot);
        let cover = if self.is_narrow { &self.slim } else { &self.robot.footprint };
        let health = &self.validator.health;
        let hide_unseen = |window: &mut ObstacleGrid| {
            if health.blind_sectors() > 0 {
                let from_m = self.robot.footprint.circumscribed_radius_m() + UNSEEN_GAP_M;
                health.block_unseen(window, &now.pose, from_m);
            }
        };
        let field = self
            .obstacles
            .window_with(&robot, self.window_half_m, self.is_narrow, hide_unseen)
            .map_err(|error| Fault::Choose(error.into()))?;
        let (mut new_route, mut has_new_route) = (None, false);
        let fastest = self.limited_speed(&robot);
        let mut state = State {
            settings: &self.settings,
            robot: &self.robot,
            tick: self.tick,
            now,
            measured: &observation.twist,
            last_command: &self.base.last_command,
            field: &field,
            is_narrow: self.is_narrow,
            to_narrow_m: self.to_narrow_m,
            blocked_s: self.replanner.blocked_s,
            path_kind: self.replanner.path_kind,
            leading_end: self.waypoints.leading_end(),
            slim: &self.slim,
            inflated: InflatedBodies::new(
                cover,
                &self.robot.limits,
                &self.settings,
                self.behaviours.planner().settings(),
                &field,
                now,
            ),
            visible: VisibleSpace { pose: observation.pose, scan: &observation.scan, health },
            standing_room: self.standing_room.as_ref(),
            goal: self.waypoints.target(),
            route: &self.route,
            off_path_m,
            local_target: robot,
            heading_error: 0.0,
            mode: self.mode,
            is_at_goal: false,
            stuck_s: 0.0,
            since_nearer_s: 0.0,
            is_slowed: self.base.is_slowed,
            fastest: fastest.min(self.robot.limits.max_vel_x),
            speed_limit: fastest,
        };
        // Noise of the pose hides a key node at one tick and shows it at the next: the robot would turn to two of them in turn.
        state.follow(&self.route, self.turning_to);
        self.to_narrow_m = self.replanner.to_narrow_m(&state);
        self.is_narrow = self.to_narrow_m.is_some() || state.is_beside_obstacle();
        state.is_at_goal = match &mut self.controller {
            Some(host) => host.is_at_goal(&state),
            None => self.behaviours.is_at_goal(&state),
        };
        self.progress.count_waiting(&state, self.dust.is_heavy());
        if !state.is_at_goal {
            let is_stuck = self.progress.check(&mut state);
            self.stuck_ticks.restart_if(self.progress.bounded_s == 0.0);
            if is_stuck {
                return Err(self.why_stuck(self.progress.bounded_s, &state));
            }
            if self.settings.features.replanning {
                if let Some(plan) = self.replanner.receive(&state, &mut self.obstacles) {
                    let route = new_route.insert(Route::new(&plan, &self.settings));
                    route.advance(&robot);
                    self.plans.push(plan);
                    self.progress.rebase(state.route.left_m(), route.left_m());
                    state.path_kind = self.replanner.path_kind;
                    state.follow(route, None);
                    has_new_route = true;
                }
                self.replanner.check_paths()?;
                self.replanner.request(&state, &self.obstacles);
            }
        }
        let may_stage = self.waypoints.may_stage() && self.controller.is_none();
        let reverses = may_stage.then(|| state.limits_in_sight().min_vel_x < 0.0);
        let decided = match &mut self.controller {
            Some(host) => {
                if has_new_route {
                    host.set_plan(&state.route.path);
                }
                host.decide(&state, observation, self.obstacles.moving())
            }
            None => self.behaviours.decide(state),
        };
        if let Some(route) = new_route {
            self.route = route;
        }
        let decision = decided.map_err(|fault| self.with_modes(fault))?;
        Ok(self.settled(decision, now, fastest, reverses))
    }

    /// A decision of the behaviours within the speed limit, m/s, and with the mode that follows from it. `reverses` is that of
    /// [`Self::mode_after`].
    fn settled(
        &mut self,
        mut decision: Decision,
        now: &PredictedState,
        fastest: f64,
        reverses: Option<bool>,
    ) -> Decision {
        let is_turning = decision.mode == Mode::Rotating;
        self.turning_to = is_turning.then_some(decision.local_target);
        if decision.mode != Mode::Evading {
            decision.command = self.at_most(fastest, &decision.command, &now.twist);
        }
        self.stuck_ticks.count(decision.mode, &decision.command);
        decision.mode = self.mode_after(decision.mode, now, reverses);
        decision
    }

    /// Sets how near to each other the local planner checks poses.
    fn set_step(&mut self) {
        let planner = self.behaviours.planner_mut();
        let times_s = (self.step_s, planner.settings().sim_time_s);
        planner.set_step(if self.is_narrow {
            step_that_overlooks(OVERLOOKED_M, &self.slim, &self.robot.limits, times_s)
        } else {
            self.step_s
        });
    }
}

/// Half the side of the local window, metres: the reach of the longest trajectory and some clearance beyond.
fn window_half_m(settings: &NavigatorSettings, local: &LocalSettings, robot: &RobotModel) -> f64 {
    let limits = &robot.limits;
    let fastest = limits.max_vel_x.max(-limits.min_vel_x).max(settings.escape_speed);
    fastest * local.sim_time_s
        + local.max_clearance_m.max(settings.safety_margin_m).min(WINDOW_CLEARANCE_M)
        + robot.footprint.circumscribed_radius_m()
}
