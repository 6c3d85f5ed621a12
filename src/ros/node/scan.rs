//! A scan as the navigator takes it: counter-clockwise, from the robot's own origin.

use core::f64::consts::TAU;

use super::MessageError;
use crate::geometry::Pose;
use crate::localization::{DeskewedScan, PoseHistory};
use crate::map::{Beam, Scan, TimedScan};
use crate::ros::msg::LaserScan;

/// So many beams may be missing or too many by the angles: drivers round them.
const BEAMS_OFF: f64 = 2.0;
/// A lidar no farther from the robot's origin than this, metres, stands there.
const AT_ORIGIN_M: f64 = 1e-3;
/// A revolution takes no longer than this, seconds: a time between beams that says more is none.
const LONGEST_S: f64 = 1.0;
/// Most beams of a scan that is seen from elsewhere.
const MOST_BEAMS: f64 = 65_536.0;

/// A scan in the lidar's own frame.
///
/// # Errors
/// When angles, ranges and limits do not fit together.
pub fn scan(message: &LaserScan) -> Result<Scan, MessageError> {
    let [first, last, step] = [
        ("angle_min", message.angle_min),
        ("angle_max", message.angle_max),
        ("angle_increment", message.angle_increment),
    ]
    .map(|(field, angle)| finite(field, angle));
    let (first, last, step) = (first?, last?, step?);
    let range_min = finite("range_min", message.range_min)?;
    let range_max = finite("range_max", message.range_max)?;
    require("angle_increment", step, step != 0.0, "other than zero")?;
    require("range_min", range_min, range_min >= 0.0, "at least zero")?;
    let is_above = range_max > range_min;
    require("range_max", range_max, is_above, "above range_min")?;
    let found = message.ranges.len();
    let expected = ((last - first) / step).round() + 1.0;
    if found > 0 && (found as f64 - expected).abs() > BEAMS_OFF {
        return Err(MessageError::WrongBeamCount { found, expected });
    }
    let mut ranges: Vec<f64> = message
        .ranges
        .iter()
        .map(|range| measured(f64::from(*range), range_min, range_max))
        .collect();
    let mut angle_min = first;
    // A lidar that hangs or turns the other way round.
    if step < 0.0 {
        ranges.reverse();
        angle_min = first + found.saturating_sub(1) as f64 * step;
    }
    Ok(Scan {
        angle_min,
        angle_increment: step.abs(),
        range_max,
        ranges,
    })
}

/// The same in the order in which it was measured, with the time of each beam by the sender's clock. None where the message does
/// not say when that was.
pub fn sweep(message: &LaserScan, scan: &Scan) -> Option<TimedScan> {
    let (stamp, count) = (message.header.stamp, scan.ranges.len());
    if stamp.is_zero() || count == 0 {
        return None;
    }
    let step_s = f64::from(message.time_increment);
    let is_step = (0.0..=LONGEST_S / count as f64).contains(&step_s);
    let step_s = if is_step { step_s } else { 0.0 };
    let is_clockwise = message.angle_increment < 0.0;
    let beam = |index: usize| {
        let at = if is_clockwise {
            count - 1 - index
        } else {
            index
        };
        Beam {
            angle: scan.angle(at),
            range: scan.ranges[at],
            time_s: stamp.seconds() + index as f64 * step_s,
        }
    };
    Some(TimedScan {
        beams: (0..count).map(beam).collect(),
        range_max: scan.range_max,
    })
}

/// A range by REP 117: too near to be measured is as near as can be; what lies outside the limits otherwise is no measurement.
fn measured(range: f64, range_min: f64, range_max: f64) -> f64 {
    if range == f64::NEG_INFINITY {
        return range_min;
    }
    if range == f64::INFINITY || (range_min..=range_max).contains(&range) {
        return range;
    }
    f64::NAN
}

/// A scan by a lidar that is mounted at a pose of the robot's frame, as from the robot's origin at the newest pose of a track of
/// its motion: each beam is where it was when it was measured.
pub fn from_now(scan: &Scan, sweep: &TimedScan, mount: &Pose, track: &PoseHistory) -> Scan {
    let beams = sweep.beams.iter().map(|beam| beam.from_mount(mount));
    let mut view = DeskewedScan::default();
    let sweep = TimedScan {
        beams: beams.collect(),
        range_max: scan.range_max + mount.position().coords.norm(),
    };
    view.take(&sweep, track);
    // Twice as many directions as there were: a beam is moved by a quarter of an angle at most.
    let directions = (2.0 * TAU / scan.angle_increment).ceil();
    view.scan(directions.clamp(1.0, MOST_BEAMS) as usize)
}

/// A scan by a lidar that is mounted at a pose of the robot's frame, as from the robot's origin: in each direction the nearest
/// of what was hit there.
pub fn from_origin(scan: Scan, mount: &Pose) -> Scan {
    if mount.position().coords.norm() <= AT_ORIGIN_M {
        return Scan {
            angle_min: scan.angle_min + mount.yaw,
            ..scan
        };
    }
    if scan.ranges.is_empty() {
        return scan;
    }
    let beams = (TAU / scan.angle_increment).ceil().clamp(1.0, MOST_BEAMS);
    let seen = |(index, &range): (usize, &f64)| {
        let beam = Beam {
            angle: scan.angle(index),
            range,
            time_s: 0.0,
        };
        let beam = beam.from_mount(mount);
        (!range.is_nan()).then_some((beam.angle, beam.range))
    };
    Scan::from_measurements(
        beams as usize,
        scan.range_max + mount.position().coords.norm(),
        scan.ranges.iter().enumerate().filter_map(seen),
    )
}

fn finite(field: &'static str, value: f32) -> Result<f64, MessageError> {
    let is_finite = value.is_finite();
    let value = f64::from(value);
    require(field, value, is_finite, "finite").map(|()| value)
}

fn require(
    field: &'static str,
    value: f64,
    good: bool,
    expected: &'static str,
) -> Result<(), MessageError> {
    if good {
        return Ok(());
    }
    Err(MessageError::OutOfRange {
        field,
        value,
        expected,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;

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
    fn ranges_mean_what_rep_117_says() {
        let (far, near) = (f32::INFINITY, f32::NEG_INFINITY);
        let scan = scan(&message(&[1.0, far, near, 0.1, 9.0, f32::NAN])).expect("sound");
        assert_eq!(&scan.ranges[..2], [1.0, f64::INFINITY]);
        assert_eq!(scan.ranges[2], f64::from(0.2_f32));
        assert!(scan.ranges[3..].iter().all(|range| range.is_nan()));
    }

    #[test]
    fn a_clockwise_scan_is_turned_round() {
        let mut clockwise = message(&[1.0, 2.0, 3.0]);
        (clockwise.angle_min, clockwise.angle_max) = (1.0, 0.0);
        clockwise.angle_increment = -0.5;
        let scan = scan(&clockwise).expect("sound");
        assert_eq!((scan.angle_min, scan.angle_increment), (0.0, 0.5));
        assert_eq!(scan.ranges, [3.0, 2.0, 1.0]);
    }

    #[test]
    fn a_mounted_scan_hits_the_same_points() {
        let ranges: Vec<f32> = (0..12).map(|beam| 2.0 + 0.1 * beam as f32).collect();
        let seen = scan(&message(&ranges)).expect("sound");
        let mount = Pose::new(0.3, -0.2, 1.0);
        let moved = from_origin(seen.clone(), &mount);
        let hits: Vec<Point> = moved.hits(&Pose::default()).collect();
        // Of two that now lie in one direction the nearer stays.
        let away = |there: &Point| {
            let nearest = hits.iter().map(|hit| (hit - there).norm());
            nearest.fold(f64::INFINITY, f64::min) / there.coords.norm()
        };
        let offs: Vec<f64> = seen.hits(&mount).map(|there| away(&there)).collect();
        assert_eq!(offs.len(), 12);
        // Within half a beam's angle of so coarse a scan, or where that one was dropped, within a whole one's.
        let near = offs.iter().filter(|off| **off <= 0.27).count();
        assert!(near >= hits.len() && hits.len() >= 10, "{offs:?}");
        assert!(offs.iter().all(|off| *off <= 0.55), "{offs:?}");
        let turned = from_origin(seen.clone(), &Pose::new(0.0, 0.0, 1.0));
        assert_eq!((turned.angle_min, &turned.ranges), (1.0, &seen.ranges));
        let nothing = scan(&message(&[f32::INFINITY; 12])).expect("sound");
        let open = from_origin(nothing, &mount);
        assert!(open.ranges.iter().any(|range| range.is_infinite()));
        assert!(open.hits(&Pose::default()).next().is_none());
    }
}
