//! New goals for a robot that drives.

use std::thread::{Builder, JoinHandle};

use crate::navigator::{Fault, NavigationMap, PlannedGoals, Waypoints};
use crate::runtime::Config;

/// The path to the newest goal, planned on its own thread while the robot drives on.
#[derive(Debug, Default)]
pub struct GoalUpdate {
    running: Option<JoinHandle<Result<PlannedGoals, Fault>>>,
    /// A newer goal or map arrived since the start of the thread.
    is_outdated: bool,
}

impl GoalUpdate {
    /// Plans a path on a map. While a thread plans already, it only marks that plan as outdated. Returns false if no thread starts.
    pub fn start(&mut self, map: NavigationMap, waypoints: Waypoints, config: &Config) -> bool {
        if self.is_running() {
            self.is_outdated = true;
            return true;
        }
        let config = config.clone();
        let plan = move || config.plan_goals(map, &waypoints, &mut || 0.0);
        self.running = Builder::new().name("inbye-goal".to_owned()).spawn(plan).ok();
        self.is_outdated = false;
        self.is_running()
    }

    /// Whether a path is being planned.
    pub const fn is_running(&self) -> bool {
        self.running.is_some()
    }

    /// The map has changed: the path must be planned on the newest one.
    pub const fn outdate(&mut self) {
        self.is_outdated = true;
    }

    /// The end of the thread, once.
    pub fn take(&mut self) -> Option<GoalPlan> {
        let finished = self.running.take_if(|running| running.is_finished())?;
        Some(match finished.join() {
            Ok(planned) if !self.is_outdated => GoalPlan::Newest(Box::new(planned)),
            _ => GoalPlan::Outdated,
        })
    }
}

/// What a thread has planned.
pub enum GoalPlan {
    /// The path to the newest goal on the newest map, or why there is none.
    Newest(Box<Result<PlannedGoals, Fault>>),
    /// Plan again.
    Outdated,
}
