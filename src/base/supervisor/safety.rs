//! The safety policy of the supervisor: which command goes to the base now. No thread, no port, no clock.

use thiserror::Error;

use super::SupervisorSettings;
use crate::base::fault_detector::{BaseSample, FaultDetector};
use crate::base::{BaseError, BaseSettings, Feedback, StopCause};
use crate::geometry::Twist;
use crate::robot::Mixer;

/// Longest ramp of one step, seconds: speeds must not jump after a pause of the caller.
const MAX_STEP_S: f64 = 0.1;

/// Time after a release in which the base may still report its stop, seconds: the command has to arrive, and the next report
/// to return.
const RELEASE_GRACE_S: f64 = 0.5;

/// What goes to the base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OutgoingCommand {
    /// A motion, ramped and within the tracks' limits.
    Drive(Twist),
    /// The latched stop.
    EngageStop,
    /// The end of the latched stop, sent once.
    ReleaseStop,
}

/// Why a target or a release was rejected.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum CommandRejected {
    /// A motion or a time stamp that is NaN or infinite.
    #[error("the target is not finite")]
    NotFinite,
    /// The time stamp is older than that of the previous target.
    #[error("the target is {by_s:.3} s older than the previous one")]
    OutOfOrder {
        /// Difference of the time stamps, seconds.
        by_s: f64,
    },
    /// The time stamp is farther ahead than a target lasts: such a target would never expire.
    #[error("the target is {ahead_s:.3} s ahead of the clock")]
    TooFarAhead {
        /// Time stamp minus now, seconds.
        ahead_s: f64,
    },
    /// A stop is latched.
    #[error("a stop is latched: release it first")]
    Stopped,
    /// The base still moves.
    #[error("the base still moves: a stop is released at a standstill")]
    StillMoving,
}

/// What the base is commanded to do, and why.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum DriveStatus {
    /// Stands: no target was set.
    #[default]
    NoTarget,
    /// Follows the target.
    Driving,
    /// Brakes and stands: the target has expired.
    TargetExpired {
        /// Age of the target, seconds.
        age_s: f64,
    },
    /// Stands: the base has not reported since the connection was opened.
    AwaitingFeedback,
    /// Gets no command: there is no connection.
    Disconnected(BaseError),
    /// Stands until the latched stop is released.
    Stopped(StopCause),
}

/// Decides which command goes to the base. Times in seconds from one origin; a clock that runs backwards is harmless.
#[derive(Clone, Debug)]
pub struct SafetyController {
    settings: SupervisorSettings,
    base: BaseSettings,
    mixer: Mixer,
    detector: FaultDetector,
    target: Option<Target>,
    /// Time stamp of the newest target ever accepted.
    newest_stamp_s: f64,
    stop_cause: Option<StopCause>,
    release: Release,
    status: DriveStatus,
    has_feedback: bool,
    is_still: bool,
    sent: Twist,
    last_s: Option<f64>,
    rejected: u64,
}

#[derive(Clone, Copy, Debug)]
struct Target {
    twist: Twist,
    stamp_s: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Release {
    None,
    /// To be sent.
    Due,
    /// Sent at this time; the base has not yet reported the end of its stop.
    Sent(f64),
}

impl SafetyController {
    /// Creates the controller of a base that stands and has not reported.
    ///
    /// # Errors
    /// Settings out of range.
    pub fn new(base: &BaseSettings, settings: SupervisorSettings) -> Result<Self, BaseError> {
        settings.validate()?;
        Ok(Self {
            detector: FaultDetector::new(base, settings.fault_detector)?,
            settings,
            base: *base,
            mixer: Mixer::new(base.drive(), base.tracks),
            target: None,
            newest_stamp_s: f64::NEG_INFINITY,
            stop_cause: None,
            release: Release::None,
            status: DriveStatus::NoTarget,
            has_feedback: false,
            is_still: true,
            sent: Twist::STOP,
            last_s: None,
            rejected: 0,
        })
    }

    /// Replaces the target motion. The target expires [`SupervisorSettings::target_timeout_s`] after its time stamp.
    ///
    /// # Errors
    /// [`CommandRejected`]: the previous target then stays, and expires.
    pub fn set_target(
        &mut self,
        twist: &Twist,
        stamp_s: f64,
        now_s: f64,
    ) -> Result<(), CommandRejected> {
        if self.stop_cause.is_some() {
            return Err(CommandRejected::Stopped);
        }
        let checked = self.check(twist, stamp_s, now_s);
        match checked {
            Ok(()) => {
                self.newest_stamp_s = stamp_s;
                self.target = Some(Target { twist: *twist, stamp_s });
            }
            Err(_) => self.rejected += 1,
        }
        checked
    }

    fn check(&self, twist: &Twist, stamp_s: f64, now_s: f64) -> Result<(), CommandRejected> {
        if !(twist.is_finite() && stamp_s.is_finite()) {
            return Err(CommandRejected::NotFinite);
        }
        if stamp_s < self.newest_stamp_s {
            let by_s = self.newest_stamp_s - stamp_s;
            return Err(CommandRejected::OutOfOrder { by_s });
        }
        let ahead_s = stamp_s - now_s;
        if ahead_s > self.settings.target_timeout_s {
            return Err(CommandRejected::TooFarAhead { ahead_s });
        }
        Ok(())
    }

    /// Latches a stop. A stop that is latched already keeps its cause.
    pub fn stop(&mut self, cause: StopCause) {
        self.stop_cause = self.stop_cause.or(Some(cause));
        self.target = None;
        self.release = Release::None;
    }

    /// Ends a latched stop, as an operator's explicit decision. The base stands until the next target; a fault that persists is
    /// detected again.
    ///
    /// # Errors
    /// [`CommandRejected::StillMoving`] if the base reports motion.
    pub fn release(&mut self) -> Result<(), CommandRejected> {
        if self.has_feedback && !self.is_still {
            return Err(CommandRejected::StillMoving);
        }
        self.stop_cause = None;
        self.target = None;
        self.release = Release::Due;
        self.detector.release();
        Ok(())
    }

    /// Returns the command to send now. Call it at the fixed rate.
    pub fn next_command(&mut self, now_s: f64) -> OutgoingCommand {
        let elapsed_s = now_s - self.last_s.replace(now_s).unwrap_or(now_s);
        let elapsed_s = elapsed_s.clamp(0.0, MAX_STEP_S);
        if let Some(cause) = self.stop_cause {
            self.stand(DriveStatus::Stopped(cause));
            return OutgoingCommand::EngageStop;
        }
        if self.release == Release::Due && self.has_feedback {
            self.release = Release::Sent(now_s);
            self.stand(DriveStatus::NoTarget);
            return OutgoingCommand::ReleaseStop;
        }
        if !self.has_feedback {
            self.stand(DriveStatus::AwaitingFeedback);
            return OutgoingCommand::Drive(Twist::STOP);
        }
        let target = self.valid_target(now_s);
        let speeds = self.mixer.mix(&target, elapsed_s);
        self.sent = self.mixer.twist(&speeds);
        OutgoingCommand::Drive(self.sent)
    }

    /// The target motion, or zero if there is none or it has expired.
    fn valid_target(&mut self, now_s: f64) -> Twist {
        let Some(Target { twist, stamp_s }) = self.target else {
            self.status = DriveStatus::NoTarget;
            return Twist::STOP;
        };
        let age_s = now_s - stamp_s;
        // A time stamp far ahead is from before the clock ran backwards.
        if age_s.abs() > self.settings.target_timeout_s {
            self.status = DriveStatus::TargetExpired { age_s };
            return Twist::STOP;
        }
        self.status = DriveStatus::Driving;
        twist
    }

    /// Restarts the ramps from a standstill. A missing connection takes precedence over every other status.
    fn stand(&mut self, status: DriveStatus) {
        if !matches!(self.status, DriveStatus::Disconnected(_)) {
            self.status = status;
        }
        self.mixer.reset();
        self.sent = Twist::STOP;
    }

    /// Takes the base's latest report, which may be the previous one again.
    pub fn on_feedback(&mut self, feedback: &Feedback, now_s: f64) {
        self.has_feedback = true;
        let tracks = self.base.drive().tracks(&feedback.twist);
        let fastest = tracks.left.abs().max(tracks.right.abs());
        self.is_still = fastest < self.settings.fault_detector.motion_threshold_m_s;
        if self.stop_cause.is_some() {
            return;
        }
        match self.release {
            Release::Due => return,
            Release::Sent(at_s) if feedback.emergency_stop && now_s - at_s < RELEASE_GRACE_S => {
                return;
            }
            _ => self.release = Release::None,
        }
        let sample = BaseSample { now_s, sent: self.sent, feedback: *feedback };
        if let Some(cause) = self.detector.update(&sample).copied() {
            self.stop(cause);
        }
    }

    /// The connection has failed, or could not be opened.
    pub fn on_disconnect(&mut self, error: BaseError) {
        self.has_feedback = false;
        self.status = DriveStatus::NoTarget;
        self.stand(DriveStatus::Disconnected(error));
    }

    /// A connection was opened; the base has not reported on it.
    pub fn on_connect(&mut self) {
        self.has_feedback = false;
        self.status = DriveStatus::NoTarget;
        self.stand(DriveStatus::AwaitingFeedback);
    }

    /// What the last command was, and why.
    #[must_use]
    pub const fn status(&self) -> &DriveStatus {
        &self.status
    }

    /// Cause of the latched stop, if a stop is latched.
    #[must_use]
    pub const fn stop_cause(&self) -> Option<&StopCause> {
        self.stop_cause.as_ref()
    }

    /// The last motion sent.
    #[must_use]
    pub const fn sent(&self) -> &Twist {
        &self.sent
    }

    /// Number of invalid targets so far.
    #[must_use]
    pub const fn rejected(&self) -> u64 {
        self.rejected
    }
}
