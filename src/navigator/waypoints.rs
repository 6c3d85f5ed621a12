//! Goals of a mission, one after the other.

use crate::geometry::Point;
use crate::global::{Plan, PlanError};
use crate::settings::{SettingError, require};

/// A position to reach, and optionally the yaw to stand there with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// Position, metres in the map frame.
    pub position: Point,
    /// Yaw, radians.
    pub yaw: Option<f64>,
}

impl Goal {
    /// A goal with any yaw.
    #[must_use]
    pub const fn at(position: Point) -> Self {
        Self { position, yaw: None }
    }

    /// Rejects a yaw that is not finite: the robot would turn at the goal for ever.
    pub(crate) fn check_yaw(&self) -> Result<(), SettingError> {
        let yaw = self.yaw.unwrap_or_default();
        require(yaw.is_finite(), "yaw of a goal", yaw, "finite")
    }
}

/// Start and goals of a mission. Every goal but the last is a waypoint, at which the robot pauses.
#[derive(Clone, Debug, PartialEq)]
pub struct Waypoints {
    /// Position of the robot.
    pub start: Point,
    /// Goals in order; at least one.
    pub goals: Vec<Goal>,
}

/// The present goal, and those after it with the plans that lead there.
#[derive(Clone, Debug)]
pub(super) struct WaypointQueue {
    /// The goal that the robot drives to or stands at.
    pub goal: Goal,
    /// Number of goals before that.
    pub passed: usize,
    /// End of the pause at the present goal, seconds.
    pub pause_until_s: f64,
    /// The next one last.
    ahead: Vec<(Goal, Plan)>,
}

impl WaypointQueue {
    /// Plans to every goal, so that an unreachable one is an error before the robot moves. Returns the queue and the plan to
    /// the first goal.
    ///
    /// # Errors
    /// Where there is no path to a goal, or its yaw is not finite.
    pub fn planned(
        waypoints: &Waypoints,
        mut plan: impl FnMut(Point, Point) -> Result<Plan, PlanError>,
    ) -> Result<(Self, Plan), PlanError> {
        let mut ahead = Vec::with_capacity(waypoints.goals.len());
        let mut from = waypoints.start;
        for goal in &waypoints.goals {
            goal.check_yaw()?;
            ahead.push((*goal, plan(from, goal.position)?));
            from = goal.position;
        }
        ahead.reverse();
        // Without a goal the robot stays where it is.
        let (goal, first) = match ahead.pop() {
            Some(next) => next,
            None => (Goal::at(from), plan(from, from)?),
        };
        let queue = Self { goal, passed: 0, ahead, pause_until_s: f64::NEG_INFINITY };
        Ok((queue, first))
    }

    /// Whether another goal follows.
    pub const fn has_next(&self) -> bool {
        !self.ahead.is_empty()
    }

    /// Takes the next goal as the present one and returns the plan to it; `None` during the pause or after the last goal.
    pub fn next(&mut self, now_s: f64) -> Option<Plan> {
        if now_s < self.pause_until_s {
            return None;
        }
        let (goal, plan) = self.ahead.pop()?;
        self.goal = goal;
        self.passed += 1;
        Some(plan)
    }
}
