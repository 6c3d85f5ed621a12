//! The `DynaBARN` worlds (Nair et al. 2022): cylinders that move by a script through an open field, and whose fault it is
//! when the robot and one of them touch.
//!
//! The cylinders take no notice of the robot, so some contacts are nobody's fault. A plain rate of success counts them
//! all; [`Blame`] says which count against the robot.

mod blame;
mod error;
mod world;

pub use blame::{Blame, Hindsight, State};
pub use error::DynaBarnError;
pub use world::{Body, DynaBarnWorld, read_world, read_worlds};
