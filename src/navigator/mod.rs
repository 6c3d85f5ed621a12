//! The hybrid method of the paper (section 3.3.3), extended so that missions finish.
//!
//! A global path gives key nodes, and the local planner drives to one after the other. At each tick [`Navigator::step`] takes
//! an observation and returns a decision; `behaviours` lists what the robot does, by priority. The navigator reads no clock
//! and no file, and a plan takes effect at a tick that is fixed when the plan is requested. So the same observations give the
//! same decisions.

mod async_planner;
mod base_response;
mod behaviours;
mod condition_timer;
mod controller;
mod controller_host;
mod deadline;
mod decision;
mod dust;
mod exact_clearance;
mod first_problem;
mod frozen_scan;
mod global_planner;
mod goal_yaw;
mod inflated_bodies;
mod map_update;
mod mode_ticks;
mod narrow_passages;
mod navigation_map;
#[expect(clippy::module_inception, reason = "the main type of this module has its name")]
mod navigator;
mod new_objects;
mod no_path;
mod observation;
mod obstacle_model;
mod occlusion;
mod oncoming;
mod passive_safety;
mod predicted_state;
mod progress;
mod recent_people;
mod replanning;
mod retries;
mod route;
mod route_planner;
mod scan_health;
mod scan_visibility;
mod settings;
mod speed_limits;
mod staging;
mod state;
#[cfg(test)]
mod test_state;
mod tracker;
mod turn_safety;
mod visible_space;
mod waypoints;
mod zoned_map;

pub use controller::{Controller, ControllerError, ControllerInput, ControllerReply};
pub use deadline::{COMMAND_LIFETIME_S, DeadlineStats};
pub use decision::{Decision, Fault, Mode};
pub use global_planner::GlobalPlanner;
#[cfg(feature = "sim")]
pub(crate) use global_planner::{END_TOLERANCE_M, check_cells, check_ends};
pub use map_update::{MapSource, PreparedMap};
pub use navigation_map::NavigationMap;
pub use navigator::{Navigator, PlannedGoals};
pub use observation::{Observation, ObservationFault};
pub use obstacle_model::ObstacleModel;
pub use route_planner::RoutePlanner;
pub use settings::{NavigatorFeatures, NavigatorSettings};
pub use speed_limits::limits_in_zones;
pub use state::RobotModel;
pub use waypoints::{Goal, Waypoints};
pub use zoned_map::ZonedMap;

#[cfg(feature = "sim")]
pub(crate) use goal_yaw::no_room;
#[cfg(feature = "sim")]
pub(crate) use mode_ticks::ModeTicks;
pub(crate) use route::Route;
#[cfg(feature = "experiment")]
pub(crate) use scan_visibility::measures_beyond;
