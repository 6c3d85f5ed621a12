//! The safety policy of the supervisor: which command goes to the base now. No thread, no port, no clock.

use super::standstill::Standstill;
use super::{CommandRejected, DriveStatus, OutgoingCommand, SupervisorSettings};
use crate::base::encoder_speed::max_plausible_speed;
use crate::base::fault_detector::{BaseSample, FaultDetector};
use crate::base::protocol::RELEASE_GRACE_S;
use crate::base::{
    BaseError, BaseSettings, Faults, Feedback, OperatorState, ProtectiveAction, ProtectiveLayer,
    StopCause,
};
use crate::geometry::Twist;
use crate::map::TimedScan;
use crate::robot::{Mixer, TickClock, TrackSpeeds};

/// Time of zero commands after a gap, seconds: the port's buffer is read, and two reports of the slowest controller arrive.
const RESTART_S: f64 = 0.1;

/// Lag of a track behind its command, seconds. A base that follows with a greater lag brakes from its measured speed.
const LAG_S: f64 = 0.2;

/// Time beyond braking for a base to come to a standstill after the end of its commands, seconds.
const SETTLING_S: f64 = 1.0;

/// Least time between two reports of a base, seconds.
const MIN_LATER_S: f64 = 0.001;

/// Decides which command goes to the base. Times in seconds from one origin; a clock that runs backwards is harmless.
#[derive(Clone, Debug)]
pub struct SafetyController {
    settings: SupervisorSettings,
    base: BaseSettings,
    mixer: Mixer,
    detector: FaultDetector,
    /// Limits the target by raw scans; none for a base that is commanded by hand.
    protection: Option<ProtectiveLayer>,
    target: Option<Target>,
    /// Time stamp of the newest target ever accepted.
    newest_stamp_s: f64,
    stop_cause: Option<StopCause>,
    release: Release,
    status: DriveStatus,
    has_feedback: bool,
    /// The newest report.
    report: Report,
    standstill: Standstill,
    /// Time by which the base must stand, once [`Self::end`] was called.
    stands_by_s: Option<f64>,
    sent: Twist,
    tick_clock: TickClock,
    /// End of the last gap. Only later targets are followed.
    resumed_s: f64,
    /// Whether the base stands since that gap.
    is_restarting: bool,
    rejected: u64,
}

/// What the base has reported.
#[derive(Clone, Copy, Debug)]
struct Report {
    /// Measured speeds of the tracks.
    tracks: TrackSpeeds,
    /// Age when it was read, seconds.
    age_s: f64,
    /// Its time, seconds.
    stamp_s: f64,
    /// Whether the base has stopped by itself.
    has_stopped_itself: bool,
}

impl Default for Report {
    fn default() -> Self {
        Self {
            tracks: TrackSpeeds::default(),
            age_s: 0.0,
            stamp_s: f64::NEG_INFINITY,
            has_stopped_itself: false,
        }
    }
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
            protection: None,
            target: None,
            newest_stamp_s: f64::NEG_INFINITY,
            stop_cause: None,
            release: Release::None,
            status: DriveStatus::NoTarget,
            has_feedback: false,
            report: Report::default(),
            standstill: Standstill::new(),
            stands_by_s: None,
            sent: Twist::STOP,
            tick_clock: TickClock::new(settings.period_s()),
            resumed_s: f64::NEG_INFINITY,
            is_restarting: true,
            rejected: 0,
        })
    }

    /// From now on every target passes through this layer, armed or not. The layer takes over the ramp of the tracks.
    pub fn protect(&mut self, layer: ProtectiveLayer) {
        self.protection = Some(layer.with_tracks(self.base.drive(), self.base.tracks));
    }

    /// Hands a raw scan to the protective layer, with the time of its last beam.
    pub fn update_scan(&mut self, scan: &TimedScan, stamp_s: f64) {
        if let Some(layer) = &mut self.protection {
            layer.update_scan(scan, stamp_s);
        }
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

    /// Ends a latched stop, as an operator's explicit decision. The base gets the release once its reports show a standstill. It
    /// stands until the next target; a fault that persists is detected again.
    ///
    /// # Errors
    /// [`CommandRejected::StillMoving`] if the base reports motion.
    pub fn release(&mut self) -> Result<(), CommandRejected> {
        if self.has_feedback && !self.standstill.is_still() {
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
        let tick = self.tick_clock.tick(now_s);
        let max_gap_s = self.settings.max_gap_s + self.settings.period_s();
        // A process that was stopped, or a clock that jumped: the base may have stopped by itself, and its surroundings changed.
        let was_paused = !(0.0..=max_gap_s).contains(&tick.elapsed_s());
        if let Some(cause) = self.stop_cause {
            self.interrupt(now_s, DriveStatus::Stopped(cause));
            return OutgoingCommand::EngageStop;
        }
        if self.release == Release::Due && self.has_feedback {
            if !self.standstill.is_still() {
                // It was released while it could not report, or has begun to move since.
                self.interrupt(now_s, DriveStatus::Restarting);
                return OutgoingCommand::EngageStop;
            }
            self.release = Release::Sent(now_s);
            self.interrupt(now_s, DriveStatus::NoTarget);
            return OutgoingCommand::ReleaseStop;
        }
        if !self.has_feedback {
            self.interrupt(now_s, DriveStatus::AwaitingFeedback);
            return OutgoingCommand::Drive(Twist::STOP);
        }
        if self.stands_by_s.is_some() {
            self.interrupt(now_s, DriveStatus::NoTarget);
            return OutgoingCommand::Drive(Twist::STOP);
        }
        if let Some(action) = self.forbidden(now_s) {
            self.interrupt(now_s, DriveStatus::Protected(action));
            return OutgoingCommand::Drive(Twist::STOP);
        }
        if was_paused || self.report.has_stopped_itself {
            self.interrupt(now_s, DriveStatus::Restarting);
            return OutgoingCommand::Drive(Twist::STOP);
        }
        let target = if self.report.age_s > max_gap_s {
            self.status = DriveStatus::ReportsLate { age_s: self.report.age_s };
            (self.resumed_s, self.is_restarting) = (now_s, true);
            None
        } else {
            let target = self.valid_target(now_s);
            if self.is_restarting {
                let is_settled = now_s - self.resumed_s >= RESTART_S;
                if let (Some(target), true) = (target, is_settled) {
                    self.mixer.restart(&self.report.tracks, &target);
                    self.is_restarting = false;
                } else {
                    if target.is_some() {
                        self.status = DriveStatus::Restarting;
                    }
                    self.halt();
                    return OutgoingCommand::Drive(Twist::STOP);
                }
            }
            target
        };
        let target = target.map(|target| self.protected(&target, now_s));
        if target.is_none_or(|target| target == Twist::STOP) {
            let allowance = LAG_S * self.base.tracks.acc_lim_track;
            self.mixer.limit_to(&self.report.tracks, allowance);
        }
        let speeds = self.mixer.mix(&target.unwrap_or_default(), tick);
        self.sent = self.mixer.twist(&speeds);
        if self.sent != Twist::STOP {
            // The earlier reports are of a base that had no reason to move.
            self.standstill.forget(self.report.stamp_s);
        }
        OutgoingCommand::Drive(self.sent)
    }

    /// The target as the protective layer permits it.
    fn protected(&mut self, target: &Twist, now_s: f64) -> Twist {
        let Some(layer) = &mut self.protection else {
            return *target;
        };
        let (limited, action) = layer.limit(target, &self.sent, now_s);
        if !action.passes() {
            self.status = DriveStatus::Protected(action);
        }
        limited
    }

    /// The action of the operator's switch, if it forbids motion, with or without a target. Zero goes out at once, without a ramp.
    fn forbidden(&mut self, now_s: f64) -> Option<ProtectiveAction> {
        let layer = self.protection.as_mut()?;
        if layer.operator().state() == OperatorState::Armed {
            return None;
        }
        let (_, action) = layer.limit(&Twist::STOP, &self.sent, now_s);
        Some(action)
    }

    /// The target motion; none if there is none, or it has expired, or it is older than the end of the last gap.
    fn valid_target(&mut self, now_s: f64) -> Option<Twist> {
        let Some(Target { twist, stamp_s }) = self.target else {
            self.status = DriveStatus::NoTarget;
            return None;
        };
        let age_s = now_s - stamp_s;
        // A time stamp far ahead is from before the clock ran backwards.
        if age_s.abs() > self.settings.target_timeout_s {
            self.status = DriveStatus::TargetExpired { age_s };
            return None;
        }
        if stamp_s < self.resumed_s {
            self.status = DriveStatus::Restarting;
            return None;
        }
        self.status = DriveStatus::Driving;
        Some(twist)
    }

    /// Begins or continues a gap: the base stands, and only targets from now on count.
    fn interrupt(&mut self, now_s: f64, status: DriveStatus) {
        self.resumed_s = now_s;
        self.stand(status);
    }

    /// Stands. A missing connection takes precedence over every other status.
    fn stand(&mut self, status: DriveStatus) {
        if !matches!(self.status, DriveStatus::Disconnected(_)) {
            self.status = status;
        }
        self.halt();
    }

    /// Commands zero; the next motion restarts.
    fn halt(&mut self) {
        self.is_restarting = true;
        self.mixer.reset();
        self.sent = Twist::STOP;
    }

    /// Takes the base's latest report, which may be the previous one again.
    pub fn on_feedback(&mut self, feedback: &Feedback, now_s: f64) {
        self.has_feedback = true;
        self.report.tracks = self.base.drive().tracks(&feedback.twist);
        self.report.age_s = feedback.age_s;
        self.report.has_stopped_itself =
            feedback.is_stop_suspected || feedback.faults.contains(Faults::WATCHDOG);
        let stamp_s = now_s - feedback.age_s;
        let later_s = stamp_s - self.report.stamp_s;
        // A report comes again in each cycle until there is a new one, and its time is then the same only to some microseconds.
        if later_s > MIN_LATER_S || later_s < -self.settings.max_gap_s {
            self.report.stamp_s = stamp_s;
            if let Some(layer) = &mut self.protection {
                layer.update_motion(&feedback.twist, stamp_s);
            }
        }
        let least = self.settings.fault_detector.motion_threshold_m_s;
        let turn_rate = feedback.yaw_rate.unwrap_or(feedback.twist.angular);
        self.standstill.update((self.fastest(), least), turn_rate, self.report.stamp_s);
        if self.stop_cause.is_some() || self.stands_by_s.is_some() {
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

    /// Reported speed of the faster track, m/s. One that is not finite counts as the highest.
    fn fastest(&self) -> f64 {
        let TrackSpeeds { left, right } = self.report.tracks;
        if left.is_finite() && right.is_finite() {
            left.abs().max(right.abs())
        } else {
            self.base.tracks.max_track_speed
        }
    }

    /// Ends all motion for good: from now on only stops go out. [`Self::has_ended`] tells how long to send them.
    pub fn end(&mut self, now_s: f64) {
        self.release = Release::None;
        let fastest = self.fastest().min(max_plausible_speed(&self.base));
        let braking_s = fastest / -self.base.tracks.decel_lim_track;
        self.stands_by_s = Some(now_s + braking_s + SETTLING_S);
        if self.has_feedback {
            // A base that follows late may still begin to move.
            self.standstill.forget(self.report.stamp_s);
        }
    }

    /// Whether the base stands after [`Self::end`], or should have stood for a second: if its reports then still show motion, it ignores its
    /// commands. A stop is latched for that cause, unless a fault is known already.
    pub fn has_ended(&mut self, now_s: f64) -> bool {
        let is_over = self.stands_by_s.is_some_and(|latest_s| now_s >= latest_s);
        let is_unexplained = matches!(self.stop_cause, None | Some(StopCause::Requested));
        if is_over && self.has_feedback && self.standstill.moves() && is_unexplained {
            let measured = self.base.drive().twist(&self.report.tracks);
            let Twist { linear, angular } = Twist::STOP;
            self.stop_cause = Some(if measured.is_finite() {
                StopCause::IgnoresCommands { linear, angular, measured }
            } else {
                StopCause::NotFinite
            });
        }
        is_over || self.stands_by_s.is_some() && self.standstill.is_still()
    }

    /// The connection has failed, or could not be opened.
    pub fn on_disconnect(&mut self, error: BaseError) {
        self.forget_reports();
        self.status = DriveStatus::NoTarget;
        self.stand(DriveStatus::Disconnected(error));
    }

    /// A connection was opened; the base has not reported on it.
    pub fn on_connect(&mut self) {
        self.forget_reports();
        self.status = DriveStatus::NoTarget;
        self.stand(DriveStatus::AwaitingFeedback);
    }

    /// Forgets the earlier reports: the base may have been pushed meanwhile.
    const fn forget_reports(&mut self) {
        self.has_feedback = false;
        self.standstill.forget(self.report.stamp_s);
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

    /// End of the last gap, seconds: only targets with a later time stamp are followed.
    #[must_use]
    pub const fn resumed_s(&self) -> f64 {
        self.resumed_s
    }

    /// Time of the newest report, seconds; minus infinity before the first one. It stays while that report comes again.
    #[must_use]
    pub const fn reported_s(&self) -> f64 {
        self.report.stamp_s
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
