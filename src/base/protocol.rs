//! The two sides of a wire protocol, without I/O: bytes and time in, bytes and motion out.

use core::fmt;
use core::str::FromStr;

use serde::{Deserialize, Serialize};

use super::arduino::{ArduinoDevice, ArduinoSession};
use super::encoder_speed::EncoderSpeed;
use super::native::{NativeDevice, NativeSession};
use super::roboclaw::{RoboClawDevice, RoboClawSession};
use super::wheeltec::{WheeltecDevice, WheeltecSession};
use super::{BaseError, BaseSettings, Bumper, Faults, Feedback, Tilt};
use crate::geometry::Twist;
use crate::robot::{PerTrack, TrackSpeeds};
use crate::settings::{parse_choice, words};

words! {
    /// A wire protocol of bases.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
    #[non_exhaustive]
    pub enum Protocol {
        /// This crate's own frames: see [`super::native`].
        #[default]
        Native = "native",
        /// WHEELTEC's STM32 controllers: see [`super::wheeltec`].
        Wheeltec = "wheeltec",
        /// `RoboClaw` motor controllers: see [`super::roboclaw`].
        Roboclaw = "roboclaw",
        /// `ROSArduinoBridge`: see [`super::arduino`].
        Arduino = "arduino",
    }
}

/// Time after a release in which the base may still report its stop, seconds: command and report take time, and may be damaged.
pub(super) const RELEASE_GRACE_S: f64 = 0.5;

impl Protocol {
    /// Whether a base with the published firmware stops by itself when commands cease.
    #[must_use]
    pub const fn has_watchdog(self) -> bool {
        !matches!(self, Self::Wheeltec)
    }

    /// Creates a session: the host's side of the protocol.
    ///
    /// # Errors
    /// Settings out of range.
    pub fn session(self, settings: BaseSettings) -> Result<Box<dyn Session>, BaseError> {
        Ok(match self {
            Self::Native => Box::new(NativeSession::new(settings)?),
            Self::Wheeltec => Box::new(WheeltecSession::new(settings)?),
            Self::Roboclaw => Box::new(RoboClawSession::new(settings)?),
            Self::Arduino => Box::new(ArduinoSession::new(settings)?),
        })
    }

    /// Creates a lower controller at power-on: the base's side of the protocol.
    ///
    /// # Errors
    /// Settings out of range.
    pub fn device(self, settings: BaseSettings) -> Result<Box<dyn DeviceProtocol>, BaseError> {
        Ok(match self {
            Self::Native => Box::new(NativeDevice::new(settings)?),
            Self::Wheeltec => Box::new(WheeltecDevice::new(&settings)?),
            Self::Roboclaw => Box::new(RoboClawDevice::new(settings)?),
            Self::Arduino => Box::new(ArduinoDevice::new(settings)?),
        })
    }
}

impl fmt::Display for Protocol {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

impl FromStr for Protocol {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        parse_choice("a protocol", text)
    }
}

/// The host's side of a protocol. It has no port and no clock: the caller transfers the bytes and passes the time.
///
/// Time is in seconds from any origin and never runs backwards. A session never renews a command by itself: each
/// [`Session::command`] sends one frame, which is repeated, with the latest command in it, only if its answer was lost. So the
/// base's own watchdog, if it has one, acts when the caller stops sending.
///
/// To drive a base with another protocol, write a type that holds a [`SessionCore`] and implement the methods without a default.
/// `receive` passes each complete feedback to [`SessionCore::report`]. `transmit` sends [`SessionCore::target`] while
/// [`SessionCore::is_pending`], and clears this flag. Override the other methods for requests and for a latched stop.
pub trait Session: Send {
    /// The state that the methods with a default use.
    fn core(&self) -> &SessionCore;

    /// The same state, to change it.
    fn core_mut(&mut self) -> &mut SessionCore;

    /// Speed of the serial line, baud.
    fn baud(&self) -> u32;

    /// Takes received bytes, in pieces of any size.
    fn receive(&mut self, bytes: &[u8], now_s: f64);

    /// Appends the bytes to write now to `line`. Call it after [`Session::command`], after [`Session::receive`], and
    /// periodically while [`Session::is_waiting`].
    fn transmit(&mut self, now_s: f64, line: &mut Vec<u8>);

    /// Whether an answer is outstanding; after it there may be more to write.
    fn is_waiting(&self) -> bool {
        false
    }

    /// Sets the next command and replaces one that was not sent yet. The caller has limited it; a command still beyond the
    /// tracks' highest speed is scaled down at constant curvature.
    ///
    /// # Errors
    /// [`BaseError::NotFinite`]; the previous command then stays.
    fn command(&mut self, twist: &Twist) -> Result<(), BaseError> {
        let core = self.core_mut();
        core.target = core.settings.limit(twist)?;
        core.is_pending = true;
        Ok(())
    }

    /// The latest complete feedback with its time of arrival.
    fn latest(&self) -> Option<&TimedFeedback> {
        self.core().latest.as_ref()
    }

    /// Counts of line errors so far.
    fn counters(&self) -> SessionCounters {
        let core = self.core();
        let rejected_readings = core.counters.rejected_readings + core.encoder_speed.rejected();
        SessionCounters { rejected_readings, ..core.counters }
    }

    /// Stops the base until [`Session::release`], if the protocol can latch a stop; otherwise commands zero, and the caller must
    /// keep commanding zero.
    fn engage_stop(&mut self) {
        self.core_mut().stop();
    }

    /// Ends a latched stop, as an operator's explicit decision, and clears the faults that the session found. The commanded motion
    /// becomes zero. A button that is still pressed keeps the base stopped.
    fn release(&mut self) {
        self.core_mut().release();
    }
}

/// Feedback with its time of arrival.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct TimedFeedback {
    /// Time at which its last byte was received, seconds.
    pub received_s: f64,
    /// The feedback.
    pub feedback: Feedback,
}

/// Line errors since the session began. All zero on a clean line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct SessionCounters {
    /// Bytes that belong to no frame or answer.
    pub dropped_bytes: u64,
    /// Requests repeated because no valid answer came in time.
    pub retries: u64,
    /// Requests given up after the last attempt.
    pub unanswered: u64,
    /// Encoder counts and speeds rejected because no track runs that fast.
    pub rejected_readings: u64,
}

/// State of every [`Session`]: the motion to command, the latest feedback and the line errors.
#[derive(Clone, Debug)]
pub struct SessionCore {
    /// Settings of the base.
    pub settings: BaseSettings,
    /// The commanded motion, within the tracks' highest speed.
    pub target: Twist,
    /// Whether [`Self::target`] is to be sent.
    pub is_pending: bool,
    /// Line errors that the session counts itself.
    pub counters: SessionCounters,
    pub(super) encoder_speed: EncoderSpeed,
    latest: Option<TimedFeedback>,
}

impl SessionCore {
    /// Creates the state of a session that has no command to send and no feedback.
    ///
    /// # Errors
    /// Settings out of range.
    pub fn new(settings: BaseSettings) -> Result<Self, BaseError> {
        settings.validate()?;
        Ok(Self {
            settings,
            target: Twist::STOP,
            is_pending: false,
            counters: SessionCounters::default(),
            encoder_speed: EncoderSpeed::new(&settings),
            latest: None,
        })
    }

    /// The commanded speeds of the tracks, m/s.
    #[must_use]
    pub fn target_speeds(&self) -> TrackSpeeds {
        self.settings.drive().tracks(&self.target)
    }

    /// Takes the pending command as ticks per second of the controller's channels.
    pub fn take_rates(&mut self) -> [f64; 2] {
        self.is_pending = false;
        let speeds = self.target_speeds();
        self.encoder_speed.command(&speeds);
        self.settings.channel_rates(&speeds)
    }

    /// Commands zero velocity.
    pub fn stop(&mut self) {
        self.target = Twist::STOP;
        self.is_pending = true;
    }

    /// Commands zero velocity and clears the faults that the session found.
    pub fn release(&mut self) {
        self.stop();
        self.encoder_speed.clear_fault();
    }

    /// Stores the latest feedback with its time of arrival, seconds.
    pub fn report(&mut self, feedback: Feedback, received_s: f64) {
        self.latest = Some(TimedFeedback { received_s, feedback });
    }
}

/// The communication part of a lower controller's firmware. The caller simulates motors, encoders and faults.
///
/// It knows the machine by settings of its own, which may differ from the host's, as firmware does.
pub trait DeviceProtocol: Send {
    /// Takes received bytes, in pieces of any size.
    fn receive(&mut self, bytes: &[u8], now_s: f64);

    /// Runs one cycle of the firmware's loop: appends the bytes to write to `line` and returns the set speeds of the tracks,
    /// m/s: zero while the watchdog or an emergency stop acts. Time never runs backwards.
    fn step(&mut self, now_s: f64, machine: &MachineState, line: &mut Vec<u8>) -> TrackSpeeds;

    /// Statistics of the commands received so far.
    fn command_stats(&self) -> CommandStats;
}

/// Commands received by a controller since power-on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct CommandStats {
    /// Accepted motor commands.
    pub commands: u64,
    /// Number of consecutive zero commands at the end.
    pub final_zero_commands: u64,
    /// How often the watchdog stopped running motors because commands ceased.
    pub watchdog_stops: u64,
    /// Number of zero commands between the last of these stops and the next motion.
    pub zero_commands_after_watchdog: u64,
}

/// Collects [`CommandStats`].
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CommandCounter {
    stats: CommandStats,
    is_watchdog_active: bool,
    /// Whether every command since the watchdog's last stop was zero.
    restarts: bool,
}

impl CommandCounter {
    pub(super) const fn stats(&self) -> CommandStats {
        self.stats
    }

    /// Counts an accepted command.
    pub(super) const fn command(&mut self, is_zero: bool) {
        self.stats.commands += 1;
        self.restarts &= is_zero;
        if self.restarts {
            self.stats.zero_commands_after_watchdog += 1;
        }
        self.stats.final_zero_commands =
            if is_zero { self.stats.final_zero_commands + 1 } else { 0 };
    }

    /// Counts the watchdog's stops; call it in every cycle with whether the watchdog holds motors that were commanded to run.
    pub(super) fn watchdog(&mut self, is_active: bool) {
        if is_active && !self.is_watchdog_active {
            self.stats.watchdog_stops += 1;
            self.stats.zero_commands_after_watchdog = 0;
            self.restarts = true;
        }
        self.is_watchdog_active = is_active;
    }
}

/// Times the periodic reports of a controller; the first one is due at once.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReportTimer {
    period_s: f64,
    next_s: f64,
}

impl ReportTimer {
    pub(super) const fn new(period_s: f64) -> Self {
        Self { period_s, next_s: f64::NEG_INFINITY }
    }

    /// Whether a report is due now; the next one is then due a period after this one was. There is no burst of reports after a pause.
    pub(super) fn is_due(&mut self, now_s: f64) -> bool {
        let is_due = now_s >= self.next_s;
        if is_due {
            let next_s = self.next_s + self.period_s;
            self.next_s = if next_s > now_s { next_s } else { now_s + self.period_s };
        }
        is_due
    }
}

/// State of the machine as its controller measures it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MachineState {
    /// Encoder counts of the tracks, modulo 2^32.
    pub encoder_counts: PerTrack<u32>,
    /// Measured speeds of the tracks, m/s.
    pub speeds: TrackSpeeds,
    /// Turn rate by the gyro, rad/s.
    pub yaw_rate: f64,
    /// Battery voltage.
    pub battery_v: f64,
    /// Faults found by the controller.
    pub faults: Faults,
    /// Whether the emergency button is pressed.
    pub button_pressed: bool,
    /// Tilt against the horizontal.
    pub tilt: Tilt,
    /// Bumpers that are pressed.
    pub bumper: Bumper,
    /// Whether a cliff sensor sees no ground.
    pub cliff: bool,
}
