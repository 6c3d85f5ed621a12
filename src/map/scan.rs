//! One revolution of a planar lidar.

use core::f64::consts::{PI, TAU};

use crate::geometry::{Point, Pose};

/// Ranges measured at equal angles, counter-clockwise, from the robot's own origin.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Scan {
    /// Direction of the first beam in the robot's frame, radians.
    pub angle_min: f64,
    /// Angle from one beam to the next, radians, above zero.
    pub angle_increment: f64,
    /// Longest range the sensor reports, metres.
    pub range_max: f64,
    /// A range for each beam, metres. Infinite: nothing within `range_max`. NaN: no measurement.
    pub ranges: Vec<f64>,
}

impl Scan {
    /// A scan of so many equal angles over a full turn from measurements in any directions, each a direction in radians and a range
    /// in metres: in each angle the nearest; NaN where there is none.
    #[must_use]
    pub fn from_measurements(
        beams: usize,
        range_max: f64,
        measured: impl Iterator<Item = (f64, f64)>,
    ) -> Self {
        let angle_increment = TAU / beams.max(1) as f64;
        let mut ranges = vec![f64::NAN; beams];
        for (direction, range) in measured {
            let beam = ((direction + PI) / angle_increment).rem_euclid(beams as f64) as usize;
            if let Some(before) = ranges.get_mut(beam.min(beams.saturating_sub(1))) {
                // NaN is no measurement: anything is better.
                *before = before.min(range);
            }
        }
        Self {
            // The middle of the first direction.
            angle_min: -PI + angle_increment / 2.0,
            angle_increment,
            range_max,
            ranges,
        }
    }

    /// The direction of a beam in the robot's frame, radians.
    #[must_use]
    pub fn angle(&self, beam: usize) -> f64 {
        self.angle_min + beam as f64 * self.angle_increment
    }

    /// Whether every beam has a direction. No beam at all is sound: nothing was measured.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        self.ranges.is_empty()
            || (self.angle_min.is_finite()
                && self.angle_increment.is_finite()
                && self.angle_increment > 0.0
                && self.range_max.is_finite())
    }

    /// The points in the map frame that beams hit, for a robot at this pose. Beams that hit nothing, and ranges that
    /// are not within zero to `range_max`, give no point.
    pub fn hits(&self, pose: &Pose) -> impl Iterator<Item = Point> + '_ {
        let pose = *pose;
        let within = |range: &f64| (0.0..=self.range_max).contains(range);
        let beams = self.ranges.iter().enumerate();
        beams
            .filter(move |(_, range)| within(range))
            .map(move |(beam, &range)| {
                let direction = pose.yaw + self.angle(beam);
                Point::new(
                    pose.x + range * libm::cos(direction),
                    pose.y + range * libm::sin(direction),
                )
            })
    }
}
