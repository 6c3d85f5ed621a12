//! What the navigator knows at a tick.

use std::sync::Arc;

use super::inflated_bodies::InflatedBodies;
use super::passive_safety::PassiveSafety;
use super::{Decision, Goal, Mode, NavigatorSettings, Route};
use crate::geometry::{Point, Pose, Twist, bearing, wrap_angle};
use crate::local::ClearanceField;
use crate::map::MovingDisc;
use crate::robot::{Footprint, Limits};

/// Distance between two checked points of a straight line, metres.
const LINE_STEP_M: f64 = 0.1;

/// What the navigator knows of the robot.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotModel {
    /// Shape of the robot.
    pub footprint: Footprint,
    /// Velocity and acceleration limits of its base.
    pub limits: Limits,
}

/// The robot and the moving obstacles at the time when a command sent now takes effect.
///
/// Radio, bus and motor delay a command; until it takes effect the robot follows the last one. A decision for the present
/// pose would brake too late by the distance driven until then.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PredictedState {
    /// Time of the observation, seconds.
    pub time_s: f64,
    /// Predicted pose of the robot.
    pub pose: Pose,
    /// Predicted velocity, as far as the base can have followed the last command.
    pub twist: Twist,
    /// Predicted moving obstacles.
    pub moving: Vec<MovingDisc>,
}

impl PredictedState {
    /// Predicts from the observed time, pose and twist, the tracked obstacles and the last command.
    pub fn new(
        (time_s, pose, twist): (f64, &Pose, &Twist),
        moving: &[MovingDisc],
        last_command: &Twist,
        limits: &Limits,
        delay_s: f64,
    ) -> Self {
        let (pose, twist) = limits.advance(pose, twist, last_command, delay_s);
        Self {
            time_s,
            pose,
            twist,
            moving: moving.iter().map(|disc| disc.after(delay_s)).collect(),
        }
    }
}

/// What a behaviour decides from.
pub(super) struct State<'a> {
    pub settings: &'a NavigatorSettings,
    pub robot: &'a RobotModel,
    /// Control period, seconds.
    pub period_s: f64,
    /// The robot and the moving obstacles when the command takes effect.
    pub now: &'a PredictedState,
    /// Distances to static obstacles around the robot.
    pub field: &'a Arc<ClearanceField>,
    /// The footprint and the moving obstacles with their margins.
    pub inflated: InflatedBodies,
    pub goal: &'a Goal,
    pub route: &'a Route,
    /// Distance of the robot from the path, metres.
    pub off_path_m: f64,
    /// The key node to drive to.
    pub local_target: Point,
    /// Angle from the robot's heading to the local target, radians.
    pub heading_error: f64,
    /// Mode of the last tick with a valid observation.
    pub mode: Mode,
    /// Whether the robot is near enough to the goal to park.
    pub is_at_goal: bool,
    /// Time since the last progress along the path, seconds.
    pub stuck_s: f64,
    /// Highest forward speed that the behaviours with higher priority allow, m/s.
    pub speed_limit: f64,
}

impl<'a> State<'a> {
    /// Follows a route: selects its key node to drive to.
    pub fn follow(&mut self, route: &'a Route) {
        let Self { settings, now, .. } = *self;
        let in_sight = |node: &Point| self.is_straight_clear_to(node);
        let target = route.key_node(settings.min_lookahead_m, settings.lookahead_m, in_sight);
        self.route = route;
        self.local_target = target;
        self.heading_error = wrap_angle(bearing(&now.pose.position(), &target) - now.pose.yaw);
    }

    /// The velocity after one period of braking at the limit, on the same arc.
    pub fn brake(&self) -> Twist {
        self.robot.limits.brake(&self.now.twist, self.period_s)
    }

    /// The velocity nearest to a wanted one that the robot reaches within one period.
    pub fn towards(&self, wanted: &Twist) -> Twist {
        let limits = &self.robot.limits;
        limits.reachable(&self.now.twist, wanted, self.period_s)
    }

    /// The check for passive safety; `None` where that feature is off.
    pub fn passive_safety(&self) -> Option<PassiveSafety<'_>> {
        let settings = self.settings;
        settings.features.passive_safety.then_some(PassiveSafety {
            now: self.now,
            footprint: &self.robot.footprint,
            limits: &self.robot.limits,
            delay_s: settings.actuation_delay_s + self.period_s,
        })
    }

    /// Whether driving towards a velocity until the next tick keeps passive safety.
    pub fn is_safe_towards(&self, wanted: &Twist) -> bool {
        let next = self.towards(wanted);
        self.passive_safety().is_none_or(|safety| safety.stops_in_time(&next))
    }

    /// As [`Self::towards`], or braking where that would break passive safety.
    pub fn safe_towards(&self, wanted: &Twist) -> Twist {
        if self.is_safe_towards(wanted) { self.towards(wanted) } else { self.brake() }
    }

    /// Whether a disc as large as the footprint's largest could move straight from the robot's position to a point, as far as
    /// the local window shows.
    pub fn is_straight_clear_to(&self, point: &Point) -> bool {
        let Ok(body) = Footprint::round(self.robot.footprint.max_disc_radius_m()) else {
            return false;
        };
        let from = self.now.pose.position();
        let line = point - from;
        let steps = (line.norm() / LINE_STEP_M).ceil();
        (1..=steps as u32).all(|step| {
            let point = from + line * (f64::from(step) / steps);
            let there = Pose::new(point.x, point.y, 0.0);
            let clearance_m = self.field.clearance_m(&body, &there);
            clearance_m.is_none_or(|clearance_m| clearance_m > 0.0)
        })
    }

    /// A decision to brake.
    pub fn stand(&self, mode: Mode) -> Decision {
        Decision::new(self.brake(), mode, self.goal.position)
    }
}
