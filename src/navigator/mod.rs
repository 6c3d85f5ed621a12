//! When to do which: the paper's hybrid method (section 3.3.3), made to finish.
//!
//! The global path gives key nodes; the local planner drives to one after the other; the robot stops at the last. At
//! each tick [`Navigator::step`] takes what the robot sees and returns what it does. It holds no clock and no
//! file, and its planning thread answers at promised ticks: the same observations give the same decisions.

mod abilities;
mod arriving;
mod background;
mod caution;
mod close_up;
mod deadline;
mod density;
mod driving;
mod evading;
mod fading;
mod fault;
mod getting_out;
mod goal;
mod hybrid;
mod kept_clear;
mod local_map;
mod mode;
mod observation;
mod outlook;
mod parking;
mod planning;
mod pose_filter;
mod recovery;
mod replanning;
mod route;
mod senses;
mod settings;
mod surroundings;
mod tour;
mod tracker;
mod trail;
mod turning;
mod view;
mod watch;

pub use abilities::Abilities;
pub use deadline::{Deadline, Punctuality};
pub use density::{Density, MISSES_REMEMBERED, MISSES_TO_LOWER, SLACK, SLACK_TO_RAISE};
pub use fading::{Fading, PLAN_LIVES_S};
pub use fault::Fault;
pub use goal::{Goal, Journey};
pub use hybrid::{Decision, Navigator, RobotModel};
pub use mode::Mode;
pub use observation::Observation;
pub use planning::RoutePlanner;
pub use pose_filter::{PoseFilter, PoseFix};
pub use route::Route;
pub use senses::Doubt;
pub use settings::NavigatorSettings;
pub use surroundings::Surroundings;
pub use tracker::Tracker;
