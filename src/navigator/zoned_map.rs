//! An occupancy grid with its zones, and the distances of decisions on it.

use std::sync::{Arc, OnceLock};

use super::NavigationMap;
use crate::local::{ClearanceField, ProblemError};
use crate::map::{MaskError, OccupancyGrid, UnknownPolicy, Zones};

/// An occupancy grid with its zones. It measures its distances to obstacles once for each policy of unknown cells, at the first
/// decision with that policy.
#[derive(Debug)]
pub struct ZonedMap {
    /// The cells.
    pub grid: Arc<OccupancyGrid>,
    /// Zones on the same cells, if there are any.
    pub zones: Option<Arc<Zones>>,
    fields: [OnceLock<Arc<ClearanceField>>; 2],
}

impl ZonedMap {
    /// Creates a map from a grid and zones on its cells.
    #[must_use]
    pub fn new(grid: impl Into<Arc<OccupancyGrid>>, zones: Option<Arc<Zones>>) -> Self {
        Self { grid: grid.into(), zones, fields: Default::default() }
    }

    /// This map with the zones of two masks, as in [`Zones::from_masks`], in addition to its own.
    ///
    /// # Errors
    /// A mask makes no zones on this map.
    pub fn with_masks(
        &self,
        keepout: Option<&OccupancyGrid>,
        speed: Option<&OccupancyGrid>,
    ) -> Result<Self, MaskError> {
        let zones = Zones::from_masks(self.grid.frame(), self.zones.as_deref(), keepout, speed)?;
        Ok(Self::new(Arc::clone(&self.grid), zones.map(Arc::new)))
    }

    /// The map for a navigator.
    #[must_use]
    pub fn navigation_map(&self, unknown: UnknownPolicy) -> NavigationMap {
        NavigationMap { obstacles: self.grid.obstacles(unknown), zones: self.zones.clone() }
    }

    /// The distances to the obstacles and closed zones.
    ///
    /// # Errors
    /// The resolution is out of range.
    pub fn field(&self, unknown: UnknownPolicy) -> Result<&Arc<ClearanceField>, ProblemError> {
        let field = &self.fields[usize::from(unknown == UnknownPolicy::Free)];
        if let Some(field) = field.get() {
            return Ok(field);
        }
        let measured = ClearanceField::new(&self.navigation_map(unknown).closed())?;
        Ok(field.get_or_init(|| Arc::new(measured)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;

    #[test]
    fn distances_are_measured_once_for_each_policy_of_unknown_cells() {
        let map = OccupancyGrid::from_rows(&["......", "...??."], 0.5, Pose::default());
        let map = ZonedMap::new(map.expect("a map"), None);
        let fields = [UnknownPolicy::Blocked, UnknownPolicy::Free]
            .map(|unknown| [(); 2].map(|()| Arc::as_ptr(map.field(unknown).expect("a field"))));
        assert!(fields.iter().all(|[first, again]| first == again));
        assert_ne!(fields[0], fields[1]);
    }
}
