//! Converts a scan to the navigator's form: counter-clockwise, in the robot's frame.

use super::notices::MessageError;
use crate::geometry::{Pose, Vector};
use crate::localization::{DeskewedScan, PoseHistory};
use crate::map::{Beam, Scan, TimedScan};
use crate::ros::msg::LaserScan;
use crate::settings::require;

/// Tolerance of the number of beams: drivers round the angles.
const BEAM_COUNT_TOLERANCE: f64 = 2.0;
/// Longest revolution, seconds. A larger time between beams is ignored.
const MAX_REVOLUTION_S: f64 = 1.0;

/// A scan in the lidar's own frame.
///
/// # Errors
/// When angles, ranges and limits are inconsistent.
pub fn laser_scan(message: &LaserScan) -> Result<Scan, MessageError> {
    let first = finite("angle_min", message.angle_min)?;
    let last = finite("angle_max", message.angle_max)?;
    let step = finite("angle_increment", message.angle_increment)?;
    let range_min = finite("range_min", message.range_min)?;
    let range_max = finite("range_max", message.range_max)?;
    require(step != 0.0, "angle_increment", step, "other than zero")?;
    require(range_min >= 0.0, "range_min", range_min, "at least zero")?;
    require(range_max > range_min, "range_max", range_max, "above range_min")?;
    let found = message.ranges.len();
    let expected = ((last - first) / step).round() + 1.0;
    if found > 0 && (found as f64 - expected).abs() > BEAM_COUNT_TOLERANCE {
        return Err(MessageError::WrongBeamCount { found, expected });
    }
    let mut ranges: Vec<f64> = message
        .ranges
        .iter()
        .map(|range| measured(f64::from(*range), range_min, range_max))
        .collect();
    let mut angle_min = first;
    // A lidar that is upside down or rotates clockwise.
    if step < 0.0 {
        ranges.reverse();
        angle_min = first + found.saturating_sub(1) as f64 * step;
    }
    let scan =
        Scan { angle_min, angle_increment: step.abs(), range_max, ranges, ..Scan::default() };
    let turns = scan.turns();
    if turns > Scan::MOST_TURNS { Err(MessageError::TooManyTurns { turns }) } else { Ok(scan) }
}

/// The distance in the robot's plane of a return of a tilted lidar. `lean` is the horizontal part of the robot's upward axis in the
/// lidar's frame. The direction in the plane differs from the beam's by less than half a degree, which is left out.
pub fn level_range(angle: f64, range: f64, lean: &Vector) -> f64 {
    let (sin, cos) = libm::sincos(angle);
    let rise = lean.x * cos + lean.y * sin;
    range * (1.0 - rise * rise).sqrt()
}

/// The scan in the order of measurement, with the time of each beam by the sender's clock. None without beams.
pub fn timed_scan(message: &LaserScan, scan: &Scan) -> Option<TimedScan> {
    let (stamp, count) = (message.header.stamp, scan.ranges.len());
    if count == 0 {
        return None;
    }
    let step_s = f64::from(message.time_increment);
    let is_step = (0.0..=MAX_REVOLUTION_S / count as f64).contains(&step_s);
    let step_s = if is_step { step_s } else { 0.0 };
    let is_clockwise = message.angle_increment < 0.0;
    let beam = |index: usize| {
        let at = if is_clockwise { count - 1 - index } else { index };
        Beam {
            angle: scan.angle(at),
            range: scan.ranges[at],
            time_s: stamp.seconds() + index as f64 * step_s,
        }
    };
    let beams = (0..count).map(beam).collect();
    Some(TimedScan { beams, range_max: scan.range_max, ..TimedScan::default() })
}

/// A range by REP-117: a detection below the limits becomes the shortest range, any other value outside the limits NaN.
fn measured(range: f64, range_min: f64, range_max: f64) -> f64 {
    if range == f64::NEG_INFINITY {
        return range_min;
    }
    if range == f64::INFINITY || (range_min..=range_max).contains(&range) {
        return range;
    }
    f64::NAN
}

/// The scan with the directions of the robot's frame at the newest pose of its history. Each beam starts where the lidar was at its
/// time. `mount` is the lidar's pose on the robot.
pub fn deskew(timed: &TimedScan, mount: &Pose, history: &PoseHistory) -> Scan {
    let mut deskewed = DeskewedScan::default();
    deskewed.deskew(&timed.clone().from_mount(mount), history);
    deskewed.to_scan(timed.beams.len())
}

fn finite(field: &'static str, value: f32) -> Result<f64, MessageError> {
    require(value.is_finite(), field, f64::from(value), "finite")?;
    Ok(f64::from(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(ranges: &[f32]) -> LaserScan {
        LaserScan {
            angle_min: 0.0,
            angle_max: 0.5 * (ranges.len() - 1) as f32,
            angle_increment: 0.5,
            range_min: 0.2,
            range_max: 8.0,
            ranges: ranges.to_vec(),
            ..LaserScan::default()
        }
    }

    #[test]
    fn ranges_follow_rep_117() {
        let (far, near) = (f32::INFINITY, f32::NEG_INFINITY);
        let scan = laser_scan(&message(&[1.0, far, near, 0.1, 9.0, f32::NAN])).expect("valid");
        assert_eq!(&scan.ranges[..2], [1.0, f64::INFINITY]);
        assert_eq!(scan.ranges[2], f64::from(0.2_f32));
        assert!(scan.ranges[3..].iter().all(|range| range.is_nan()));
    }

    #[test]
    fn clockwise_scan_is_reversed() {
        let mut clockwise = message(&[1.0, 2.0, 3.0]);
        (clockwise.angle_min, clockwise.angle_max) = (1.0, 0.0);
        clockwise.angle_increment = -0.5;
        let scan = laser_scan(&clockwise).expect("valid");
        assert_eq!((scan.angle_min, scan.angle_increment), (0.0, 0.5));
        assert_eq!(scan.ranges, [3.0, 2.0, 1.0]);
    }

    #[test]
    fn converted_scan_keeps_the_field_of_view() {
        let mut part = message(&[2.0; 181]);
        (part.angle_min, part.angle_max, part.angle_increment) = (-1.5, 1.5, 0.016_666_7);
        let scan = laser_scan(&part).expect("valid");
        let timed = TimedScan::from_scan(&scan, 0.1, 0.1);
        let turn = |scan: &Scan| scan.ranges.len() as f64 * scan.angle_increment;
        for mount in [Pose::default(), Pose::new(0.2, -0.1, 2.0)] {
            let deskewed = deskew(&timed, &mount, &PoseHistory::default());
            assert!((turn(&deskewed) - 3.0).abs() < 0.02, "{}", turn(&deskewed));
            assert_eq!(deskewed.origin, mount.position());
        }
    }
}
