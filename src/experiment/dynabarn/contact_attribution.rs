//! Attribution of a contact in hindsight: did the robot cause it, and could it have avoided it?

use crate::experiment::ContactCause;
use crate::geometry::{Point, Pose, Twist};
use crate::map::MovingDisc;
use crate::robot::{Footprint, Limits};

/// The robot's true state at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Time, seconds.
    pub time_s: f64,
    /// Pose.
    pub pose: Pose,
    /// Velocity.
    pub twist: Twist,
}

/// The robot and the true motion of the obstacles around it.
pub struct ContactAttribution<'a> {
    /// The robot's shape.
    pub footprint: &'a Footprint,
    /// The limits of its base.
    pub limits: &'a Limits,
    /// The obstacles at a time in seconds.
    pub moving: &'a dyn Fn(f64) -> Vec<MovingDisc>,
}

/// An avoiding command starts this long before the contact, seconds.
const HINDSIGHT_S: f64 = 2.5;
/// The robot must still be clear this long after the contact, seconds.
const CLEAR_AFTER_S: f64 = 1.0;
/// Closing speed above which the robot caused the contact, m/s.
const CLOSING_M_S: f64 = 0.05;
/// A gap up to this counts as the contact, metres: the simulation rounds the times of its steps.
const CONTACT_TOLERANCE_M: f64 = 0.002;
/// Number of speeds and of turn rates tried, each from the lowest to the highest.
const TRIED: u32 = 15;
/// Time between two gap checks, seconds: 4 cm for a robot and a cylinder at 2 m/s each.
const STEP_S: f64 = 0.01;

impl ContactAttribution<'_> {
    /// Returns the latest of these states, in order of time, that is early enough to avoid a contact; the first if all are
    /// too late.
    #[must_use]
    pub fn before<'s>(states: &'s [State], contact: &State) -> Option<&'s State> {
        // A tick's time is a sum and has a rounding error.
        let latest_s = contact.time_s - HINDSIGHT_S + 1e-9;
        let early = states.partition_point(|state| state.time_s <= latest_s);
        states.get(early.saturating_sub(1))
    }

    /// The cause of a contact, from the true states some time before it and at it.
    ///
    /// The contact is avoidable when a constant command, reached within the robot's accelerations and kept, stays clear of
    /// all obstacles until a second after the contact; the obstacles move as they truly did. The base obeys at once here,
    /// and commands between those tried are not considered.
    #[must_use]
    pub fn cause(&self, before: &State, contact: &State) -> ContactCause {
        if self.closing_m_s(contact) > CLOSING_M_S {
            ContactCause::Robot
        } else if self.avoiding_command(before, contact.time_s + CLEAR_AFTER_S).is_some() {
            ContactCause::Avoidable
        } else {
            ContactCause::Other
        }
    }

    /// Highest speed at which the robot's own motion closes the gap to an obstacle that it touches, m/s.
    fn closing_m_s(&self, contact: &State) -> f64 {
        let State { time_s, pose, twist } = contact;
        let is_touched =
            |disc: &MovingDisc| self.footprint.gap_to_moving_m(pose, disc) <= CONTACT_TOLERANCE_M;
        let closing =
            |disc: MovingDisc| self.footprint.closing_speed_m_s(pose, twist, &disc.center());
        let touched = (self.moving)(*time_s).into_iter().filter(is_touched);
        touched.map(closing).fold(f64::NEG_INFINITY, f64::max)
    }

    /// The first command that stays clear of all obstacles until a time.
    fn avoiding_command(&self, from: &State, until_s: f64) -> Option<Twist> {
        let limits = self.limits;
        let value = |low: f64, high: f64, index: u32| {
            low + (high - low) * f64::from(index) / f64::from(TRIED - 1)
        };
        let steps = ((until_s - from.time_s) / STEP_S).ceil().max(0.0) as u32;
        // The obstacles at each step are the same for every command.
        let moving: Vec<Vec<MovingDisc>> =
            (0..=steps).map(|step| (self.moving)(from.time_s + f64::from(step) * STEP_S)).collect();
        let commands = (0..TRIED * TRIED).map(|index| {
            let turn = limits.max_vel_theta;
            Twist::new(
                value(limits.min_vel_x, limits.max_vel_x, index % TRIED),
                value(-turn, turn, index / TRIED),
            )
        });
        // An odd count from a negative lowest speed need not contain zero.
        let all = [Twist::STOP].into_iter().chain(commands);
        all.into_iter().find(|command| self.stays_clear(from, command, &moving))
    }

    fn stays_clear(&self, from: &State, command: &Twist, moving: &[Vec<MovingDisc>]) -> bool {
        let (mut pose, mut twist) = (from.pose, from.twist);
        for discs in moving {
            let touches = |disc: &MovingDisc| {
                self.footprint.gap_to_disc_m(&pose, &disc.center(), disc.radius) <= 0.0
            };
            if discs.iter().any(touches) {
                return false;
            }
            let next = self.limits.reachable(&twist, command, STEP_S);
            pose = advance(&pose, &twist.mean(&next));
            twist = next;
        }
        true
    }
}

/// The pose after a step along the chord of the arc; its length differs from the arc's by less than 1 in 10,000.
fn advance(pose: &Pose, twist: &Twist) -> Pose {
    let turn = twist.angular * STEP_S;
    let (sin, cos) = libm::sincos(pose.yaw + turn / 2.0);
    let distance = twist.linear * STEP_S;
    let place = Point::new(pose.x + distance * cos, pose.y + distance * sin);
    Pose::new(place.x, place.y, pose.yaw + turn)
}
