//! Planar lidar scans: with all beams at one moment ([`Scan`]), and with a time for each beam ([`TimedScan`]).

use core::f64::consts::{PI, TAU};

use crate::geometry::{Point, Pose, Vector, wrap_angle};

/// Ranges measured at equal angles, counter-clockwise, from the place of the lidar.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Scan {
    /// Place of the lidar in the robot's frame, metres.
    pub origin: Point,
    /// Direction of the first beam in the robot's frame, radians.
    pub angle_min: f64,
    /// Angle between adjacent beams, radians, above zero.
    pub angle_increment: f64,
    /// Largest range of the sensor, metres, above zero.
    pub range_max: f64,
    /// A range for each beam, metres. Infinite: nothing within `range_max`. NaN, zero and below: no measurement.
    pub ranges: Vec<f64>,
}

/// What is wrong with a scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, thiserror::Error)]
#[non_exhaustive]
pub enum ScanError {
    /// A coordinate of the lidar is not finite.
    #[error("the place of the lidar is not finite")]
    Place,
    /// The direction of the first beam is not finite.
    #[error("angle_min of the scan is not finite")]
    FirstAngle,
    /// The angle between beams is not finite, or not above zero.
    #[error("angle_increment of the scan is not finite and above zero")]
    AngleIncrement,
    /// The largest range is not finite, or not above zero.
    #[error("range_max of the scan is not finite and above zero")]
    LargestRange,
    /// The beams span more than [`Scan::MOST_TURNS`], as those of angles in degrees do.
    #[error(
        "the beams of the scan span more than {} turns: angles are in radians",
        Scan::MOST_TURNS
    )]
    TooWide,
}

impl Scan {
    /// A full turn, and some beams more: the first and the last one of some lidars overlap.
    pub const MOST_TURNS: f64 = 1.1;

    /// Creates a full-turn scan of `beams` equal angles from measurements of a lidar at the robot's origin in any direction, each a
    /// direction in radians and a range in metres. Each beam has its smallest range, or NaN without a measurement. A range that is
    /// NaN, zero or below, and a direction that is not finite, are no measurement. For a lidar elsewhere, measure in its own frame,
    /// and convert the scan with [`Self::from_mount`].
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
        Self { angle_min: -PI, angle_increment, range_max, ranges, ..Self::default() }
    }

    /// As [`Self::from_measurements`], of a lidar that measures in `beams` directions of a field of view alone: from a direction
    /// counter-clockwise by an angle, both in radians. A measurement beyond that field, made from another place a moment ago,
    /// counts in the nearest direction: nothing is known of the directions in between.
    pub(crate) fn from_measurements_within(
        (from, turn): (f64, f64),
        beams: usize,
        range_max: f64,
        measured: impl Iterator<Item = (f64, f64)>,
    ) -> Self {
        let beams = beams.max(2);
        let angle_increment = turn / (beams - 1) as f64;
        let half_unseen = 0.5 * (TAU - turn);
        let mut ranges = vec![f64::NAN; beams];
        for (direction, range) in measured.filter(is_measured) {
            let turned = (direction - from + half_unseen).rem_euclid(TAU) - half_unseen;
            let beam = (turned / angle_increment).round().max(0.0) as usize;
            let nearest = &mut ranges[beam.min(beams - 1)];
            *nearest = nearest.min(range);
        }
        Self { angle_min: from, angle_increment, range_max, ranges, ..Self::default() }
    }

    /// Converts a scan from the frame of a lidar to the robot's frame; `mount` is the pose of the lidar there.
    #[must_use]
    pub fn from_mount(self, mount: &Pose) -> Self {
        let origin = mount.transform(&self.origin);
        Self { origin, angle_min: wrap_angle(self.angle_min + mount.yaw), ..self }
    }

    /// The direction of a beam in the robot's frame, radians: from [`Self::angle_min`] on, and beyond pi where the beams go on.
    #[must_use]
    pub fn angle(&self, beam: usize) -> f64 {
        self.angle_min + beam as f64 * self.angle_increment
    }

    /// The angle from the first beam to the last one, in turns.
    pub(crate) fn turns(&self) -> f64 {
        self.ranges.len().saturating_sub(1) as f64 * self.angle_increment / TAU
    }

    /// Checks that the lidar has a place, that the beams have directions within about a turn, and that the sensor has a largest range.
    /// A scan without beams is valid.
    ///
    /// # Errors
    /// The first value that is wrong.
    pub fn validate(&self) -> Result<(), ScanError> {
        let is_positive = |value: f64| value.is_finite() && value > 0.0;
        match self {
            Self { ranges, .. } if ranges.is_empty() => Ok(()),
            Self { origin, .. } if !is_place(origin) => Err(ScanError::Place),
            Self { angle_min, .. } if !angle_min.is_finite() => Err(ScanError::FirstAngle),
            Self { angle_increment, .. } if !is_positive(*angle_increment) => {
                Err(ScanError::AngleIncrement)
            }
            Self { range_max, .. } if !is_positive(*range_max) => Err(ScanError::LargestRange),
            _ if self.turns() > Self::MOST_TURNS => Err(ScanError::TooWide),
            _ => Ok(()),
        }
    }

    /// Whether a range is that of a return: above zero and at most [`Self::range_max`].
    #[must_use]
    pub fn is_return(&self, range: f64) -> bool {
        is_return(range, self.range_max)
    }

    /// The beam end points in the map frame, for a robot at this pose. Beams without a return give no point.
    pub fn hits(&self, pose: &Pose) -> impl Iterator<Item = Point> + '_ {
        let (from, yaw) = (pose.transform(&self.origin), pose.yaw);
        let beams = self.ranges.iter().enumerate();
        let returns = beams.filter(|(_, range)| self.is_return(**range));
        returns.map(move |(beam, _)| self.end_from(&from, yaw, beam))
    }

    /// The end of a beam with a return, for a lidar at this place on a robot with this yaw, radians.
    pub(crate) fn end_from(&self, lidar: &Point, yaw: f64, beam: usize) -> Point {
        let (sin, cos) = libm::sincos(yaw + self.angle(beam));
        *lidar + Vector::new(cos, sin) * self.ranges[beam]
    }
}

/// Whether a range is a measurement: NaN, zero and below are none.
pub(crate) fn is_measurement(range: f64) -> bool {
    range > 0.0
}

/// Whether a range is that of a return, for a sensor with this largest range.
fn is_return(range: f64, range_max: f64) -> bool {
    is_measurement(range) && range <= range_max
}

/// Whether a direction and a range are a measurement.
fn is_measured(&(direction, range): &(f64, f64)) -> bool {
    direction.is_finite() && is_measurement(range)
}

/// Whether a place is finite.
fn is_place(place: &Point) -> bool {
    place.x.is_finite() && place.y.is_finite()
}

/// A single lidar measurement.
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
}

/// The beams of one lidar revolution, each with its own time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TimedScan {
    /// Place of the lidar in the robot's frame, metres.
    pub origin: Point,
    /// The beams, in the order of measurement where the lidar keeps it.
    pub beams: Vec<Beam>,
    /// Largest range of the sensor, metres.
    pub range_max: f64,
}

impl TimedScan {
    /// Distributes the beams of a scan evenly over `duration_s`; the last beam has the time `end_s`, seconds.
    #[must_use]
    pub fn from_scan(scan: &Scan, end_s: f64, duration_s: f64) -> Self {
        let gaps = scan.ranges.len().saturating_sub(1);
        let share = |index: usize| if gaps == 0 { 1.0 } else { index as f64 / gaps as f64 };
        let beam = |(index, &range): (usize, &f64)| Beam {
            angle: scan.angle(index),
            range,
            time_s: end_s - duration_s * (1.0 - share(index)),
        };
        Self {
            origin: scan.origin,
            beams: scan.ranges.iter().enumerate().map(beam).collect(),
            range_max: scan.range_max,
        }
    }

    /// Converts the beams from the frame of a lidar to the robot's frame; `mount` is the pose of the lidar there.
    #[must_use]
    pub fn from_mount(mut self, mount: &Pose) -> Self {
        self.origin = mount.transform(&self.origin);
        for beam in &mut self.beams {
            beam.angle = wrap_angle(mount.yaw + beam.angle);
        }
        self
    }

    /// Time of the newest beam, seconds, in any order of the beams; none without beams.
    #[must_use]
    pub fn end_s(&self) -> Option<f64> {
        self.beams.iter().map(|beam| beam.time_s).reduce(f64::max)
    }

    /// Whether the lidar has a place, and every beam a finite direction and time.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let is_valid = |beam: &Beam| beam.angle.is_finite() && beam.time_s.is_finite();
        is_place(&self.origin) && self.range_max.is_finite() && self.beams.iter().all(is_valid)
    }
}
