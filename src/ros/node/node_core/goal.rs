//! New goals: a robot that stands plans at once, one that drives plans on another thread and drives on.

use super::NodeCore;
use crate::geometry::Pose;
use crate::navigator::{Fault, Goal, Mode, Navigator, Waypoints};
use crate::ros::msg::ActionEnd;
use crate::ros::node::action::UNKNOWN;
use crate::ros::node::notices::MessageError;
use crate::runtime::{MapUpdate, Preparation};

impl NodeCore {
    /// Sets the goal in a frame, in place of the one before.
    pub(super) fn set_goal(
        &mut self,
        now_s: f64,
        (found, goal): (String, Goal),
    ) -> Result<(), MessageError> {
        self.check_active()?;
        self.check_map_frame(&found)?;
        let is_repeated = self.is_present_goal(&found, &goal);
        self.end_action(ActionEnd::ABORTED, Some((UNKNOWN, "a newer goal replaced it".to_owned())));
        self.accepted_s = now_s;
        if is_repeated {
            return Ok(());
        }
        self.stats.aborted += u64::from(self.has_open_goal());
        self.goal = Some((found, goal));
        let drives = self.ended_s.is_none() && self.navigator.is_some();
        (self.ended_s, self.without_scan_since_s) = (None, None);
        self.stats.goals += 1;
        if drives {
            self.plan_while_driving();
        } else {
            self.navigator = None;
        }
        Ok(())
    }

    /// Plans from the robot's pose to the goal on another thread. Where that is not possible the robot stops, and then plans.
    fn plan_while_driving(&mut self) {
        let planned = self.navigation_map().zip(self.waypoints(&self.pose));
        let is_started = planned.is_some_and(|(map, waypoints)| {
            let config = self.settings.config.clone();
            let plan = move || config.plan_goals(map, &waypoints, &mut || 0.0);
            self.goal_update.start("inbye-goal", || plan)
        });
        if !is_started {
            self.navigator = None;
        }
    }

    /// Lets the robot drive to the newest goal, once the path is planned.
    pub(super) fn update_goal(&mut self, now_s: f64) {
        let Some((planned, is_outdated)) = self.goal_update.take() else {
            return;
        };
        let Some(navigator) = &mut self.navigator else {
            return;
        };
        match planned.filter(|_| !is_outdated) {
            Some(Ok(goals)) => {
                navigator.follow_goals(goals);
                self.announce();
            }
            Some(Err(fault)) => {
                self.navigator = None;
                self.abort_by(now_s, &fault);
            }
            None => self.plan_while_driving(),
        }
    }

    /// A robot that arrives at the last goal, or fails on its way there, while it plans to a newer one: it stops, and then plans.
    pub(super) fn check_end_of_last_goal(&mut self, mode: Mode) {
        let has_failed = self.navigator.as_ref().is_some_and(|last| last.fault().is_some());
        if mode == Mode::Arrived || has_failed {
            self.navigator = None;
        }
    }

    /// A navigator from the robot's pose to the goal; none without a map or a goal.
    pub(super) fn new_navigator(
        &self,
        pose: &Pose,
        clock: &mut dyn FnMut() -> f64,
    ) -> Option<Result<Navigator, Fault>> {
        let map = self.navigation_map()?;
        let engine = Box::new(self.engine.clone());
        Some(self.settings.config.new_navigator(map, &self.waypoints(pose)?, engine, clock))
    }

    fn waypoints(&self, pose: &Pose) -> Option<Waypoints> {
        let (_, goal) = self.goal.as_ref()?;
        Some(Waypoints { start: pose.position(), goals: vec![*goal] })
    }

    pub(super) fn start(&mut self, navigator: Navigator) {
        // The navigator has the newest map and goal.
        self.map_update = MapUpdate::default();
        self.goal_update = Preparation::default();
        self.navigator = Some(navigator);
        self.published_plans = 0;
        self.announce();
    }

    fn announce(&mut self) {
        if let Some(navigator) = &self.navigator {
            let to = navigator.goal().position;
            self.notices.push(format!("driving to ({:.2}, {:.2})", to.x, to.y));
            self.notices.reset_sensor_fault();
        }
    }
}
