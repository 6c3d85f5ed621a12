//! Backing out of where nothing goes on: when, for how long, and where to.

use super::breadcrumbs::Breadcrumbs;
use super::predicted_state::PredictedState;
use super::progress_checker::Since;
use crate::geometry::{Point, Pose};

/// How long the first attempt to back out lasts, seconds; each further one twice as long, up to so many doublings.
const BACKING_S: f64 = 2.0;
const LONGEST_BACKING: u32 = 3;
/// One that gets on so slowly that it made no progress for so many patiences is held up too, however it wiggles.
const WIGGLING: f64 = 3.0;
/// A robot slower than this that does not turn is held up, m/s.
const CREEPING: f64 = 0.05;

/// Attempts to back out, one longer than the other until there is progress.
pub struct Recovery {
    trail: Breadcrumbs,
    held_up: Since,
    attempts: u32,
    backing_until_s: f64,
    next_s: f64,
}

impl Default for Recovery {
    fn default() -> Self {
        Self {
            trail: Breadcrumbs::default(),
            held_up: Since::default(),
            attempts: 0,
            backing_until_s: f64::NEG_INFINITY,
            next_s: f64::NEG_INFINITY,
        }
    }
}

impl Recovery {
    /// Whether the robot shall back out now.
    pub fn is_backing(&self, now_s: f64) -> bool {
        now_s < self.backing_until_s
    }

    /// Notes a tick of turning in place, which is no standing still.
    pub fn turned(&mut self) {
        self.held_up = Since::default();
    }

    /// Notes a tick of driving, `stuck_s` after the last progress; a robot held up for longer than `stuck_patience_s` backs
    /// out from the next tick on.
    pub fn drove(&mut self, now: &PredictedState, stuck_s: f64, stuck_patience_s: f64) {
        let now_s = now.time_s;
        self.trail.note(&now.pose.position());
        if stuck_s == 0.0 {
            self.attempts = 0;
        }
        let creeps = now.twist.linear.abs() < CREEPING;
        let held_up_s = self.held_up.update(now_s, creeps);
        let is_patient = held_up_s <= stuck_patience_s && stuck_s <= WIGGLING * stuck_patience_s;
        if is_patient || now_s < self.next_s {
            return;
        }
        // Each attempt in vain makes the next one longer, so that two that wait for one another part at last.
        let doublings = self.attempts.min(LONGEST_BACKING);
        self.attempts += 1;
        self.held_up = Since::default();
        self.backing_until_s = now_s + BACKING_S * f64::from(1_u32 << doublings);
        // The way found after backing out gets its chance before the next attempt.
        self.next_s = self.backing_until_s + 2.0 * stuck_patience_s;
    }

    /// The place to back out to: on the way it came, or straight behind where it came from nowhere.
    pub fn place_behind(&mut self, pose: &Pose) -> Point {
        self.trail
            .behind(&pose.position())
            .unwrap_or_else(|| pose.transform(&Point::new(-1.0, 0.0)))
    }
}
