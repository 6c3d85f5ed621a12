//! Exact integer distance from every cell to the nearest obstacle.

mod lane;
mod row;

use super::{Cell, GridFrame, ObstacleGrid};
use row::{Reach, Row, lower};

/// The squared distance, in cells, from each cell's centre to the centre of the nearest obstacle cell.
///
/// Exact Euclidean distance transform in two passes (Meijster, Roerdink and Hesselink, 2000): first along the columns,
/// then along each row as the lower envelope of one parabola per column. All numbers are integers.
#[derive(Clone, Debug, PartialEq)]
pub struct DistanceField {
    frame: GridFrame,
    squared: Vec<u32>,
}

/// Marks a column without an obstacle: longer than any distance within a grid, and its square fits in an `i32`.
const FAR: u16 = 46_000;

impl DistanceField {
    /// The squared distance stored if the grid has no obstacle.
    pub const NO_OBSTACLE: u32 = FAR as u32 * FAR as u32;

    /// Computes the field of an obstacle grid. The area outside the grid is not an obstacle here.
    #[must_use]
    pub fn new(obstacles: &ObstacleGrid) -> Self {
        let frame = *obstacles.frame();
        let width = frame.width as usize;
        let mut squared = vec![0; frame.len()];
        Self::for_each_row(obstacles, |row, squared_cells| {
            squared[row * width..][..width].copy_from_slice(squared_cells);
        });
        Self { frame, squared }
    }

    /// Computes the squared distances of [`Self::new`] and passes each row with its index to `take`, in unspecified
    /// order. Callers that store another format avoid an intermediate copy.
    pub(crate) fn for_each_row(obstacles: &ObstacleGrid, mut take: impl FnMut(usize, &[u32])) {
        let width = obstacles.frame().width as usize;
        let mut squared = vec![Self::NO_OBSTACLE; width];
        if !obstacles.cells().contains(&true) {
            (0..obstacles.frame().height as usize).for_each(|row| take(row, &squared));
            return;
        }
        let mut reach = Reach::unknown(width);
        let (mut near, mut any) = (Row::<u16>::new(width), Row::<f64>::new(width));
        let mut heights = vec![FAR; width];
        let downwards = distance_downwards(obstacles);
        // From the highest row down, so that the distances upwards follow from the row above.
        for (row, downwards) in downwards.chunks_exact(width).enumerate().rev() {
            for (height, &below) in heights.iter_mut().zip(downwards) {
                *height = height.saturating_add(1).min(below);
            }
            if reach.is_near(width) {
                lower(&mut near, &heights, &mut reach, &mut squared);
            } else {
                lower(&mut any, &heights, &mut reach, &mut squared);
            }
            take(row, &squared);
        }
    }

    /// Size and pose of the grid.
    #[must_use]
    pub const fn frame(&self) -> &GridFrame {
        &self.frame
    }

    /// All squared distances in cells, row-major, lowest row first.
    #[must_use]
    pub fn squared_cells(&self) -> &[u32] {
        &self.squared
    }

    /// Distance in metres from the centre of a cell to the centre of the nearest obstacle cell; infinite if the grid has
    /// no obstacle. The cell must lie inside the grid.
    #[must_use]
    pub fn distance_m(&self, cell: Cell) -> f64 {
        match self.squared[self.frame.index(cell)] {
            Self::NO_OBSTACLE.. => f64::INFINITY,
            squared => f64::from(squared).sqrt() * self.frame.resolution_m,
        }
    }
}

/// For each cell, the distance in rows to the nearest obstacle of the same column at or below it, or [`FAR`].
fn distance_downwards(obstacles: &ObstacleGrid) -> Vec<u16> {
    let width = obstacles.frame().width as usize;
    let mut distances = vec![0; obstacles.cells().len()];
    let mut heights = vec![FAR; width];
    let rows = obstacles.cells().chunks_exact(width);
    for (blocked, out) in rows.zip(distances.chunks_exact_mut(width)) {
        for ((height, &blocked), out) in heights.iter_mut().zip(blocked).zip(out) {
            let above = height.saturating_add(1).min(FAR);
            *height = if blocked { 0 } else { above };
            *out = *height;
        }
    }
    distances
}
