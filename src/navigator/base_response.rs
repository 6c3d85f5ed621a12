//! The response of the base to commands: sent commands, commands in flight, and the identified response.

use super::state::CommandsInFlight;
use super::{NavigatorSettings, Observation};
use crate::geometry::Twist;
use crate::robot::{Limits, MotionEstimate, MotionIdentifier};

/// No base is commanded to turn by more than the inverse of this ratio: a wrong estimate must not spin it.
const MIN_TURN_RATIO: f64 = 0.5;

/// A command below this share of the decided speed is slowed.
const SLOWED: f64 = 0.9;

/// The commands so far, and the response of the base that was identified from them.
pub(super) struct BaseResponse {
    /// The limits of the settings.
    nominal: Limits,
    /// Whether the identified response is used.
    is_identified: bool,
    /// Time from a command to its effect by the settings, seconds.
    stated_delay_s: f64,
    identifier: MotionIdentifier,
    /// The last commands without the correction of the turn rate: the motion that the robot should make.
    pub in_flight: CommandsInFlight,
    /// Time of the last tick with a finite time, seconds, and the command that was sent then.
    sent: Option<(f64, Twist)>,
    /// The last command, without the correction of the turn rate.
    pub last_command: Twist,
    /// Whether the sender sent a slower command than the last one decided, and not that to stand: its protective layer limits it.
    pub is_slowed: bool,
}

impl BaseResponse {
    /// A base with these limits that has got no command yet.
    pub fn new(nominal: Limits, settings: &NavigatorSettings) -> Self {
        Self {
            nominal,
            is_identified: settings.identify_motion,
            stated_delay_s: settings.actuation_delay_s,
            identifier: MotionIdentifier::new(&nominal, settings.unidentified_delay_s),
            in_flight: CommandsInFlight::default(),
            sent: None,
            last_command: Twist::STOP,
            is_slowed: false,
        }
    }

    /// The identified response of the base.
    pub const fn estimate(&self) -> &MotionEstimate {
        self.identifier.estimate()
    }

    /// The command for a wanted motion. A base whose tracks turn it less than calibrated is commanded to turn more.
    pub fn corrected(&self, wanted: &Twist) -> Twist {
        let ratio = self.turn_ratio();
        if ratio == 1.0 {
            return *wanted;
        }
        self.nominal.clamp(&Twist::new(wanted.linear, wanted.angular / ratio))
    }

    /// Remembers a command that was sent at a time, and what the robot drives by it.
    pub fn set_sent(&mut self, time_s: f64, command: &Twist) {
        self.sent = time_s.is_finite().then_some((time_s, *command));
        self.last_command = Twist::new(command.linear, command.angular * self.turn_ratio());
    }

    /// Forgets the commands so far.
    pub fn forget_commands(&mut self) {
        self.sent = None;
        self.last_command = Twist::STOP;
        self.in_flight = CommandsInFlight::default();
    }

    /// Time from a command to its effect, seconds: the upper end of the identified interval.
    pub fn delay_s(&self) -> f64 {
        if !self.is_identified {
            return self.stated_delay_s;
        }
        self.identifier.estimate().safe_delay_s.max(self.stated_delay_s)
    }

    /// Remembers what was sent since the last tick.
    pub fn record_sent(&mut self, observation: &Observation) {
        if let Some((sent_s, decided)) = self.sent {
            let command = observation.sent.filter(Twist::is_finite).unwrap_or(decided);
            let speed = command.linear.abs();
            self.is_slowed = speed > 0.0 && speed < SLOWED * decided.linear.abs();
            self.set_sent(sent_s, &command);
            self.sent = None;
            self.in_flight.record(sent_s, &self.last_command);
            self.identifier.command(sent_s, &command);
        }
    }

    /// Compares the commands so far with the measured motion. Returns the limits that the drive has shown; none where they are
    /// not used.
    pub fn identify(&mut self, observation: &Observation) -> Option<Limits> {
        if !self.is_identified {
            return None;
        }
        self.identifier.observe(observation.odometry_s, &observation.twist);
        let ratio = self.turn_ratio().min(1.0);
        let limits = self.identifier.estimate().limits(&self.nominal);
        Some(Limits {
            max_vel_theta: limits.max_vel_theta * ratio,
            acc_lim_theta: limits.acc_lim_theta * ratio,
            decel_lim_theta: limits.decel_lim_theta * ratio,
            ..limits
        })
    }

    /// Measured over commanded turn rate: the value of its interval that is nearest to one.
    fn turn_ratio(&self) -> f64 {
        let ratio = self.identifier.estimate().turn_ratio.filter(|_| self.is_identified);
        ratio.map_or(1.0, |ratio| 1.0_f64.min(ratio.high).max(ratio.low).max(MIN_TURN_RATIO))
    }
}
