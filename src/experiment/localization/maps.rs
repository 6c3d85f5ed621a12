//! Maps that are hard to localize in.

use crate::geometry::{Point, Pose};
use crate::map::{Cell, GridFrame, OCCUPIED_THRESHOLD, OccupancyGrid};

const FREE: i8 = 0;
const OCCUPIED: i8 = 100;

/// Side of a cell of the smooth roadways, metres.
const RESOLUTION_M: f64 = 0.05;

/// Straight parallel roadways along x with their lower walls at these y, metres. Their smooth walls do not show the position
/// along them.
pub(super) fn roadways(length_m: f64, lower_m: &[f64], width_m: f64) -> OccupancyGrid {
    let highest_m = lower_m.iter().fold(0.0, |most: f64, &low| most.max(low));
    let frame = GridFrame {
        width: ((length_m + 2.0) / RESOLUTION_M).round() as i32,
        height: ((highest_m + width_m + 1.0) / RESOLUTION_M).round() as i32,
        resolution_m: RESOLUTION_M,
        origin: Pose::default(),
    };
    let is_open = |place: &Point| {
        let along = place.x > 1.0 && place.x < 1.0 + length_m;
        along && lower_m.iter().any(|&low| place.y > low && place.y < low + width_m)
    };
    OccupancyGrid::from_fn(
        frame,
        |cell| {
            if is_open(&frame.center_of(cell)) { FREE } else { OCCUPIED }
        },
    )
}

/// The map with cells of twice the size, occupied where half of the area or more is.
pub(super) fn coarsened(map: &OccupancyGrid) -> OccupancyGrid {
    let fine = map.frame();
    let frame = GridFrame {
        width: fine.width / 2,
        height: fine.height / 2,
        resolution_m: 2.0 * fine.resolution_m,
        origin: fine.origin,
    };
    let is_occupied = |column: i32, row: i32| {
        map.get(Cell::new(column, row)).is_some_and(|value| *value >= OCCUPIED_THRESHOLD)
    };
    OccupancyGrid::from_fn(frame, |Cell { column, row }| {
        let occupied = [(0, 0), (1, 0), (0, 1), (1, 1)]
            .iter()
            .filter(|(right, up)| is_occupied(2 * column + right, 2 * row + up))
            .count();
        if occupied >= 2 { OCCUPIED } else { FREE }
    })
}
