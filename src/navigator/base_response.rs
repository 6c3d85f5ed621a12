//! The response of the base to commands: sent commands, commands in flight, and the identified response.

use super::predicted_state::CommandsInFlight;
use super::{NavigatorSettings, Observation};
use crate::geometry::Twist;
use crate::robot::{Limits, MotionEstimate, MotionIdentifier};

/// No base is commanded to turn by more than the inverse of this ratio: a wrong estimate must not spin it.
const MIN_TURN_RATIO: f64 = 0.5;

/// A base that drives faster than commanded by more than this share is commanded to drive slower.
const FASTER: f64 = 0.1;

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
    /// The last commands without their correction: the motion that the robot should make.
    pub in_flight: CommandsInFlight,
    /// Time of the last tick with a finite time, seconds, and the command that was sent then.
    sent: Option<(f64, Twist)>,
    /// The last command, without its correction.
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

    /// The command for a wanted motion. A base whose tracks turn it less than calibrated is commanded to turn more, and one that drives
    /// faster than commanded is commanded to drive slower.
    pub fn corrected(&self, wanted: &Twist) -> Twist {
        let (speed_ratio, turn_ratio) = (self.speed_ratio(), self.turn_ratio());
        if speed_ratio == 1.0 && turn_ratio == 1.0 {
            return *wanted;
        }
        let command = Twist::new(wanted.linear / speed_ratio, wanted.angular / turn_ratio);
        self.nominal.clamp(&command)
    }

    /// Remembers a command that was sent at a time, and what the robot drives by it.
    pub fn set_sent(&mut self, time_s: f64, command: &Twist) {
        self.sent = time_s.is_finite().then_some((time_s, *command));
        self.last_command =
            Twist::new(command.linear * self.speed_ratio(), command.angular * self.turn_ratio());
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

    /// Measured over commanded speed of a base that drives faster than commanded for certain; one for any other.
    fn speed_ratio(&self) -> f64 {
        let ratio = self.identifier.estimate().speed_ratio.filter(|_| self.is_identified);
        ratio.filter(|ratio| ratio.low > 1.0 + FASTER).map_or(1.0, |ratio| ratio.value)
    }

    /// Measured over commanded turn rate: the value of its interval that is nearest to one.
    fn turn_ratio(&self) -> f64 {
        let ratio = self.identifier.estimate().turn_ratio.filter(|_| self.is_identified);
        ratio.map_or(1.0, |ratio| 1.0_f64.min(ratio.high).max(ratio.low).max(MIN_TURN_RATIO))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::map::Scan;

    fn observation(time_s: f64, linear: f64) -> Observation {
        Observation {
            time_s,
            pose: Pose::default(),
            pose_s: time_s,
            lost: None,
            twist: Twist::new(linear, 0.0),
            odometry_s: time_s,
            scan: Scan::default(),
            scan_s: time_s,
            scan_changed_s: time_s,
            sent: None,
        }
    }

    /// The command for 0.8 m/s, after 20 s with a base that drives this many times as fast as commanded.
    fn commanded(times: f64) -> f64 {
        let mut base = BaseResponse::new(Limits::default(), &NavigatorSettings::default());
        let mut speed = 0.0;
        for tick in 0..200 {
            let time_s = 0.1 * f64::from(tick);
            let seen = observation(time_s, times * speed);
            base.record_sent(&seen);
            base.identify(&seen);
            let phase_s = time_s % 6.0;
            let wanted = phase_s.min(6.0 - phase_s).min(0.8);
            let command = base.corrected(&Twist::new(wanted, 0.0));
            base.set_sent(time_s, &command);
            speed = command.linear;
        }
        base.corrected(&Twist::new(0.8, 0.0)).linear
    }

    #[test]
    fn base_that_drives_faster_than_commanded_is_commanded_to_drive_slower() {
        assert!((commanded(1.25) - 0.64).abs() < 0.02, "{}", commanded(1.25));
        assert_eq!([commanded(1.0), commanded(1.05), commanded(0.8)], [0.8; 3]);
    }
}
