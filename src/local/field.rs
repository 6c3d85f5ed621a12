//! The distance field in the format of the engines: 16 bits per cell, in the engines' unit of length.

use core::sync::atomic::{AtomicU64, Ordering};

use multiversion::multiversion;

use super::ProblemError;
use crate::geometry::Pose;
use crate::map::{DistanceField, GridFrame, ObstacleGrid};
use crate::robot::Footprint;

/// Distance from each cell to the nearest obstacle cell, in whole units of length: from centre to centre, or between areas.
///
/// The unit is the cell's side divided by a power of two, the first result that is at most 1/4096 m. It is 0.122 to
/// 0.244 mm; a shift converts a position in units to a cell; 16 bits hold at least 8 m. Longer distances, and all
/// distances of a grid without obstacles, are stored as 65535.
#[derive(Debug)]
pub struct ClearanceField {
    frame: GridFrame,
    cell_bits: u32,
    /// One entry more than there are cells.
    units: Vec<u16>,
    id: u64,
}

/// Accepted resolutions, metres.
pub const RESOLUTION_RANGE_M: (f64, f64) = (0.001, 2.0);

/// The id of the next field. Ids are unique in the process: an engine compares them to find whether it holds a field.
static NEXT_ID: AtomicU64 = AtomicU64::new(1);

impl ClearanceField {
    /// Computes the field of an obstacle grid: the distance from the centre of each cell to the centre of the nearest obstacle
    /// cell. The true distance from a point of the cell to the obstacle's square may be less, by up to the diagonal of a cell.
    ///
    /// # Errors
    /// When the cells are smaller than 1 mm or larger than 2 m.
    pub fn new(obstacles: &ObstacleGrid) -> Result<Self, ProblemError> {
        let (cell_bits, units) = distances(obstacles)?;
        Ok(Self::of(*obstacles.frame(), cell_bits, units))
    }

    /// Computes lower bounds of the true distances: from any point of a cell to the nearest point of any obstacle cell's
    /// square, to half a unit. A disc that is clear in this field is clear of every square.
    ///
    /// Divides each cell of the grid into `parts` by `parts` cells. The bound is below the distance of a point by less than
    /// the diagonal of such a part. Only cells of obstacles have the distance zero.
    ///
    /// # Errors
    /// When the cells of the grid, or their parts, are smaller than 1 mm or larger than 2 m.
    pub fn of_areas(obstacles: &ObstacleGrid, parts: u16) -> Result<Self, ProblemError> {
        let parts = usize::from(parts.max(1));
        // A cell nearer than one cell to an obstacle's cell may touch it. Distances between areas are distances between
        // centres to the obstacles with all their neighbours.
        let grown = grown_in_parts(obstacles, parts);
        let (cell_bits, mut units) = distances(&grown)?;
        let frame = *grown.frame();
        let (width, coarse_width) = (frame.width as usize, obstacles.frame().width as usize);
        let mut line = vec![false; width];
        let rows = units[..frame.len()].chunks_exact_mut(parts * width);
        for (rows, blocked) in rows.zip(obstacles.cells().chunks_exact(coarse_width)) {
            divide(blocked, parts, &mut line);
            rows.chunks_exact_mut(width).for_each(|row| raise_free(row, &line));
        }
        Ok(Self::of(frame, cell_bits, units))
    }

    fn of(frame: GridFrame, cell_bits: u32, units: Vec<u16>) -> Self {
        Self { frame, cell_bits, units, id: NEXT_ID.fetch_add(1, Ordering::Relaxed) }
    }

    /// Size and pose of the grid.
    #[must_use]
    pub const fn frame(&self) -> &GridFrame {
        &self.frame
    }

    /// The unit of length, metres.
    #[must_use]
    #[inline]
    pub fn unit_m(&self) -> f64 {
        self.frame.resolution_m / f64::from(1_u32 << self.cell_bits)
    }

    /// The side of a cell is two to this power of units.
    #[must_use]
    pub const fn cell_bits(&self) -> u32 {
        self.cell_bits
    }

    /// Distances in units, row-major, lowest row first.
    #[must_use]
    pub fn units(&self) -> &[u16] {
        &self.units[..self.frame.len()]
    }

    /// [`Self::units`] and one more entry, for vector loads of two entries.
    #[must_use]
    pub(super) fn padded_units(&self) -> &[u16] {
        &self.units
    }

    /// Clearance of a footprint at a pose, metres, as the engines compute it: the smallest, over all discs, of the
    /// distance at the cell under the disc's centre minus the radius. `None` when a centre is off the field.
    #[must_use]
    pub fn clearance_m(&self, footprint: &Footprint, pose: &Pose) -> Option<f64> {
        let mut least = f64::INFINITY;
        for (center, radius_m) in footprint.at(pose) {
            let units = self.units[self.frame.index(self.frame.cell_of(&center)?)];
            least = least.min(f64::from(units) * self.unit_m() - radius_m);
        }
        Some(least)
    }

    /// The id of the field, unique in this process.
    #[doc(hidden)]
    #[must_use]
    pub const fn id(&self) -> u64 {
        self.id
    }
}

/// The base-2 logarithm of the units per cell, and the distance between the centres of each cell and of the nearest obstacle
/// cell in units, with one more entry.
fn distances(obstacles: &ObstacleGrid) -> Result<(u32, Vec<u16>), ProblemError> {
    let frame = *obstacles.frame();
    let (min, max) = RESOLUTION_RANGE_M;
    if !(min..=max).contains(&frame.resolution_m) {
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
    let width = frame.width as usize;
    let mut units = vec![0; frame.len() + 1];
    DistanceField::for_each_row(obstacles, |row, squared| {
        all_in_units(squared, cell_bits, &mut units[row * width..][..width]);
    });
    Ok((cell_bits, units))
}

/// A grid with each cell divided into `parts` by `parts`, and each obstacle grown by one part to all sides.
fn grown_in_parts(obstacles: &ObstacleGrid, parts: usize) -> ObstacleGrid {
    let coarse = obstacles.frame();
    let (columns, rows) = (coarse.width as usize, coarse.height as usize);
    let frame = GridFrame {
        width: coarse.width * parts as i32,
        height: coarse.height * parts as i32,
        resolution_m: coarse.resolution_m / parts as f64,
        origin: coarse.origin,
    };
    let width = columns * parts;
    let mut cells = vec![false; frame.len()];
    let (mut line, mut grown) = (vec![false; width], vec![false; width]);
    for (row, blocked) in obstacles.cells().chunks_exact(columns).enumerate() {
        if !blocked.contains(&true) {
            continue;
        }
        divide(blocked, parts, &mut line);
        grown.copy_from_slice(&line);
        join(&mut grown[1..], &line);
        join(&mut grown, &line[1..]);
        let to = ((row + 1) * parts + 1).min(rows * parts);
        for row in (row * parts).saturating_sub(1)..to {
            join(&mut cells[row * width..][..width], &grown);
        }
    }
    ObstacleGrid::new(frame, cells)
}

/// Writes each cell this many times.
fn divide(cells: &[bool], parts: usize, line: &mut [bool]) {
    if parts == 1 {
        line.copy_from_slice(cells);
        return;
    }
    line.chunks_exact_mut(parts).zip(cells).for_each(|(parts, cell)| parts.fill(*cell));
}

/// Marks the cells that other ones mark.
fn join(cells: &mut [bool], others: &[bool]) {
    cells.iter_mut().zip(others).for_each(|(cell, other)| *cell |= *other);
}

/// Raises each value that does not belong to an obstacle to at least one, with AVX2 if available.
#[multiversion(targets("x86_64+avx2"))]
fn raise_free(values: &mut [u16], is_obstacle: &[bool]) {
    let both = values.iter_mut().zip(is_obstacle);
    both.for_each(|(value, is_obstacle)| *value = (*value).max(u16::from(!is_obstacle)));
}

/// Applies [`in_units`] to a row, with AVX2 if available.
#[multiversion(targets("x86_64+avx2"))]
fn all_in_units(squared_cells: &[u32], cell_bits: u32, units: &mut [u16]) {
    for (units, &squared) in units.iter_mut().zip(squared_cells) {
        *units = in_units(squared, cell_bits);
    }
}

/// Converts a squared distance in cells to units: rounded to the nearest, at most `u16::MAX`.
///
/// The root in `f32` is off by less than one; integers correct it. The root of an integer is never midway between two integers.
#[inline(always)]
fn in_units(squared_cells: u32, cell_bits: u32) -> u16 {
    const MOST: u32 = u16::MAX as u32;
    /// Adding it rounds a float and leaves the integer in the low bits; vector instructions can do that, and cannot do `f32::round`.
    const TWO_TO_23: f32 = 8_388_608.0;
    let squared = squared_cells.min(((MOST * MOST) >> (2 * cell_bits)) + 1);
    let root = (squared as f32).sqrt() * (1_u32 << cell_bits) as f32;
    let units = ((root + TWO_TO_23).to_bits() & 0x7F_FFFF) as i32;
    // Both terms wrap alike, and their difference is small.
    let rest = (squared << (2 * cell_bits)).wrapping_sub(units.wrapping_mul(units) as u32) as i32;
    let units = units + i32::from(rest > units) - i32::from(rest <= -units);
    units.clamp(0, MOST as i32) as u16
}

#[cfg(test)]
mod tests {
    use super::in_units;

    /// The squares midway between units are `k^2 + k + 1/4`: the squares next to them are the critical ones.
    #[test]
    fn units_round_to_nearest() {
        for cell_bits in 0..=13 {
            let scale = 1_u64 << (2 * cell_bits);
            let units_of = |squared| u64::from(in_units(squared, cell_bits));
            for below in 0..65_535_u64 {
                let halfway = (below * below + below) / scale;
                for squared in halfway..halfway + 2 {
                    let units = units_of(squared as u32);
                    let square = squared * scale;
                    let least = units == 0 || square > units * units - units;
                    let most = units == 65_535 || square <= units * units + units;
                    assert!(least && most, "root of {squared} x {scale} is not {units}");
                }
            }
            assert_eq!(units_of(u32::MAX), 65_535);
            assert_eq!(units_of(0), 0);
        }
    }
}
