//! The `DynaBARN` worlds (Nair et al. 2022): cylinders that move along scripts through an open field, and the attribution of
//! contacts between them and the robot.
//!
//! The cylinders ignore the robot, so it cannot avoid every contact. A plain success rate counts all contacts;
//! [`ContactAttribution`] finds those that the robot caused or could have avoided.
//!
//! Published results were measured in Gazebo; this simulator has no physics and no message delays. The cylinders move as
//! in Gazebo, on a Catmull-Rom spline with time linear between keyframes (`PoseAnimation` of `gazebosim/gazebo-classic`,
//! `Spline` of `gazebosim/gz-math`; its tension is zero by default).

mod config;
mod contact_attribution;
mod error;
mod simulation;
mod world;

pub use config::dynabarn_config;
pub use contact_attribution::{ContactAttribution, State};
pub use error::DynaBarnError;
pub use world::{DynaBarnWorld, ScriptedCylinder, parse_world, read_world, read_worlds};
