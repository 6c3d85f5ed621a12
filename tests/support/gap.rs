//! Clearance of a polyline by brute force in small steps, independent of the crate's arithmetic.

use inbye::geometry::Point;
use inbye::map::{Cell, ObstacleGrid};

/// Step length to detect a violated clearance: a twentieth of a cell.
pub const STEP: f64 = 1.0 / 20.0;

/// The smallest distance, metres, from any step of the polyline to an obstacle cell's square within `reach_m` of
/// it. Steps are at most `step` cells long.
pub fn smallest_gap_m(points: &[Point], obstacles: &ObstacleGrid, reach_m: f64, step: f64) -> f64 {
    let cell_m = obstacles.frame().resolution_m;
    let reach = reach_m / cell_m;
    let units: Vec<(f64, f64)> = points.iter().map(|at| in_cells(at, obstacles)).collect();
    let mut least = f64::INFINITY;
    for (index, &(x, y)) in units.iter().enumerate() {
        let (to_x, to_y) = units[(index + 1).min(units.len() - 1)];
        let steps = (libm::hypot(to_x - x, to_y - y) / step).ceil().max(1.0);
        for number in 0..=steps as i32 {
            let share = f64::from(number) / steps;
            let at = (x + (to_x - x) * share, y + (to_y - y) * share);
            least = least.min(squared_gap(at, obstacles, reach));
        }
    }
    least.sqrt() * cell_m
}

/// Whether every point is on the grid.
pub fn is_on_grid(points: &[Point], obstacles: &ObstacleGrid) -> bool {
    let frame = obstacles.frame();
    let (width, height) = (f64::from(frame.width), f64::from(frame.height));
    points.iter().all(|at| {
        let (x, y) = in_cells(at, obstacles);
        x >= -1e-9 && y >= -1e-9 && x <= width + 1e-9 && y <= height + 1e-9
    })
}

fn in_cells(point: &Point, obstacles: &ObstacleGrid) -> (f64, f64) {
    let frame = obstacles.frame();
    let (sine, cosine) = libm::sincos(frame.origin.yaw);
    let (x, y) = (point.x - frame.origin.x, point.y - frame.origin.y);
    ((cosine * x + sine * y) / frame.resolution_m, (cosine * y - sine * x) / frame.resolution_m)
}

fn squared_gap((x, y): (f64, f64), obstacles: &ObstacleGrid, reach: f64) -> f64 {
    let frame = obstacles.frame();
    let span = |at: f64, side: i32| {
        let low = (at - reach).floor() as i32 - 1;
        let high = (at + reach).ceil() as i32 + 1;
        low.max(0)..high.min(side)
    };
    let mut least = f64::INFINITY;
    for row in span(y, frame.height) {
        for column in span(x, frame.width) {
            if obstacles.is_blocked(Cell::new(column, row)) {
                let nearest_x = x.clamp(f64::from(column), f64::from(column + 1));
                let nearest_y = y.clamp(f64::from(row), f64::from(row + 1));
                least = least.min((x - nearest_x).powi(2) + (y - nearest_y).powi(2));
            }
        }
    }
    least
}
