//! The BARN worlds (Perille et al. 2020: Benchmark Autonomous Robot Navigation), driven in a closed loop by the rules of
//! the BARN Challenge. The goal is ten metres ahead, behind a field of cylinders that only the laser shows and no map.
//!
//! The rules are BARN's, but the simulator is not. The published figures in the worlds' file were measured in Gazebo. This
//! simulator does not have Gazebo's physics, delays and contacts.

mod config;
mod course;
mod summary;
mod world;

pub use config::barn_config;
pub use course::{Course, Cylinder, TRUTH_RESOLUTION_M, empty_map, score, truth};
pub use summary::{BarnSummary, OverWorlds, PublishedMeans};
pub use world::{BarnWorld, Published, parse_cylinders, parse_list, read_worlds};

pub(super) use world::OPTIMAL_SPEED;
