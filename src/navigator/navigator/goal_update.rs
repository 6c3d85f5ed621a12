//! Goals of a mission: the plans to them, and other goals for a navigator that drives.

use super::Navigator;
use crate::global::{Plan, PlanError};
use crate::navigator::global_planner::checked_plan;
use crate::navigator::goal_yaw::{check_yaws, goals_with_room};
use crate::navigator::staging::StagingSearch;
use crate::navigator::waypoints::WaypointQueue;
use crate::navigator::{
    Fault, GlobalPlanner, Mode, NavigationMap, NavigatorSettings, ObstacleModel, RobotModel,
    Waypoints,
};

/// Goals with the paths to them, for [`Navigator::follow_goals`]. To plan them takes time in proportion to the map's area: do it
/// on another thread, while the robot drives to its present goal.
pub struct PlannedGoals {
    queue: WaypointQueue,
    plan: Plan,
}

impl PlannedGoals {
    /// Plans a path to every goal on a map, for a navigator with these settings. `waypoints.start` is where the robot is. Times the
    /// planner's stages by `clock`, in seconds.
    ///
    /// # Errors
    /// When a goal is out of range, there is no path to it, or the body does not fit there.
    pub fn new(
        map: impl Into<NavigationMap>,
        waypoints: &Waypoints,
        (robot, settings): (&RobotModel, &NavigatorSettings),
        planner: &mut dyn GlobalPlanner,
        clock: &mut dyn FnMut() -> f64,
    ) -> Result<Self, Fault> {
        let obstacles = ObstacleModel::without_tracking(map);
        let (queue, plan) =
            planned_goals(waypoints, &obstacles, (robot, settings), planner, clock)?;
        Ok(Self { queue, plan })
    }
}

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
    /// The call takes as long as the plans, and no decision is made meanwhile: on a large map use [`Self::follow_goals`]. Times the
    /// planner's stages by `clock`, in seconds.
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
        self.follow_goals(PlannedGoals { queue, plan });
        Ok(())
    }

    /// Replaces the goals without a stop, as [`Self::replace_goals`], by goals that were planned on the present map. The robot may have
    /// driven on since: where it is far from the path, it plans again.
    pub fn follow_goals(&mut self, goals: PlannedGoals) {
        self.waypoints = goals.queue;
        self.replanner.start_mission();
        self.follow(goals.plan);
        (self.mode, self.fault) = (Mode::Driving, None);
    }
}
