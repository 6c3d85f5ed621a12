//! A tracked base in motion: motors that lag, ramps that limit, and a pose that follows exact arcs.

use serde::{Deserialize, Serialize};

use super::SimError;
use super::error::{above_zero, at_least_zero, require};
use crate::base::{Base, BaseError, Feedback, finite};
use crate::geometry::{Pose, Twist, wrap_angle};
use crate::robot::{Limits, TrackSpeeds, TrackedDrive};

/// Longest step of the integration, seconds.
const SUB_STEP_S: f64 = 0.01;

/// How a simulated base answers commands.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DriveDynamics {
    /// Time constant of each track's motor under closed-loop speed control, seconds, at least zero: a step of the
    /// set speed is followed to 63 % within it. Default 0.05 s.
    pub motor_lag_s: f64,
    /// Age of a command, seconds, above which the base brakes by itself. Default 0.5 s.
    pub command_timeout_s: f64,
}

impl Default for DriveDynamics {
    fn default() -> Self {
        Self {
            motor_lag_s: 0.05,
            command_timeout_s: 0.5,
        }
    }
}

impl DriveDynamics {
    /// Checks every number.
    ///
    /// # Errors
    /// [`SimError::BadSetting`] names the first that is out of range.
    pub fn validate(&self) -> Result<(), SimError> {
        at_least_zero("motor_lag_s", self.motor_lag_s)?;
        above_zero("command_timeout_s", self.command_timeout_s)
    }
}

/// A simulated tracked base: the same to a caller as a real one, but its time passes only in [`SimBase::step`].
///
/// A command, brought within the speed limits, is approached by a ramp within the acceleration limits; each track's
/// motor follows the ramp with a first-order lag. So speed and turn rate never change faster than the limits allow;
/// only when the motion reverses does the braking limit, and not the lower one for gaining, hold for a few lags more.
/// The tracks do not slip.
#[derive(Clone, Debug)]
pub struct SimBase {
    drive: TrackedDrive,
    limits: Limits,
    dynamics: DriveDynamics,
    pose: Pose,
    command: Twist,
    command_age_s: f64,
    /// Where the ramp stands.
    set: Twist,
    tracks: TrackSpeeds,
}

impl SimBase {
    /// A base that stands still at a pose.
    ///
    /// # Errors
    /// Names the first setting that is out of range.
    pub fn new(
        drive: TrackedDrive,
        limits: Limits,
        dynamics: DriveDynamics,
        pose: Pose,
    ) -> Result<Self, SimError> {
        limits.validate()?;
        dynamics.validate()?;
        above_zero("track_width_m", drive.track_width_m)?;
        for (name, value) in [
            ("start x", pose.x),
            ("start y", pose.y),
            ("start yaw", pose.yaw),
        ] {
            require(value.is_finite(), name, value, "finite")?;
        }
        Ok(Self {
            drive,
            limits,
            dynamics,
            pose,
            command: Twist::STOP,
            command_age_s: 0.0,
            set: Twist::STOP,
            tracks: TrackSpeeds::default(),
        })
    }

    /// Where the base truly is; its yaw is in (-pi, pi].
    #[must_use]
    pub const fn pose(&self) -> &Pose {
        &self.pose
    }

    /// How fast it truly moves.
    #[must_use]
    pub fn twist(&self) -> Twist {
        self.drive.twist(&self.tracks)
    }

    /// Lets time pass, seconds; none for a time that is not above zero.
    ///
    /// Steps of at most 10 ms: within each the twist is the mean of those at its ends, along which the pose moves
    /// on an exact arc.
    pub fn step(&mut self, time_s: f64) {
        if !(time_s > 0.0 && time_s.is_finite()) {
            return;
        }
        let steps = (time_s / SUB_STEP_S).ceil().max(1.0);
        let sub_step_s = time_s / steps;
        for _ in 0..steps as u64 {
            self.sub_step(sub_step_s);
        }
    }

    fn sub_step(&mut self, time_s: f64) {
        let wanted = if self.command_age_s > self.dynamics.command_timeout_s {
            Twist::STOP
        } else {
            self.command
        };
        self.command_age_s += time_s;
        self.set = self.limits.reachable(&self.set, &wanted, time_s);
        let before = self.twist();
        let set = self.drive.tracks(&self.set);
        let share = if self.dynamics.motor_lag_s > 0.0 {
            1.0 - libm::exp(-time_s / self.dynamics.motor_lag_s)
        } else {
            1.0
        };
        self.tracks.left += share * (set.left - self.tracks.left);
        self.tracks.right += share * (set.right - self.tracks.right);
        let after = self.twist();
        let mean = Twist::new(
            f64::midpoint(before.linear, after.linear),
            f64::midpoint(before.angular, after.angular),
        );
        self.pose = along_arc(&self.pose, &mean, time_s);
    }
}

impl Base for SimBase {
    /// Never blocks.
    fn send(&mut self, command: &Twist) -> Result<(), BaseError> {
        self.command = self.limits.nearest_allowed(finite(command)?);
        self.command_age_s = 0.0;
        Ok(())
    }

    /// Never blocks, never fails: the true twist.
    fn feedback(&mut self) -> Result<Feedback, BaseError> {
        Ok(Feedback {
            twist: self.twist(),
            ..Feedback::default()
        })
    }
}

/// The pose after driving with a constant twist for a time: an arc of a circle, exact also where it is straight.
fn along_arc(pose: &Pose, twist: &Twist, time_s: f64) -> Pose {
    let half_turn = twist.angular * time_s / 2.0;
    // The chord is shorter than the arc by sin(h) / h, and points half the turn away from the start.
    let shortening = if half_turn.abs() < 1e-4 {
        1.0 - half_turn * half_turn / 6.0
    } else {
        libm::sin(half_turn) / half_turn
    };
    let chord = twist.linear * time_s * shortening;
    let (sin, cos) = libm::sincos(pose.yaw + half_turn);
    Pose {
        x: pose.x + chord * cos,
        y: pose.y + chord * sin,
        yaw: wrap_angle(pose.yaw + 2.0 * half_turn),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;

    #[test]
    fn a_half_circle_ends_a_diameter_to_the_left_facing_back() {
        // 1 m/s at 0.5 rad/s is a circle of radius 2 m; half of it takes 2 pi seconds.
        let end = along_arc(&Pose::default(), &Twist::new(1.0, 0.5), 2.0 * PI);
        assert!(end.x.abs() < 1e-12 && (end.y - 4.0).abs() < 1e-12);
        assert!((end.yaw.abs() - PI).abs() < 1e-12);
    }

    #[test]
    fn the_arc_has_no_seam_where_it_turns_straight() {
        let x_of = |angular| along_arc(&Pose::default(), &Twist::new(1.0, angular), 1.0).x;
        assert!((x_of(1.999e-4) - x_of(2.001e-4)).abs() < 2e-11);
        assert!((x_of(0.0) - 1.0).abs() < 1e-15);
    }
}
