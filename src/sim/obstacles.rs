//! People on foot: discs that walk back and forth along routes and mind the robot, or not.

use crate::geometry::{Point, Pose, Vector};
use crate::global::Path;
use crate::map::MovingDisc;
use crate::robot::Footprint;

/// The gap to the robot, metres, that a yielding walker keeps: it does not take a step that would end nearer and
/// bring it nearer still.
pub const YIELD_GAP_M: f64 = 0.3;

/// How long, seconds, a yielding walker stands before it turns round.
pub const YIELD_PATIENCE_S: f64 = 3.0;

/// Longest step of a walk, seconds: at 1 m/s a walker looks again every 2 cm.
const SUB_STEP_S: f64 = 0.02;

/// One walker.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Walker {
    pub(super) radius_m: f64,
    pub(super) speed_m_s: f64,
    pub(super) route: Path,
    pub(super) yields: bool,
    /// Distance along the route.
    pub(super) along_m: f64,
    pub(super) forward: bool,
    /// How long it has stood for the robot; zero while it walks.
    held_s: f64,
}

/// All moving obstacles of a simulation.
///
/// Each walks its route from end to end and back at its own speed. One that yields holds while its next step would
/// bring it within [`YIELD_GAP_M`] of the robot, and turns round after [`YIELD_PATIENCE_S`]; so it never walks into
/// the robot, though the robot may drive into it. Walkers do not mind each other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Walkers {
    walkers: Vec<Walker>,
}

impl Walker {
    pub(super) fn new(radius_m: f64, speed_m_s: f64, route: Path, yields: bool) -> Self {
        Self {
            radius_m,
            speed_m_s,
            route,
            yields,
            along_m: 0.0,
            forward: true,
            held_s: 0.0,
        }
    }

    fn center(&self) -> Point {
        self.route.point_at(self.along_m)
    }

    /// Zero while it holds.
    fn velocity(&self) -> Vector {
        if self.held_s > 0.0 {
            return Vector::zeros();
        }
        let along = self.route.direction_at(self.along_m) * self.speed_m_s;
        if self.forward { along } else { -along }
    }

    fn step(&mut self, time_s: f64, pose: &Pose, footprint: &Footprint) {
        let (along_m, forward) = self.next_place(time_s);
        if self.yields {
            let gap = |center| footprint.gap_to_disc_m(pose, &center, self.radius_m);
            let ahead = gap(self.route.point_at(along_m));
            if ahead < YIELD_GAP_M && ahead < gap(self.center()) {
                self.hold(time_s);
                return;
            }
        }
        self.held_s = 0.0;
        self.along_m = along_m;
        self.forward = forward;
    }

    /// Where a step leads, and which way it faces then: the way back from the ends of the route.
    fn next_place(&self, time_s: f64) -> (f64, bool) {
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

    fn hold(&mut self, time_s: f64) {
        self.held_s += time_s;
        if self.held_s >= YIELD_PATIENCE_S {
            self.held_s = 0.0;
            self.forward = !self.forward;
        }
    }
}

impl Walkers {
    pub(super) const fn new(walkers: Vec<Walker>) -> Self {
        Self { walkers }
    }

    /// How many there are.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.walkers.len()
    }

    /// Whether there is none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.walkers.is_empty()
    }

    /// Lets everybody walk for a time, seconds, while the robot stands at a pose; none for a time that is not above
    /// zero.
    pub fn step(&mut self, time_s: f64, robot: &Pose, footprint: &Footprint) {
        if !(time_s > 0.0 && time_s.is_finite()) {
            return;
        }
        let steps = (time_s / SUB_STEP_S).ceil().max(1.0);
        for walker in &mut self.walkers {
            for _ in 0..steps as u64 {
                walker.step(time_s / steps, robot, footprint);
            }
        }
    }

    /// Where everybody is now and how they move; who holds does not.
    #[must_use]
    pub fn discs(&self) -> Vec<MovingDisc> {
        let disc = |walker: &Walker| {
            let (center, velocity) = (walker.center(), walker.velocity());
            MovingDisc {
                x: center.x,
                y: center.y,
                radius: walker.radius_m,
                vx: velocity.x,
                vy: velocity.y,
            }
        };
        self.walkers.iter().map(disc).collect()
    }
}
