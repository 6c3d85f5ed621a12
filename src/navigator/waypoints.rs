//! The stops of a mission, one after the other.

use super::{Goal, Waypoints};
use crate::geometry::Point;
use crate::global::{Plan, PlanError};

/// A goal, and those after it with the way that leads there.
#[derive(Clone, Debug)]
pub(super) struct WaypointQueue {
    goal: Goal,
    done: usize,
    /// The next one last.
    ahead: Vec<(Goal, Plan)>,
    /// When the robot goes on from where it stands, seconds.
    goes_on_s: f64,
}

impl WaypointQueue {
    /// A journey with the way to each stop, and the way to the first: so that one that cannot be done is refused before
    /// the robot moves.
    ///
    /// # Errors
    /// Where there is no way to a stop.
    pub fn planned(
        journey: &Waypoints,
        mut plan: impl FnMut(Point, Point) -> Result<Plan, PlanError>,
    ) -> Result<(Self, Plan), PlanError> {
        let mut ahead = Vec::with_capacity(journey.stops.len());
        let mut from = journey.start;
        for goal in &journey.stops {
            ahead.push((*goal, plan(from, goal.position)?));
            from = goal.position;
        }
        ahead.reverse();
        let Some((goal, first)) = ahead.pop() else {
            // No stop at all: it stays where it is.
            let goal = Goal {
                position: from,
                yaw: None,
            };
            return plan(from, from).map(|stay| (Self::of(goal, ahead), stay));
        };
        Ok((Self::of(goal, ahead), first))
    }

    const fn of(goal: Goal, ahead: Vec<(Goal, Plan)>) -> Self {
        Self {
            goal,
            done: 0,
            ahead,
            goes_on_s: f64::NEG_INFINITY,
        }
    }

    /// The stop it makes for or stands at.
    pub const fn goal(&self) -> &Goal {
        &self.goal
    }

    /// Stops before that.
    pub const fn done(&self) -> usize {
        self.done
    }

    /// Whether another stop follows.
    pub const fn goes_on(&self) -> bool {
        !self.ahead.is_empty()
    }

    /// Stands here until a time.
    pub const fn stand_until(&mut self, time_s: f64) {
        self.goes_on_s = time_s;
    }

    /// The way to the next stop, which is the goal from now on, if there is one and it is time.
    pub fn next(&mut self, now_s: f64) -> Option<Plan> {
        if now_s < self.goes_on_s {
            return None;
        }
        let (goal, plan) = self.ahead.pop()?;
        self.goal = goal;
        self.done += 1;
        Some(plan)
    }
}
