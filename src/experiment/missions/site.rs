//! A map to drive on.

use std::sync::Arc;

use crate::digest::BitDigest;
use crate::map::{Cell, FreeSpace, ObstacleGrid, OccupancyGrid};
use crate::runtime::Config;

/// A map, and where the robot's origin may be on it.
#[derive(Clone, Debug)]
pub struct MissionSite {
    /// What it is called in rows; no two of a campaign have the same name.
    pub name: String,
    /// The ground as the robot knows it.
    pub map: Arc<OccupancyGrid>,
    /// What blocks on it.
    pub obstacles: ObstacleGrid,
    /// Where the robot's origin keeps the least distance of a global path from every obstacle.
    pub free: FreeSpace,
    /// The free cells that are not at the map's rim, ascending, by their positions in storage.
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
        // Beyond the map everything is an obstacle to a robot, though not to free space.
        let rim = (planner.least_radius_m() / frame.resolution_m).ceil() as i32;
        let is_inner = |cell: Cell| {
            (rim..frame.width - rim).contains(&cell.column)
                && (rim..frame.height - rim).contains(&cell.row)
        };
        let free_cells = (0..frame.len())
            .filter(|&index| free.is_free(frame.cell_at(index)) && is_inner(frame.cell_at(index)))
            .collect();
        Self {
            name: name.to_owned(),
            map: Arc::new(map),
            obstacles,
            free,
            free_cells,
        }
    }

    /// Its name and a digest of its ground: another map, another name.
    #[must_use]
    pub fn identity(&self) -> (String, String) {
        let mut digest = BitDigest::default();
        let frame = self.map.frame();
        for value in [
            frame.resolution_m,
            frame.origin.x,
            frame.origin.y,
            frame.origin.yaw,
        ] {
            digest.real(value);
        }
        digest.wide(frame.width as u64);
        for &cell in self.obstacles.cells() {
            digest.word(u32::from(cell));
        }
        (self.name.clone(), digest.hex())
    }
}
