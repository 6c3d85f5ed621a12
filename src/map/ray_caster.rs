//! The first obstacle along a straight ray.

use multiversion::multiversion;

use super::{DistanceField, GridFrame, ObstacleGrid};
use crate::geometry::Point;

/// A ray crosses the free cells around it at once where they reach at least this far, cells; otherwise it takes the next cell.
const WORTH_SKIPPING: u8 = 4;
/// Far more than the rounding of the distances along a ray, cells.
const SKIP_MARGIN: f64 = 0.01;
/// Rays that are followed at once.
const LANES: usize = 8;
/// What [`RayCaster::free`] holds for an obstacle, and for the border outside the grid.
const BLOCKED: u8 = 0;

/// Where a ray ends, metres from its start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum RayEnd {
    /// At the first obstacle.
    Blocked(f64),
    /// Where it leaves the grid.
    Outside(f64),
    /// At its longest range.
    Free,
}

/// Casts rays among the obstacles of a grid.
///
/// The traversal and its distances are the same, bit for bit, as with single steps (Amanatides and Woo 1987). In free space a ray may
/// cross several borders of one axis at once, because the order of the borders of the two axes does not matter there.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RayCaster {
    frame: GridFrame,
    /// How many cells are free around any point of each cell, rounded down; at least one where the cell is free. One cell of
    /// border on each side.
    free: Vec<u8>,
    stride: usize,
}

impl RayCaster {
    /// Prepares the obstacles of a grid. Everything outside is solid.
    pub fn new(obstacles: &ObstacleGrid) -> Self {
        let mut caster = Self::without_free_cells(*obstacles.frame());
        DistanceField::for_each_row(obstacles, |row, squared| caster.set_row(row, squared));
        caster
    }

    /// As [`Self::new`], from the distance field of the grid.
    #[cfg(feature = "sim")]
    pub fn of_field(field: &DistanceField) -> Self {
        let frame = *field.frame();
        let mut caster = Self::without_free_cells(frame);
        let rows = field.squared_cells().chunks_exact(frame.width as usize);
        rows.enumerate().for_each(|(row, squared)| caster.set_row(row, squared));
        caster
    }

    fn without_free_cells(frame: GridFrame) -> Self {
        let stride = frame.width as usize + 2;
        Self { frame, free: vec![BLOCKED; stride * (frame.height as usize + 2)], stride }
    }

    /// Sets the free cells of a row by its squared distances to the nearest obstacle.
    fn set_row(&mut self, row: usize, squared: &[u32]) {
        let last_row = self.frame.height as usize - 1;
        let last_column = squared.len() - 1;
        let to_border = row.min(last_row - row);
        let cells = &mut self.free[(row + 1) * self.stride + 1..][..squared.len()];
        for (column, (cell, &squared)) in cells.iter_mut().zip(squared).enumerate() {
            if squared > 0 {
                let to_border = to_border.min(column).min(last_column - column) as f64;
                let free = DistanceField::free_cells(squared).min(to_border);
                *cell = free.clamp(1.0, f64::from(u8::MAX)) as u8;
            }
        }
    }

    /// Follows a ray from a finite point in a direction of the map frame, radians, to its longest range, metres.
    #[cfg(any(feature = "sim", test))]
    pub fn cast(&self, start: &Point, direction: f64, longest_m: f64) -> RayEnd {
        let [end] = follow(self, &[(*start, direction)], longest_m);
        end
    }

    /// As [`Self::cast`] for each of these starts and directions.
    pub fn cast_all(&self, rays: &[(Point, f64)], longest_m: f64) -> Vec<RayEnd> {
        let (groups, rest) = rays.as_chunks::<LANES>();
        let mut ends = Vec::with_capacity(rays.len());
        groups.iter().for_each(|group| ends.extend(follow(self, group, longest_m)));
        rest.iter().for_each(|ray| ends.extend(follow(self, &[*ray], longest_m)));
        ends
    }

    /// What a ray finds in a cell that it enters at a distance, in cells, or up to where it crosses free cells at once.
    #[inline(always)]
    fn look(&self, index: usize, entered: f64, longest: f64) -> Result<f64, RayEnd> {
        if entered > longest {
            return Err(RayEnd::Free);
        }
        match self.free[index] {
            BLOCKED => {
                let range_m = entered * self.frame.resolution_m;
                let is_outside = self.is_border(index);
                Err(if is_outside { RayEnd::Outside(range_m) } else { RayEnd::Blocked(range_m) })
            }
            free if free >= WORTH_SKIPPING => Ok(entered + f64::from(free) - SKIP_MARGIN),
            _ => Ok(f64::NEG_INFINITY),
        }
    }

    const fn is_border(&self, index: usize) -> bool {
        let (row, column) = (index / self.stride, index % self.stride);
        row == 0
            || column == 0
            || column + 1 == self.stride
            || index + self.stride >= self.free.len()
    }
}

/// Crossings of a ray with the cell borders of one axis.
pub(super) struct Crossing {
    /// -1, 0 or 1 cells.
    step: i32,
    /// Distance to the next border; infinite for a ray across the axis.
    pub(super) next: f64,
    /// Distance between two borders.
    pitch: f64,
}

impl Crossing {
    pub(super) fn new(start: f64, direction: f64) -> Self {
        let within = start - start.floor();
        if direction > 0.0 {
            Self { step: 1, next: (1.0 - within) / direction, pitch: 1.0 / direction }
        } else if direction < 0.0 {
            Self { step: -1, next: within / -direction, pitch: 1.0 / -direction }
        } else {
            Self { step: 0, next: f64::INFINITY, pitch: f64::INFINITY }
        }
    }

    /// Crosses the next border; returns its distance.
    pub(super) fn cross(&mut self, coordinate: &mut i32) -> f64 {
        *coordinate = coordinate.saturating_add(self.step);
        let at = self.next;
        self.next += self.pitch;
        at
    }
}

/// Follows several rays at once, compiled for the widest vectors of the processor. A ray in a wide space crosses many borders, one
/// addition after the other: those of other rays fill the time.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn follow<const N: usize>(
    caster: &RayCaster,
    rays: &[(Point, f64); N],
    longest_m: f64,
) -> [RayEnd; N] {
    let frame = &caster.frame;
    let longest = longest_m / frame.resolution_m;
    let mut ends = [RayEnd::Outside(0.0); N];
    let mut is_open = [false; N];
    let mut index = [0.0; N];
    let mut entered = [0.0; N];
    let (mut columns, mut rows) = (Crossings::<N>::none(), Crossings::<N>::none());
    for (lane, (start, direction)) in rays.iter().enumerate() {
        let start = frame.to_cell_units(start);
        let Some(cell) = frame.cell_at_units(&start) else {
            continue;
        };
        let (sin, cos) = libm::sincos(direction - frame.origin.yaw);
        is_open[lane] = true;
        let stride = caster.stride as f64;
        index[lane] = f64::from(cell.row + 1) * stride + f64::from(cell.column + 1);
        columns.set(lane, &Crossing::new(start.x, cos), 1.0);
        rows.set(lane, &Crossing::new(start.y, sin), stride);
    }
    while is_open != [false; N] {
        let mut free_to = [f64::NEG_INFINITY; N];
        for lane in 0..N {
            if is_open[lane] {
                match caster.look(index[lane] as usize, entered[lane], longest) {
                    Ok(distance) => free_to[lane] = distance,
                    Err(end) => {
                        ends[lane] = end;
                        is_open[lane] = false;
                    }
                }
            }
        }
        cross_up_to(&mut columns, &mut rows, &free_to, &mut index);
        for lane in 0..N {
            let is_column = columns.next[lane] <= rows.next[lane];
            let is_row = !is_column;
            entered[lane] = if is_column { columns.next[lane] } else { rows.next[lane] };
            columns.cross_if(lane, is_open[lane] & is_column, &mut index);
            rows.cross_if(lane, is_open[lane] & is_row, &mut index);
        }
    }
    ends
}

/// Crosses the borders up to the distance of each ray.
#[inline(always)]
fn cross_up_to<const N: usize>(
    columns: &mut Crossings<N>,
    rows: &mut Crossings<N>,
    distances: &[f64; N],
    index: &mut [f64; N],
) {
    loop {
        let mut is_any = false;
        for (lane, &distance) in distances.iter().enumerate() {
            let column = columns.next[lane] <= distance;
            let row = rows.next[lane] <= distance;
            columns.cross_if(lane, column, index);
            rows.cross_if(lane, row, index);
            is_any |= column | row;
        }
        if !is_any {
            return;
        }
    }
}

/// [`Crossing`] of several rays; steps are those of the index. They have the type of the distances: a comparison of distances then
/// selects them without a conversion.
struct Crossings<const N: usize> {
    step: [f64; N],
    next: [f64; N],
    pitch: [f64; N],
}

impl<const N: usize> Crossings<N> {
    const fn none() -> Self {
        Self { step: [0.0; N], next: [f64::INFINITY; N], pitch: [0.0; N] }
    }

    fn set(&mut self, lane: usize, crossing: &Crossing, stride: f64) {
        self.step[lane] = f64::from(crossing.step) * stride;
        self.next[lane] = crossing.next;
        self.pitch[lane] = crossing.pitch;
    }

    /// Crosses the next border of a ray, or stays.
    #[inline(always)]
    fn cross_if(&mut self, lane: usize, crosses: bool, index: &mut [f64; N]) {
        index[lane] += if crosses { self.step[lane] } else { 0.0 };
        self.next[lane] += if crosses { self.pitch[lane] } else { 0.0 };
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;
    use crate::geometry::{Pose, Vector};
    use crate::map::GridRay;

    /// Where a ray ends by single steps of the traversal.
    fn stepped(obstacles: &ObstacleGrid, start: &Point, direction: f64, longest_m: f64) -> RayEnd {
        let frame = obstacles.frame();
        let (sin, cos) = libm::sincos(direction - frame.origin.yaw);
        let ray = GridRay::new(&frame.to_cell_units(start), &Vector::new(cos, sin));
        for (cell, entered) in ray {
            if entered > longest_m / frame.resolution_m {
                return RayEnd::Free;
            }
            let range_m = entered * frame.resolution_m;
            if !frame.contains(cell) {
                return RayEnd::Outside(range_m);
            }
            if obstacles.is_blocked(cell) {
                return RayEnd::Blocked(range_m);
            }
        }
        RayEnd::Free
    }

    #[test]
    fn ray_ends_where_single_steps_end_to_the_bit() {
        let mut random = Pcg64Mcg::seed_from_u64(7);
        for (share, origin) in [(0.0, 0.0), (0.002, 0.4), (0.03, -2.0), (0.3, 0.0)] {
            let frame = GridFrame::new(130, 90, 0.05, Pose::new(1.0, -2.0, origin));
            let frame = frame.expect("a valid size");
            let obstacles = ObstacleGrid::from_fn(frame, |_| random.random::<f64>() < share);
            let caster = RayCaster::new(&obstacles);
            #[cfg(feature = "sim")]
            assert_eq!(caster, RayCaster::of_field(&DistanceField::new(&obstacles)));
            let mut ends = [0; 3];
            let (mut rays, mut single) = (Vec::new(), Vec::new());
            for case in 0..4000 {
                // Starts on corners of cells, and directions along the axes, are ties.
                let place = |random: &mut Pcg64Mcg, cells: f64| {
                    let at = random.random::<f64>() * (cells + 4.0) - 2.0;
                    0.05 * if case % 4 == 0 { at.floor() } else { at }
                };
                let local = Point::new(place(&mut random, 130.0), place(&mut random, 90.0));
                let start = frame.origin.transform(&local);
                let turn = if case % 5 == 0 { f64::from(case / 5) } else { random.random() };
                let direction = origin + turn * core::f64::consts::FRAC_PI_4 * 8.0;
                let end = caster.cast(&start, direction, 2.5);
                assert_eq!(
                    end,
                    stepped(&obstacles, &start, direction, 2.5),
                    "{start:?} {direction}"
                );
                rays.push((start, direction));
                single.push(end);
                ends[match end {
                    RayEnd::Blocked(_) => 0,
                    RayEnd::Outside(_) => 1,
                    RayEnd::Free => 2,
                }] += 1;
            }
            assert_eq!(caster.cast_all(&rays[..3999], 2.5), single[..3999], "at once");
            assert!(ends[1] > 0 && (ends[0] > 0) == (share > 0.0), "{ends:?}");
        }
    }
}
