//! The navigator's map: obstacles and zones.

use std::sync::Arc;

use crate::map::{ObstacleGrid, Zones};

/// A map for navigation.
#[derive(Clone, Debug)]
pub struct NavigationMap {
    /// What a lidar sees, and what the robot must not touch.
    pub obstacles: ObstacleGrid,
    /// Zones on the same cells, if there are any.
    pub zones: Option<Arc<Zones>>,
}

impl From<ObstacleGrid> for NavigationMap {
    fn from(obstacles: ObstacleGrid) -> Self {
        Self { obstacles, zones: None }
    }
}

impl NavigationMap {
    /// Obstacles and closed zones: where no path leads.
    #[must_use]
    pub fn closed(&self) -> ObstacleGrid {
        match &self.zones {
            Some(zones) => zones.with_obstacles(&self.obstacles),
            None => self.obstacles.clone(),
        }
    }
}
