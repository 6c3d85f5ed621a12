//! The navigator: one decision for each observation.

use std::collections::BTreeMap;

use super::deadline::Deadline;
use super::observation_validator::ObservationValidator;
use super::parking::Parking;
use super::predicted_state::PredictedState;
use super::progress_checker::ProgressChecker;
use super::recovery::Recovery;
use super::replanning::Replanning;
use super::waypoints::WaypointQueue;
use super::{
    Fault, Goal, Mode, NavigatorSettings, Observation, ObservationFault, ObstacleModel, Route,
    RoutePlanner, Waypoints,
};
use crate::geometry::{Point, Twist};
use crate::global::Plan;
use crate::local::{ClearanceField, Counts, LocalPlanner};
use crate::map::ObstacleGrid;
use crate::robot::{Footprint, Limits};

/// A robot that parks and gets further from the goal than its tolerance by this factor drives there again.
const LEAVES_GOAL: f64 = 2.0;

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

/// Follows global paths to its stops among obstacles that the map does not show.
pub struct Navigator {
    pub(super) settings: NavigatorSettings,
    pub(super) robot: RobotModel,
    pub(super) planner: LocalPlanner,
    pub(super) surroundings: ObstacleModel,
    pub(super) tour: WaypointQueue,
    pub(super) route: Route,
    pub(super) plans: Vec<Plan>,
    pub(super) mode: Mode,
    pub(super) watch: ProgressChecker,
    pub(super) recovery: Recovery,
    pub(super) parking: Parking,
    pub(super) replanning: Replanning,
    /// A robot that turns in place drives on when its target lies within this of its heading, radians.
    pub(super) turns_until: f64,
    pub(super) deadline: Option<Deadline>,
    pub(super) last_command: Twist,
    senses: ObservationValidator,
    fault: Option<Fault>,
}

impl Navigator {
    /// A navigator with a path to each stop.
    ///
    /// # Errors
    /// When there is no path to one, or no thread to plan on.
    pub fn new(
        known: ObstacleGrid,
        journey: &Waypoints,
        robot: RobotModel,
        planner: LocalPlanner,
        mut route_planner: RoutePlanner,
        settings: NavigatorSettings,
        clock: &mut dyn FnMut() -> f64,
    ) -> Result<Self, Fault> {
        let (tour, plan) = WaypointQueue::planned(journey, |from, to| {
            route_planner.plan(&known, from, to, clock)
        })?;
        Ok(Self {
            route: Route::new(&plan, &settings),
            plans: vec![plan],
            surroundings: if settings.features.tracking {
                ObstacleModel::new(known.clone())
            } else {
                ObstacleModel::without_tracking(known.clone())
            },
            replanning: Replanning::new(known, route_planner)?,
            turns_until: settings.rotate_in_place_until,
            deadline: settings
                .deadline_s
                .map(|limit_s| Deadline::new(limit_s, planner.settings(), &robot.limits)),
            settings,
            robot,
            planner,
            tour,
            mode: Mode::Driving,
            watch: ProgressChecker::default(),
            recovery: Recovery::default(),
            parking: Parking::default(),
            senses: ObservationValidator::default(),
            last_command: Twist::STOP,
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

    /// The stop it makes for, or stands at, and how many it has been to before.
    #[must_use]
    pub fn stop(&self) -> (&Goal, usize) {
        (self.tour.goal(), self.tour.done())
    }

    /// What it has seen that the map does not show.
    #[must_use]
    pub const fn obstacle_model(&self) -> &ObstacleModel {
        &self.surroundings
    }

    /// How many observations were not believed, by why.
    #[must_use]
    pub const fn observation_faults(&self) -> &BTreeMap<ObservationFault, u64> {
        self.senses.counts()
    }

    /// Why the last observation was not believed; none where it was.
    #[must_use]
    pub const fn observation_fault(&self) -> Option<ObservationFault> {
        self.senses.doubt()
    }

    /// The local planner.
    #[must_use]
    pub const fn planner(&self) -> &LocalPlanner {
        &self.planner
    }

    /// Decides what to do now. After the last stop is reached, or a mission given up, the answer is to stand. The command
    /// is within the robot's limits, and within what it reaches in one control period unless it is too fast already.
    pub fn step(&mut self, observation: &Observation) -> Decision {
        let mut decision = self.decide(observation);
        decision.command = self.robot.limits.clamp(&decision.command);
        self.last_command = decision.command;
        decision
    }

    fn decide(&mut self, observation: &Observation) -> Decision {
        let limits = &self.robot.limits;
        let judged = self
            .senses
            .judge(observation, &self.last_command, limits, &self.settings);
        let has_new_scan = match judged {
            Ok(has_new_scan) => has_new_scan,
            Err(doubt) => return self.doubt(doubt),
        };
        let Observation {
            time_s,
            pose,
            twist,
            scan,
            lost: _,
            scan_s: _,
        } = observation;
        if has_new_scan && !self.is_over() {
            self.surroundings.update(*time_s, pose, scan);
        }
        let now = PredictedState::new(
            (*time_s, pose, twist),
            self.surroundings.moving(),
            &self.last_command,
            &self.robot.limits,
            self.settings.actuation_delay_s,
        );
        if self.is_over() {
            return self.stand(&now, self.mode);
        }
        match self.act(&now) {
            Ok(decision) => decision,
            Err(fault) => {
                self.fault = Some(fault);
                self.mode = Mode::Failed;
                self.stand(&now, Mode::Failed)
            }
        }
    }

    /// Brakes, from what it was told last: where it is and how fast it moves are not known. Gives up when that lasts.
    fn doubt(&mut self, doubt: ObservationFault) -> Decision {
        let period_s = self.planner.settings().control_period_s;
        let times = self.senses.doubted_in_a_row();
        let mut mode = self.mode;
        if !self.is_over() {
            // What it was doing it goes on with when this is over.
            mode = Mode::SensorFault;
            let stuck_patience_s = match doubt {
                ObservationFault::Lost(_) => self.settings.localization_patience_s,
                _ => self.settings.sensor_fault_patience_s,
            };
            if f64::from(times) * period_s > stuck_patience_s {
                self.fault = Some(Fault::FaultyObservation {
                    fault: doubt,
                    count: times,
                });
                (self.mode, mode) = (Mode::Failed, Mode::Failed);
            }
        }
        Decision {
            command: self.robot.limits.brake(&self.last_command, period_s),
            ..self.standing(mode)
        }
    }

    const fn is_over(&self) -> bool {
        matches!(self.mode, Mode::Arrived | Mode::Failed)
    }

    fn act(&mut self, now: &PredictedState) -> Result<Decision, Fault> {
        if self.mode == Mode::AtWaypoint {
            return Ok(self.stop_over(now));
        }
        let robot = now.pose.position();
        let off_path_m = self.route.advance(&robot);
        let field = self
            .surroundings
            .window(&robot, self.window_half_m())
            .map_err(|error| Fault::Choose(error.into()))?;
        if self.is_at_goal(now, &field) {
            return self.park(now, &field);
        }
        let left_m = self.route.left_m();
        let radius_m = self.settings.required_movement_radius;
        let stuck_s = self.watch.stuck_s(now.time_s, left_m, radius_m);
        if stuck_s > self.settings.movement_time_allowance {
            return Err(self.why_stuck(stuck_s));
        }
        self.replan(now, &field, off_path_m, stuck_s);
        self.drive(now, &field, stuck_s)
    }

    /// Whether the robot is near enough to its goal to park, or parks and has not left it since.
    fn is_at_goal(&self, now: &PredictedState, field: &ClearanceField) -> bool {
        let goal = self.tour.goal();
        let robot = now.pose.position();
        let away_m = (robot - goal.position).norm();
        let tolerance_m = self.settings.xy_goal_tolerance;
        let near_m = if self.parking.has_begun() {
            LEAVES_GOAL * tolerance_m
        } else {
            tolerance_m
        };
        away_m <= near_m
            || Parking::can_begin(&now.pose, goal, &self.settings)
                && self.is_straight_clear(&robot, &goal.position, field)
    }

    fn why_stuck(&self, stuck_s: f64) -> Fault {
        let left_m = self.route.left_m();
        if let Some(error) = self.replanning.no_way() {
            return Fault::Plan(error);
        }
        if matches!(self.mode, Mode::Blocked | Mode::Escaping) {
            return Fault::NoControl { stuck_s, left_m };
        }
        Fault::NoProgress {
            stuck_s,
            radius_m: self.settings.required_movement_radius,
            left_m,
        }
    }

    /// Braking at the limit, on the arc that it drives.
    pub(super) fn brake(&self, now: &PredictedState) -> Twist {
        let period_s = self.planner.settings().control_period_s;
        self.robot.limits.brake(&now.twist, period_s)
    }

    /// The nearest to a velocity that is reached by the next tick.
    pub(super) fn towards(&self, now: &PredictedState, wanted: &Twist) -> Twist {
        let period_s = self.planner.settings().control_period_s;
        self.robot.limits.reachable(&now.twist, wanted, period_s)
    }

    pub(super) fn stand(&self, now: &PredictedState, mode: Mode) -> Decision {
        Decision {
            command: self.brake(now),
            ..self.standing(mode)
        }
    }

    fn standing(&self, mode: Mode) -> Decision {
        Decision {
            command: Twist::STOP,
            mode,
            local_target: self.tour.goal().position,
            counts: None,
        }
    }
}
