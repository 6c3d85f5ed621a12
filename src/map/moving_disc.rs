//! A moving obstacle as planned around.

use serde::{Deserialize, Serialize};

use crate::geometry::Point;

/// A disc in the map frame that moves with constant velocity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MovingDisc {
    /// Current x coordinate of the centre, metres in the map frame.
    pub x: f64,
    /// Current y coordinate of the centre, metres in the map frame.
    pub y: f64,
    /// Radius, metres, above zero.
    pub radius: f64,
    /// Velocity along x, metres per second.
    #[serde(default)]
    pub vx: f64,
    /// Velocity along y, metres per second.
    #[serde(default)]
    pub vy: f64,
}

impl MovingDisc {
    /// The current centre.
    #[must_use]
    pub const fn center(&self) -> Point {
        Point::new(self.x, self.y)
    }

    /// The disc moved by its velocity for a time, seconds.
    #[must_use]
    pub const fn after(&self, time_s: f64) -> Self {
        Self { x: self.x + self.vx * time_s, y: self.y + self.vy * time_s, ..*self }
    }

    /// Whether every number is finite and the radius above zero.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        [self.x, self.y, self.radius, self.vx, self.vy].iter().all(|value| value.is_finite())
            && self.radius > 0.0
    }
}
