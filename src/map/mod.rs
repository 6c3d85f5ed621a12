//! Maps: occupancy grids, map files, obstacle and distance grids, free space, lidar scans.
//!
//! Every grid has a frame ([`GridFrame`]); row 0 is the row with the lowest y. The area outside a grid is an obstacle,
//! and so are unknown cells unless [`UnknownPolicy::Free`] is selected.

mod bit_grid;
mod distance_field;
mod error;
mod free_space;
mod grid;
mod grid_ray;
mod image;
mod load;
mod map_server;
mod map_server_writer;
mod moving_disc;
mod movingai;
mod object_runs;
mod ray_caster;
mod scan;
mod scan_change;
pub(crate) mod yaml;
mod zone_masks;
mod zones;

pub(crate) use bit_grid::BitGrid;
pub use distance_field::DistanceField;
pub use error::{MapError, MapWarning};
pub use free_space::FreeSpace;
pub use grid::{
    Cell, Grid, GridFrame, MAX_GRID_CELLS, MAX_GRID_SIDE, MAX_RESOLUTION_M, OCCUPIED_THRESHOLD,
    ObstacleGrid, OccupancyGrid, UNKNOWN, UnknownPolicy,
};
pub(crate) use grid_ray::GridRay;
pub use load::{LoadOptions, has_own_resolution, load, load_with_warnings};
pub use moving_disc::MovingDisc;
pub use movingai::{Scenario, cell_from_top_left, parse_scen, read_scen};
pub(crate) use object_runs::object_runs;
pub(crate) use ray_caster::{RayCaster, RayEnd};
#[cfg(feature = "sim")]
pub(crate) use scan::is_measurement;
pub use scan::{Beam, Scan, ScanError, TimedScan};
pub use scan_change::ScanChange;
pub use zone_masks::{Mask, MaskError, MaskFault};
pub use zones::Zones;
