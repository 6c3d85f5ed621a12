//! Dilation of obstacles by an exact distance.

use super::bit_grid::{BitGrid, clear_padding};

/// Returns the cells whose square is nearer than `distance`, in cells, to the square of a set cell.
///
/// Set cells themselves have distance zero. A distance of zero or less gives no cell; NaN gives all cells. Each row is
/// dilated sideways once, from the farthest target row to the nearest: a row `dy` away receives the row dilated by what
/// the distance leaves at that `dy`.
pub(super) fn dilate(cells: &BitGrid, width: i32, height: i32, distance: f64) -> BitGrid {
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
    for row in 0..height {
        clear_padding(near.row_mut(row), width);
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
        core::mem::swap(&mut self.words, &mut self.spare);
    }
}
