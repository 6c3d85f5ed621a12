//! A path with a time for each key point.

use super::SimError;
use crate::geometry::{Point, Vector};
use crate::settings::require;

/// Shortest time between keys, seconds, and largest coordinate, metres: within them every speed is finite.
const SHORTEST_LEG_S: f64 = 1e-6;
const FARTHEST_M: f64 = 1e9;

/// Interpolation between keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Interpolation {
    Linear,
    Spline,
}

/// Key points with times, and the interpolation between them. The position is the first key's before the first time and
/// the last key's after the last time. A path with a period restarts after it.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedPath {
    keys: Vec<(f64, Point)>,
    loop_s: Option<f64>,
    interpolation: Interpolation,
}

impl TimedPath {
    /// Creates a path that is linear between keys. Times in seconds, points in metres, the period in seconds.
    ///
    /// # Errors
    /// [`SimError::Setting`] without keys, for times below zero or less than a microsecond apart, for a
    /// period that is not above zero or ends before the last time, for a coordinate beyond 1e9 m, or a number that is not finite.
    pub fn new(keys: &[(f64, Point)], loop_s: Option<f64>) -> Result<Self, SimError> {
        require(!keys.is_empty(), "number of keyframes", keys.len() as f64, "at least one")?;
        let mut latest = -SHORTEST_LEG_S;
        for &(time_s, point) in keys {
            require(
                time_s.is_finite() && time_s >= 0.0 && time_s - latest >= SHORTEST_LEG_S,
                "time of a keyframe",
                time_s,
                "finite, at least zero and a microsecond or more after the one before",
            )?;
            latest = time_s;
            for value in [point.x, point.y] {
                let fits = value.abs() <= FARTHEST_M;
                require(fits, "coordinate of a keyframe", value, "-1e9 to 1e9")?;
            }
        }
        if let Some(period_s) = loop_s {
            require(
                period_s.is_finite() && period_s > 0.0 && period_s >= latest,
                "loop_s",
                period_s,
                "finite, above zero and not before the last keyframe",
            )?;
        }
        Ok(Self { keys: keys.to_vec(), loop_s, interpolation: Interpolation::Linear })
    }

    /// Interpolates by a Catmull-Rom spline, as Gazebo's animated models: the tangent at a key is half the vector from
    /// the previous key to the next, independent of their times. At an end of an open path it is half the vector to the
    /// neighbour.
    #[must_use]
    pub fn on_spline(self) -> Self {
        Self { interpolation: Interpolation::Spline, ..self }
    }

    /// The period, seconds.
    #[must_use]
    pub const fn period_s(&self) -> Option<f64> {
        self.loop_s
    }

    /// Times, seconds, and the point at each, metres.
    #[must_use]
    pub fn keys(&self) -> &[(f64, Point)] {
        &self.keys
    }

    /// Position, metres, and velocity, m/s, at a time since the start, seconds, at least zero. The velocity is zero
    /// before the first key and after the last.
    #[must_use]
    pub fn at(&self, time_s: f64) -> (Point, Vector) {
        let time_s = self.within_period(time_s);
        let after = self.keys.partition_point(|key| key.0 <= time_s);
        let Some(from) = after.checked_sub(1) else {
            return (self.keys[0].1, Vector::ZERO);
        };
        let (from_s, begin) = self.keys[from];
        let Some(&(to_s, end)) = self.keys.get(after) else {
            return (begin, Vector::ZERO);
        };
        let leg_s = to_s - from_s;
        let share = (time_s - from_s) / leg_s;
        let displacement = end - begin;
        match self.interpolation {
            Interpolation::Linear => (begin + displacement * share, displacement / leg_s),
            Interpolation::Spline => {
                let tangents = [self.tangent(from), self.tangent(after)];
                // The cubic in Hermite form, and its derivative.
                let along = polynomial(share, [0.0, 0.0, 3.0, -2.0]);
                let bends = [
                    polynomial(share, [0.0, 1.0, -2.0, 1.0]),
                    polynomial(share, [0.0, 0.0, -1.0, 1.0]),
                ];
                let position = begin + displacement * along + sum(bends, tangents);
                let along = polynomial(share, [0.0, 6.0, -6.0, 0.0]);
                let bends = [
                    polynomial(share, [1.0, -4.0, 3.0, 0.0]),
                    polynomial(share, [0.0, -2.0, 3.0, 0.0]),
                ];
                (position, (displacement * along + sum(bends, tangents)) / leg_s)
            }
        }
    }

    /// The spline's tangent at a key, metres per leg.
    fn tangent(&self, key: usize) -> Vector {
        let position = |key: usize| self.keys[key].1;
        let last = self.keys.len() - 1;
        let is_closed = position(0) == position(last);
        let (before, after) = match key {
            0 if is_closed => (last - 1, 1),
            0 => (0, 1),
            _ if key < last => (key - 1, key + 1),
            _ if is_closed => (last - 1, 1),
            _ => (last - 1, last),
        };
        (position(after) - position(before)) * 0.5
    }

    /// A time within the first period, seconds.
    pub(super) fn within_period(&self, time_s: f64) -> f64 {
        self.loop_s.map_or(time_s, |period_s| libm::fmod(time_s, period_s))
    }
}

/// `a + b x + c x^2 + d x^3`.
fn polynomial(x: f64, [a, b, c, d]: [f64; 4]) -> f64 {
    a + x * (b + x * (c + x * d))
}

fn sum(weights: [f64; 2], [one, other]: [Vector; 2]) -> Vector {
    one * weights[0] + other * weights[1]
}
