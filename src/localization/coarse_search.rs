//! A search around a predicted pose, before the scan matcher: its steps converge only from poses that are already near.
//!
//! This is correlative scan matching (Olson, "Real-Time Correlative Scan Matching", ICRA 2009) with a small window.

use nalgebra::Matrix3;

use super::DeskewedScan;
use super::pose_estimate::axis_variances;
use super::signed_distance_field::SignedDistanceField;
use crate::geometry::{Point, Pose, wrap_angle};

/// Steps of the search, metres and radians, and its largest extent to each side.
const STEP_M: f64 = 0.08;
const STEP_RAD: f64 = 0.02;
const MAX_EXTENT_M: f64 = 0.8;
const MAX_EXTENT_RAD: f64 = 0.6;

/// The window in standard deviations of the predicted pose.
const SIGMAS: f64 = 3.0;

/// Number of beams that are scored.
const BEAMS: usize = 60;

/// Beam ends up to this distance from a surface count on a map, metres.
const SCORED_DISTANCE_M: f64 = 0.2;

/// The pose on a map around a predicted one from which the beams end nearest to surfaces. The prior counts by its standard
/// deviations, metres and radians.
pub(super) fn search_map(
    map: &SignedDistanceField,
    scan: &DeskewedScan,
    prior: &Pose,
    sigmas: (f64, f64),
) -> Pose {
    coarse_search(scan.hits.iter().map(|hit| hit.end), prior, sigmas, map)
}

/// The largest extent of a search along one direction to each side, metres.
const MAX_EXTENT_ALONG_M: f64 = 6.0;

/// As [`search_map`], along the direction in which the predicted position is least certain, with all beams. The prior counts by the
/// covariance of x, y and yaw.
pub(super) fn search_along(
    map: &SignedDistanceField,
    scan: &DeskewedScan,
    prior: &Pose,
    covariance: &Matrix3<f64>,
) -> Pose {
    let (a, b, c) = (covariance[(0, 0)], covariance[(0, 1)], covariance[(1, 1)]);
    let [variance, _] = axis_variances(a, b, c);
    let (sin, cos) = libm::sincos(0.5 * libm::atan2(2.0 * b, a - c));
    let ends: Vec<Point> = scan.hits.iter().map(|hit| prior.transform(&hit.end)).collect();
    let extent_m = (SIGMAS * variance.sqrt()).min(MAX_EXTENT_ALONG_M);
    let (mut best, mut best_m) = (f64::NEG_INFINITY, 0.0);
    for step in outwards((extent_m / STEP_M).ceil() as i32) {
        let along_m = STEP_M * f64::from(step);
        let (dx, dy) = (along_m * cos, along_m * sin);
        let score = |end: &Point| map.of_cell(map.column(end.x + dx), map.row(end.y + dy));
        let total = ends.iter().map(score).sum::<f64>() - 0.5 * along_m * along_m / variance;
        if total > best {
            (best, best_m) = (total, along_m);
        }
    }
    Pose { x: prior.x + best_m * cos, y: prior.y + best_m * sin, ..*prior }
}

/// Scores of points, each by the cell of a grid in which it lies.
pub(crate) trait CellScores {
    /// The column of the cells at an x; below zero or beyond the last column outside the grid.
    fn column(&self, x: f64) -> i32;

    /// The row of the cells at a y, likewise.
    fn row(&self, y: f64) -> i32;

    /// The score of a cell, 0 to 1; 0 outside.
    fn of_cell(&self, column: i32, row: i32) -> f64;
}

impl CellScores for SignedDistanceField {
    #[inline]
    fn column(&self, x: f64) -> i32 {
        self.cells_to(x)
    }

    #[inline]
    fn row(&self, y: f64) -> i32 {
        self.cells_to(y)
    }

    #[inline]
    fn of_cell(&self, column: i32, row: i32) -> f64 {
        let distance_m = self.distance_in_cell_m(column, row).unwrap_or(SCORED_DISTANCE_M);
        (1.0 - distance_m.abs() / SCORED_DISTANCE_M).max(0.0)
    }
}

/// The cells of the beam ends of one heading, at all translations of the search: computed when an end is first scored.
struct Cells<'a, S> {
    scores: &'a S,
    /// The translations of one axis, in the order of the search, metres.
    shifts: Vec<f64>,
    ends: Vec<Point>,
    /// For each end the columns by the shifts, and the rows.
    columns: Vec<i32>,
    rows: Vec<i32>,
}

impl<'a, S: CellScores> Cells<'a, S> {
    fn new(scores: &'a S, shifts: Vec<f64>) -> Self {
        Self { scores, shifts, ends: Vec::new(), columns: Vec::new(), rows: Vec::new() }
    }

    fn set_ends(&mut self, ends: impl Iterator<Item = Point>) {
        self.ends.clear();
        self.ends.extend(ends);
        self.columns.clear();
        self.rows.clear();
    }

    /// Adds the scores of the ends at a translation by these shifts to a total, in order, as long as the remaining ones can raise
    /// it above `best`; `None` where they cannot.
    fn total_above(
        &mut self,
        best: f64,
        mut total: f64,
        (across, up): (usize, usize),
    ) -> Option<f64> {
        let side = self.shifts.len();
        let mut left = self.ends.len() as f64;
        for end in 0..self.ends.len() {
            if total + left <= best {
                return None;
            }
            left -= 1.0;
            if self.columns.len() == end * side {
                self.add_cells(self.ends[end]);
            }
            let (column, row) = (self.columns[end * side + across], self.rows[end * side + up]);
            total += self.scores.of_cell(column, row);
        }
        (total > best).then_some(total)
    }

    fn add_cells(&mut self, end: Point) {
        let Self { scores, shifts, columns, rows, .. } = self;
        columns.extend(shifts.iter().map(|shift| scores.column(end.x + shift)));
        rows.extend(shifts.iter().map(|shift| scores.row(end.y + shift)));
    }
}

/// The pose around a predicted one at which the beam ends have the highest sum of scores. The prior counts by its standard
/// deviations, metres and radians. Ends are in the robot's frame.
pub(crate) fn coarse_search(
    ends: impl ExactSizeIterator<Item = Point>,
    prior: &Pose,
    (sigma_m, sigma_rad): (f64, f64),
    scores: &impl CellScores,
) -> Pose {
    let stride = ends.len().div_ceil(BEAMS).max(1);
    let ends: Vec<Point> = ends.step_by(stride).collect();
    let steps =
        |sigma: f64, step: f64, most: f64| ((SIGMAS * sigma).min(most) / step).ceil() as i32;
    let across = steps(sigma_m, STEP_M, MAX_EXTENT_M);
    let around = steps(sigma_rad, STEP_RAD, MAX_EXTENT_RAD);
    let shifts = outwards(across).map(|step| STEP_M * f64::from(step)).collect();
    let mut cells = Cells::new(scores, shifts);
    let (mut best, mut best_pose) = (f64::NEG_INFINITY, *prior);
    for turn in outwards(around) {
        let turned = STEP_RAD * f64::from(turn);
        let (sin, cos) = libm::sincos(prior.yaw + turned);
        cells.set_ends(ends.iter().map(|end| {
            Point::new(prior.x + cos * end.x - sin * end.y, prior.y + sin * end.x + cos * end.y)
        }));
        let of_turn = (turned / sigma_rad) * (turned / sigma_rad);
        for up in 0..cells.shifts.len() {
            for across in 0..cells.shifts.len() {
                let (dx, dy) = (cells.shifts[across], cells.shifts[up]);
                let far = (dx * dx + dy * dy) / (sigma_m * sigma_m) + of_turn;
                if let Some(total) = cells.total_above(best, -0.5 * far, (across, up)) {
                    best = total;
                    best_pose =
                        Pose::new(prior.x + dx, prior.y + dy, wrap_angle(prior.yaw + turned));
                }
            }
        }
    }
    best_pose
}

/// The numbers from zero outwards: 0, -1, 1, -2, 2 and so on. A good pose is found early, and most others are given up soon.
fn outwards(most: i32) -> impl Iterator<Item = i32> {
    core::iter::once(0).chain((1..=most).flat_map(|step| [-step, step]))
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;

    /// Scores by the distance from lines at a coordinate on each axis, in cells of 1 cm.
    struct Walls {
        at: Point,
        reach_m: f64,
    }

    const CELL_M: f64 = 0.01;

    impl CellScores for Walls {
        fn column(&self, x: f64) -> i32 {
            (x / CELL_M).floor() as i32
        }

        fn row(&self, y: f64) -> i32 {
            (y / CELL_M).floor() as i32
        }

        fn of_cell(&self, column: i32, row: i32) -> f64 {
            let off = |cell: i32, wall: f64| ((f64::from(cell) + 0.5) * CELL_M - wall).abs();
            (1.0 - off(column, self.at.x).min(off(row, self.at.y)) / self.reach_m).max(0.0)
        }
    }

    #[test]
    fn search_finds_a_corner_from_a_wrong_pose() {
        let walls = Walls { at: Point::new(5.0, 3.0), reach_m: 0.3 };
        let truth = Pose::new(0.4, -0.2, 0.15);
        let east = (0..40).map(|step| Point::new(5.0, -3.0 + 0.15 * f64::from(step)));
        let north = (0..40).map(|step| Point::new(-1.0 + 0.15 * f64::from(step), 3.0));
        let ends: Vec<Point> =
            east.chain(north).map(|point| truth.inverse_transform(&point)).collect();
        let found = coarse_search(ends.into_iter(), &Pose::default(), (0.3, 0.1), &walls);
        assert!((found.position() - truth.position()).norm() < STEP_M, "{found:?}");
        assert!((found.yaw - truth.yaw).abs() <= STEP_RAD, "{found:?}");
    }

    /// The search gives up poses early, and knows the cells of beams from other poses.
    #[test]
    fn search_finds_the_best_of_all_poses() {
        let mut random = Pcg64Mcg::seed_from_u64(5);
        for case in 0..60 {
            let mut within = |most: f64| most * (2.0 * random.random::<f64>() - 1.0);
            let prior = Pose::new(within(0.5), within(0.5), within(3.0));
            let walls = Walls { at: Point::new(within(4.0), within(4.0)), reach_m: 0.4 };
            let ends: Vec<Point> =
                (0..20 + case).map(|_| Point::new(within(5.0), within(5.0))).collect();
            let sigmas = (0.02 + 0.1 * within(1.0).abs(), 0.01 + 0.03 * within(1.0).abs());
            let found = coarse_search(ends.iter().copied(), &prior, sigmas, &walls);

            let stride = ends.len().div_ceil(BEAMS).max(1);
            let total = |pose: &Pose| {
                let of_end = |end: &Point| {
                    let at = pose.transform(end);
                    walls.of_cell(walls.column(at.x), walls.row(at.y))
                };
                let far = (pose.position() - prior.position()).norm() / sigmas.0;
                let turned = wrap_angle(pose.yaw - prior.yaw) / sigmas.1;
                ends.iter().step_by(stride).map(of_end).sum::<f64>()
                    - 0.5 * (far * far + turned * turned)
            };
            let most = |sigma: f64, step: f64| (SIGMAS * sigma / step).ceil() as i32;
            let (across, around) = (most(sigmas.0, STEP_M), most(sigmas.1, STEP_RAD));
            let mut best = f64::NEG_INFINITY;
            for (turn, row, column) in (-around..=around).flat_map(|turn| {
                (-across..=across)
                    .flat_map(move |row| (-across..=across).map(move |column| (turn, row, column)))
            }) {
                let [x, y] = [column, row].map(|step| STEP_M * f64::from(step));
                let yaw = prior.yaw + STEP_RAD * f64::from(turn);
                best = best.max(total(&Pose::new(prior.x + x, prior.y + y, yaw)));
            }
            // A beam end on the border of two cells may fall on either side, by rounding.
            assert!(total(&found) > best - 0.06, "case {case}: {} of {best}", total(&found));
        }
    }
}
