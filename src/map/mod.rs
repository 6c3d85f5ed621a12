//! Where is free space: grids of the ground, read from files, and the distance to the nearest obstacle.
//!
//! A grid lies on the ground with its own frame ([`GridFrame`]); row 0 is the lowest y. Everything outside a grid
//! is an obstacle, and so is unknown ground unless [`UnknownPolicy::Free`] is asked for.

mod distance_field;
mod free_space;
mod grid;
mod moving_disc;
mod scan;

pub use distance_field::DistanceField;
pub use free_space::FreeSpace;
pub use grid::{
    Cell, GridFrame, MAX_GRID_SIDE, OCCUPIED_FROM, ObstacleGrid, OccupancyGrid, UNKNOWN,
    UnknownPolicy,
};
pub use moving_disc::MovingDisc;
pub use scan::Scan;
