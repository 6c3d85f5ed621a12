//! A map for random missions.

use std::sync::Arc;

use crate::map::{Cell, FreeSpace, ObstacleGrid, OccupancyGrid};
use crate::runtime::Config;

/// A map, and its free cells for the robot's origin.
#[derive(Clone, Debug)]
pub struct MissionSite {
    /// Its name in rows and messages.
    pub name: String,
    /// The map that the robot has.
    pub map: Arc<OccupancyGrid>,
    /// Its obstacles.
    pub obstacles: ObstacleGrid,
    /// Cells at least as far from every obstacle as a global path must be.
    pub free: FreeSpace,
    /// Indices of the free cells that are not at the map's border, ascending.
    pub(super) free_cells: Vec<usize>,
}

impl MissionSite {
    /// A map for the robot of a configuration.
    #[must_use]
    pub fn new(name: &str, map: OccupancyGrid, config: &Config) -> Self {
        let obstacles = map.obstacles(config.unknown);
        let planner = config.route_planner(map.frame().resolution_m);
        let free = FreeSpace::new(&obstacles, planner.least_radius_m());
        let frame = *free.frame();
        // Everything outside the map is an obstacle for a robot, but not for `FreeSpace`.
        let rim = (planner.least_radius_m() / frame.resolution_m).ceil() as i32;
        let is_inner = |cell: Cell| {
            (rim..frame.width - rim).contains(&cell.column)
                && (rim..frame.height - rim).contains(&cell.row)
        };
        let free_cells = (0..frame.len())
            .filter(|&index| free.is_free(frame.cell_at(index)) && is_inner(frame.cell_at(index)))
            .collect();
        Self { name: name.to_owned(), map: Arc::new(map), obstacles, free, free_cells }
    }
}
