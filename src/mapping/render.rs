//! An occupancy map from scans at known poses.

use crate::geometry::{Point, Pose};
use crate::localization::DeskewedScan;
use crate::map::{GridFrame, GridRay, MapError, OccupancyGrid, UNKNOWN};

/// Side of a cell, metres.
pub const MAP_RESOLUTION_M: f64 = 0.05;

/// Beams up to this range draw the map, metres: farther beams are far apart from each other.
pub(super) const MAPPED_RANGE_M: f64 = 25.0;

/// A cell is occupied if at least this fraction of the beams that reach it end in it. GMapping takes 0.25; higher values cut holes
/// into walls that are seen at small angles.
const OCCUPIED_FRACTION: f64 = 0.3;

/// A beam does not show free space in the last half cell before its end. A longer distance would move the surfaces of walls
/// towards the robot.
const UNCERTAIN_CELLS: f64 = 0.5;

/// Free space around the beam ends, metres.
const MARGIN_M: f64 = 0.5;

const FREE: i8 = 0;
const OCCUPIED: i8 = 100;

/// Counts of the beams of a cell. A map has up to 100 million cells, so they are small: a full count halves both, and their ratio stays.
#[derive(Clone, Copy, Default)]
struct Counts {
    ends: u16,
    passes: u16,
}

impl Counts {
    const fn add_end(&mut self) {
        self.halve_if_full(self.ends);
        self.ends += 1;
    }

    const fn add_pass(&mut self) {
        self.halve_if_full(self.passes);
        self.passes += 1;
    }

    const fn halve_if_full(&mut self, count: u16) {
        if count == u16::MAX {
            (self.ends, self.passes) = (self.ends / 2, self.passes / 2);
        }
    }
}

/// The map that scans show at their poses: cells in which beams end are occupied, cells through which they pass are free, and
/// others are unknown. Without returns it is one unknown cell.
///
/// # Errors
/// Returns an error if the scans cover too large an area for a grid.
pub fn render<'a>(
    scans: impl Iterator<Item = (Pose, &'a DeskewedScan)> + Clone,
) -> Result<OccupancyGrid, MapError> {
    let frame = frame(scans.clone())?;
    let mut counts = vec![Counts::default(); frame.len()];
    for (pose, scan) in scans {
        for (from, end) in used(&pose, scan) {
            add(&mut counts, &frame, &from, &end);
        }
    }
    let value = |counts: &Counts| {
        let (ends, all) =
            (f64::from(counts.ends), f64::from(counts.ends) + f64::from(counts.passes));
        if all == 0.0 {
            UNKNOWN
        } else if ends >= OCCUPIED_FRACTION * all {
            OCCUPIED
        } else {
            FREE
        }
    };
    Ok(OccupancyGrid::new(frame, counts.iter().map(value).collect()))
}

/// The used beams in the map frame: start and end.
fn used<'a>(pose: &Pose, scan: &'a DeskewedScan) -> impl Iterator<Item = (Point, Point)> + use<'a> {
    let pose = *pose;
    let near = |(from, end): &(Point, Point)| (*end - *from).norm() <= MAPPED_RANGE_M;
    let hits = scan.hits.iter().map(|hit| (hit.from, hit.end)).filter(near);
    hits.map(move |(from, end)| (pose.transform(&from), pose.transform(&end)))
}

/// Whether no beam of a scan is used.
pub(super) fn shows_nothing(scan: &DeskewedScan) -> bool {
    used(&Pose::default(), scan).next().is_none()
}

/// The frame of the map of scans at these poses.
pub(super) fn frame<'a>(
    scans: impl Iterator<Item = (Pose, &'a DeskewedScan)>,
) -> Result<GridFrame, MapError> {
    let beams = scans.flat_map(|(pose, scan)| used(&pose, scan));
    let Some([low, high]) = Point::bounds(beams.flat_map(|(from, end)| [from, end])) else {
        return GridFrame::new(1, 1, MAP_RESOLUTION_M, Pose::default());
    };
    let corner = |low: f64| ((low - MARGIN_M) / MAP_RESOLUTION_M).floor() * MAP_RESOLUTION_M;
    let (left, bottom) = (corner(low.x), corner(low.y));
    let side =
        |from: f64, high: f64| ((high + MARGIN_M - from) / MAP_RESOLUTION_M).ceil().min(1e9) as i32;
    let origin = Pose::new(left, bottom, 0.0);
    GridFrame::new(side(left, high.x), side(bottom, high.y), MAP_RESOLUTION_M, origin)
}

fn add(counts: &mut [Counts], frame: &GridFrame, from: &Point, end: &Point) {
    let (from, to) = (frame.to_cell_units(from), frame.to_cell_units(end));
    let length = (to - from).norm();
    if let Some(cell) = frame.cell_at_units(&to) {
        counts[frame.index(cell)].add_end();
    }
    if length <= UNCERTAIN_CELLS {
        return;
    }
    let direction = (to - from) * (1.0 / length);
    let free = GridRay::new(&from, &direction)
        .take_while(|(_, entered)| *entered < length - UNCERTAIN_CELLS);
    for (cell, _) in free {
        if frame.contains(cell) {
            counts[frame.index(cell)].add_pass();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::localization::Hit;

    #[test]
    fn beams_show_free_occupied_and_unknown_cells() {
        let hit = Hit { from: Point::default(), end: Point::new(1.025, 0.02), is_alone: false };
        let far = Hit { from: Point::default(), end: Point::new(-40.0, 0.0), is_alone: false };
        let scan =
            DeskewedScan { hits: vec![hit, far], range_max: 50.0, ..DeskewedScan::default() };
        let map = render([(Pose::new(0.0, 0.0, 0.0), &scan)].into_iter()).expect("a small map");
        let value = |x: f64, y: f64| {
            let cell = map.frame().cell_of(&Point::new(x, y)).expect("inside");
            *map.get(cell).expect("inside")
        };
        assert_eq!(value(1.025, 0.02), OCCUPIED);
        assert_eq!(value(0.5, 0.01), FREE);
        assert_eq!(value(0.5, 0.3), UNKNOWN);
        assert_eq!(value(1.2, 0.02), UNKNOWN);
        let empty = render(core::iter::empty()).expect("one cell");
        assert_eq!(empty.cells(), [UNKNOWN]);
    }

    #[test]
    fn robot_that_stands_long_does_not_fill_its_surroundings() {
        let scan_to = |x: f64| {
            let end = Point::new(x, 0.02);
            let hits = vec![Hit { from: Point::default(), end, is_alone: false }];
            DeskewedScan { hits, range_max: 9.0, ..DeskewedScan::default() }
        };
        // A fifth of the beams end before the wall.
        let (wall, dust) = (scan_to(1.025), scan_to(0.525));
        let scans =
            (0..200_000).map(|index| (Pose::default(), if index % 5 == 0 { &dust } else { &wall }));
        let map = render(scans).expect("a small map");
        let value = |x: f64| {
            let cell = map.frame().cell_of(&Point::new(x, 0.02)).expect("inside");
            *map.get(cell).expect("inside")
        };
        assert_eq!([value(0.525), value(1.025)], [FREE, OCCUPIED]);
    }
}
