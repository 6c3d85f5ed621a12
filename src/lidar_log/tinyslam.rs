//! The `.dat` files of tinySLAM: one line for each revolution of a Hokuyo URG-04LX, with the counts of both wheels.
//!
//! Fields, geometry and scale are those of the published tinySLAM source (`test/test_loop_closing.c`, `CoreSLAM_state.c`):
//! time in microseconds, an unused field, left and right wheel count, 20 unused fields, 682 ranges in millimetres over 240
//! degrees; wheels of 0.077 m radius with 2000 counts per turn, 0.165 m from the robot's centre; the lidar 0.145 m before it.
//! A revolution of 360 degrees lasts 0.1 s. The time and the counts are taken as those of the last beam, since the scans of both
//! published logs agree better with each other so than with the first beam.
//!
//! The range zero, and the values below 20 mm, are codes of the sensor for no measurement.

use core::f64::consts::{FRAC_PI_3, PI};

use super::fields::Fields;
use super::{LogError, LogRecord, LoggedScan};
use crate::geometry::{Pose, wrap_angle};
use crate::map::{Beam, TimedScan};

/// Number of ranges, and smallest number of fields of a line.
const RANGES: usize = 682;
const UNUSED: usize = 20;
pub(super) const FIELDS: usize = 4 + UNUSED + RANGES;

/// Metres of a wheel per count.
const M_PER_COUNT: f64 = 2.0 * PI * 0.077 / 2000.0;
/// Half the distance between the wheels, metres.
const HALF_TRACK_M: f64 = 0.165;
/// Place of the lidar before the robot's centre, metres.
const MOUNT_M: f64 = 0.145;
/// The beams cover this angle on both sides, radians.
const SIDE_RAD: f64 = 2.0 * FRAC_PI_3;
/// Time of the beams of a revolution, seconds: 240 of 360 degrees at 10 Hz.
const SWEEP_S: f64 = 0.1 * 2.0 / 3.0;
/// Ranges below this are error codes, and those above the sensor's limit are no measurements, metres.
const RANGE_M: (f64, f64) = (0.02, 5.6);

pub(super) fn parse(text: &str) -> Result<Vec<LogRecord>, LogError> {
    let mut records = Vec::new();
    let mut before: Option<(i64, i64)> = None;
    let mut odometry = Pose::default();
    for (index, line) in text.lines().enumerate() {
        if line.trim().is_empty() {
            continue;
        }
        let mut fields = Fields::new(index + 1, "a revolution", line.split_whitespace());
        let time_s = fields.whole("time")? as f64 * 1e-6;
        fields.skip(1, "second field")?;
        let counts = (fields.whole("left wheel count")?, fields.whole("right wheel count")?);
        fields.skip(UNUSED, "unused fields")?;
        let ranges = fields.numbers(RANGES, "682 ranges")?;
        // The published logs have a further number at the end of each line.
        if !fields.is_empty() {
            fields.skip(1, "further field")?;
        }
        if !fields.is_empty() {
            let word = fields.word("further field")?;
            let expected = "the end of the line: a file whose lines end with CR alone needs LF";
            return Err(fields.bad("field after its 682 ranges", word, expected));
        }
        if let Some((left, right)) = before.replace(counts) {
            let travel_m = |now: i64, before: i64| M_PER_COUNT * now.wrapping_sub(before) as f64;
            odometry = moved(&odometry, travel_m(counts.0, left), travel_m(counts.1, right));
        }
        let scan = Some(scan(&ranges, time_s));
        records.push(LogRecord { time_s, odometry, corrected: None, scan });
    }
    Ok(records)
}

/// The pose after a travel of the left and right wheel, metres, along an arc.
fn moved(pose: &Pose, left_m: f64, right_m: f64) -> Pose {
    let (distance_m, turn) =
        (f64::midpoint(left_m, right_m), (right_m - left_m) / (2.0 * HALF_TRACK_M));
    let (sin, cos) = libm::sincos(pose.yaw + 0.5 * turn);
    Pose::new(pose.x + distance_m * cos, pose.y + distance_m * sin, wrap_angle(pose.yaw + turn))
}

fn scan(ranges_mm: &[f64], end_s: f64) -> LoggedScan {
    let mount = Pose::new(MOUNT_M, 0.0, 0.0);
    let gaps = (RANGES - 1) as f64;
    let beam = |(index, range_mm): (usize, &f64)| {
        let fraction = index as f64 / gaps;
        let range = range_mm * 1e-3;
        let is_measured = range >= RANGE_M.0 && range <= RANGE_M.1;
        Beam {
            angle: SIDE_RAD * (2.0 * fraction - 1.0),
            range: if is_measured { range } else { f64::NAN },
            time_s: end_s - SWEEP_S * (1.0 - fraction),
        }
    };
    let beams = ranges_mm.iter().enumerate().map(beam).collect();
    let beams = TimedScan { beams, range_max: RANGE_M.1, ..TimedScan::default() };
    LoggedScan { mount, beams: beams.from_mount(&mount) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With CR alone at the ends of its lines, a whole file is one line. The published logs have one number more than they need.
    #[test]
    fn line_with_more_than_a_revolution_is_refused() {
        let line = |ending: &str| {
            format!("1000000 0 0 0 {}{}{ending}", "0 ".repeat(UNUSED), "1000 ".repeat(RANGES))
        };
        assert_eq!(parse(&line("0\n")).map(|records| records.len()), Ok(1));
        let error = parse(&(line("\r") + &line("\r"))).expect_err("two revolutions");
        let text = error.to_string();
        assert!(text.starts_with("line 1: ") && text.contains("CR alone"), "{text}");
    }
}
