//! Whose fault a contact is.

use crate::geometry::{Point, Pose, Twist, Vector};
use crate::map::MovingDisc;
use crate::robot::{Footprint, Limits};

/// Whether a contact counts against the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Blame {
    /// The robot was closing the gap by its own motion.
    pub by_robot: bool,
    /// In hindsight the robot could have stayed clear.
    pub avoidable: bool,
}

/// The robot's true state at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// When, seconds.
    pub time_s: f64,
    /// Where it was.
    pub pose: Pose,
    /// How fast it moved.
    pub twist: Twist,
}

/// What the robot could have known and done.
pub struct Hindsight<'a> {
    /// Its shape.
    pub footprint: &'a Footprint,
    /// What its base can do.
    pub limits: &'a Limits,
    /// What truly moved: where everything was, or would have been, at a time in seconds.
    pub moving: &'a dyn Fn(f64) -> Vec<MovingDisc>,
}

/// How long before a contact its avoidance is looked for, seconds.
const HINDSIGHT_S: f64 = 2.5;
/// How long after it the robot must still be clear, seconds.
const CLEAR_AFTER_S: f64 = 1.0;
/// A robot that nears what it touches by less than this stood, or drew back, m/s.
const CLOSING: f64 = 0.05;
/// Speeds and turn rates tried, each from the lowest to the highest.
const TRIED: u32 = 15;
/// Time between two looks, seconds: at 2 m/s, and as fast a cylinder, 4 cm.
const STEP_S: f64 = 0.01;

impl Blame {
    /// Whether the contact counts against the robot.
    #[must_use]
    pub const fn counts(self) -> bool {
        self.by_robot || self.avoidable
    }
}

impl Hindsight<'_> {
    /// The latest of these states, in the order of time, that is early enough before a contact to avoid it from; the
    /// first, where all are later.
    #[must_use]
    pub fn before<'s>(states: &'s [State], contact: &State) -> Option<&'s State> {
        // A tick's time is a sum with its rounding.
        let latest_s = contact.time_s - HINDSIGHT_S + 1e-9;
        let early = states.partition_point(|state| state.time_s <= latest_s);
        states.get(early.saturating_sub(1))
    }

    /// Blame for a contact, from the true state some time before and at the contact.
    ///
    /// It could have been avoided when some constant command, reached within the robot's accelerations and kept, leads
    /// clear of everything until a second after the contact, moving as it truly did. The base obeys at once there; and
    /// what lies between the commands tried is not looked at.
    #[must_use]
    pub fn blame(&self, before: &State, contact: &State) -> Blame {
        Blame {
            by_robot: self.closing(contact) > CLOSING,
            avoidable: self
                .way_out(before, contact.time_s + CLEAR_AFTER_S)
                .is_some(),
        }
    }

    /// How fast the robot's own motion brings it nearer to what it touches, m/s; where it touches several, the fastest.
    fn closing(&self, contact: &State) -> f64 {
        let robot = contact.pose.position();
        let heading = contact.pose.isometry().rotation * Vector::new(1.0, 0.0);
        let Twist { linear, angular } = contact.twist;
        let mut fastest = f64::NEG_INFINITY;
        for (own, own_radius_m) in self.footprint.at(&contact.pose) {
            let arm = own - robot;
            let velocity = heading * linear + Vector::new(-arm.y, arm.x) * angular;
            for disc in (self.moving)(contact.time_s) {
                let apart = disc.center() - own;
                let gap_m = apart.norm() - own_radius_m - disc.radius;
                if gap_m <= 0.0 && apart.norm() > 0.0 {
                    fastest = fastest.max(velocity.dot(&apart) / apart.norm());
                }
            }
        }
        fastest
    }

    /// The first command that leads clear of everything until a time.
    fn way_out(&self, from: &State, until_s: f64) -> Option<Twist> {
        let limits = self.limits;
        let value = |low: f64, high: f64, index: u32| {
            low + (high - low) * f64::from(index) / f64::from(TRIED - 1)
        };
        let steps = ((until_s - from.time_s) / STEP_S).ceil().max(0.0) as u32;
        // Where everything is, step by step: the same for every command.
        let moving: Vec<Vec<MovingDisc>> = (0..=steps)
            .map(|step| (self.moving)(from.time_s + f64::from(step) * STEP_S))
            .collect();
        let commands = (0..TRIED * TRIED).map(|index| {
            let turn = limits.max_vel_theta;
            Twist::new(
                value(limits.min_vel_x, limits.max_vel_x, index % TRIED),
                value(-turn, turn, index / TRIED),
            )
        });
        // Standing is no value of an even count from a lowest speed below zero.
        let all = [Twist::STOP].into_iter().chain(commands);
        all.into_iter()
            .find(|command| self.stays_clear(from, command, &moving))
    }

    fn stays_clear(&self, from: &State, command: &Twist, moving: &[Vec<MovingDisc>]) -> bool {
        let (mut pose, mut twist) = (from.pose, from.twist);
        for discs in moving {
            let touches = |disc: &MovingDisc| {
                self.footprint
                    .gap_to_disc_m(&pose, &disc.center(), disc.radius)
                    <= 0.0
            };
            if discs.iter().any(touches) {
                return false;
            }
            let next = self.limits.reachable(&twist, command, STEP_S);
            let mean = Twist::new(
                f64::midpoint(twist.linear, next.linear),
                f64::midpoint(twist.angular, next.angular),
            );
            pose = moved(&pose, &mean);
            twist = next;
        }
        true
    }
}

/// A step along the chord of the arc, whose length differs from the arc's by less than a part in 10,000.
fn moved(pose: &Pose, twist: &Twist) -> Pose {
    let turn = twist.angular * STEP_S;
    let (sin, cos) = libm::sincos(pose.yaw + turn / 2.0);
    let way = twist.linear * STEP_S;
    let place = Point::new(pose.x + way * cos, pose.y + way * sin);
    Pose::new(place.x, place.y, pose.yaw + turn)
}
