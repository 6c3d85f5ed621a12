//! Where is free space: grids of the ground, read from files, and the distance to the nearest obstacle.
//!
//! A grid lies on the ground with its own frame ([`GridFrame`]); row 0 is the lowest y. Everything outside a grid
//! is an obstacle, and so is unknown ground unless [`UnknownPolicy::Free`] is asked for.

mod bit_grid;
mod dilation;
mod distance_field;
mod error;
mod free_space;
mod grey_image;
mod grid;
mod load;
mod map_server;
mod map_yaml;
mod moving_disc;
mod movingai;
mod note;
mod scan;
mod scenario;
mod sweep;
mod text_map;
pub(crate) mod yaml;

pub(crate) use bit_grid::BitGrid;
pub use distance_field::DistanceField;
pub use error::MapError;
pub use free_space::FreeSpace;
pub use grid::{
    Cell, GridFrame, MAX_GRID_CELLS, MAX_GRID_SIDE, OCCUPIED_THRESHOLD, ObstacleGrid,
    OccupancyGrid, UNKNOWN, UnknownPolicy,
};
pub use load::{LoadOptions, load, load_with_warnings};
pub use moving_disc::MovingDisc;
pub use movingai::cell_from_top_left;
pub use note::MapWarning;
pub use scan::Scan;
pub use scenario::{Scenario, parse_scen, read_scen};
pub use sweep::{Beam, TimedScan};
