//! The BARN worlds (Perille et al. 2020: Benchmark Autonomous Robot Navigation), driven in a closed loop by the rules of
//! the BARN Challenge: from a start to a goal ten metres on, through a field of cylinders that no map shows, seen by the
//! laser alone.
//!
//! The rules are BARN's; the simulator is not. What the worlds' file publishes was measured in Gazebo, whose physics,
//! delays and contacts this one does not have.

mod config;
mod error;
mod ground;
mod row;
mod run;
mod score;
mod summary;
mod table;
mod world;

pub use config::barn_config;
pub use error::BarnError;
pub use ground::{Cylinder, TRUTH_RESOLUTION_M, empty_map, truth};
pub use row::BarnRow;
pub use run::{Course, Task};
pub use score::score;
pub use summary::{Outcome, PublishedMeans, Summary};
pub use world::{BarnWorld, Published, parse_cylinders, parse_list, read_worlds};
