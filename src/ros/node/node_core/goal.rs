//! New goals: a robot that stands plans at once, one that drives plans on another thread and drives on.

use super::NodeCore;
use crate::geometry::Pose;
use crate::navigator::{Fault, Mode, Navigator, Waypoints};
use crate::ros::msg::ActionEnd;
use crate::ros::node::action::UNKNOWN;
use crate::ros::node::incoming::GoalInput;
use crate::ros::node::notices::MessageError;
use crate::runtime::{MapUpdate, Preparation};

/// Maximum number of frames to try, and to name, in the text for a goal in an unknown frame.
const MAX_CANDIDATES: usize = 64;
const MAX_KNOWN: usize = 5;

impl NodeCore {
    /// Sets the goal, in place of the one before. A goal in another frame than the map's is transformed.
    pub(super) fn set_goal(&mut self, now_s: f64, goal: &GoalInput) -> Result<(), MessageError> {
        self.check_active()?;
        let GoalInput { frame, goal, .. } = self.in_map_frame(now_s, goal)?;
        let is_repeated = self.is_present_goal(&frame, &goal);
        self.end_action(ActionEnd::ABORTED, Some((UNKNOWN, "a newer goal replaced it".to_owned())));
        self.accepted_s = now_s;
        if is_repeated {
            return Ok(());
        }
        self.stats.aborted += u64::from(self.has_open_goal());
        self.goal = Some((frame, goal));
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

    /// A goal in the map's frame, by the pose of its frame at its stamp. Before the first map it stays in its own frame.
    pub(super) fn in_map_frame(
        &self,
        now_s: f64,
        goal: &GoalInput,
    ) -> Result<GoalInput, MessageError> {
        let map = self.inputs.map.as_ref().filter(|map| map.frame != goal.frame);
        let Some(map) = map else {
            return Ok(goal.clone());
        };
        let stamp_s = if goal.stamp.is_zero() { now_s } else { goal.stamp.seconds().min(now_s) };
        let (limits, odometry_frame) = (self.age_limits(), self.odometry_frame().ok());
        let pose_of = |frame: &str| {
            self.inputs.pose_in_map(frame, stamp_s, now_s, &limits, odometry_frame.as_ref())
        };
        if let Some(pose) = pose_of(&goal.frame) {
            return Ok(goal.transformed(&map.frame, &pose));
        }
        let names = self.inputs.frame_names();
        let candidates = names.into_iter().take(MAX_CANDIDATES);
        let known: Vec<&str> =
            candidates.filter(|frame| pose_of(frame).is_some()).take(MAX_KNOWN).collect();
        Err(MessageError::UnknownFrame {
            found: goal.frame.clone(),
            expected: map.frame.clone(),
            known: known.join(", "),
        })
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
