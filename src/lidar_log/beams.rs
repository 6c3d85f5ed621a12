//! From the readings of a line to the beams of a scan.

use core::f64::consts::{FRAC_PI_2, PI};
use std::collections::BTreeMap;

use super::{LogRecord, LoggedScan};
use crate::geometry::Pose;
use crate::map::{Beam, TimedScan};

/// Longest range of a SICK LMS, metres: readings of 81.83 m and more are its codes for no echo, dazzle and faults (13 bits,
/// 8183 and up; SICK, "Telegrams for Operating/Configuring the LMS 2xx", 2006).
pub(super) const SICK_RANGE_M: f64 = 80.0;

/// A largest reading that is at least this fraction of all readings is the sensor's value for no echo.
const SATURATED_FRACTION: f64 = 0.005;

/// Direction of the first beam and angle between beams of a scan without stated angles, radians: a half turn in front of the
/// lidar, as CARMEN assumes. 180 and 360 readings lack the last one of 181 and 361.
pub(super) fn half_turn(readings: usize) -> (f64, f64) {
    let gaps = if readings.is_multiple_of(2) { readings } else { readings - 1 };
    (-FRAC_PI_2, PI / gaps.max(1) as f64)
}

/// A scan without beam times. Readings outside the lidar's range are no measurements: glass and black surfaces give no echo
/// either, so such a beam shows no free space.
pub(super) fn scan(
    readings: &[f64],
    (first, step): (f64, f64),
    range_max: f64,
    mount: &Pose,
    time_s: f64,
) -> LoggedScan {
    let beam = |(index, &range): (usize, &f64)| {
        let range = if range > 0.0 && range <= range_max { range } else { f64::NAN };
        Beam { angle: first + step * index as f64, range, time_s }
    };
    let beams = readings.iter().enumerate().map(beam).collect();
    let beams = TimedScan { beams, range_max, ..TimedScan::default() }.from_mount(mount);
    LoggedScan { mount: *mount, beams }
}

/// Removes the limit of each lidar from its readings, see [`remove_limit`]. Each lidar has a place on the robot.
pub(super) fn remove_limits(records: &mut [LogRecord]) {
    let mut lidars: BTreeMap<[u64; 3], Vec<&mut LoggedScan>> = BTreeMap::new();
    for scan in records.iter_mut().filter_map(|record| record.scan.as_mut()) {
        let Pose { x, y, yaw } = scan.mount;
        lidars.entry([x, y, yaw].map(f64::to_bits)).or_default().push(scan);
    }
    lidars.values_mut().for_each(|scans| remove_limit(scans));
}

/// Removes the readings of a lidar at the largest value if they are too many for a measured distance: a sensor that reports its
/// limit.
pub(crate) fn remove_limit(scans: &mut [&mut LoggedScan]) {
    let mut counts: BTreeMap<u64, usize> = BTreeMap::new();
    let (mut readings, mut largest) = (0_usize, 0.0_f64);
    for beam in scans.iter().flat_map(|scan| &scan.beams.beams) {
        if beam.range.is_finite() {
            readings += 1;
            largest = largest.max(beam.range);
            *counts.entry(beam.range.to_bits()).or_default() += 1;
        }
    }
    let at_largest = counts.get(&largest.to_bits()).copied().unwrap_or_default();
    if at_largest < 10 || (at_largest as f64) < SATURATED_FRACTION * readings as f64 {
        return;
    }
    for beam in scans.iter_mut().flat_map(|scan| &mut scan.beams.beams) {
        if beam.range == largest {
            beam.range = f64::NAN;
        }
    }
}
