//! When to do which: the paper's hybrid method (section 3.3.3), made to finish.
//!
//! The global path gives key nodes; the local planner drives to one after the other; the robot stops at the last. At
//! each tick [`Navigator::step`] takes what the robot sees and returns what it does. It holds no clock and no
//! file, and its planning thread answers at promised ticks: the same observations give the same decisions.

mod features;
mod goal_handling;
mod async_planner;
mod passive_safety;
mod exact_clearance;
mod deadline;
mod adaptive_sampling;
mod path_following;
mod evasion;
mod command_decay;
mod fault;
mod escape;
mod goal;
mod navigator;
mod inflated_bodies;
mod local_map;
mod mode;
mod observation;
mod predicted_state;
mod parking;
mod route_planner;
mod pose_filter;
mod recovery;
mod replanning;
mod route;
mod observation_validator;
mod settings;
mod obstacle_model;
mod waypoints;
mod tracker;
mod breadcrumbs;
mod rotate_in_place;
mod scan_visibility;
mod progress_checker;

pub use features::NavigatorFeatures;
pub use deadline::{Deadline, DeadlineStats};
pub use adaptive_sampling::{AdaptiveSampling, MISSES_REMEMBERED, MISSES_TO_LOWER, SLACK, SLACK_TO_RAISE};
pub use command_decay::{CommandDecay, COMMAND_LIFETIME_S};
pub use fault::Fault;
pub use goal::{Goal, Waypoints};
pub use navigator::{Decision, Navigator, RobotModel};
pub use mode::Mode;
pub use observation::Observation;
pub use route_planner::RoutePlanner;
pub use pose_filter::{PoseFilter, PoseMeasurement};
pub use route::Route;
pub use observation_validator::ObservationFault;
pub use settings::NavigatorSettings;
pub use obstacle_model::ObstacleModel;
pub use tracker::Tracker;
