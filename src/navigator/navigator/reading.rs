//! What a caller reads of the navigator.

use std::collections::BTreeMap;

use super::Navigator;
use crate::global::Plan;
use crate::local::LocalPlanner;
use crate::navigator::controller_host::ControllerHost;
use crate::navigator::deadline::Deadline;
use crate::navigator::{
    ControllerReply, DeadlineStats, Fault, Goal, ObservationFault, ObstacleModel,
};
use crate::robot::{MotionEstimate, TickClock};

impl Navigator {
    /// Name of the controller that decides in place of the behaviours, if there is one.
    #[must_use]
    pub fn controller_name(&self) -> Option<&str> {
        self.controller.as_ref().map(ControllerHost::name)
    }

    /// The answer of that controller at the last tick; none where it was not asked.
    #[must_use]
    pub fn controller_reply(&self) -> Option<&ControllerReply> {
        self.controller.as_ref()?.reply()
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

    /// Why the mission failed, if it did.
    #[must_use]
    pub const fn fault(&self) -> Option<&Fault> {
        self.fault.as_ref()
    }

    /// The goal that the robot drives to or stands at.
    #[must_use]
    pub const fn goal(&self) -> &Goal {
        self.waypoints.goal()
    }

    /// Number of goals that the robot has left behind.
    #[must_use]
    pub const fn goals_passed(&self) -> usize {
        self.waypoints.passed
    }

    /// Length of the path ahead, metres.
    #[must_use]
    pub fn distance_left_m(&self) -> f64 {
        self.route.left_m() + self.waypoints.beyond_target_m()
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

    /// The measured times between observations.
    #[must_use]
    pub const fn tick_clock(&self) -> &TickClock {
        &self.tick_clock
    }

    /// The identified response of the base.
    #[must_use]
    pub const fn motion(&self) -> &MotionEstimate {
        self.base.estimate()
    }
}
