//! Motion back and forth along a route.

use crate::geometry::{Point, Vector};
use crate::global::Path;

/// Motion between the ends of a route at constant speed.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Patrol {
    pub(super) route: Path,
    pub(super) speed_m_s: f64,
    /// Distance along the route.
    pub(super) along_m: f64,
    pub(super) forward: bool,
}

impl Patrol {
    pub(super) const fn new(route: Path, speed_m_s: f64) -> Self {
        Self { route, speed_m_s, along_m: 0.0, forward: true }
    }

    pub(super) fn center(&self) -> Point {
        self.route.point_at(self.along_m)
    }

    pub(super) fn velocity(&self) -> Vector {
        let along = self.route.direction_at(self.along_m) * self.speed_m_s;
        if self.forward { along } else { -along }
    }

    pub(super) fn center_after(&self, time_s: f64) -> Point {
        self.route.point_at(self.state_after(time_s).0)
    }

    pub(super) fn step(&mut self, time_s: f64) {
        (self.along_m, self.forward) = self.state_after(time_s);
    }

    pub(super) const fn reverse(&mut self) {
        self.forward = !self.forward;
    }

    /// Distance along the route and direction after a step; it reverses at the ends.
    fn state_after(&self, time_s: f64) -> (f64, bool) {
        let length = self.route.length_m();
        let stride = self.speed_m_s * time_s;
        let (along, forward) = if self.forward {
            (self.along_m + stride, true)
        } else {
            (self.along_m - stride, false)
        };
        if along > length {
            ((2.0 * length - along).max(0.0), false)
        } else if along < 0.0 {
            ((-along).min(length), true)
        } else {
            (along, forward)
        }
    }
}
