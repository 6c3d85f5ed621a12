//! How near a path comes to obstacles.

use crate::geometry::Point;
use crate::map::{Cell, DistanceField, ObstacleGrid};

use super::Path;

/// The smallest distance from a path to any obstacle cell's square, metres, zero where it touches one; infinite on a map
/// without obstacles. Ground off the map is no obstacle here.
///
/// Exact to 1 mm: the path is looked at every 2 mm of its distance to the nearest wall, and at least every 2 mm where it
/// is near.
#[must_use]
pub fn min_clearance_m(path: &Path, obstacles: &ObstacleGrid) -> f64 {
    const STEP_M: f64 = 0.002;
    let field = DistanceField::new(obstacles);
    let mut least = f64::INFINITY;
    let mut arc_m = 0.0;
    loop {
        let distance = distance_m(&path.point_at(arc_m), obstacles, &field);
        least = least.min(distance);
        if arc_m >= path.length_m() || distance == f64::INFINITY {
            return least;
        }
        // Within `distance - least` of here nothing can be nearer than the least so far.
        arc_m = (arc_m + (distance - least).max(STEP_M)).min(path.length_m());
    }
}

/// Distance from a point to the nearest obstacle square.
fn distance_m(point: &Point, obstacles: &ObstacleGrid, field: &DistanceField) -> f64 {
    let frame = obstacles.frame();
    let Some(cell) = frame.cell_of(point) else {
        return f64::INFINITY;
    };
    let to_center = field.distance_m(cell) / frame.resolution_m;
    if to_center == f64::INFINITY {
        return to_center;
    }
    let at = frame.to_cell_units(point);
    // The nearest square's centre is at most three half diagonals further than the nearest centre.
    let reach = (to_center + 2.2).ceil() as i32;
    let mut least = f64::INFINITY;
    for row in cell.row - reach..=cell.row + reach {
        for column in cell.column - reach..=cell.column + reach {
            let place = Cell::new(column, row);
            if frame.contains(place) && obstacles.is_blocked(place) {
                let beyond =
                    |at: f64, low: i32| (f64::from(low) - at).max(at - f64::from(low + 1)).max(0.0);
                let (dx, dy) = (beyond(at.x, column), beyond(at.y, row));
                least = least.min(dx * dx + dy * dy);
            }
        }
    }
    least.sqrt() * frame.resolution_m
}
