//! Bounds of the scores of many poses at once, for branch and bound.
//!
//! The method is that of Hess, Kohler, Rapp and Andor, "Real-Time Loop Closure in 2D LIDAR SLAM", ICRA 2016. Coarser levels hold the
//! maximum of the scores of 2^k x 2^k cells. The sum over the cells of a scan therefore bounds the sums of all translations of a
//! node.

/// Scores of cells, and their maxima.
#[derive(Clone, Debug)]
pub(crate) struct ScorePyramid {
    columns: i32,
    rows: i32,
    /// Level k holds at each cell the maximum over 2^k columns to the right and 2^k rows up.
    levels: Vec<Vec<u8>>,
}

impl ScorePyramid {
    /// The pyramid of scores in rows, the lowest first.
    pub fn new(columns: i32, rows: i32, scores: Vec<u8>, levels: usize) -> Self {
        let (width, height) = (columns as usize, rows as usize);
        let mut pyramid = Self { columns, rows, levels: vec![scores] };
        for level in 1..levels {
            let reach = 1_usize << (level - 1);
            let below = &pyramid.levels[level - 1];
            let mut across = vec![0; below.len()];
            for (out, row) in across.chunks_exact_mut(width).zip(below.chunks_exact(width)) {
                out.copy_from_slice(row);
                if reach < width {
                    for (out, right) in out.iter_mut().zip(&row[reach..]) {
                        *out = (*out).max(*right);
                    }
                }
            }
            for row in 0..height.saturating_sub(reach) {
                let (own, above) = across.split_at_mut((row + reach) * width);
                let own = &mut own[row * width..][..width];
                for (out, up) in own.iter_mut().zip(&above[..width]) {
                    *out = (*out).max(*up);
                }
            }
            pyramid.levels.push(across);
        }
        pyramid
    }

    pub const fn columns(&self) -> i32 {
        self.columns
    }

    pub const fn rows(&self) -> i32 {
        self.rows
    }

    /// Level of the largest nodes.
    pub const fn top(&self) -> usize {
        self.levels.len() - 1
    }

    /// The score of a cell; 0 outside.
    #[cfg(any(test, feature = "logs"))]
    pub fn score(&self, column: i32, row: i32) -> u8 {
        self.sum_of(0, &[(column, row)], 0, 0) as u8
    }

    /// Bound of the sums of the cells over all translations of a node: by `right` and `up` cells, and up to 2^level - 1 more of
    /// both. At level 0 it is the sum itself.
    pub fn sum_of(&self, level: usize, cells: &[(i32, i32)], right: i32, up: i32) -> u32 {
        let scores = &self.levels[level];
        // A cell left of or below the grid still covers cells of the grid at a coarse level.
        let reach = (1 << level) - 1;
        let mut sum = 0;
        for (column, row) in cells {
            let (column, row) = (column + right, row + up);
            let is_near =
                column >= -reach && row >= -reach && column < self.columns && row < self.rows;
            if is_near {
                let (column, row) = (column.max(0), row.max(0));
                sum += u32::from(scores[row as usize * self.columns as usize + column as usize]);
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn node_bounds_the_scores_of_all_its_translations() {
        let (columns, rows) = (13, 9);
        let scores: Vec<u8> = (0..columns * rows).map(|cell| (cell * 73 % 251) as u8).collect();
        let pyramid = ScorePyramid::new(columns, rows, scores, 4);
        for level in 0..=pyramid.top() {
            let side = 1 << level;
            for up in -9..rows {
                for right in -9..columns {
                    let within = (0..side * side)
                        .map(|cell| pyramid.score(right + cell % side, up + cell / side));
                    let largest = within.max().expect("a node has cells");
                    let bound = pyramid.sum_of(level, &[(0, 0)], right, up);
                    // Left of and below the grid it may be larger.
                    let is_inside = right >= 0 && up >= 0;
                    assert!(bound >= u32::from(largest), "{level}: {right}, {up}");
                    assert!(!is_inside || bound == u32::from(largest), "{level}: {right}, {up}");
                }
            }
        }
    }
}
