//! The robot's footprint as a set of discs.

use serde::{Deserialize, Serialize};

use super::RobotError;
use crate::geometry::{Point, Pose, Vector};
use crate::map::MovingDisc;

/// A disc in the robot's frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Disc {
    /// x coordinate of the centre, forward, metres.
    pub x: f64,
    /// y coordinate of the centre, to the left, metres.
    pub y: f64,
    /// Radius, metres, above zero.
    pub radius: f64,
}

/// The discs that cover a robot. Two or three discs cover a rectangle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<Disc>")]
pub struct Footprint(Vec<Disc>);

impl Footprint {
    /// Creates a footprint from discs.
    ///
    /// # Errors
    /// Returns an error without discs, or for a disc with a value that is not finite or a radius not above zero.
    pub fn new(discs: Vec<Disc>) -> Result<Self, RobotError> {
        if discs.is_empty() {
            return Err(RobotError::EmptyFootprint);
        }
        for (index, &Disc { x, y, radius }) in discs.iter().enumerate() {
            if !(x.is_finite() && y.is_finite() && radius.is_finite() && radius > 0.0) {
                return Err(RobotError::BadDisc { index, x, y, radius });
            }
        }
        Ok(Self(discs))
    }

    /// Creates the footprint of a round robot: one disc around its origin.
    ///
    /// # Errors
    /// Returns an error if the radius, in metres, is not finite and above zero.
    pub fn round(radius: f64) -> Result<Self, RobotError> {
        Self::new(vec![Disc { x: 0.0, y: 0.0, radius }])
    }

    /// The discs, at least one.
    #[must_use]
    pub fn discs(&self) -> &[Disc] {
        &self.0
    }

    /// Radius of the circle around the robot's origin that contains the footprint, metres.
    #[must_use]
    pub fn circumscribed_radius_m(&self) -> f64 {
        let reach = |disc: &Disc| libm::hypot(disc.x, disc.y) + disc.radius;
        self.0.iter().map(reach).fold(0.0, f64::max)
    }

    /// Radius of the largest disc, metres.
    #[must_use]
    pub fn max_disc_radius_m(&self) -> f64 {
        self.0.iter().map(|disc| disc.radius).fold(0.0, f64::max)
    }

    /// Distance between a robot at this pose and another disc, metres; zero or less means contact.
    #[must_use]
    pub fn gap_to_disc_m(&self, pose: &Pose, center: &Point, radius_m: f64) -> f64 {
        self.at(pose)
            .map(|(own, own_radius)| (center - own).norm() - own_radius - radius_m)
            .fold(f64::INFINITY, f64::min)
    }

    /// Distance between a robot at this pose and a moving obstacle, metres; zero or less means contact.
    #[must_use]
    pub fn gap_to_moving_m(&self, pose: &Pose, disc: &MovingDisc) -> f64 {
        self.gap_to_disc_m(pose, &disc.center(), disc.radius)
    }

    /// Adds a margin, metres, to each radius. A negative margin shrinks the discs, down to 1 mm.
    #[must_use]
    pub fn padded(&self, margin_m: f64) -> Self {
        let grow = |disc: &Disc| Disc { radius: (disc.radius + margin_m).max(1e-3), ..*disc };
        Self(self.0.iter().map(grow).collect())
    }

    /// Centre and radius of each disc in the map frame, for a robot at a pose.
    pub fn at(&self, pose: &Pose) -> impl Iterator<Item = (Point, f64)> + '_ {
        let (center, turn) = (pose.position(), libm::sincos(pose.yaw));
        self.0
            .iter()
            .map(move |disc| (center + Vector::new(disc.x, disc.y).rotated(turn), disc.radius))
    }
}

impl TryFrom<Vec<Disc>> for Footprint {
    type Error = RobotError;

    fn try_from(discs: Vec<Disc>) -> Result<Self, RobotError> {
        Self::new(discs)
    }
}
