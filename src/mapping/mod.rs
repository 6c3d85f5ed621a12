//! Maps from lidar logs: simultaneous localization and mapping, after the drive.
//!
//! Each scan is matched to the latest ones, by the scan matcher of [`localization`](crate::localization). A node of the pose
//! graph that sees an earlier part of the map closes a loop: branch and bound correlative scan matching over submaps (Hess et
//! al. 2016) finds its place, and the graph is optimised. At the end, all nodes that are near each other are matched again.
//!
//! Results are identical at every run and on every machine: all sums run in a fixed order on one thread, and trigonometry uses
//! `libm`.

mod error;
mod log_scans;
mod loops;
mod mapper;
mod matching;
mod pose_graph;
mod render;
mod score_grid;
mod surfels;

pub use error::MappingError;
pub use log_scans::{LogScan, log_scans};
pub use render::{MAP_RESOLUTION_M, render};

use crate::geometry::Pose;
use crate::lidar_log::LidarLog;
use crate::map::{MAX_GRID_SIDE, MapError, OccupancyGrid};
use render::{MAPPED_RANGE_M, frame, shows_nothing};

/// Farthest coordinate of a pose, metres: there adjacent numbers are 0.1 micrometres apart, and at 1e15 m a whole cell.
const MAX_COORDINATE_M: f64 = 1e9;

/// A map from a log, with the poses that it rests on.
#[derive(Clone, Debug)]
pub struct MappedLog {
    /// Free, occupied and unknown cells. The first scan has the pose [`LidarLog::start`].
    pub map: OccupancyGrid,
    /// For each record of the log with a scan, its pose in the map frame.
    pub poses: Vec<Option<Pose>>,
    /// Number of nodes of the pose graph.
    pub nodes: usize,
    /// For each closed loop, the distance between its measured and its final position, metres.
    pub loop_errors_m: Vec<f64>,
    /// Errors of places that the robot visited again, metres. For each pair of nodes that are near each other and more than 20 nodes
    /// apart in time: the distance of the second node's final position from its position as matched to the first node. The match
    /// starts at the final pose, so it does not find errors beyond its range.
    pub revisit_errors_m: Vec<f64>,
    /// Number of scans that did not match the scans before them, and follow odometry.
    pub unmatched: usize,
    /// Records of scans that match near the scan before them, but not where the odometry puts them. The map follows the scans.
    pub odometry_jumps: Vec<usize>,
    /// Records of scans that do not match, after a step of the odometry of 0.25 m or 0.2 rad or more, or as the first of two in a row, and
    /// before scans that match: the map before and after them may not fit together.
    pub gaps: Vec<usize>,
}

/// Makes a map from the odometry and the scans of a log. Its corrected poses are not used, except for the first. `on_scan` is
/// called after each scan.
///
/// # Errors
/// Returns an error if no reading of the log is in range, the map is too large for a grid, or it is too far from the origin.
pub fn map_log(log: &LidarLog, on_scan: &mut dyn FnMut()) -> Result<MappedLog, MappingError> {
    let scans = log_scans(log);
    check_ranges(&scans)?;
    // No map holds such a jump. Matching moves a scan by metres at most, and searches long for it.
    let by_odometry = scans.iter().map(|scan| (scan.odometry, &scan.scan));
    if longest_step(log, &scans).0 > f64::from(MAX_GRID_SIDE) * MAP_RESOLUTION_M
        && let Err(error) = frame(by_odometry)
    {
        return Err(too_large(&error, log, &scans));
    }
    let start = log.start().unwrap_or_default();
    check_coordinates(scans.iter().map(|scan| scan.odometry).chain([start]))?;
    let solved = mapper::solve(&scans, &start, on_scan);
    let placed = solved.poses.iter().copied().zip(scans.iter().map(|scan| &scan.scan));
    let map = render(placed).map_err(|error| too_large(&error, log, &scans))?;
    let mut poses = vec![None; log.records.len()];
    for (scan, pose) in scans.iter().zip(&solved.poses) {
        poses[scan.record] = Some(*pose);
    }
    let records =
        |scans_of: Vec<usize>| scans_of.iter().map(|index| scans[*index].record).collect();
    Ok(MappedLog {
        map,
        poses,
        nodes: solved.nodes,
        loop_errors_m: solved.loop_errors_m,
        revisit_errors_m: solved.revisit_errors_m,
        unmatched: solved.unmatched,
        odometry_jumps: records(solved.odometry_jumps),
        gaps: records(solved.gaps),
    })
}

/// Checks that scans have a reading within the range that is used, 25 m.
///
/// # Errors
/// Returns an error if no reading is: most likely the ranges are not in metres.
pub fn check_ranges(scans: &[LogScan]) -> Result<(), MappingError> {
    if scans.iter().all(|scan| shows_nothing(&scan.scan)) {
        return Err(MappingError::NoReading { range_m: MAPPED_RANGE_M });
    }
    Ok(())
}

/// Checks that poses are near enough to the origin for a map.
///
/// # Errors
/// Returns an error if a coordinate is beyond 1e9 m.
pub fn check_coordinates(mut poses: impl Iterator<Item = Pose>) -> Result<(), MappingError> {
    let far = poses.find(|pose| pose.x.abs().max(pose.y.abs()) > MAX_COORDINATE_M);
    far.map_or(Ok(()), |Pose { x, y, .. }| Err(MappingError::FarFromOrigin { x, y }))
}

/// The error for a map of this size. Ranges are limited, so such scans lie far apart: most likely the odometry jumps.
fn too_large(error: &MapError, log: &LidarLog, scans: &[LogScan]) -> MappingError {
    let (width, height) = match error {
        MapError::BadGridSize { width, height } => (*width, *height),
        _ => (0, 0),
    };
    let (step_m, time_s) = longest_step(log, scans);
    MappingError::TooLarge { width, height, step_m, time_s }
}

/// The longest step of the odometry from one scan to the next, metres, and the time after it.
fn longest_step(log: &LidarLog, scans: &[LogScan]) -> (f64, f64) {
    let steps = scans.windows(2).map(|pair| {
        let step = pair[1].odometry.position() - pair[0].odometry.position();
        (step.norm(), log.records[pair[1].record].time_s)
    });
    steps.max_by(|(one_m, _), (other_m, _)| one_m.total_cmp(other_m)).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use core::f64::consts::{FRAC_PI_2, PI};
    use core::fmt::Write as _;

    use super::*;
    use crate::geometry::{Point, Vector, wrap_angle};
    use crate::trajectory::{ErrorStatistics, absolute_error};

    /// Walls of a ring of corridors 2 m wide, with niches, as segments.
    fn walls() -> Vec<(Point, Point)> {
        let mut walls = Vec::new();
        let mut line = |points: &[(f64, f64)]| {
            for pair in points.windows(2) {
                let [from, to] = [pair[0], pair[1]].map(|(x, y)| Point::new(x, y));
                walls.push((from, to));
            }
        };
        line(&[(0.0, 0.0), (5.0, 0.0), (5.0, -0.8), (6.5, -0.8), (6.5, 0.0), (14.0, 0.0)]);
        line(&[(14.0, 0.0), (14.0, 3.0), (14.6, 3.0), (14.6, 3.7), (14.0, 3.7), (14.0, 10.0)]);
        line(&[(14.0, 10.0), (9.0, 10.0), (9.0, 10.9), (7.0, 10.9), (7.0, 10.0), (0.0, 10.0)]);
        line(&[(0.0, 10.0), (0.0, 6.0), (-0.5, 6.0), (-0.5, 5.2), (0.0, 5.2), (0.0, 0.0)]);
        line(&[(2.0, 2.0), (12.0, 2.0), (12.0, 8.0), (2.0, 8.0), (2.0, 2.0)]);
        walls
    }

    fn range(walls: &[(Point, Point)], from: &Point, angle: f64) -> f64 {
        let direction = Vector::new(libm::cos(angle), libm::sin(angle));
        let hit = |(start, end): &(Point, Point)| {
            let (wall, to) = (*end - *start, *start - *from);
            let cross = |a: &Vector, b: &Vector| a.x * b.y - a.y * b.x;
            let denominator = cross(&direction, &wall);
            let (along, at) =
                (cross(&to, &wall) / denominator, cross(&to, &direction) / denominator);
            (along > 0.0 && (0.0..=1.0).contains(&at)).then_some(along)
        };
        walls.iter().filter_map(hit).fold(f64::INFINITY, f64::min)
    }

    /// A drive one and a half times around the ring: true poses, and a log whose odometry turns and slips.
    fn drive() -> (Vec<Pose>, String) {
        let corners = [(1.0, 1.0), (13.0, 1.0), (13.0, 9.0), (1.0, 9.0)];
        let mut truth = Vec::new();
        for leg in 0..6 {
            let [from, to] = [corners[leg % 4], corners[(leg + 1) % 4]];
            let (dx, dy) = (to.0 - from.0, to.1 - from.1);
            let steps = (libm::hypot(dx, dy) / 0.4).round() as usize;
            let yaw = libm::atan2(dy, dx);
            for step in 0..steps {
                let along = step as f64 / steps as f64;
                truth.push(Pose::new(from.0 + along * dx, from.1 + along * dy, yaw));
            }
            for turn in 1..4 {
                let yaw = wrap_angle(yaw + FRAC_PI_2 * f64::from(turn) / 4.0);
                truth.push(Pose::new(to.0, to.1, yaw));
            }
        }
        let walls = walls();
        let mut odometry = Pose::default();
        let mut text = String::new();
        for (index, pose) in truth.iter().enumerate() {
            if index > 0 {
                let step = truth[index - 1].inverse_transform_pose(pose);
                let wrong = Pose::new(0.95 * step.x, step.y, 0.97 * step.yaw + 0.006);
                odometry = odometry.transform_pose(&wrong);
            }
            let _ = write!(text, "FLASER 181");
            for beam in 0..181 {
                let angle = pose.yaw - FRAC_PI_2 + PI * f64::from(beam) / 180.0;
                let noise = 0.01 * libm::sin(12.9 * f64::from(beam) + 7.3 * index as f64);
                let _ = write!(text, " {:.3}", range(&walls, &pose.position(), angle) + noise);
            }
            let Pose { x, y, yaw } = odometry;
            let time_s = 0.5 * index as f64;
            let _ = writeln!(text, " {x} {y} {yaw} {x} {y} {yaw} {time_s} host {time_s}");
        }
        (truth, text)
    }

    #[test]
    fn map_of_a_ring_is_straight_and_equal_at_every_run() {
        let (truth, text) = drive();
        let log = LidarLog::parse(&text).expect("a valid log");
        let mapped = map_log(&log, &mut || ()).expect("a small map");
        let poses: Vec<Pose> = mapped.poses.iter().flatten().copied().collect();
        let error = |poses: &[Pose]| {
            let pairs: Vec<_> = poses.iter().copied().zip(truth.iter().copied()).collect();
            absolute_error(&pairs).expect("there are poses")
        };
        let odometry: Vec<Pose> = log.records.iter().map(|record| record.odometry).collect();
        assert!(error(&odometry).position_m.max > 1.0);
        let found = error(&poses);
        assert!(found.position_m.max < 0.05, "{found:?}");
        assert!(found.yaw_rad.max < 0.01, "{found:?}");
        assert_eq!(mapped.unmatched, 0);
        // The corridors of the ring look alike, so some loops are wrong; they lose their weight.
        let loops = ErrorStatistics::of(mapped.loop_errors_m.clone()).expect("a closed loop");
        assert!(loops.median < 0.03, "{loops:?}");
        // The robot drives half of the ring twice.
        let revisits = ErrorStatistics::of(mapped.revisit_errors_m.clone()).expect("revisits");
        assert!(mapped.revisit_errors_m.len() > 50 && revisits.median < 0.02, "{revisits:?}");
        let again = map_log(&log, &mut || ()).expect("a small map");
        assert_eq!((again.map, again.poses), (mapped.map, mapped.poses));
    }

    /// The odometry moves too far, turns, or restarts, at a corner and in a corridor.
    #[test]
    fn jump_of_odometry_does_not_break_the_map() {
        let (truth, text) = drive();
        let log = LidarLog::parse(&text).expect("a valid log");
        for (at, jump) in [
            (57, Pose::new(3.0, 0.0, 0.0)),
            (57, Pose::new(0.0, 0.0, 1.2)),
            (57, Pose::new(-6.0, 3.0, 2.5)),
            (75, Pose::new(6.0, 0.0, 0.0)),
        ] {
            let mut log = log.clone();
            for record in &mut log.records[at..] {
                record.odometry = jump.transform_pose(&record.odometry);
            }
            let mapped = map_log(&log, &mut || ()).expect("a small map");
            assert_eq!((&mapped.odometry_jumps[..], mapped.gaps.len()), (&[at][..], 0), "{jump:?}");
            let pairs = mapped.poses.iter().flatten().copied().zip(truth.iter().copied());
            let error = absolute_error(&pairs.collect::<Vec<_>>()).expect("there are poses");
            assert!(error.position_m.max < 0.05, "{jump:?}: {error:?}");
        }
    }

    /// The log of another place follows.
    #[test]
    fn gap_of_a_log_is_named() {
        let (_, text) = drive();
        let mut log = LidarLog::parse(&text).expect("a valid log");
        log.records.drain(20..70);
        let mapped = map_log(&log, &mut || ()).expect("a small map");
        assert_eq!((&mapped.odometry_jumps[..], &mapped.gaps[..]), (&[][..], &[20][..]));
    }

    /// The robot is carried into a round room while its wheels stand still. It stands there for a while, and drives on. Or it also
    /// drives a step just before, with a blind lidar: that is no second gap.
    #[test]
    fn robot_that_was_carried_without_odometry_leaves_a_gap() {
        let (_, text) = drive();
        let first: Vec<&str> = text.lines().take(20).collect();
        let first = first.join("\n") + "\n";
        let log = LidarLog::parse(&first).expect("a valid log");
        let carried = log.records[19].odometry;
        for (step_m, is_blind) in [(0.0, false), (0.3, true)] {
            let mut text = first.clone();
            for index in 20..50 {
                let driven_m = 0.1 * f64::from((index - 30).max(0));
                let Pose { x, y, yaw } =
                    carried.transform_pose(&Pose::new(step_m + driven_m, 0.0, 0.0));
                let _ = write!(text, "FLASER 181");
                for beam in 0..181 {
                    let (sin, cos) = libm::sincos(PI * f64::from(beam) / 180.0 - FRAC_PI_2);
                    let across = driven_m * sin;
                    let range = (9.0 - across * across).sqrt() - driven_m * cos;
                    let _ =
                        write!(text, " {:.3}", if is_blind && index == 20 { 81.91 } else { range });
                }
                let time_s = 0.5 * f64::from(index);
                let _ = writeln!(text, " {x} {y} {yaw} {x} {y} {yaw} {time_s} host {time_s}");
            }
            let log = LidarLog::parse(&text).expect("a valid log");
            let mapped = map_log(&log, &mut || ()).expect("a small map");
            assert_eq!((&mapped.odometry_jumps[..], &mapped.gaps[..]), (&[][..], &[20][..]));
        }
    }

    #[test]
    fn log_of_one_scan_has_a_map() {
        let log = LidarLog::parse("FLASER 1 3 0 0 0 0 0 0 1 host 1\n").expect("a valid log");
        let mapped = map_log(&log, &mut || ()).expect("a small map");
        assert_eq!(mapped.poses, [Some(Pose::default())]);
    }

    #[test]
    fn log_without_readings_in_range_has_no_map() {
        // Nothing, no echo, and three metres in millimetres.
        for reading in ["0", "81.91", "3000"] {
            let text = format!("FLASER 1 {reading} 0 0 0 0 0 0 1 host 1\n");
            let log = LidarLog::parse(&text).expect("a valid log");
            let refused = map_log(&log, &mut || ()).err();
            assert_eq!(refused, Some(MappingError::NoReading { range_m: 25.0 }), "{reading}");
        }
    }

    #[test]
    fn log_far_from_the_origin_is_named() {
        let scan = |time_s: u32| format!("FLASER 1 3 1e17 0 0 1e17 0 0 {time_s} host {time_s}\n");
        let log = LidarLog::parse(&(scan(1) + &scan(2))).expect("a valid log");
        let error = map_log(&log, &mut || ()).expect_err("no map").to_string();
        assert!(error.contains("(1e17, 0.0), farther than 1000000000.0 m"), "{error}");
    }

    #[test]
    fn jump_of_odometry_is_named_with_its_time() {
        let scan = |at_m: f64, time_s: f64| {
            format!("FLASER 1 3 {at_m} {at_m} 0 {at_m} {at_m} 0 {time_s} host {time_s}\n")
        };
        // Beyond the longest side of a map, and beyond its area.
        for (jump_m, step) in [(5000.0, "7071.1 m"), (900.0, "1272.8 m")] {
            let text = scan(0.0, 1.0)
                + &scan(0.3, 1.5)
                + &scan(0.3 + jump_m, 2.0)
                + &scan(0.5 + jump_m, 2.5);
            let log = LidarLog::parse(&text).expect("a valid log");
            let error = map_log(&log, &mut || ()).expect_err("too large").to_string();
            assert!(error.contains(&format!("by up to {step}, at 2.000 s")), "{error}");
        }
    }
}
