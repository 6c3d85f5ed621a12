//! When to do which: the paper's hybrid method (section 3.3.3), made to finish.
//!
//! The global path gives key nodes; the local planner drives to one after the other; the robot stops at the last. At
//! each tick [`Navigator::step`] takes what the robot sees and returns what it does. It holds no clock and no
//! file, and its planning thread answers at promised ticks: the same observations give the same decisions.

mod adaptive_sampling;
mod async_planner;
mod breadcrumbs;
mod command_decay;
mod deadline;
mod escape;
mod evasion;
mod exact_clearance;
mod fault;
mod features;
mod goal;
mod goal_handling;
mod inflated_bodies;
mod local_map;
mod mode;
mod navigator;
mod observation;
mod observation_validator;
mod obstacle_model;
mod parking;
mod passive_safety;
mod path_following;
mod pose_filter;
mod predicted_state;
mod progress_checker;
mod recovery;
mod replanning;
mod rotate_in_place;
mod route;
mod route_planner;
mod scan_visibility;
mod settings;
mod tracker;
mod waypoints;

pub use adaptive_sampling::{
    AdaptiveSampling, MISSES_REMEMBERED, MISSES_TO_LOWER, SLACK, SLACK_TO_RAISE,
};
pub use command_decay::{COMMAND_LIFETIME_S, CommandDecay};
pub use deadline::{Deadline, DeadlineStats};
pub use fault::Fault;
pub use features::NavigatorFeatures;
pub use goal::{Goal, Waypoints};
pub use mode::Mode;
pub use navigator::{Decision, Navigator, RobotModel};
pub use observation::Observation;
pub use observation_validator::ObservationFault;
pub use obstacle_model::ObstacleModel;
pub use pose_filter::{PoseFilter, PoseMeasurement};
pub use route::Route;
pub use route_planner::RoutePlanner;
pub use settings::NavigatorSettings;
pub use tracker::Tracker;
