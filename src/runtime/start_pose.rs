//! Whether the robot's body fits where a mission starts.

use super::ObstacleGap;
use crate::geometry::{Point, Pose};
use crate::global::PlanError;
use crate::map::{Cell, ObstacleGrid};
use crate::navigator::no_room;
use crate::robot::Footprint;

/// Places that are tried around a start without room: circles, the distance between two of them, metres, and directions.
const NEARBY_CIRCLES: u32 = 40;
const NEARBY_STEP_M: f64 = 0.05;
const NEARBY_DIRECTIONS: u32 = 24;

/// Rejects a start at which the body touches an obstacle of the map: the mission would end with contact before the robot moves. The
/// planner checks only the robot's position, without its yaw.
///
/// # Errors
/// [`PlanError::StartOccupied`], with the nearest yaw that fits, or a place nearby where the body fits with this yaw.
pub(crate) fn check_start(
    start: &Pose,
    obstacles: &ObstacleGrid,
    footprint: &Footprint,
) -> Result<(), PlanError> {
    let place = start.position();
    let is_free = obstacles.frame().cell_of(&place).is_some_and(|cell| !obstacles.is_blocked(cell));
    // The planner rejects a start outside the map or in an obstacle, and names the nearest free point. Most others are in the open: they
    // need no distances of the whole map.
    if !is_free || is_open(&place, obstacles, footprint.circumscribed_radius_m()) {
        return Ok(());
    }
    let ground = ObstacleGap::new(obstacles.clone());
    let fits_at = |pose: &Pose| ground.gap_m(footprint, pose) > 0.0;
    let fits = |yaw: f64| fits_at(&Pose { yaw, ..*start });
    if fits(start.yaw) {
        return Ok(());
    }
    let circle = |number: u32| place.circle(f64::from(number) * NEARBY_STEP_M, NEARBY_DIRECTIONS);
    let has_room = |at: &Point| fits_at(&Pose::new(at.x, at.y, start.yaw));
    let nearby = || (1..=NEARBY_CIRCLES).flat_map(circle).find(has_room);
    Err(PlanError::StartOccupied { place, why: no_room(start.yaw, fits, nearby) })
}

/// Whether no obstacle touches the square around a place, this far to each side along the axes of the grid, metres.
fn is_open(place: &Point, obstacles: &ObstacleGrid, half_m: f64) -> bool {
    let frame = obstacles.frame();
    let (middle, half) = (frame.to_cell_units(place), half_m / frame.resolution_m);
    let cells = |at: f64| ((at - half).ceil() - 1.0) as i32..=(at + half).floor() as i32;
    cells(middle.y)
        .all(|row| cells(middle.x).all(|column| !obstacles.is_blocked(Cell::new(column, row))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::GridFrame;
    use crate::robot::Polygon;

    /// A footprint may be larger than any map.
    #[test]
    fn square_beyond_all_cells_is_not_open() {
        let frame = GridFrame::new(10, 10, 0.001, Pose::default()).expect("a size");
        let ground = ObstacleGrid::filled(frame, false);
        let middle = Point::new(0.005, 0.005);
        for (half_m, expected) in [(0.001, true), (0.006, false), (1e300, false)] {
            assert_eq!(is_open(&middle, &ground, half_m), expected, "{half_m} m");
        }
    }

    /// A robot of 0.8 by 0.4 m in a corridor along x, 0.6 m wide.
    #[test]
    fn start_across_a_corridor_is_rejected_with_the_nearest_yaw_that_fits() {
        let frame = GridFrame::new(100, 26, 0.1, Pose::new(-5.0, -1.3, 0.0)).expect("a size");
        let ground = ObstacleGrid::from_fn(frame, |cell| !(10..16).contains(&cell.row));
        let body = Footprint::covering(Polygon::rectangle(0.8, 0.4).expect("a body"));
        let check = |x, y, yaw| check_start(&Pose::new(x, y, yaw), &ground, &body);
        assert_eq!(
            [check(0.0, 0.0, 0.0), check(0.0, 0.0, 0.2), check(9.0, 0.0, 0.0)],
            [Ok(()), Ok(()), Ok(())]
        );
        let error = check(0.0, 0.0, 1.4).expect_err("no room").to_string();
        assert!(error.starts_with("START_OCCUPIED: start (0.00, 0.00) has no room"), "{error}");
        assert!(error.ends_with("with yaw 1.40: the nearest yaw that fits is 0.27"), "{error}");
        let error = check(0.0, -0.25, 0.0).expect_err("no room").to_string();
        assert!(error.ends_with("no yaw fits there; it fits at (0.10, -0.08)"), "{error}");
    }
}
