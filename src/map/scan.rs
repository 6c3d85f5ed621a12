//! Planar lidar scans: with all beams at one moment ([`Scan`]), and with a time for each beam ([`TimedScan`]).

use core::f64::consts::{PI, TAU};

use crate::geometry::{Point, Pose, wrap_angle};

/// Ranges measured at equal angles, counter-clockwise, from the robot's origin.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Scan {
    /// Direction of the first beam in the robot's frame, radians.
    pub angle_min: f64,
    /// Angle between adjacent beams, radians, above zero.
    pub angle_increment: f64,
    /// Largest range of the sensor, metres, above zero.
    pub range_max: f64,
    /// A range for each beam, metres. Infinite: nothing within `range_max`. NaN, zero and below: no measurement.
    pub ranges: Vec<f64>,
}

impl Scan {
    /// Creates a full-turn scan of `beams` equal angles from measurements in any direction, each a direction in radians and
    /// a range in metres. Each beam has its smallest range, or NaN without a measurement. A range that is NaN, zero or below, and a
    /// direction that is not finite, are no measurement.
    #[must_use]
    pub fn from_measurements(
        beams: usize,
        range_max: f64,
        measured: impl Iterator<Item = (f64, f64)>,
    ) -> Self {
        let angle_increment = TAU / beams.max(1) as f64;
        let mut ranges = vec![f64::NAN; beams];
        for (direction, range) in measured.filter(is_measured) {
            // The nearest beam: an evenly spaced lidar measures in the directions of the beams, and no rounding may put
            // two of its measurements into one beam and none into the next.
            let beam = ((direction + PI) / angle_increment).round();
            let beam = beam.rem_euclid(beams as f64) as usize;
            if let Some(smallest) = ranges.get_mut(beam.min(beams.saturating_sub(1))) {
                // `f64::min` ignores the NaN of a beam without a measurement.
                *smallest = smallest.min(range);
            }
        }
        Self { angle_min: -PI, angle_increment, range_max, ranges }
    }

    /// As [`Self::from_measurements`], of a lidar that measures in `beams` directions of a field of view alone: from a direction
    /// counter-clockwise by an angle, both in radians. The scan is wider where measurements lie beyond that field.
    pub(crate) fn from_measurements_within(
        (from, turn): (f64, f64),
        beams: usize,
        range_max: f64,
        measured: impl Iterator<Item = (f64, f64)>,
    ) -> Self {
        let angle_increment = turn / (beams.max(2) - 1) as f64;
        let half_unseen = 0.5 * (TAU - turn);
        let before = (half_unseen / angle_increment).ceil() as usize;
        let mut ranges = vec![f64::NAN; beams + 2 * before];
        let mut seen = before..before + beams;
        for (direction, range) in measured.filter(is_measured) {
            let turned = (direction - from + half_unseen).rem_euclid(TAU) - half_unseen;
            let beam = (turned / angle_increment).round() + before as f64;
            let beam = (beam.max(0.0) as usize).min(ranges.len() - 1);
            ranges[beam] = ranges[beam].min(range);
            seen = seen.start.min(beam)..seen.end.max(beam + 1);
        }
        let angle_min = from + (seen.start as f64 - before as f64) * angle_increment;
        Self { angle_min, angle_increment, range_max, ranges: ranges[seen].to_vec() }
    }

    /// The direction of a beam in the robot's frame, radians.
    #[must_use]
    pub fn angle(&self, beam: usize) -> f64 {
        self.angle_min + beam as f64 * self.angle_increment
    }

    /// Whether every beam has a direction, and the sensor a largest range above zero. A scan without beams is valid.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        self.ranges.is_empty()
            || (self.angle_min.is_finite()
                && self.angle_increment.is_finite()
                && self.angle_increment > 0.0
                && self.range_max.is_finite()
                && self.range_max > 0.0)
    }

    /// Whether a range is that of a return: above zero and at most [`Self::range_max`].
    #[must_use]
    pub fn is_return(&self, range: f64) -> bool {
        is_return(range, self.range_max)
    }

    /// The beam end points in the map frame, for a robot at this pose. Beams without a return give no point.
    pub fn hits(&self, pose: &Pose) -> impl Iterator<Item = Point> + '_ {
        let pose = *pose;
        let beams = self.ranges.iter().enumerate();
        beams.filter(|(_, range)| self.is_return(**range)).map(move |(beam, &range)| {
            let (sin, cos) = libm::sincos(pose.yaw + self.angle(beam));
            Point::new(pose.x + range * cos, pose.y + range * sin)
        })
    }
}

/// Whether a range is that of a return, for a sensor with this largest range.
fn is_return(range: f64, range_max: f64) -> bool {
    range > 0.0 && range <= range_max
}

/// Whether a direction and a range are a measurement.
fn is_measured(&(direction, range): &(f64, f64)) -> bool {
    direction.is_finite() && range > 0.0
}

/// A single lidar measurement, relative to the robot's origin at its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Direction in the robot's frame, radians, counter-clockwise.
    pub angle: f64,
    /// Range, metres. Infinite: nothing within [`TimedScan::range_max`]. NaN, zero and below: no measurement.
    pub range: f64,
    /// Time of the measurement, seconds.
    pub time_s: f64,
}

impl Beam {
    /// Whether the beam has a return, for a sensor with this largest range, metres.
    pub(crate) fn is_return(&self, range_max: f64) -> bool {
        is_return(self.range, range_max)
    }

    /// Converts a measurement from the frame of a lidar to the robot's frame; `mount` is the pose of the lidar there. A range
    /// that is no measurement becomes NaN.
    #[must_use]
    pub fn from_mount(self, mount: &Pose) -> Self {
        let angle = wrap_angle(mount.yaw + self.angle);
        let is_measured = self.range > 0.0;
        if !is_measured || self.range.is_infinite() {
            return Self { angle, range: if is_measured { self.range } else { f64::NAN }, ..self };
        }
        let (sin, cos) = libm::sincos(angle);
        let (x, y) = (mount.x + self.range * cos, mount.y + self.range * sin);
        Self { angle: libm::atan2(y, x), range: libm::hypot(x, y), ..self }
    }
}

/// The beams of one lidar revolution, each with its own time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TimedScan {
    /// The beams, in the order of measurement where the lidar keeps it.
    pub beams: Vec<Beam>,
    /// Largest range of the sensor, metres.
    pub range_max: f64,
}

impl TimedScan {
    /// Distributes the beams of a scan evenly over `duration_s`; the last beam has the time `end_s`, seconds.
    #[must_use]
    pub fn from_scan(scan: &Scan, end_s: f64, duration_s: f64) -> Self {
        let gaps = (scan.ranges.len().max(2) - 1) as f64;
        let beam = |(index, &range): (usize, &f64)| Beam {
            angle: scan.angle(index),
            range,
            time_s: end_s - duration_s * (1.0 - index as f64 / gaps),
        };
        Self {
            beams: scan.ranges.iter().enumerate().map(beam).collect(),
            range_max: scan.range_max,
        }
    }

    /// Converts the beams from the frame of a lidar to the robot's frame; `mount` is the pose of the lidar there.
    #[must_use]
    pub fn from_mount(mut self, mount: &Pose) -> Self {
        // The direction of a beam in the robot's frame depends on its range. One without a measurement has that of the beam before.
        // With any other one, a lidar of less than a full turn seems to look, and to see nothing, beyond its field of view.
        let mut ranges = self.beams.iter().map(|beam| beam.range);
        let mut known = ranges.find(|range| !range.is_nan()).unwrap_or(f64::INFINITY);
        for beam in &mut self.beams {
            let range = beam.range;
            if !range.is_nan() {
                known = range;
            }
            *beam = Beam { range: known, ..*beam }.from_mount(mount);
            if range.is_nan() {
                beam.range = range;
            }
        }
        self.range_max += mount.position().to_vector().norm();
        self
    }

    /// Time of the newest beam, seconds, in any order of the beams; none without beams.
    #[must_use]
    pub fn end_s(&self) -> Option<f64> {
        self.beams.iter().map(|beam| beam.time_s).reduce(f64::max)
    }

    /// Whether every beam has a finite direction and time.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let is_valid = |beam: &Beam| beam.angle.is_finite() && beam.time_s.is_finite();
        self.range_max.is_finite() && self.beams.iter().all(is_valid)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A lidar behind the robot's origin that looks back, 0.7 m from the walls at both sides.
    #[test]
    fn beam_without_a_measurement_keeps_the_field_of_view_of_a_mounted_lidar() {
        let mount = Pose::new(-0.25, 0.0, PI);
        let beam = |angle: f64| Beam { angle, range: 0.7 / libm::sin(angle).abs(), time_s: 0.0 };
        let beams: Vec<Beam> = (-9..=9).map(|step| beam(0.25 * f64::from(step) + 1e-3)).collect();
        let scan = TimedScan { beams, range_max: 10.0 };
        let ahead = |scan: &TimedScan| {
            let angles = scan.beams.iter().map(|beam| beam.angle.abs());
            angles.fold(f64::INFINITY, f64::min)
        };
        let whole = ahead(&scan.clone().from_mount(&mount));
        let mut dropped = scan;
        let last = dropped.beams.len() - 1;
        for at in [0, last] {
            dropped.beams[at].range = f64::NAN;
        }
        let dropped = dropped.from_mount(&mount);
        assert!(dropped.beams[0].range.is_nan() && dropped.beams[last].range.is_nan());
        assert!(ahead(&dropped) > whole - 0.1, "{} of {whole}", ahead(&dropped));
        assert!((dropped.range_max - 10.25).abs() < 1e-12);
    }
}
