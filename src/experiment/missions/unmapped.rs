//! Obstacles on the path that the map does not show.

use core::ops::RangeInclusive;

use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use crate::geometry::{Point, Pose, Vector};
use crate::global::Path;
use crate::map::ObstacleGrid;
use crate::navigator::RoutePlanner;

/// Half the side of a box or the radius of a pillar, metres.
const HALF_M: RangeInclusive<f64> = 0.15..=0.35;
/// Largest distance of its centre from the path, metres, to either side.
const OFFSET_M: f64 = 0.5;
/// Smallest distance along the path from either end, metres.
const FROM_ENDS_M: f64 = 2.0;
/// Attempts to find a position that leaves a path.
const ATTEMPTS: usize = 12;

/// Adds one or two boxes or pillars on a path, and returns the obstacles and how many were added. After each addition the
/// planner still finds a path from end to end.
pub(super) fn add_unmapped(
    ground: &ObstacleGrid,
    path: &Path,
    planner: &mut RoutePlanner,
    rng: &mut Pcg64Mcg,
) -> (ObstacleGrid, usize) {
    let wanted = rng.random_range(1..=2);
    let mut truth = ground.clone();
    let mut placed = 0;
    let stretch = FROM_ENDS_M..path.length_m() - FROM_ENDS_M;
    let ends = path.points().first().zip(path.points().last());
    let Some((&start, &goal)) = ends.filter(|_| !stretch.is_empty()) else {
        return (truth, placed);
    };
    for _ in 0..ATTEMPTS {
        if placed == wanted {
            break;
        }
        let arc_m = rng.random_range(stretch.clone());
        let along = path.direction_at(arc_m);
        let aside = Vector::new(-along.y, along.x) * rng.random_range(-OFFSET_M..=OFFSET_M);
        let half_m = rng.random_range(HALF_M);
        let middle = path.point_at(arc_m) + aside;
        let mut tried = truth.clone();
        if rng.random_bool(0.5) {
            tried.fill_disc(&middle, half_m);
        } else {
            fill_box(&mut tried, &middle, libm::atan2(along.y, along.x), half_m);
        }
        let near_an_end = [start, goal].iter().any(|end| (end - middle).norm() < FROM_ENDS_M);
        if !near_an_end && planner.plan(&tried, start, goal, &mut || 0.0).is_ok() {
            truth = tried;
            placed += 1;
        }
    }
    (truth, placed)
}

/// Marks every cell whose centre is in a square around a point, rotated by a yaw; `half_m` is half its side.
fn fill_box(grid: &mut ObstacleGrid, middle: &Point, yaw: f64, half_m: f64) {
    let frame = *grid.frame();
    let square = Pose::new(middle.x, middle.y, yaw);
    for cell in frame.cells_around(middle, half_m * core::f64::consts::SQRT_2) {
        let inside = square.inverse_transform(&frame.center_of(cell));
        if inside.x.abs() <= half_m && inside.y.abs() <= half_m {
            grid.set(cell, true);
        }
    }
}
