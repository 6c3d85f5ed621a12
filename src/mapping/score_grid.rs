//! Loop closure: branch and bound correlative scan matching.
//!
//! The search of Hess, Kohler, Rapp and Andor, "Real-Time Loop Closure in 2D LIDAR SLAM", ICRA 2016: the best pose of a scan in
//! a window on a grid of scores.

use super::surfels::Surfel;
use crate::geometry::{Point, Pose, wrap_angle};
use crate::localization::{CellScores, EndCells, ScorePyramid};

/// Side of a cell, metres.
const CELL_M: f64 = 0.05;
/// Number of levels: the coarsest node covers 64 x 64 translations.
const LEVELS: usize = 7;
/// A cell scores by the distance from the next surface point, up to this number of cells.
const REACH: i32 = 3;
/// Highest score of a cell.
const FULL: u8 = 200;
/// Largest number of cells, so that memory stays small.
const MAX_CELLS: usize = 6_000_000;

/// The window of a search around a pose.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    pub extent_m: f64,
    pub extent_rad: f64,
    /// Results below this score are none.
    pub min_score: f64,
}

/// Scores of places by their distance from surfaces.
pub(super) struct ScoreGrid {
    corner: Point,
    scores: ScorePyramid,
}

impl CellScores for ScoreGrid {
    fn column(&self, x: f64) -> i32 {
        ((x - self.corner.x) / CELL_M).floor() as i32
    }

    fn row(&self, y: f64) -> i32 {
        ((y - self.corner.y) / CELL_M).floor() as i32
    }

    fn of_cell(&self, column: i32, row: i32) -> f64 {
        f64::from(self.scores.score(column, row)) / f64::from(FULL)
    }
}

impl ScoreGrid {
    /// Scores of the finest level alone: enough for [`CellScores`].
    pub fn fine(surfels: &[Surfel]) -> Option<Self> {
        Self::with_levels(surfels, 1)
    }

    /// Scores of all levels.
    pub fn new(surfels: &[Surfel]) -> Option<Self> {
        Self::with_levels(surfels, LEVELS)
    }

    /// The corner of the grid of points, and its numbers of columns and rows. None without points, and for points too far apart.
    pub fn frame(points: impl Iterator<Item = Point>) -> Option<(Point, i32, i32)> {
        let [low, high] = Point::bounds(points)?;
        let margin_m = CELL_M * f64::from(REACH + 1);
        let corner = Point::new(low.x - margin_m, low.y - margin_m);
        let cells = |most: f64, least: f64| ((most + margin_m - least) / CELL_M).ceil();
        let (columns, rows) = (cells(high.x, corner.x), cells(high.y, corner.y));
        (columns * rows <= MAX_CELLS as f64).then_some((corner, columns as i32, rows as i32))
    }

    fn with_levels(surfels: &[Surfel], levels: usize) -> Option<Self> {
        let points = surfels.iter().map(|surfel| surfel.point);
        let (corner, columns, rows) = Self::frame(points)?;
        let mut kernel = Vec::new();
        for up in -REACH..=REACH {
            for right in -REACH..=REACH {
                let far = f64::from(up * up + right * right).sqrt() / f64::from(REACH + 1);
                kernel.push((right, up, ((1.0 - far).max(0.0) * f64::from(FULL)).round() as u8));
            }
        }
        let mut scores = vec![0_u8; columns as usize * rows as usize];
        for Surfel { point, .. } in surfels {
            let column = ((point.x - corner.x) / CELL_M) as i32;
            let row = ((point.y - corner.y) / CELL_M) as i32;
            for &(right, up, score) in &kernel {
                let (column, row) = (column + right, row + up);
                if column >= 0 && row >= 0 && column < columns && row < rows {
                    let cell = &mut scores[(row * columns + column) as usize];
                    *cell = score.max(*cell);
                }
            }
        }
        Some(Self { corner, scores: ScorePyramid::new(columns, rows, &scores, levels) })
    }

    /// The pose in a window around a predicted one at which points in the robot's frame have the highest mean score, and that
    /// score, 0 to 1.
    pub fn search(
        &self,
        points: &[Point],
        predicted: &Pose,
        window: &Window,
    ) -> Option<(Pose, f64)> {
        let farthest = points.iter().map(|it| it.to_vector().norm()).fold(1.0, f64::max);
        // The farthest point moves by about a cell per step of the angle (Hess et al. 2016, equation 7).
        let cosine = 1.0 - CELL_M * CELL_M / (2.0 * farthest * farthest);
        let step_rad = libm::acos(cosine);
        let turns = (window.extent_rad / step_rad).ceil() as i32;
        let extent = (window.extent_m / CELL_M).ceil() as i32;
        let top = self.scores.top();
        let side = 1_usize << top;
        // The sum of scores that a result must exceed.
        let mut best_sum = (window.min_score * f64::from(FULL) * points.len() as f64) as u32;
        let mut best: Option<(i32, i32, i32)> = None;
        // Cells of the points for each angle, at the lower left corner of the window: blocks begin there.
        let cells: Vec<EndCells> = (-turns..=turns)
            .map(|turn| {
                let (sin, cos) = libm::sincos(predicted.yaw + step_rad * f64::from(turn));
                let cell = |point: &Point| {
                    let x = predicted.x + cos * point.x - sin * point.y - self.corner.x;
                    let y = predicted.y + sin * point.x + cos * point.y - self.corner.y;
                    ((x / CELL_M).floor() as i32 - extent, (y / CELL_M).floor() as i32 - extent)
                };
                EndCells::new(&points.iter().map(cell).collect::<Vec<_>>())
            })
            .collect();
        let mut roots = Vec::new();
        for (turn, cells) in cells.iter().enumerate() {
            for up in (0..=2 * extent).step_by(2 * side) {
                for right in (0..=2 * extent).step_by(2 * side) {
                    let all = self.quarters(top, cells, (right, up), 2 * extent);
                    let good = all.into_iter().filter(|(sum, ..)| *sum > best_sum);
                    roots.extend(good.map(|(sum, right, up)| (sum, turn as i32, right, up)));
                }
            }
        }
        // The best bound first; equal bounds in a fixed order.
        roots.sort_by(|one, other| other.0.cmp(&one.0).then(one.cmp(other)));
        for (bound, turn, right, up) in roots {
            if bound <= best_sum {
                break;
            }
            let node = (turn, right, up);
            self.descend(top, &cells, node, 2 * extent, &mut best_sum, &mut best);
        }
        let (turn, right, up) = best?;
        let yaw = wrap_angle(predicted.yaw + step_rad * f64::from(turn - turns));
        let (dx, dy) = (CELL_M * f64::from(right - extent), CELL_M * f64::from(up - extent));
        let score = f64::from(best_sum) / (f64::from(FULL) * points.len() as f64);
        Some((Pose::new(predicted.x + dx, predicted.y + dy, yaw), score))
    }

    /// The four blocks of a level from a translation on, with the bounds of their sums: 0 beyond the last translation.
    fn quarters(
        &self,
        level: usize,
        cells: &EndCells,
        (right, up): (i32, i32),
        last: i32,
    ) -> [(u32, i32, i32); 4] {
        let side = 1 << level;
        let sums = self.scores.sums_of_four(level, cells, right, up);
        let mut quarters =
            [(right, up), (right, up + side), (right + side, up), (right + side, up + side)]
                .into_iter()
                .zip(sums);
        core::array::from_fn(|_| {
            let ((right, up), sum) = quarters.next().unwrap_or_default();
            (if right <= last && up <= last { sum } else { 0 }, right, up)
        })
    }

    /// Searches the translations below a node that can be better than the best one.
    fn descend(
        &self,
        level: usize,
        cells: &[EndCells],
        (turn, right, up): (i32, i32, i32),
        last: i32,
        best_sum: &mut u32,
        best: &mut Option<(i32, i32, i32)>,
    ) {
        let mut quarters = self.quarters(level - 1, &cells[turn as usize], (right, up), last);
        quarters.sort_by(|one, other| other.0.cmp(&one.0).then(one.cmp(other)));
        for (bound, right, up) in quarters {
            if bound <= *best_sum {
                break;
            }
            if level == 1 {
                (*best_sum, *best) = (bound, Some((turn, right, up)));
            } else {
                self.descend(level - 1, cells, (turn, right, up), last, best_sum, best);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vector;

    /// Two walls of a corner.
    fn corner() -> Vec<Surfel> {
        let point =
            |x: f64, y: f64| Surfel { point: Point::new(x, y), normal: Vector::new(1.0, 0.0) };
        let mut surfels: Vec<Surfel> =
            (0..80).map(|step| point(3.0, 0.05 * f64::from(step))).collect();
        surfels.extend((0..120).map(|step| point(-3.0 + 0.05 * f64::from(step), 4.0)));
        surfels.push(point(0.5, 1.0));
        surfels
    }

    /// The best score over all poses of the window, without bounds.
    fn searched(grid: &ScoreGrid, points: &[Point], window: &Window) -> f64 {
        let farthest = points.iter().map(|it| it.to_vector().norm()).fold(1.0, f64::max);
        let step = libm::acos(1.0 - CELL_M * CELL_M / (2.0 * farthest * farthest));
        let turns = (window.extent_rad / step).ceil() as i32;
        let extent = (window.extent_m / CELL_M).ceil() as i32;
        let mut best = 0.0_f64;
        for turn in -turns..=turns {
            let (sin, cos) = libm::sincos(step * f64::from(turn));
            for up in -extent..=extent {
                for right in -extent..=extent {
                    let total: f64 = points
                        .iter()
                        .map(|point| {
                            let x = cos * point.x - sin * point.y + CELL_M * f64::from(right);
                            let y = sin * point.x + cos * point.y + CELL_M * f64::from(up);
                            grid.of_cell(grid.column(x), grid.row(y))
                        })
                        .sum();
                    best = best.max(total / points.len() as f64);
                }
            }
        }
        best
    }

    #[test]
    fn branch_and_bound_finds_the_best_pose_of_the_window() {
        let surfels = corner();
        let grid = ScoreGrid::new(&surfels).expect("a small grid");
        let truth = Pose::new(0.62, -0.4, 0.21);
        let points: Vec<Point> =
            surfels.iter().step_by(3).map(|it| truth.inverse_transform(&it.point)).collect();
        let window = Window { extent_m: 1.0, extent_rad: 0.3, min_score: 0.5 };
        let found = grid.search(&points, &Pose::default(), &window);
        let (pose, score) = found.expect("it is in the window");
        assert!((pose.position() - truth.position()).norm() < 0.1, "{pose:?}");
        assert!((pose.yaw - truth.yaw).abs() < 0.02, "{pose:?}");
        assert!((score - searched(&grid, &points, &window)).abs() < 1e-6, "{score}");
        // Outside of the window there is no good pose.
        let small = Window { extent_m: 0.2, extent_rad: 0.05, min_score: 0.9 };
        assert!(grid.search(&points, &Pose::default(), &small).is_none());
    }
}
