//! Goals of a mission, one after the other.

use super::staging::{LeadingEnd, Staging, StagingSearch};
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
    /// Number of goals before the present one.
    pub passed: usize,
    /// End of the pause at the present goal, seconds.
    pub pause_until_s: f64,
    goal: Goal,
    stage: Stage,
    /// The next one last.
    ahead: Vec<Leg>,
}

/// The way to a goal from the one before.
#[derive(Clone, Debug)]
struct Leg {
    goal: Goal,
    plan: Plan,
    staging: Option<Staging>,
}

/// Part of the way to a goal.
#[derive(Clone, Debug)]
enum Stage {
    /// To the goal, by the direct plan. The leg has just begun, and the robot may drive by the staging pose instead.
    Begun(Staging),
    /// To the staging pose.
    ToStaging(Staging),
    /// To the goal.
    ToGoal(LeadingEnd),
}

impl Stage {
    /// The first part of a leg.
    fn first(staging: Option<Staging>) -> Self {
        staging.map_or(Self::ToGoal(LeadingEnd::Nose), Self::Begun)
    }
}

impl WaypointQueue {
    /// Plans to every goal, so that an unreachable one is an error before the robot moves. Returns the queue and the plan to
    /// the first goal.
    ///
    /// # Errors
    /// Where there is no path to a goal, or its yaw is not finite.
    pub fn planned(
        waypoints: &Waypoints,
        search: &StagingSearch<'_>,
        mut plan: impl FnMut(Point, Point) -> Result<Plan, PlanError>,
    ) -> Result<(Self, Plan), PlanError> {
        let mut ahead = Vec::with_capacity(waypoints.goals.len());
        let mut from = waypoints.start;
        for goal in &waypoints.goals {
            goal.check_yaw()?;
            let direct = plan(from, goal.position);
            let staging = match &direct {
                Ok(direct) => search.find(goal, direct, &mut plan),
                Err(PlanError::GoalOccupied { .. }) => search.straight_to(goal, from, &mut plan),
                Err(_) => None,
            };
            let plan = direct.or_else(|error| staging.as_ref().map(Staging::whole).ok_or(error))?;
            ahead.push(Leg { goal: *goal, plan, staging });
            from = goal.position;
        }
        ahead.reverse();
        // Without a goal the robot stays where it is.
        let first = match ahead.pop() {
            Some(next) => next,
            None => Leg { goal: Goal::at(from), plan: plan(from, from)?, staging: None },
        };
        let Leg { goal, plan, staging } = first;
        let stage = Stage::first(staging);
        Ok((Self { goal, stage, passed: 0, ahead, pause_until_s: f64::NEG_INFINITY }, plan))
    }

    /// The goal that the robot drives to or stands at.
    pub const fn goal(&self) -> &Goal {
        &self.goal
    }

    /// Where the robot drives to at present: its goal, or the staging pose of its goal.
    pub const fn target(&self) -> &Goal {
        match &self.stage {
            Stage::ToStaging(staging) => &staging.pose,
            _ => &self.goal,
        }
    }

    /// Length of the way from the present target to the goal, metres.
    pub fn beyond_target_m(&self) -> f64 {
        match &self.stage {
            Stage::ToStaging(staging) => staging.to_goal.smoothed.length_m(),
            _ => 0.0,
        }
    }

    /// How the robot drives to its target.
    pub const fn leading_end(&self) -> LeadingEnd {
        match self.stage {
            Stage::ToGoal(leading_end) => leading_end,
            Stage::Begun(_) | Stage::ToStaging(_) => LeadingEnd::Nose,
        }
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
        let Leg { goal, plan, staging } = self.ahead.pop()?;
        (self.goal, self.stage) = (goal, Stage::first(staging));
        self.passed += 1;
        Some(plan)
    }

    /// Whether a leg has just begun, and the robot may drive by a staging pose.
    pub const fn may_stage(&self) -> bool {
        matches!(self.stage, Stage::Begun(_))
    }

    /// Decides once, when a leg has just begun, whether a robot with this yaw, radians, drives by the staging pose; returns the plan to
    /// there. A robot that does not see behind it, `reverses` is false, cannot drive tail first.
    pub fn choose(&mut self, yaw: f64, reverses: bool) -> Option<Plan> {
        let Stage::Begun(staging) = &self.stage else {
            return None;
        };
        let is_possible = reverses || staging.leading_end == LeadingEnd::Nose;
        let staging = (is_possible && staging.is_needed(yaw)).then(|| staging.clone());
        let plan = staging.as_ref().map(|staging| staging.to_pose.clone());
        self.stage = staging.map_or(Stage::ToGoal(LeadingEnd::Nose), Stage::ToStaging);
        plan
    }

    /// Goes on from the staging pose to the goal, and returns the plan; `None` elsewhere.
    pub fn leave_staging(&mut self) -> Option<Plan> {
        let Stage::ToStaging(Staging { to_goal, leading_end, .. }) = &self.stage else {
            return None;
        };
        let (plan, leading_end) = (to_goal.clone(), *leading_end);
        self.stage = Stage::ToGoal(leading_end);
        Some(plan)
    }
}
