//! Masks of zones, as users give them: maps whose values are those of Nav2's costmap filters.

use thiserror::Error;

use super::{GridFrame, OccupancyGrid, Zones};
use crate::geometry::Point;

/// A mask of zones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mask {
    /// Its occupied cells are closed.
    Keepout,
    /// Its values limit the speed.
    Speed,
}

impl core::fmt::Display for Mask {
    fn fmt(&self, out: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        out.write_str(match self {
            Self::Keepout => "keepout",
            Self::Speed => "speed",
        })
    }
}

/// What is wrong with a mask. Each message says what to change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum MaskFault {
    /// The two do not overlap.
    #[error("the mask does not lie on the map: give it the origin of the map")]
    OffMap,
    /// A keepout mask without an occupied cell on the map.
    #[error("no cell of the map is closed: the mask must have occupied cells, of 100 percent")]
    NothingClosed,
    /// A speed mask with an occupied cell.
    #[error(
        "a cell is 100 percent, a limit of zero: close the zone with a keepout mask; if the cell was to have a limit, set \
         `mode: scale` and `occupied_thresh: 1.0` in the mask"
    )]
    LimitOfZero,
    /// A speed mask without a limit on the map.
    #[error("no cell of the map has a limit: the mask must have values above 0 (`mode: scale`)")]
    NoLimit,
}

/// Why a mask makes no zones.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("{mask}: {fault}")]
pub struct MaskError {
    /// Which one.
    pub mask: Mask,
    /// What is wrong with it.
    pub fault: MaskFault,
}

impl Zones {
    /// The zones of two masks on a map, in addition to `earlier` ones of this map; none without any. The masks may have another size
    /// and resolution than the map.
    ///
    /// Occupied cells of `keepout` are closed. A value of 30 in `speed` limits the speed to 70 percent of the largest, as with
    /// `base: 100.0` and `multiplier: -1.0` of Nav2's speed filter.
    ///
    /// # Errors
    /// [`MaskError`] for a mask that closes or limits nothing, or has a limit of zero.
    ///
    /// # Panics
    /// Panics if the earlier zones have another number of cells than the map.
    pub fn from_masks(
        map: &GridFrame,
        earlier: Option<&Self>,
        keepout: Option<&OccupancyGrid>,
        speed: Option<&OccupancyGrid>,
    ) -> Result<Option<Self>, MaskError> {
        let mut zones = Self::new(map);
        for (mask, grid) in [(Mask::Keepout, keepout), (Mask::Speed, speed)] {
            let added = grid.map_or(Ok(()), |grid| zones.add_mask(mask, grid));
            added.map_err(|fault| MaskError { mask, fault })?;
        }
        if let Some(earlier) = earlier {
            zones.add(earlier);
        }
        let has_any = earlier.is_some() || keepout.is_some() || speed.is_some();
        Ok(has_any.then_some(zones))
    }

    fn add_mask(&mut self, mask: Mask, grid: &OccupancyGrid) -> Result<(), MaskFault> {
        match mask {
            Mask::Keepout => self.add_keepout_mask(grid),
            Mask::Speed if grid.cells().iter().any(|&value| value >= 100) => {
                Err(MaskFault::LimitOfZero)
            }
            Mask::Speed => {
                self.add_speed_mask(grid, |value| (value > 0).then(|| 100.0 - f64::from(value)))
            }
        }
    }

    /// Closes what a mask closes, as [`Self::close`].
    pub(crate) fn add_keepout_mask(&mut self, mask: &OccupancyGrid) -> Result<(), MaskFault> {
        self.check_place(mask)?;
        self.close(mask);
        if self.is_open() { Err(MaskFault::NothingClosed) } else { Ok(()) }
    }

    /// Limits the speed by a mask, as [`Self::limit_speed`].
    pub(crate) fn add_speed_mask(
        &mut self,
        mask: &OccupancyGrid,
        percent: impl Fn(i8) -> Option<f64>,
    ) -> Result<(), MaskFault> {
        self.check_place(mask)?;
        self.limit_speed(mask, percent);
        if self.has_speed_limits() { Ok(()) } else { Err(MaskFault::NoLimit) }
    }

    fn check_place(&self, mask: &OccupancyGrid) -> Result<(), MaskFault> {
        let (map, mask) = (self.frame(), mask.frame());
        let overlap = !is_beside(map, mask) && !is_beside(mask, map);
        if overlap { Ok(()) } else { Err(MaskFault::OffMap) }
    }
}

/// Whether all of a grid lies beyond one side of another. Two rectangles overlap if none of their sides separates them.
fn is_beside(grid: &GridFrame, other: &GridFrame) -> bool {
    let corners = grid.corners().map(|corner| other.to_cell_units(&corner));
    let is_beyond = |along: fn(&Point) -> f64, size: i32| {
        corners.iter().all(|corner| along(corner) <= 0.0)
            || corners.iter().all(|corner| along(corner) >= f64::from(size))
    };
    is_beyond(|corner| corner.x, other.width) || is_beyond(|corner| corner.y, other.height)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;

    fn grid(x: f64, cells: [i8; 3]) -> OccupancyGrid {
        let frame = GridFrame::new(3, 1, 1.0, Pose::new(x, 0.0, 0.0)).expect("a valid size");
        OccupancyGrid::new(frame, cells.to_vec())
    }

    #[test]
    fn masks_close_and_limit_or_say_why_not() {
        let map = grid(0.0, [0; 3]);
        let of = |keepout: Option<&OccupancyGrid>, speed: Option<&OccupancyGrid>| {
            Zones::from_masks(map.frame(), None, keepout, speed)
        };
        let closed = |mask: OccupancyGrid| of(Some(&mask), None).map_err(|error| error.fault);
        let limited = |mask: OccupancyGrid| of(None, Some(&mask)).map_err(|error| error.fault);
        assert_eq!(closed(grid(9.0, [100; 3])), Err(MaskFault::OffMap));
        assert_eq!(closed(grid(0.0, [99, -1, 0])), Err(MaskFault::NothingClosed));
        assert_eq!(limited(grid(0.0, [0, -1, 0])), Err(MaskFault::NoLimit));
        assert_eq!(limited(grid(0.0, [30, 0, 100])), Err(MaskFault::LimitOfZero));
        assert_eq!(of(None, None), Ok(None));
        let masks = [grid(1.0, [0, 100, 0]), grid(0.0, [30, 0, 0])];
        let zones = of(Some(&masks[0]), Some(&masks[1])).expect("valid masks").expect("zones");
        assert_eq!(zones.closed().cells(), [false, false, true]);
        assert_eq!(zones.speed_limit(&Point::new(0.5, 0.5), 2.0), Some(1.4));
        let strip = GridFrame::new(1, 9, 1.0, Pose::new(1.0, -4.0, 0.0)).expect("a valid size");
        let strip = OccupancyGrid::new(strip, vec![100; 9]);
        let zones = of(Some(&strip), None).expect("no corner, but an overlap").expect("zones");
        assert_eq!(zones.closed().cells(), [false, true, false]);
        let diagonal = GridFrame::new(2, 2, 1.0, Pose::new(3.7, 0.0, 0.5)).expect("a valid size");
        let beside = closed(OccupancyGrid::new(diagonal, vec![100; 4]));
        assert_eq!(beside, Err(MaskFault::OffMap), "its bounding box overlaps");
        let error = of(Some(&masks[0]), Some(&masks[0])).expect_err("a limit of zero");
        assert!(error.to_string().starts_with("speed: a cell is 100 percent"), "{error}");
    }

    #[test]
    fn masks_of_two_calls_make_the_zones_of_one() {
        let map = grid(0.0, [0; 3]);
        let of = |earlier: Option<&Zones>, keepout, speed| {
            Zones::from_masks(map.frame(), earlier, keepout, speed).expect("valid masks")
        };
        let (keepout, speed) = (grid(0.0, [0, 100, 0]), grid(0.0, [30, 30, 60]));
        let both = of(None, Some(&keepout), Some(&speed));
        let closed = of(None, Some(&keepout), None);
        let slow = of(None, None, Some(&speed));
        assert_eq!(of(closed.as_ref(), None, Some(&speed)), both);
        assert_eq!(of(slow.as_ref(), Some(&keepout), None), both);
        assert_eq!(of(both.as_ref(), None, None), both);
        // Of two limits the lower counts.
        let other = of(slow.as_ref(), None, Some(&grid(0.0, [50, 10, 0]))).expect("zones");
        assert_eq!(other.grid().cells(), [50, 70, 40]);
    }
}
