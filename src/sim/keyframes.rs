//! A scripted way: places at given times.

use super::SimError;
use super::error::require;
use crate::geometry::{Point, Vector};

/// Somebody who is at given places at given times and moves evenly from each to the next.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keyframes {
    /// Times in ascending order, seconds, with the place at each.
    keys: Vec<(f64, Point)>,
    loop_s: Option<f64>,
    /// Since the script began; below the period of a loop.
    time_s: f64,
}

impl Keyframes {
    pub(super) fn new(keys: &[(f64, Point)], loop_s: Option<f64>) -> Result<Self, SimError> {
        require(
            !keys.is_empty(),
            "number of keyframes",
            keys.len() as f64,
            "at least one",
        )?;
        let mut latest = (-1.0_f64).next_up();
        for &(time_s, place) in keys {
            require(
                time_s.is_finite() && time_s >= 0.0 && time_s > latest,
                "time of a keyframe",
                time_s,
                "finite, at least zero and after the one before",
            )?;
            latest = time_s;
            for value in [place.x, place.y] {
                require(value.is_finite(), "place of a keyframe", value, "finite")?;
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
            time_s: 0.0,
        })
    }

    pub(super) fn center(&self) -> Point {
        self.place_at(self.time_s)
    }

    /// That of the leg it is on; zero before the first key and after the last.
    pub(super) fn velocity(&self) -> Vector {
        self.leg_at(self.time_s)
            .map_or_else(Vector::zeros, |[(from_s, from), (to_s, to)]| {
                (to - from) / (to_s - from_s)
            })
    }

    pub(super) fn center_after(&self, time_s: f64) -> Point {
        self.place_at(self.time_after(time_s))
    }

    pub(super) fn step(&mut self, time_s: f64) {
        self.time_s = self.time_after(time_s);
    }

    fn time_after(&self, time_s: f64) -> f64 {
        let time_s = self.time_s + time_s;
        self.loop_s
            .map_or(time_s, |period_s| libm::fmod(time_s, period_s))
    }

    fn place_at(&self, time_s: f64) -> Point {
        if let Some([(from_s, from), (to_s, to)]) = self.leg_at(time_s) {
            from + (to - from) * ((time_s - from_s) / (to_s - from_s))
        } else if time_s < self.keys[0].0 {
            self.keys[0].1
        } else {
            self.keys[self.keys.len() - 1].1
        }
    }

    /// The two keys that a time lies between.
    fn leg_at(&self, time_s: f64) -> Option<[(f64, Point); 2]> {
        let after = self.keys.partition_point(|key| key.0 <= time_s);
        let from = after.checked_sub(1)?;
        Some([self.keys[from], *self.keys.get(after)?])
    }
}
