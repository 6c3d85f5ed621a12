//! Detects a base that does not follow its commands: stuck, reversed or runaway tracks, slip, delay, low battery.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{BaseError, BaseSettings, Faults, Feedback};
use crate::geometry::Twist;
use crate::robot::{PerTrack, Side, TrackSpeeds, TrackedDrive};
use crate::settings::settings;

/// A track below this share of its commanded speed stands, if for long.
const STUCK_SHARE: f64 = 0.1;

/// A track that runs backwards by at least this share of its commanded speed is wired in reverse, if for long. No track coasts
/// or rolls back at half its commanded speed.
const REVERSED_SHARE: f64 = 0.5;

/// Time for which commands must be delayed, seconds: a controller that is held up for a moment catches up.
const COMMAND_DELAY_S: f64 = 0.5;

/// Time for which the battery voltage must be low, seconds: it sags under load when a base starts.
const LOW_BATTERY_S: f64 = 5.0;

settings! {
    /// How far the measured motion may deviate from the command, and for how long.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct FaultDetectorSettings {
        /// Commanded speed from which a track is expected to move. Default 0.1 m/s: below it a deadband, a slope or
        /// coarse encoders may hold a sound track.
        pub motion_threshold_m_s: f64 = 0.1, ["m/s", above 0];
        /// Time after which a track that should move and stands is stuck. Default 1 s: motors with a lag of 0.1 s
        /// have long moved, and blocked motors have not yet burnt out.
        pub stuck_s: f64 = 1.0, ["s", above 0];
        /// Time after which a track that runs against its command is reversed. Default 0.5 s: commands are ramped, so
        /// that tracks follow them within a lag or two.
        pub reversed_s: f64 = 0.5, ["s", above 0];
        /// Speed by which a runaway track exceeds every recent command. Default 0.15 m/s: more than a good speed
        /// control overshoots.
        pub runaway_margin_m_s: f64 = 0.15, ["m/s", above 0];
        /// Time after which such a track has run away, and the time that counts as recent. Default 0.5 s.
        pub runaway_s: f64 = 0.5, ["s", above 0];
        /// Difference of the turn rates by gyro and tracks that counts as slip if it also exceeds half of the
        /// greater rate. Default 0.4 rad/s: the effective track width is known to about 10 % on one floor.
        pub slip_rate_rad_s: f64 = 0.4, ["rad/s", above 0];
        /// Time after which slip is a fault. Default 1 s: over stones a base slips for moments.
        pub slip_s: f64 = 1.0, ["s", above 0];
        /// Age at which a command that the base has not accepted is delayed; only for protocols that acknowledge
        /// commands. Default 0.2 s: ten commands, and two cycles of the slowest planner.
        pub command_delay_s: f64 = 0.2, ["s", above 0];
    }
}

/// A report of the base with the command it should follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaseSample {
    /// Time, seconds from any origin; never backwards.
    pub now_s: f64,
    /// The last motion sent, after all limits and ramps.
    pub sent: Twist,
    /// The latest feedback, not out of date.
    pub feedback: Feedback,
}

/// Compares a base's motion with its commands. Latches the first fault until it is released.
///
/// Each symptom has a timer that restarts when the symptom ends: a track is stuck if every command of the last second demanded
/// motion and it stood throughout. Ramped commands pass through zero at a reversal, so that neither a reversal nor a start
/// counts against a track. A track that slows down may be as fast as any recent command.
#[derive(Clone, Debug)]
pub struct FaultDetector {
    settings: FaultDetectorSettings,
    drive: TrackedDrive,
    min_battery_v: Option<f64>,
    /// Recent commands to the tracks, the oldest first.
    recent: VecDeque<(f64, TrackSpeeds)>,
    timers: Timers,
    cause: Option<StopCause>,
}

/// Timers of all symptoms.
#[derive(Clone, Copy, Debug, Default)]
struct Timers {
    tracks: PerTrack<TrackTimers>,
    slip: Timer,
    command_delay: Timer,
    low_battery: Timer,
}

/// Timers of one track's symptoms.
#[derive(Clone, Copy, Debug, Default)]
struct TrackTimers {
    stuck: Timer,
    reversed: Timer,
    too_fast: Timer,
}

/// Start of a condition that holds without interruption.
#[derive(Clone, Copy, Debug, Default)]
struct Timer(Option<f64>);

impl Timer {
    /// Whether the condition has held for this time, seconds.
    fn elapsed(&mut self, holds: bool, now_s: f64, for_s: f64) -> bool {
        self.0 = if holds { self.0.or(Some(now_s)) } else { None };
        self.0.is_some_and(|start_s| now_s - start_s >= for_s)
    }
}

impl FaultDetector {
    /// Creates the detector of a base that stands.
    ///
    /// # Errors
    /// Settings out of range.
    pub fn new(base: &BaseSettings, settings: FaultDetectorSettings) -> Result<Self, BaseError> {
        base.validate()?;
        settings.validate()?;
        Ok(Self {
            settings,
            drive: base.drive(),
            min_battery_v: base.min_battery_v,
            recent: VecDeque::new(),
            timers: Timers::default(),
            cause: None,
        })
    }

    /// Takes a sample and returns the first fault since the last release, if there is one.
    ///
    /// Call it at least ten times per second. [`Faults::WATCHDOG`] alone is no fault: it ends with the next command.
    pub fn update(&mut self, sample: &BaseSample) -> Option<&StopCause> {
        let found = self.detect(sample);
        self.cause = self.cause.or(found);
        self.cause.as_ref()
    }

    /// Forgets the fault and resets every timer, as an operator's explicit decision. A fault that persists is detected again.
    pub fn release(&mut self) {
        self.cause = None;
        self.recent.clear();
        self.timers = Timers::default();
    }

    fn detect(&mut self, sample: &BaseSample) -> Option<StopCause> {
        let BaseSample { now_s, feedback, .. } = *sample;
        let commanded = self.drive.tracks(&sample.sent);
        self.recent.push_back((now_s, commanded));
        let oldest_s = now_s - self.settings.runaway_s;
        while self.recent.front().is_some_and(|(at_s, _)| *at_s < oldest_s) {
            self.recent.pop_front();
        }
        if feedback.emergency_stop {
            return Some(StopCause::EmergencyStop);
        }
        let faults = feedback.faults.difference(Faults::WATCHDOG);
        if !faults.is_empty() {
            return Some(StopCause::Fault(faults));
        }
        if !feedback.twist.is_finite() {
            return Some(StopCause::NotFinite);
        }
        let measured = self.drive.tracks(&feedback.twist);
        // Every check runs in every case: no timer may stand still because another one has elapsed.
        let left = self.check_track(Side::Left, now_s, commanded.left, measured.left);
        let right = self.check_track(Side::Right, now_s, commanded.right, measured.right);
        let slip = self.check_slip(now_s, &feedback);
        let command_delay = self.check_command_delay(now_s, &feedback);
        let battery = self.check_battery(now_s, &feedback);
        left.or(right).or(slip).or(command_delay).or(battery)
    }

    fn check_track(
        &mut self,
        side: Side,
        now_s: f64,
        commanded: f64,
        measured: f64,
    ) -> Option<StopCause> {
        let settings = self.settings;
        let recent = || {
            let of_side = |(_, speeds): &(f64, TrackSpeeds)| speeds.of(side);
            self.recent.iter().map(of_side)
        };
        let fastest = recent().fold(0.0, f64::max);
        let slowest = recent().fold(0.0, f64::min);
        let should_move = commanded.abs() >= settings.motion_threshold_m_s;
        let along = measured * commanded.signum();
        let stuck = should_move && along.abs() < STUCK_SHARE * commanded.abs();
        let against = should_move && along <= -REVERSED_SHARE * commanded.abs();
        let too_fast = measured > fastest + settings.runaway_margin_m_s
            || measured < slowest - settings.runaway_margin_m_s;
        let timers = match side {
            Side::Left => &mut self.timers.tracks.left,
            Side::Right => &mut self.timers.tracks.right,
        };
        let stuck = timers.stuck.elapsed(stuck, now_s, settings.stuck_s);
        let reversed = timers.reversed.elapsed(against, now_s, settings.reversed_s);
        let too_fast = timers.too_fast.elapsed(too_fast, now_s, settings.runaway_s);
        // Under speed control swapped leads make a track ever faster: that is no runaway.
        if reversed || too_fast && against {
            Some(StopCause::Reversed { side, commanded, measured })
        } else if too_fast {
            Some(StopCause::Runaway { side, commanded, measured })
        } else if stuck {
            Some(StopCause::Stuck { side, commanded, measured })
        } else {
            None
        }
    }

    fn check_slip(&mut self, now_s: f64, feedback: &Feedback) -> Option<StopCause> {
        let tracks = feedback.twist.angular;
        let gyro = feedback.yaw_rate.unwrap_or(tracks);
        let difference = (gyro - tracks).abs();
        let slips = difference > self.settings.slip_rate_rad_s
            && difference > 0.5 * gyro.abs().max(tracks.abs());
        self.timers
            .slip
            .elapsed(slips, now_s, self.settings.slip_s)
            .then_some(StopCause::Slip { tracks, gyro })
    }

    fn check_command_delay(&mut self, now_s: f64, feedback: &Feedback) -> Option<StopCause> {
        let delay_s = feedback.command_delay_s?;
        let is_delayed = delay_s > self.settings.command_delay_s;
        self.timers
            .command_delay
            .elapsed(is_delayed, now_s, COMMAND_DELAY_S)
            .then_some(StopCause::CommandDelay { delay_s })
    }

    fn check_battery(&mut self, now_s: f64, feedback: &Feedback) -> Option<StopCause> {
        let min = self.min_battery_v?;
        let volts = feedback.battery_v?;
        self.timers
            .low_battery
            .elapsed(volts < min, now_s, LOW_BATTERY_S)
            .then_some(StopCause::LowBattery { volts, min })
    }
}

/// Why a stop is latched. Speeds in m/s, forward positive.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum StopCause {
    /// The caller requested the stop.
    #[error("a stop was requested")]
    Requested,
    /// The base is at its own emergency stop.
    #[error(
        "the base is at its emergency stop: check its surroundings, release the button, then release the stop"
    )]
    EmergencyStop,
    /// Faults found by the base or its driver.
    #[error("the base reports: {0}")]
    Fault(Faults),
    /// The measured motion is NaN or infinite.
    #[error("the base reports a motion that is not finite")]
    NotFinite,
    /// A track stands although it is commanded to move.
    #[error(
        "the {side} track stands (measured {measured:.2} m/s) while commanded {commanded:.2} m/s: it is stuck, or its motor or encoder is not connected"
    )]
    Stuck {
        /// The track.
        side: Side,
        /// Commanded speed.
        commanded: f64,
        /// Measured speed.
        measured: f64,
    },
    /// A track runs against its command.
    #[error(
        "the {side} track runs at {measured:.2} m/s while commanded {commanded:.2} m/s: its motor or encoder is wired in reverse, or the tracks are swapped"
    )]
    Reversed {
        /// The track.
        side: Side,
        /// Commanded speed.
        commanded: f64,
        /// Measured speed.
        measured: f64,
    },
    /// A track is faster than every recent command.
    #[error(
        "the {side} track runs at {measured:.2} m/s while commanded {commanded:.2} m/s: it has run away; cut the motors' power if it does not stop"
    )]
    Runaway {
        /// The track.
        side: Side,
        /// Commanded speed.
        commanded: f64,
        /// Measured speed.
        measured: f64,
    },
    /// Gyro and tracks disagree on the turn rate.
    #[error(
        "the turn rate is {tracks:.2} rad/s by the tracks and {gyro:.2} rad/s by the gyro: the tracks slip or are swapped, or the effective track width is wrong"
    )]
    Slip {
        /// Turn rate by the tracks, rad/s.
        tracks: f64,
        /// Turn rate by the gyro, rad/s.
        gyro: f64,
    },
    /// The battery is low.
    #[error("the battery has {volts:.1} V, less than {min:.1} V: charge it")]
    LowBattery {
        /// Measured voltage.
        volts: f64,
        /// Configured minimum.
        min: f64,
    },
    /// The base accepts commands too late.
    #[error(
        "the base is {delay_s:.2} s behind with its commands: its controller reads them too slowly, or the serial line delays them"
    )]
    CommandDelay {
        /// Age of the oldest command not yet accepted, seconds.
        delay_s: f64,
    },
}
