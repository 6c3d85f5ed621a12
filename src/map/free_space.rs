//! The free configuration space of a round robot: obstacles dilated by an exact distance.

use core::{iter, mem};
use std::collections::VecDeque;

use super::bit_grid::{BitGrid, clear_padding};
use super::{Cell, GridFrame, ObstacleGrid};
use crate::geometry::Point;

/// The cells in which the centre of a round robot keeps its radius from every obstacle.
///
/// A cell is free if **every** point of its square is at least the radius away from **every** point of every obstacle
/// cell's square and of the area outside the grid, and the cell itself is no obstacle. A curve that stays on free cells
/// therefore keeps the radius from all obstacles, at any point within the cells.
///
/// Uses three bits per cell, so that a search reads 64 cells at once along rows or columns.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeSpace {
    frame: GridFrame,
    radius_m: f64,
    free: BitGrid,
    /// `free` with rows and columns exchanged.
    free_by_column: BitGrid,
    obstacles: BitGrid,
}

impl FreeSpace {
    /// Computes the free cells for a robot of this radius in metres. A negative radius counts as zero; NaN leaves no cell
    /// free.
    #[must_use]
    pub fn new(obstacles: &ObstacleGrid, radius_m: f64) -> Self {
        let [space] = Self::for_radii(obstacles, [radius_m]);
        space
    }

    /// Computes [`Self::new`] for several radii.
    #[must_use]
    pub fn for_radii<const N: usize>(obstacles: &ObstacleGrid, radii_m: [f64; N]) -> [Self; N] {
        let frame = *obstacles.frame();
        let GridFrame { width, height, .. } = frame;
        let obstacles = BitGrid::from_cells(width, height, obstacles.cells());
        radii_m.map(|radius_m| {
            let near = dilate(&obstacles, width, height, radius_m / frame.resolution_m);
            let free = near.nor(&obstacles);
            Self {
                frame,
                radius_m,
                free_by_column: free.transposed(),
                free,
                obstacles: obstacles.clone(),
            }
        })
    }

    /// Frees the cells that are free in `other` and whose centre is within a distance, metres, of a point. This lets a
    /// robot leave a place nearer to an obstacle than this space allows.
    ///
    /// # Panics
    /// Panics if the frames differ.
    pub(crate) fn free_cells_near(&mut self, other: &Self, center: &Point, distance_m: f64) {
        assert_eq!(self.frame, other.frame, "both spaces have the same frame");
        let near = self.frame.cells_within(center, distance_m);
        for cell in near.filter(|&cell| other.is_free(cell)) {
            self.free.set(cell, true);
            self.free_by_column.set(Cell::new(cell.row, cell.column), true);
        }
    }

    /// Keeps the cells that are free in `other` too.
    ///
    /// # Panics
    /// Panics if the frames differ.
    pub(crate) fn intersect(&mut self, other: &Self) {
        assert_eq!(self.frame, other.frame, "both spaces have the same frame");
        self.free.intersect(&other.free);
        self.free_by_column.intersect(&other.free_by_column);
    }

    /// Size and pose of the grid.
    #[must_use]
    pub const fn frame(&self) -> &GridFrame {
        &self.frame
    }

    /// Whether the robot's centre may be anywhere in the cell. False outside the grid.
    #[must_use]
    pub fn is_free(&self, cell: Cell) -> bool {
        self.free.get(cell)
    }

    /// Whether a disc around a point lies in the grid and keeps clear of the square of every obstacle; its radius is in metres.
    #[must_use]
    pub(crate) fn is_clear(&self, center: &Point, radius_m: f64) -> bool {
        let GridFrame { width, height, resolution_m, .. } = self.frame;
        let (at, radius) = (self.frame.to_cell_units(center), radius_m / resolution_m);
        let is_within = |at: f64, size: i32| at >= radius && at + radius <= f64::from(size);
        is_within(at.x, width)
            && is_within(at.y, height)
            // Few cells are obstacles: their bits are read before distances are computed.
            && !self.frame.cells_around(center, radius_m).any(|cell| {
                self.obstacles.get(cell) && self.frame.is_touched(&cell, center, radius_m)
            })
    }

    /// Distance kept from every obstacle, metres, except in cells freed by `free_cells_near`.
    #[must_use]
    pub const fn radius_m(&self) -> f64 {
        self.radius_m
    }

    /// Whether the cell itself is an obstacle. True outside the grid.
    #[must_use]
    pub fn is_obstacle(&self, cell: Cell) -> bool {
        !self.frame.contains(cell) || self.obstacles.get(cell)
    }

    /// The free cell whose centre is nearest to a point; the point may lie outside the grid. Ties go to the first cell in
    /// storage order. None if no cell is free.
    #[must_use]
    pub fn nearest_free(&self, point: &Point) -> Option<Cell> {
        let at = self.frame.to_cell_units(point);
        let (width, height) = (self.frame.width, self.frame.height);
        // Far outside the grid, rounding hides the differences between squared distances. They are therefore without the part that
        // all cells have in common: the square of the distance from the point to the edge.
        let edge = Point::new(at.x.clamp(0.0, width.into()), at.y.clamp(0.0, height.into()));
        let beyond = edge - at;
        let square = |offset: f64, beyond: f64| offset * (offset + 2.0 * beyond);
        // Of the columns whose centres are not right of the point, the last one.
        let column = ((at.x - 0.5).floor() as i32).clamp(0, width - 1);
        let first_row = (at.y.floor() as i32).clamp(0, height - 1);
        let mut best: Option<(f64, Cell)> = None;
        // The rows around that of the point, until none can hold a nearer cell.
        for offset in 0..height {
            let mut is_last = true;
            for row in [first_row - offset, first_row + offset] {
                let across = square(f64::from(row) + 0.5 - edge.y, beyond.y);
                let is_near = best.is_none_or(|(squared, _)| across <= squared);
                if !(0..height).contains(&row) || !is_near {
                    continue;
                }
                is_last = false;
                for column in self.free.nearest_in_row(row, column).into_iter().flatten() {
                    let cell = Cell::new(column, row);
                    let squared = square(cell.center().x - edge.x, beyond.x) + across;
                    let is_better = |(least, other): (f64, Cell)| {
                        let is_first = (row, column) < (other.row, other.column);
                        squared < least || (squared == least && is_first)
                    };
                    if best.is_none_or(is_better) {
                        best = Some((squared, cell));
                    }
                }
            }
            if is_last {
                break;
            }
        }
        best.map(|(_, cell)| cell)
    }

    /// The free cells that moves along rows and columns reach from a free cell, itself first, with the numbers of these moves in
    /// ascending order. A diagonal move needs both adjacent cells free, so these moves reach all cells that a search does. Cells
    /// that were already seen are left out.
    pub(crate) fn flood(
        &self,
        start: Cell,
        seen: &mut [bool],
    ) -> impl Iterator<Item = (Cell, u32)> {
        let frame = self.frame;
        seen[frame.index(start)] = true;
        let mut open = VecDeque::from([(start, 0)]);
        iter::from_fn(move || {
            let (cell, moves) = open.pop_front()?;
            for (right, up) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
                let next = Cell::new(cell.column + right, cell.row + up);
                if self.is_free(next) && !mem::replace(&mut seen[frame.index(next)], true) {
                    open.push_back((next, moves + 1));
                }
            }
            Some((cell, moves))
        })
    }

    /// Number of free cells.
    #[must_use]
    pub fn count(&self) -> usize {
        self.free.count()
    }

    /// The free cells by rows, and the same by columns.
    pub(crate) const fn bits(&self) -> (&BitGrid, &BitGrid) {
        (&self.free, &self.free_by_column)
    }
}

/// Returns the cells whose square is nearer than `distance`, in cells, to the square of a set cell or to the area outside the grid.
///
/// Set cells themselves have distance zero. A distance of zero or less gives no cell; NaN gives all cells. Each row is
/// dilated sideways once, from the farthest target row to the nearest: a row `dy` away receives the row dilated by what
/// the distance leaves at that `dy`.
fn dilate(cells: &BitGrid, width: i32, height: i32, distance: f64) -> BitGrid {
    if distance.is_nan() {
        let empty = BitGrid::new(width, height);
        return empty.nor(&empty);
    }
    let half_widths = half_widths(distance, width.max(height));
    let mut near = BitGrid::new(width, height);
    let mut dilated = DilatedRow::default();
    for row in 0..height {
        if cells.row(row).iter().all(|&word| word == 0) {
            continue;
        }
        dilated.reset(cells.row(row));
        for (row_offset, &half_width) in half_widths.iter().enumerate().rev() {
            dilated.grow_to(half_width);
            let row_offset = row_offset as i32;
            for target_row in [row - row_offset, row + row_offset] {
                if (0..height).contains(&target_row) {
                    let target = near.row_mut(target_row).iter_mut();
                    target.zip(&dilated.words).for_each(|(to, from)| *to |= from);
                }
            }
        }
    }
    // The cells next to the edge, as far as those next to an obstacle.
    let rim = half_widths.len().saturating_sub(1) as i32;
    let is_beside = |at: i32, size: i32| at < rim || at >= size - rim;
    let beside: Vec<bool> = (0..width).map(|column| is_beside(column, width)).collect();
    let sides = BitGrid::from_cells(width, 1, &beside);
    for row in 0..height {
        let near = near.row_mut(row);
        if is_beside(row, height) {
            near.fill(u64::MAX);
        }
        near.iter_mut().zip(sides.row(0)).for_each(|(near, side)| *near |= side);
        clear_padding(near, width);
    }
    near
}

/// For each row offset, the largest column offset at which a cell is nearer than `distance`; both at most `limit`.
/// The gap between two squares is one cell less than the distance of their centres along each axis.
fn half_widths(distance: f64, limit: i32) -> Vec<usize> {
    let gap = |offset: i32| f64::from((offset - 1).max(0));
    let squared = |dx: i32, dy: i32| gap(dx).powi(2) + gap(dy).powi(2);
    let mut half_widths = Vec::new();
    let mut half_width = limit;
    for row_offset in 0..=limit {
        while half_width >= 0 && squared(half_width, row_offset) >= distance.abs() * distance {
            half_width -= 1;
        }
        if half_width < 0 {
            break;
        }
        half_widths.push(half_width as usize);
    }
    half_widths
}

/// A row of bits that is dilated to both sides.
#[derive(Default)]
struct DilatedRow {
    words: Vec<u64>,
    spare: Vec<u64>,
    radius: usize,
}

impl DilatedRow {
    fn reset(&mut self, row: &[u64]) {
        self.words.clear();
        self.words.extend_from_slice(row);
        self.spare.resize(row.len(), 0);
        self.radius = 0;
    }

    /// Sets all bits within `radius` of a bit of the original row.
    fn grow_to(&mut self, radius: usize) {
        while self.radius < radius {
            // A run of bits shifted by at most its own length overlaps or touches the original.
            let step = (2 * self.radius + 1).min(radius - self.radius).min(63);
            self.shift_both_ways(step as u32);
            self.radius += step;
        }
    }

    /// ORs the row with itself shifted to both sides by 1 to 63 bits.
    fn shift_both_ways(&mut self, step: u32) {
        let back = u64::BITS - step;
        let last = self.words.len() - 1;
        for (index, to) in self.spare.iter_mut().enumerate() {
            let here = self.words[index];
            let before = if index > 0 { self.words[index - 1] } else { 0 };
            let behind = if index < last { self.words[index + 1] } else { 0 };
            *to = here | here << step | before >> back | here >> step | behind << back;
        }
        mem::swap(&mut self.words, &mut self.spare);
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;
    use crate::geometry::{Pose, point_to_unit_square};

    /// Against the distances to all squares and to the edge. Free cells keep their distance at any point, and half a cell more at the centre.
    #[test]
    fn disc_is_clear_of_the_squares_that_are_farther_than_its_radius() {
        let mut random = Pcg64Mcg::seed_from_u64(2);
        let mut clear = [0; 2];
        for share in [0.01, 0.05] {
            let frame = GridFrame::new(50, 40, 0.05, Pose::new(1.0, -2.0, 0.4)).expect("a size");
            let obstacles = ObstacleGrid::from_fn(frame, |_| random.random_bool(share));
            let blocked = frame.cells().filter(|&cell| obstacles.is_blocked(cell));
            let blocked: Vec<Point> = blocked.map(Cell::corner).collect();
            let radius_m = 0.17;
            let [whole, at_center] = FreeSpace::for_radii(&obstacles, [radius_m, radius_m - 0.025]);
            for _ in 0..4000 {
                let at = Point::new(random.random_range(0.0..50.0), random.random_range(0.0..40.0));
                let squared = |square: &Point| point_to_unit_square(&at, square);
                let nearest = blocked.iter().map(squared).fold(f64::INFINITY, f64::min).sqrt();
                let to_edge = at.x.min(at.y).min(50.0 - at.x).min(40.0 - at.y);
                let nearest = nearest.min(to_edge);
                let is_clear = whole.is_clear(&frame.from_cell_units(&at), radius_m);
                if (nearest * 0.05 - radius_m).abs() > 1e-9 {
                    assert_eq!(is_clear, nearest * 0.05 > radius_m, "{at:?}");
                }
                clear[usize::from(is_clear)] += 1;
                let cell = Cell::new(at.x as i32, at.y as i32);
                assert!(is_clear || !whole.is_free(cell), "{cell:?}");
                let center = frame.center_of(cell);
                assert!(!at_center.is_free(cell) || whole.is_clear(&center, radius_m - 1e-9));
            }
        }
        assert!(clear.iter().all(|&count| count > 500), "{clear:?}");
    }
}
