//! Identification of a base's response to commands while it drives: latency, acceleration, braking, speed and turn ratios.
//!
//! With a wrong latency the stopping distance may be too short, and the robot hits an obstacle. So the latency is identified during
//! each drive, and is not only a setting. [`SpeedResponse`] compares the measured speed with a bank of models of the base, each with
//! another latency, acceleration and braking. [`TurnResponse`] compares the measured turn rate with the commanded one. Both are
//! recursive and use bounded memory. New information replaces that of old drives.
//!
//! **Which latency.** The latency runs from the hand-over of a command to its visible effect in the measured speed, by the time
//! stamp of the measurement. A lag of the motors counts as latency. Where the stamp is the true time of the measurement, this is
//! the latency of the actuation alone. Where a stamp hides an age of the measurement, the latency includes that age. In both
//! cases, the state at which a command takes effect is the measured state, advanced by a time: the present age of its stamp plus
//! the identified latency.

mod speed_response;
mod turn_response;

use serde::Serialize;

use super::Limits;
use crate::geometry::Twist;
use speed_response::SpeedResponse;
use turn_response::TurnResponse;

/// A latency is identified when its interval is at most this wide, seconds.
const NARROW_S: f64 = 0.2;

/// No base drives or turns faster than this, m/s and rad/s: such a value is an error.
pub(crate) const MAX_RATE: f64 = 100.0;

/// Whether a twist is finite, and neither of its rates is above [`MAX_RATE`].
pub(crate) fn is_plausible(twist: &Twist) -> bool {
    twist.is_finite() && twist.linear.abs() <= MAX_RATE && twist.angular.abs() <= MAX_RATE
}

/// An estimate with the interval that holds the true value in almost all drives.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// The most probable value.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// The identified response of a base to commands.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct MotionEstimate {
    /// Time from a command to its measured effect, seconds; none until the drive has shown it.
    pub delay_s: Option<Interval>,
    /// Latency that covers the base, seconds: the upper end of the interval, or an assumption before it is identified.
    pub safe_delay_s: f64,
    /// Forward acceleration, m/s^2: the limit, unless the base accelerates less.
    pub acceleration_m_s2: f64,
    /// Forward deceleration, m/s^2 and positive: the limit, unless the base brakes less.
    pub braking_m_s2: f64,
    /// Measured over commanded forward speed; none until it is known.
    pub speed_ratio: Option<Interval>,
    /// Measured over commanded turn rate; none until it is known. Below one, the effective width of the tracks is larger than
    /// the calibrated one, by the inverse of this ratio.
    pub turn_ratio: Option<Interval>,
    /// Number of measurements that no model of the base explains: a stuck base, or one that does not get these commands.
    pub unexplained: u64,
}

impl MotionEstimate {
    /// The limits with the identified acceleration and braking.
    #[must_use]
    pub const fn limits(&self, limits: &Limits) -> Limits {
        Limits { acc_lim_x: self.acceleration_m_s2, decel_lim_x: -self.braking_m_s2, ..*limits }
    }
}

/// Identifies a base's response from commands and measurements, both with their times.
#[derive(Clone, Debug)]
pub struct MotionIdentifier {
    limits: Limits,
    assumed_delay_s: f64,
    speed: SpeedResponse,
    turn: TurnResponse,
    estimate: MotionEstimate,
}

impl MotionIdentifier {
    /// Creates an identifier for a base with these limits, which assumes a latency, seconds, until it is identified.
    #[must_use]
    pub fn new(limits: &Limits, assumed_delay_s: f64) -> Self {
        Self {
            limits: *limits,
            assumed_delay_s,
            speed: SpeedResponse::new(limits),
            turn: TurnResponse::new(limits),
            estimate: MotionEstimate {
                delay_s: None,
                safe_delay_s: assumed_delay_s,
                acceleration_m_s2: limits.acc_lim_x,
                braking_m_s2: -limits.decel_lim_x,
                speed_ratio: None,
                turn_ratio: None,
                unexplained: 0,
            },
        }
    }

    /// Records a command that was handed over at a time, seconds; times ascend. Implausible values are ignored.
    pub fn command(&mut self, time_s: f64, command: &Twist) {
        if time_s.is_finite() && is_plausible(command) {
            self.speed.command(time_s, command.linear);
            self.turn.command(time_s, command.angular);
        }
    }

    /// Compares a measured motion with the commands, at the time of the measurement, seconds, by the clock of the commands. A
    /// measurement with the time of the last one is ignored, and an implausible one is.
    pub fn observe(&mut self, measured_s: f64, measured: &Twist) {
        if !(measured_s.is_finite() && is_plausible(measured)) {
            return;
        }
        if self.speed.observe(measured_s, measured.linear) {
            let Self { limits, speed, estimate, .. } = self;
            let delay_s = speed.delay_s();
            let is_narrow = delay_s.high - delay_s.low <= NARROW_S;
            estimate.delay_s = is_narrow.then_some(delay_s);
            // Within a wide interval, the assumption holds as long as nothing contradicts it.
            let is_assumed = !is_narrow && delay_s.low <= self.assumed_delay_s;
            estimate.safe_delay_s =
                if is_assumed { delay_s.high.min(self.assumed_delay_s) } else { delay_s.high };
            (estimate.acceleration_m_s2, estimate.braking_m_s2) = speed.accelerations(limits);
            estimate.speed_ratio = is_narrow.then(|| speed.ratio());
            estimate.unexplained = speed.unexplained();
        }
        if let Some(delay_s) = self.estimate.delay_s {
            self.turn.observe(measured_s, measured.angular, delay_s.value);
            self.estimate.turn_ratio = self.turn.ratio();
        }
    }

    /// What is known now.
    #[must_use]
    pub const fn estimate(&self) -> &MotionEstimate {
        &self.estimate
    }
}
