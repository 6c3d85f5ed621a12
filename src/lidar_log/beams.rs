//! From the readings of a line to the beams of a scan.

use core::f64::consts::{FRAC_PI_2, PI};
use std::collections::BTreeMap;

use super::{LogRecord, LoggedScan};
use crate::geometry::Pose;
use crate::map::{Beam, TimedScan};

/// Longest range of a SICK LMS, metres: readings of 81.83 m and more are its codes for no echo, dazzle and faults (13 bits,
/// 8183 and up; SICK, "Telegrams for Operating/Configuring the LMS 2xx", 2006).
pub(super) const SICK_RANGE_M: f64 = 80.0;

/// The values of a lidar for no echo are at least this fraction of its readings, and at least this number.
const CODES_FRACTION: f64 = 0.005;
const MIN_CODES: usize = 10;
/// Such values of a lidar lie within this distance of each other, metres: 8.183 to 8.191 m for a SICK LMS in its mode for 8 m.
const CODES_M: f64 = 0.1;
/// Glass and mirrors give single readings beyond them, up to this fraction of them. It is also the smallest fraction of the
/// lowest value.
const STRAY_FRACTION: f64 = 0.01;
/// The lowest value occurs this number of times as often as each value down to this distance below it, metres. Noise spreads a
/// measured distance over several values.
const TIMES_AS_OFTEN: usize = 5;
const BELOW_M: f64 = 0.5;

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

/// Removes the values for no echo of each lidar, see [`remove_limit`]. Each lidar has a place on the robot.
pub(super) fn remove_limits(records: &mut [LogRecord]) {
    let mut lidars: BTreeMap<[u64; 3], Vec<&mut LoggedScan>> = BTreeMap::new();
    for scan in records.iter_mut().filter_map(|record| record.scan.as_mut()) {
        let Pose { x, y, yaw } = scan.mount;
        lidars.entry([x, y, yaw].map(f64::to_bits)).or_default().push(scan);
    }
    lidars.values_mut().for_each(|scans| remove_limit(scans));
}

/// Removes the readings of a lidar that has a value for no echo: those at and above that value.
pub(crate) fn remove_limit(scans: &mut [&mut LoggedScan]) {
    let ranges = scans.iter().flat_map(|scan| &scan.beams.beams).map(|beam| beam.range);
    let mut ranges: Vec<f64> = ranges.filter(|range| range.is_finite()).collect();
    ranges.sort_unstable_by(f64::total_cmp);
    let Some(limit) = lowest_code(&ranges) else {
        return;
    };
    for beam in scans.iter_mut().flat_map(|scan| &mut scan.beams.beams) {
        if beam.range >= limit {
            beam.range = f64::NAN;
        }
    }
}

/// The lowest value for no echo in sorted ranges. It is the largest range of all, or it occurs far more often than the values
/// below it, and few ranges lie beyond it. A value without others is that of a surface: nothing shows that it is none.
fn lowest_code(ranges: &[f64]) -> Option<f64> {
    let values: Vec<&[f64]> = ranges.chunk_by(|one, other| one == other).collect();
    if values.len() == 1 {
        return None;
    }
    let first = |range_m: f64| ranges.partition_point(|range| *range < range_m);
    let is_code = |&(index, equal): &(usize, &&[f64])| {
        let beyond = ranges.len() - first(equal[0] + CODES_M);
        let codes = ranges.len() - first(equal[0]) - beyond;
        let is_few = |count: usize| (count as f64) < STRAY_FRACTION * codes as f64;
        let below = || &values[values.partition_point(|it| it[0] < equal[0] - BELOW_M)..index];
        codes >= MIN_CODES
            && codes as f64 >= CODES_FRACTION * ranges.len() as f64
            && !is_few(equal.len())
            && is_few(beyond)
            && (index + 1 == values.len()
                || below().iter().all(|it| equal.len() >= TIMES_AS_OFTEN * it.len()))
    };
    values.iter().enumerate().find(is_code).map(|(_, equal)| equal[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A drive whose lidar measures distances up to `limit_m`, evenly spread and printed with a number of decimals, and has `codes`
    /// instead of longer ones. Each scan has 20 measured distances and 5 codes in turn. Returns the largest range that is left.
    fn largest_left(limit_m: f64, decimals: i32, codes: &[f64], stray: &[f64]) -> f64 {
        let unit = libm::pow(10.0, f64::from(decimals));
        let mut left: Vec<f64> = Vec::new();
        for index in 0..4000_u32 {
            let spread = libm::fmod(0.618_034 * f64::from(index), 1.0);
            left.push((spread * limit_m * unit).round() / unit);
        }
        left.extend(codes.iter().cycle().take(1000));
        left.extend(stray);
        let mut scans: Vec<LoggedScan> = left
            .chunks(25)
            .map(|readings| scan(readings, half_turn(25), SICK_RANGE_M, &Pose::default(), 0.0))
            .collect();
        remove_limit(&mut scans.iter_mut().collect::<Vec<_>>());
        let beams = scans.iter().flat_map(|scan| &scan.beams.beams);
        beams.map(|beam| beam.range).filter(|range| range.is_finite()).fold(0.0, f64::max)
    }

    #[test]
    fn values_for_no_echo_are_removed_with_stray_readings_above() {
        for (codes, stray) in [
            (&[8.0][..], &[][..]),
            (&[8.0], &[8.05]),
            (&[8.0], &[8.01, 8.05, 11.0, 23.5, 60.0]),
            (&[8.18, 8.19], &[]),
            (&[8.18, 8.18, 8.18, 8.18, 8.18, 8.18, 8.18, 8.18, 8.18, 8.19], &[]),
            (&[8.18, 8.19, 8.19, 8.19, 8.19, 8.19, 8.19, 8.19, 8.19, 8.19], &[9.0]),
            (&[8.183, 8.184, 8.185, 8.186, 8.187, 8.188, 8.189, 8.19, 8.191], &[]),
        ] {
            for decimals in [2, 3] {
                let largest = largest_left(8.0, decimals, codes, stray);
                assert!(largest > 7.9 && largest < codes[0], "{codes:?} {stray:?}: {largest}");
            }
        }
    }

    #[test]
    fn equal_readings_are_measured_distances() {
        let readings = [3.0; 25];
        let mut scan = scan(&readings, half_turn(25), SICK_RANGE_M, &Pose::default(), 0.0);
        remove_limit(&mut [&mut scan]);
        assert!(scan.beams.beams.iter().all(|beam| beam.range == 3.0));
    }

    #[test]
    fn measured_distances_stay() {
        // None, single longer readings, and a wall with noise that a robot sees as it stands.
        let noise =
            |mm: u32| core::iter::repeat_n(7.97 + 1e-3 * f64::from(mm), mm.min(60 - mm) as usize);
        let wall: Vec<f64> = (0..60).flat_map(noise).collect();
        assert!(largest_left(8.0, 2, &[3.0], &[]) > 7.9);
        assert!(largest_left(8.0, 2, &[3.0], &[9.0; 9]) > 8.9);
        assert!(largest_left(8.0, 3, &wall, &[]) > 8.02);
    }
}
