//! The `DynaBARN` worlds (Nair et al. 2022): cylinders that move by a script through an open field, and whose fault it is
//! when the robot and one of them touch.
//!
//! The cylinders take no notice of the robot, so some contacts are nobody's fault. A plain rate of success counts them
//! all; [`Blame`] says which count against the robot.
//!
//! The simulator is not Gazebo, in which others measure: it has no physics and no delays of messages. The cylinders go as
//! they do there: time runs evenly from keyframe to keyframe, the place on a Catmull-Rom spline (`PoseAnimation` of
//! `gazebosim/gazebo-classic`, `Spline` of `gazebosim/gz-math`, whose tension is zero unless set).

mod blame;
mod config;
mod error;
mod row;
mod run;
mod summary;
mod world;

pub use blame::{Blame, Hindsight, State};
pub use config::dynabarn_config;
pub use error::DynaBarnError;
pub use row::{Culprit, DynaBarnRow};
pub use run::Task;
pub use summary::Summary;
pub use world::{Body, DynaBarnWorld, parse_world, read_world, read_worlds};
