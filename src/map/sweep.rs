//! One revolution of a planar lidar, beam after beam: a robot moves while it turns.

use super::Scan;
use crate::geometry::{Pose, wrap_angle};

/// One measurement, from the robot's own origin as the robot stood at that moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Its direction in the robot's frame, radians, counter-clockwise.
    pub angle: f64,
    /// The range, metres. Infinite: nothing within [`TimedScan::range_max`]. NaN: no measurement.
    pub range: f64,
    /// When it was measured, seconds.
    pub time_s: f64,
}

impl Beam {
    /// The same measurement by a lidar that is mounted at a pose of the robot's frame, whose own frame its angle was in.
    #[must_use]
    pub fn from_mount(self, mount: &Pose) -> Self {
        let angle = wrap_angle(mount.yaw + self.angle);
        if !self.range.is_finite() {
            return Self { angle, ..self };
        }
        let (sin, cos) = libm::sincos(angle);
        let (x, y) = (mount.x + self.range * cos, mount.y + self.range * sin);
        Self {
            angle: libm::atan2(y, x),
            range: libm::hypot(x, y),
            ..self
        }
    }
}

/// The beams of a revolution in the order in which they were measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TimedScan {
    /// The beams; their times do not descend.
    pub beams: Vec<Beam>,
    /// Longest range the sensor reports, metres.
    pub range_max: f64,
}

impl TimedScan {
    /// A scan whose last beam was measured at a time, seconds, and whose first one so long before, seconds.
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

    /// When the last beam was measured, seconds; none of a sweep without beams.
    #[must_use]
    pub fn end_s(&self) -> Option<f64> {
        self.beams.last().map(|beam| beam.time_s)
    }

    /// Whether every beam has a direction and a time.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let is_valid = |beam: &Beam| beam.angle.is_finite() && beam.time_s.is_finite();
        self.range_max.is_finite() && self.beams.iter().all(is_valid)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scan_becomes_beams_that_end_at_its_time() {
        let scan = Scan {
            angle_min: -1.0,
            angle_increment: 0.5,
            range_max: 8.0,
            ranges: vec![1.0, f64::INFINITY, 3.0],
        };
        let sweep = TimedScan::from_scan(&scan, 7.0, 0.1);
        let angles: Vec<f64> = sweep.beams.iter().map(|beam| beam.angle).collect();
        let times: Vec<f64> = sweep.beams.iter().map(|beam| beam.time_s).collect();
        assert_eq!(
            (angles, times),
            (vec![-1.0, -0.5, 0.0], vec![6.9, 6.95, 7.0])
        );
        assert!(sweep.is_valid() && sweep.end_s() == Some(7.0));
        assert_eq!(
            TimedScan::from_scan(&Scan::default(), 7.0, 0.1).end_s(),
            None
        );
    }
}
