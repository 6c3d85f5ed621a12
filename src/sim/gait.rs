//! The legs of a walking person, as a lidar at the height of shins sees them.

use crate::geometry::{Point, Vector};
use crate::map::MovingDisc;

/// Distance between the ankles across the direction of walking, metres: our choice between a narrow and a wide gait.
const STEP_WIDTH_M: f64 = 0.2;
/// Length of a step: its part at no speed, metres, and the increase with the speed, seconds. 0.7 m at 1.3 m/s, as adults walk.
const STEP_M: f64 = 0.3;
const STEP_S: f64 = 0.3;
/// A person who stops brings the feet together within this time, seconds, and reaches the full step within it.
const FEET_TOGETHER_S: f64 = 0.5;

/// Legs of a diameter that walk within a body.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Gait {
    leg_radius_m: f64,
    /// Distance walked, metres; it decides the phase.
    pub walked_m: f64,
    /// The last velocity of walking: its speed, m/s, and its direction.
    speed_m_s: f64,
    direction: Vector,
    /// Length of the present step over that of walking: 0 for a person who stands, to 1.
    stride: f64,
}

impl Gait {
    /// Legs of a diameter, metres, after a walked distance, metres.
    pub const fn new(leg_diameter_m: f64, walked_m: f64) -> Self {
        Self {
            leg_radius_m: leg_diameter_m / 2.0,
            walked_m,
            speed_m_s: 0.0,
            direction: Vector::new(1.0, 0.0),
            stride: 0.0,
        }
    }

    /// Walks for a time, seconds, at a velocity, or stands.
    pub fn step(&mut self, velocity: &Vector, time_s: f64) {
        let speed_m_s = velocity.norm();
        let change = time_s / FEET_TOGETHER_S;
        let opening = if speed_m_s > 0.0 { change } else { -change };
        self.stride = (self.stride + opening).clamp(0.0, 1.0);
        if speed_m_s > 0.0 {
            self.walked_m += speed_m_s * time_s;
            self.speed_m_s = speed_m_s;
            self.direction = *velocity / speed_m_s;
        }
    }

    /// The legs of a person at this centre, with a body radius, metres, and a walking velocity.
    ///
    /// One foot stands on the ground while the body passes over it; the other swings forward at twice the speed. Both legs stay
    /// within the body's disc.
    pub fn legs(&self, center: &Point, body_radius_m: f64, velocity: &Vector) -> [MovingDisc; 2] {
        let longest_m = 2.0 * (body_radius_m - self.leg_radius_m).max(0.0);
        let aside_m = (STEP_WIDTH_M / 2.0).min(longest_m / 2.0);
        let room_m = libm::sqrt((longest_m / 2.0 * longest_m / 2.0 - aside_m * aside_m).max(0.0));
        let walking_m = f64::midpoint(STEP_M, STEP_S * self.speed_m_s).min(room_m);
        let half_step_m = self.stride * walking_m;
        let aside = Vector::new(-self.direction.y, self.direction.x);
        // A leg's offset falls from half a step to minus half a step in one step of the body, and rises in the next.
        let phase = if walking_m > 0.0 { self.walked_m / (4.0 * walking_m) } else { 0.0 };
        let swing = 4.0 * (phase - (phase + 0.5).floor()).abs() - 1.0;
        let stands_left = phase - phase.floor() >= 0.5;
        [(1.0, stands_left), (-1.0, !stands_left)].map(|(side, stands)| {
            let offset = self.direction * (side * swing * half_step_m) + aside * (side * aside_m);
            let place = *center + offset;
            let own = if stands { Vector::ZERO } else { *velocity * 2.0 };
            MovingDisc { x: place.x, y: place.y, radius: self.leg_radius_m, vx: own.x, vy: own.y }
        })
    }
}
