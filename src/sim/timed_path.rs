//! A scripted way: places at given times.

use super::SimError;
use crate::geometry::{Point, Vector};
use crate::settings::require;

/// Shortest time from one key to the next, seconds, and greatest coordinate, metres: within them every speed is a number.
const SHORTEST_LEG_S: f64 = 1e-6;
const FARTHEST_M: f64 = 1e9;

/// How a script leads from one key to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Course {
    Straight,
    Spline,
}

/// Places at given times, and a way from each to the next. Before the first time its place is the first, after the last one
/// the last; a script with a period begins anew after it, wherever that is.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedPath {
    keys: Vec<(f64, Point)>,
    loop_s: Option<f64>,
    course: Course,
}

impl TimedPath {
    /// A script that goes straight and evenly from place to place. Times in seconds, places in metres, the period in seconds.
    ///
    /// # Errors
    /// [`SimError::Setting`] for no key, for times that are below zero or do not ascend by a microsecond at least, for a
    /// period that is not above zero or ends before the last time, for a place beyond 1e9 m, or any number that is not finite.
    pub fn new(keys: &[(f64, Point)], loop_s: Option<f64>) -> Result<Self, SimError> {
        require(
            !keys.is_empty(),
            "number of keyframes",
            keys.len() as f64,
            "at least one",
        )?;
        let mut latest = -SHORTEST_LEG_S;
        for &(time_s, place) in keys {
            require(
                time_s.is_finite() && time_s >= 0.0 && time_s - latest >= SHORTEST_LEG_S,
                "time of a keyframe",
                time_s,
                "finite, at least zero and a microsecond or more after the one before",
            )?;
            latest = time_s;
            for value in [place.x, place.y] {
                let fits = value.abs() <= FARTHEST_M;
                require(fits, "place of a keyframe", value, "-1e9 to 1e9")?;
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
        Ok(Self {
            keys: keys.to_vec(),
            loop_s,
            course: Course::Straight,
        })
    }

    /// The same places at the same times on a Catmull-Rom spline through them, as the animated models of Gazebo go: the
    /// tangent at a place is half the way from the place before it to the one after, whatever their times; at an end that is
    /// not also the beginning it is half the way to its neighbour.
    #[must_use]
    pub fn on_spline(self) -> Self {
        Self {
            course: Course::Spline,
            ..self
        }
    }

    /// The period after which it begins anew, seconds.
    #[must_use]
    pub const fn period_s(&self) -> Option<f64> {
        self.loop_s
    }

    /// Times, seconds, and the place at each, metres.
    #[must_use]
    pub fn keys(&self) -> &[(f64, Point)] {
        &self.keys
    }

    /// The place at a time since the script began, seconds and at least zero, and the velocity there, m/s: zero before the
    /// first key and after the last.
    #[must_use]
    pub fn at(&self, time_s: f64) -> (Point, Vector) {
        let time_s = self.within_period(time_s);
        let after = self.keys.partition_point(|key| key.0 <= time_s);
        let Some(from) = after.checked_sub(1) else {
            return (self.keys[0].1, Vector::zeros());
        };
        let (from_s, begin) = self.keys[from];
        let Some(&(to_s, end)) = self.keys.get(after) else {
            return (begin, Vector::zeros());
        };
        let leg_s = to_s - from_s;
        let share = (time_s - from_s) / leg_s;
        let way = end - begin;
        match self.course {
            Course::Straight => (begin + way * share, way / leg_s),
            Course::Spline => {
                let tangents = [self.tangent(from), self.tangent(after)];
                // Hermite's form of the cubic, and its slope.
                let along = polynomial(share, [0.0, 0.0, 3.0, -2.0]);
                let bends = [
                    polynomial(share, [0.0, 1.0, -2.0, 1.0]),
                    polynomial(share, [0.0, 0.0, -1.0, 1.0]),
                ];
                let place = begin + way * along + sum(bends, tangents);
                let along = polynomial(share, [0.0, 6.0, -6.0, 0.0]);
                let bends = [
                    polynomial(share, [1.0, -4.0, 3.0, 0.0]),
                    polynomial(share, [0.0, -2.0, 3.0, 0.0]),
                ];
                (place, (way * along + sum(bends, tangents)) / leg_s)
            }
        }
    }

    /// The spline's tangent at a key, metres for a leg.
    fn tangent(&self, key: usize) -> Vector {
        let place = |key: usize| self.keys[key].1;
        let last = self.keys.len() - 1;
        let is_closed = place(0) == place(last);
        let (before, after) = match key {
            0 if is_closed => (last - 1, 1),
            0 => (0, 1),
            _ if key < last => (key - 1, key + 1),
            _ if is_closed => (last - 1, 1),
            _ => (last - 1, last),
        };
        (place(after) - place(before)) * 0.5
    }

    fn within_period(&self, time_s: f64) -> f64 {
        self.loop_s
            .map_or(time_s, |period_s| libm::fmod(time_s, period_s))
    }
}

/// `a + b x + c x^2 + d x^3`.
fn polynomial(x: f64, [a, b, c, d]: [f64; 4]) -> f64 {
    a + x * (b + x * (c + x * d))
}

fn sum(weights: [f64; 2], [one, other]: [Vector; 2]) -> Vector {
    one * weights[0] + other * weights[1]
}

/// Somebody who plays a script.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TimedPathPlayer {
    script: TimedPath,
    /// Since the script began; below the period of a loop.
    time_s: f64,
}

impl TimedPathPlayer {
    pub(super) const fn new(script: TimedPath) -> Self {
        Self {
            script,
            time_s: 0.0,
        }
    }

    pub(super) fn center(&self) -> Point {
        self.script.at(self.time_s).0
    }

    pub(super) fn velocity(&self) -> Vector {
        self.script.at(self.time_s).1
    }

    pub(super) fn center_after(&self, time_s: f64) -> Point {
        self.script.at(self.time_s + time_s).0
    }

    pub(super) fn step(&mut self, time_s: f64) {
        self.time_s = self.script.within_period(self.time_s + time_s);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn script(keys: &[(f64, f64, f64)], loop_s: Option<f64>) -> TimedPath {
        let keys: Vec<_> = keys
            .iter()
            .map(|&(time_s, x, y)| (time_s, Point::new(x, y)))
            .collect();
        TimedPath::new(&keys, loop_s).expect("a sound script")
    }

    #[test]
    fn a_spline_passes_its_keys_with_tangents_along_their_neighbours() {
        let keys = [
            (0.0, 0.0, 0.0),
            (1.0, 1.0, 2.0),
            (3.0, 4.0, 2.0),
            (4.0, 4.0, 0.0),
        ];
        let spline = script(&keys, None).on_spline();
        for (time_s, x, y) in keys {
            assert_eq!(spline.at(time_s).0, Point::new(x, y), "{time_s}");
        }
        // Half of (4, 2), over the leg's one second before the key and two after it: Gazebo's clock is not smooth.
        let before = spline.at(1.0 - 1e-9).1;
        let after = spline.at(1.0 + 1e-9).1;
        assert!((before - Vector::new(2.0, 1.0)).norm() < 1e-6, "{before}");
        assert!((after - Vector::new(1.0, 0.5)).norm() < 1e-6, "{after}");
        // A straight script turns there at once.
        let straight = script(&keys, None);
        assert_eq!(straight.at(0.5).1, Vector::new(1.0, 2.0));
        assert_eq!(straight.at(1.5).1, Vector::new(1.5, 0.0));
        // Between symmetric keys the middle is the mean of both, and an eighth of the difference of the tangents.
        let middle = spline.at(2.0).0;
        let bend = (Vector::new(2.0, 1.0) - Vector::new(1.5, -1.0)) / 8.0;
        assert!((middle - (Point::new(2.5, 2.0) + bend)).norm() < 1e-12);
    }

    #[test]
    fn the_velocity_is_the_slope_of_the_place() {
        let keys = [
            (0.5, 0.0, 0.0),
            (1.0, 1.0, 2.0),
            (3.0, 4.0, 2.0),
            (4.0, 0.0, 0.0),
        ];
        for script in [
            script(&keys, Some(5.0)),
            script(&keys, Some(5.0)).on_spline(),
        ] {
            for tick in 0..240_u32 {
                let time_s = 0.013 + f64::from(tick) * 0.05;
                let slope = (script.at(time_s + 1e-6).0 - script.at(time_s - 1e-6).0) / 2e-6;
                let velocity = script.at(time_s).1;
                assert!(
                    (slope - velocity).norm() < 1e-4,
                    "{time_s}: {slope} {velocity}"
                );
            }
        }
    }

    #[test]
    fn a_closed_spline_ends_as_it_begins() {
        let keys = [
            (0.0, 0.0, 0.0),
            (1.0, 2.0, 0.0),
            (2.0, 1.0, 2.0),
            (3.0, 0.0, 0.0),
        ];
        let spline = script(&keys, Some(3.0)).on_spline();
        let (end, begin) = (spline.at(3.0 - 1e-9).1, spline.at(1e-9).1);
        assert!((end - begin).norm() < 1e-6, "{end} {begin}");
        assert!((begin - Vector::new(0.5, -1.0)).norm() < 1e-6);
    }
}
