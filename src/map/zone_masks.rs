//! Masks of zones, as users give them: maps whose values are those of Nav2's costmap filters.

use thiserror::Error;

use super::{OccupancyGrid, Zones};

/// Why a mask makes no zones. Each message says what to change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum MaskError {
    /// No corner of one lies on the other.
    #[error("the mask does not lie on the map: give it the origin of the map")]
    OffMap,
    /// A keepout mask without an occupied cell on the map.
    #[error("no cell of the map is closed: the mask must have occupied cells, of 100 percent")]
    NothingClosed,
    /// A speed mask with an occupied cell.
    #[error(
        "a cell is 100 percent, a limit of zero: set `mode: scale` and `occupied_thresh: 1.0` in the mask, or close the zone with a \
         keepout mask"
    )]
    LimitOfZero,
    /// A speed mask without a limit on the map.
    #[error("no cell of the map has a limit: the mask must have values above 0 (`mode: scale`)")]
    NoLimit,
}

impl Zones {
    /// Closes the zones of a keepout mask: its occupied cells.
    ///
    /// # Errors
    /// [`MaskError`] for a mask that closes nothing.
    pub fn add_keepout_mask(&mut self, mask: &OccupancyGrid) -> Result<(), MaskError> {
        self.check_place(mask)?;
        self.close(mask);
        if self.is_open() { Err(MaskError::NothingClosed) } else { Ok(()) }
    }

    /// Limits the speed by a speed mask: a value of 30 is a limit of 70 percent of the largest speed, as with `base: 100.0` and
    /// `multiplier: -1.0` of Nav2's speed filter.
    ///
    /// # Errors
    /// [`MaskError`] for a mask that limits nothing, or has a limit of zero.
    pub fn add_speed_mask(&mut self, mask: &OccupancyGrid) -> Result<(), MaskError> {
        self.check_place(mask)?;
        if mask.cells().iter().any(|&value| value >= 100) {
            return Err(MaskError::LimitOfZero);
        }
        self.limit_speed(mask, |value| (value > 0).then(|| 100.0 - f64::from(value)));
        if self.has_speed_limits() { Ok(()) } else { Err(MaskError::NoLimit) }
    }

    fn check_place(&self, mask: &OccupancyGrid) -> Result<(), MaskError> {
        let (map, mask) = (self.frame(), mask.frame());
        let on_map = mask.corners().iter().any(|at| map.cell_of(at).is_some())
            || map.corners().iter().any(|at| mask.cell_of(at).is_some());
        if on_map { Ok(()) } else { Err(MaskError::OffMap) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Point, Pose};
    use crate::map::GridFrame;

    fn grid(x: f64, cells: [i8; 3]) -> OccupancyGrid {
        let frame = GridFrame::new(3, 1, 1.0, Pose::new(x, 0.0, 0.0)).expect("a valid size");
        OccupancyGrid::new(frame, cells.to_vec())
    }

    #[test]
    fn masks_close_and_limit_or_say_why_not() {
        let mut zones = Zones::new(grid(0.0, [0; 3]).frame());
        assert_eq!(zones.add_keepout_mask(&grid(9.0, [100; 3])), Err(MaskError::OffMap));
        assert_eq!(zones.add_keepout_mask(&grid(0.0, [99, -1, 0])), Err(MaskError::NothingClosed));
        assert_eq!(zones.add_speed_mask(&grid(0.0, [0, -1, 0])), Err(MaskError::NoLimit));
        assert_eq!(zones.add_speed_mask(&grid(0.0, [30, 0, 100])), Err(MaskError::LimitOfZero));
        assert_eq!(zones, Zones::new(zones.frame()));
        assert_eq!(zones.add_keepout_mask(&grid(1.0, [0, 100, 0])), Ok(()));
        assert_eq!(zones.add_speed_mask(&grid(0.0, [30, 0, 0])), Ok(()));
        assert_eq!(zones.closed().cells(), [false, false, true]);
        assert_eq!(zones.speed_limit(&Point::new(0.5, 0.5), 2.0), Some(1.4));
    }
}
