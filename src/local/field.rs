//! The distance field as the engines read it: 16 bits a cell, in the engines' own unit of length.

use core::sync::atomic::{AtomicU64, Ordering};

use super::ProblemError;
use crate::geometry::Pose;
use crate::map::{DistanceField, GridFrame, ObstacleGrid};
use crate::robot::Footprint;

/// Distance from each cell's centre to the centre of the nearest obstacle cell, in whole units of length.
///
/// The unit is the cell's side divided by a power of two, the first that is at most 1/4096 m: so it lies between
/// 0.122 mm and 0.244 mm, a position in units becomes a cell by a shift, and 16 bits hold at least 8 m. Longer
/// distances, and those of a grid without obstacles, are stored as 65535.
#[derive(Debug)]
pub struct ClearanceField {
    frame: GridFrame,
    cell_bits: u32,
    /// One entry more than there are cells.
    units: Vec<u16>,
    id: u64,
}

/// Resolutions that the engines accept, metres.
pub const RESOLUTION_RANGE_M: (f64, f64) = (0.001, 2.0);

/// Fields made so far; each has its own number, so an engine knows whether it holds this one already.
static NEXT_ID: AtomicU64 = AtomicU64::new(1);

impl ClearanceField {
    /// The field of an obstacle grid.
    ///
    /// # Errors
    /// When the cells are smaller than 1 mm or larger than 2 m.
    pub fn new(obstacles: &ObstacleGrid) -> Result<Self, ProblemError> {
        let frame = *obstacles.frame();
        let (least, most) = RESOLUTION_RANGE_M;
        if !(least..=most).contains(&frame.resolution_m) {
            return Err(ProblemError::OutOfRange {
                quantity: "map resolution",
                value: frame.resolution_m,
                unit: "m",
                limit: "0.001 to 2 m",
            });
        }
        let mut cell_bits = 0;
        while frame.resolution_m * 4096.0 > f64::from(1_u32 << cell_bits) {
            cell_bits += 1;
        }
        let units_per_cell = f64::from(1_u32 << cell_bits);
        let in_units = |&squared: &u32| {
            let units = (f64::from(squared).sqrt() * units_per_cell).round();
            units.min(f64::from(u16::MAX)) as u16
        };
        let field = DistanceField::new(obstacles);
        Ok(Self {
            frame,
            cell_bits,
            units: field
                .squared_cells()
                .iter()
                .map(in_units)
                .chain([0])
                .collect(),
            id: NEXT_ID.fetch_add(1, Ordering::Relaxed),
        })
    }

    /// Size and placement.
    #[must_use]
    pub const fn frame(&self) -> &GridFrame {
        &self.frame
    }

    /// The unit of length, metres.
    #[must_use]
    pub fn unit_m(&self) -> f64 {
        self.frame.resolution_m / f64::from(1_u32 << self.cell_bits)
    }

    /// A cell's side is two to this power of units.
    #[must_use]
    pub const fn cell_bits(&self) -> u32 {
        self.cell_bits
    }

    /// Distances in units, row-major, lowest row first.
    #[must_use]
    pub fn units(&self) -> &[u16] {
        &self.units[..self.frame.len()]
    }

    /// [`Self::units`] and one entry more, for vectors that read two entries at a time.
    #[must_use]
    pub(super) fn padded_units(&self) -> &[u16] {
        &self.units
    }

    /// Clearance of a footprint at a pose, metres, as the engines see it: the distance stored for the cell under each
    /// disc's centre, less its radius; the smallest of all discs. None where a centre is off the field.
    #[must_use]
    pub fn clearance_m(&self, footprint: &Footprint, pose: &Pose) -> Option<f64> {
        let mut least = f64::INFINITY;
        for (center, radius_m) in footprint.at(pose) {
            let units = self.units[self.frame.index(self.frame.cell_of(&center)?)];
            least = least.min(f64::from(units) * self.unit_m() - radius_m);
        }
        Some(least)
    }

    /// A number that no other field of this process has.
    #[must_use]
    pub const fn id(&self) -> u64 {
        self.id
    }
}
