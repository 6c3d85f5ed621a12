//! Openings that the map does not have, such as a gate that is open now.
//!
//! Beams through an opening may have no return, as those of a covered lidar. A cover turns and moves with the robot: the beams
//! beside it keep their directions. The sides of an opening keep their places: their directions change as the robot turns and drives.

use core::ops::Range;

use super::gaps;
use crate::geometry::{Point, Pose, bearing, wrap_angle};
use crate::map::Scan;
use crate::navigator::scan_visibility::{is_full_turn, ranges_towards};

/// A gap of a scan has at least this many neighbouring beams without a return.
const MIN_BEAMS: usize = 4;
/// The direction of a side is known to this many angles between two beams, and the error of two poses, radians.
const ERROR_BEAMS: f64 = 1.5;
const ERROR_RAD: f64 = 0.015;
/// Both sides of an opening have changed their directions by at least this many angles between two beams, in as many scans.
const TURNED_BEAMS: f64 = 2.0;
const TURNED_SCANS: u32 = 3;
/// Scans in a row in which a gap is not found until it is forgotten: people pass through it, or the lidar is covered.
const MISSED_GAP: u32 = 5;
const MISSED_OPENING: u32 = 300;
/// One of this many beams beside an opening has a return.
const BESIDE_BEAMS: f64 = 3.0;

/// A gap whose sides have kept their places.
#[derive(Clone, Copy, Debug)]
struct Gap {
    /// Ends of the beams on its right and on its left, in the map frame.
    sides: [Point; 2],
    /// The directions of these beams in the first scan, in the robot's frame.
    first: [f64; 2],
    missed: u32,
    /// Number of scans in which both directions had changed.
    turned: u32,
}

impl Gap {
    const fn is_opening(&self) -> bool {
        self.turned >= TURNED_SCANS
    }

    /// Directions of the right and the left side from a pose of the robot, in its frame.
    fn directions(&self, pose: &Pose, scan: &Scan) -> [f64; 2] {
        let lidar = pose.transform(&scan.origin);
        self.sides.map(|side| wrap_angle(bearing(&lidar, &side) - pose.yaw))
    }

    /// Whether the last scan shows the gap, or both sides of it while people pass through.
    fn is_seen(&self, pose: &Pose, scan: &Scan) -> bool {
        let [right, left] = self.directions(pose, scan);
        let half_angle = 0.5 * BESIDE_BEAMS * scan.angle_increment;
        let beyond = error_of(scan) + half_angle;
        let is_side = |direction: f64| {
            ranges_towards(pose, scan, pose.yaw + direction, half_angle)
                .is_some_and(|mut ranges| ranges.any(|range_m| scan.is_return(range_m)))
        };
        self.missed == 0 || is_side(right - beyond) && is_side(left + beyond)
    }
}

/// The error of a direction, radians.
fn error_of(scan: &Scan) -> f64 {
    ERROR_RAD + ERROR_BEAMS * scan.angle_increment
}

/// The gaps of the last scans.
#[derive(Clone, Debug, Default)]
pub(super) struct Openings {
    gaps: Vec<Gap>,
    /// The directions of the openings' right sides from the last scan's lidar, in the robot's frame, and the angles from there to the
    /// left sides.
    directions: Vec<(f64, f64)>,
}

impl Openings {
    /// Follows the gaps of a new scan from a pose in the map.
    pub fn update(&mut self, pose: &Pose, scan: &Scan) {
        let (error, turned) = (error_of(scan), TURNED_BEAMS * scan.angle_increment);
        self.gaps.iter_mut().for_each(|gap| gap.missed += 1);
        for beams in beams_beside_gaps(scan) {
            let seen = beams.map(|beam| scan.angle(beam));
            let differ = |one: [f64; 2], other: [f64; 2], is: &dyn Fn(f64) -> bool| {
                one.iter().zip(other).all(|(one, other)| is(wrap_angle(one - other).abs()))
            };
            let is_same =
                |gap: &&mut Gap| differ(seen, gap.directions(pose, scan), &|by| by <= error);
            if let Some(gap) = self.gaps.iter_mut().find(is_same) {
                // By the scan, and by the motion of the robot: a loose cover alone moves too.
                let has_turned = [seen, gap.directions(pose, scan)]
                    .into_iter()
                    .all(|now| differ(now, gap.first, &|by| by >= turned));
                gap.missed = 0;
                gap.turned += u32::from(has_turned);
            } else {
                let lidar = pose.transform(&scan.origin);
                let sides = beams.map(|beam| scan.end_from(&lidar, pose.yaw, beam));
                self.gaps.push(Gap { sides, first: seen, missed: 0, turned: 0 });
            }
        }
        self.gaps
            .retain(|gap| gap.missed <= if gap.is_opening() { MISSED_OPENING } else { MISSED_GAP });
        let openings = self.gaps.iter().filter(|gap| gap.is_opening() && gap.is_seen(pose, scan));
        self.directions.clear();
        self.directions.extend(openings.map(|gap| {
            let [right, left] = gap.directions(pose, scan);
            (right, wrap_angle(left - right))
        }));
    }

    /// Whether a direction in the robot's frame leads through an opening.
    pub fn contain(&self, direction: f64) -> bool {
        let is_within = |&(right, width): &(f64, f64)| {
            let from_right = wrap_angle(direction - right);
            (0.0..=width).contains(&from_right)
        };
        self.directions.iter().any(is_within)
    }
}

/// The beams on the right and on the left of each gap.
fn beams_beside_gaps(scan: &Scan) -> Vec<[usize; 2]> {
    let count = scan.ranges.len();
    // Only in a full turn the first beam follows the last. Without any return nothing is beside the gap.
    let has_sides =
        |gap: &Range<usize>| gap.len() < count && (gap.end < count || is_full_turn(scan));
    let gaps = gaps(count, |beam| scan.is_return(scan.ranges[beam]));
    let wide = gaps.into_iter().filter(|gap| gap.len() >= MIN_BEAMS && has_sides(gap));
    wide.map(|gap| [gap.start - 1, gap.end % count]).collect()
}

#[cfg(test)]
mod tests {
    use core::f64::consts::{PI, TAU};

    use super::*;
    use crate::map::{Cell, GridFrame, ObstacleGrid, RayCaster, RayEnd};
    use crate::navigator::ObservationFault;
    use crate::navigator::scan_health::ScanHealth;

    const RANGE_M: f64 = 12.0;

    /// A room of 12 by 8 m around the origin. Its right wall has a gate from y = -1 to 1 m, with nothing behind it.
    fn room(gate: bool) -> RayCaster {
        let frame = GridFrame::new(120, 80, 0.1, Pose::new(-6.0, -4.0, 0.0)).expect("a size");
        let is_gate = |cell: Cell| gate && cell.column == 119 && (30..50).contains(&cell.row);
        RayCaster::new(&ObstacleGrid::from_fn(frame, |cell| {
            let at_edge = [(cell.column, 120), (cell.row, 80)];
            at_edge.iter().any(|&(at, count)| at == 0 || at == count - 1) && !is_gate(cell)
        }))
    }

    /// A scan of the room with the open gate, without the beams in these directions from the robot.
    fn scan(pose: &Pose, is_covered: impl Fn(f64) -> bool) -> Scan {
        let mut scan = Scan {
            origin: Point::new(0.1, 0.0),
            angle_min: -PI,
            angle_increment: TAU / 360.0,
            range_max: RANGE_M,
            ranges: Vec::new(),
        };
        let lidar = pose.transform(&scan.origin);
        let rays: Vec<_> = (0..360).map(|beam| (lidar, pose.yaw + scan.angle(beam))).collect();
        let range = |(beam, end): (usize, &RayEnd)| match end {
            RayEnd::Blocked(range_m) if !is_covered(scan.angle(beam)) => *range_m,
            _ => f64::INFINITY,
        };
        scan.ranges = room(true).cast_all(&rays, RANGE_M).iter().enumerate().map(range).collect();
        scan
    }

    /// Whether the robot stopped for a lidar that is partly blind, after each of these poses.
    fn stops(
        health: &mut ScanHealth,
        poses: &[Pose],
        is_covered: impl Fn(f64) -> bool,
    ) -> Vec<bool> {
        let known = room(false);
        let stops = |pose: &Pose| {
            health.update(pose, &scan(pose, &is_covered), &known);
            health.fault() == Some(ObservationFault::LidarPartlyBlind)
        };
        poses.iter().map(stops).collect()
    }

    fn drive_m(from: Pose, metres: f64) -> Vec<Pose> {
        let ahead = |step: usize| Pose::new(0.05 * step as f64, 0.0, 0.0);
        (0..=(metres / 0.05) as usize).map(|step| from.transform_pose(&ahead(step))).collect()
    }

    #[test]
    fn robot_drives_to_an_opening_and_past_it_but_not_with_a_cover() {
        let to_gate = drive_m(Pose::new(-5.0, 0.3, 0.0), 9.0);
        let stopped = stops(&mut ScanHealth::default(), &to_gate, |_| false);
        assert_eq!(stopped.iter().position(|stops| *stops), None);
        let past = drive_m(Pose::new(-5.0, -3.0, 0.1), 9.0);
        let stopped = stops(&mut ScanHealth::default(), &past, |_| false);
        assert_eq!(stopped.iter().position(|stops| *stops), None);
        let covered = |direction: f64| (direction - 0.5).abs() < 0.25;
        for poses in [&to_gate, &past] {
            let stopped = stops(&mut ScanHealth::default(), poses, covered);
            assert!(stopped.ends_with(&[true; 30]), "{stopped:?}");
        }
    }

    #[test]
    fn turn_shows_that_an_opening_is_none_of_the_lidar() {
        let mut health = ScanHealth::default();
        let begin = Pose::new(3.0, 0.0, 0.0);
        assert!(stops(&mut health, &[begin; 5], |_| false)[4]);
        let turn: Vec<_> =
            (0..10).map(|step| Pose { yaw: 0.02 * f64::from(step), ..begin }).collect();
        let stopped = stops(&mut health, &turn, |_| false);
        assert!(stopped[2] && !stopped[9], "{stopped:?}");
        let mut health = ScanHealth::default();
        let back = Pose::new(-2.0, 0.0, PI);
        let turn: Vec<_> =
            (0..30).map(|step| Pose { yaw: PI - 0.02 * f64::from(step), ..back }).collect();
        let stopped = stops(&mut health, &turn, |direction| direction.abs() < 0.3);
        assert!(stopped[3..].iter().all(|stops| *stops), "{stopped:?}");
    }

    #[test]
    fn loose_cover_before_a_standing_robot_is_no_opening() {
        let mut health = ScanHealth::default();
        let stands = Pose::new(-2.0, 0.0, PI);
        let stops_at = |scan: u32| {
            let half_width = if scan.is_multiple_of(2) { 0.3 } else { 0.335 };
            stops(&mut health, &[stands], |direction| direction.abs() < half_width)[0]
        };
        assert!((0..40).map(stops_at).skip(2).all(|stops| stops));
    }

    #[test]
    fn cover_beside_a_known_opening_stops_the_robot() {
        let mut health = ScanHealth::default();
        let to_gate = drive_m(Pose::new(-3.0, 0.0, 0.0), 5.0);
        assert!(!stops(&mut health, &to_gate, |_| false).contains(&true));
        let stands = [to_gate[to_gate.len() - 1]; 5];
        assert!(stops(&mut health, &stands, |direction| (0.0..0.9).contains(&direction))[4]);
        assert!(!stops(&mut health, &stands, |_| false)[4], "the cover is gone");
    }
}
