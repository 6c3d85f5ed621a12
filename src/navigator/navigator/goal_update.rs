//! Goals of a mission: the plans to them, and other goals for a navigator that drives.

use super::Navigator;
use crate::global::{Plan, PlanError};
use crate::navigator::global_planner::checked_plan;
use crate::navigator::goal_yaw::{check_yaws, goals_with_room};
use crate::navigator::staging::StagingSearch;
use crate::navigator::waypoints::WaypointQueue;
use crate::navigator::{
    Fault, GlobalPlanner, Mode, NavigatorSettings, ObstacleModel, RobotModel, Waypoints,
};

/// Plans a path to every goal on a map. Returns the queue of goals and the plan to the first one.
///
/// # Errors
/// When a goal is out of range, there is no path to it, or the body does not fit there.
pub(super) fn planned_goals(
    waypoints: &Waypoints,
    obstacles: &ObstacleModel,
    (robot, settings): (&RobotModel, &NavigatorSettings),
    planner: &mut dyn GlobalPlanner,
    clock: &mut dyn FnMut() -> f64,
) -> Result<(WaypointQueue, Plan), PlanError> {
    let closed = obstacles.closed();
    let least_radius_m = planner.least_radius_m();
    let search = StagingSearch { obstacles, closed, robot, settings, least_radius_m };
    let goals = goals_with_room(&waypoints.goals, obstacles, robot, settings);
    let waypoints = Waypoints { goals, ..*waypoints };
    let planned = WaypointQueue::planned(&waypoints, &search, |from, to| {
        checked_plan(planner, closed, &[], [from, to], clock)
    })?;
    check_yaws(&waypoints.goals, obstacles, robot, settings)?;
    Ok(planned)
}

impl Navigator {
    /// Replaces the goals without a stop, also after the last goal or a fault: plans a path to each of them on the present map, and
    /// the next decision drives to the first. `waypoints.start` is where the robot is. What the scans showed is kept.
    ///
    /// The call takes as long as the plans. No decision is made meanwhile: on a large map stop the robot before, with a speed limit
    /// of zero. Times the planner's stages by `clock`, in seconds.
    ///
    /// # Errors
    /// As [`Self::new`]. The goals so far then remain.
    pub fn replace_goals(
        &mut self,
        waypoints: &Waypoints,
        planner: &mut dyn GlobalPlanner,
        clock: &mut dyn FnMut() -> f64,
    ) -> Result<(), Fault> {
        let model = (&self.robot, &self.settings);
        let (queue, plan) = self
            .obstacles
            .without_marks(|map| planned_goals(waypoints, map, model, planner, clock))?;
        self.waypoints = queue;
        self.replanner.start_mission();
        self.follow(plan);
        (self.mode, self.fault) = (Mode::Driving, None);
        Ok(())
    }
}
