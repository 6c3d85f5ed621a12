//! The thread that owns the connection to the base.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use serde::Serialize;

use super::connection::{Connection, Exchange, OpenBase};
use super::odometer::Odometer;
use super::{CommandRejected, DriveStatus, OutgoingCommand, SafetyController, SupervisorSettings};
use crate::base::{BaseError, BaseSettings, Feedback, ProtectiveLayer, StopCause};
use crate::geometry::{Pose, Twist};
use crate::map::TimedScan;

/// Event counts since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct SupervisorCounters {
    /// Commands sent.
    pub commands: u64,
    /// Invalid targets.
    pub rejected_targets: u64,
    /// Commands sent more than one period late.
    pub late_commands: u64,
    /// Failures of the connection, including failed attempts to open it.
    pub connection_failures: u64,
    /// Connections opened, including the first.
    pub connections: u64,
}

/// Returns a revolution of a lidar with times by a clock whose present time is given, seconds; none if there is no new one.
pub type ScanSource = Box<dyn FnMut(f64) -> Option<TimedScan> + Send>;

/// Snapshot of a supervisor and its base.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SupervisorStatus {
    /// What the base is commanded to do, and why.
    pub drive_status: DriveStatus,
    /// Cause of the latched stop, if a stop is latched.
    pub stop_cause: Option<StopCause>,
    /// The last motion sent.
    pub sent: Twist,
    /// End of the last gap by [`BaseSupervisor::now_s`]: only targets with a later time stamp are followed.
    pub resumed_s: f64,
    /// The latest report since the connection was opened.
    pub feedback: Option<Feedback>,
    /// Time of that report by the supervisor's clock, seconds; none before the first one. It outlasts the connection.
    pub feedback_s: Option<f64>,
    /// Odometry pose relative to the first report, at the time of the latest one.
    pub pose: Pose,
    /// Distance travelled by odometry, forwards and backwards, metres.
    pub travelled_m: f64,
    /// Whether pose and distance lack a motion: the counters of the base jumped or were reset, or a base without encoders did not report
    /// for a time.
    pub is_odometry_uncertain: bool,
    /// Event counts.
    pub counters: SupervisorCounters,
    /// The last failure of the connection, if there was one.
    pub last_failure: Option<BaseError>,
    /// Whether targets are still followed; false after the shutdown flag was set.
    pub is_running: bool,
}

/// Number of sending threads of this process.
static SENDERS: AtomicUsize = AtomicUsize::new(0);

/// Sends the current target to a base at a fixed rate, with the guarantees of [its module](super).
///
/// Dropping it stops the base, as [`Self::end`] does.
pub struct BaseSupervisor {
    started: Instant,
    shared: Arc<Mutex<SharedState>>,
    /// Set when it is dropped. The flag of the caller is only read: it may end other things.
    is_dropped: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// State shared by the thread and its owner. Never locked during I/O.
struct SharedState {
    controller: SafetyController,
    /// The lidar of the protective layer.
    scans: Option<ScanSource>,
    odometer: Odometer,
    feedback: Option<Feedback>,
    feedback_s: Option<f64>,
    counters: SupervisorCounters,
    last_failure: Option<BaseError>,
    is_running: bool,
}

impl BaseSupervisor {
    /// Opens the connection and starts sending. The base stands until the first target. The supervisor ends when it is dropped
    /// or when `shutdown` is set, for example by a signal handler.
    ///
    /// # Errors
    /// Settings out of range, and errors of the first `open`.
    pub fn start(
        open: OpenBase,
        base: &BaseSettings,
        settings: SupervisorSettings,
        shutdown: Arc<AtomicBool>,
    ) -> Result<Self, BaseError> {
        let shared = Arc::new(Mutex::new(SharedState {
            controller: SafetyController::new(base, settings)?,
            scans: None,
            odometer: Odometer::new(base),
            feedback: None,
            feedback_s: None,
            counters: SupervisorCounters { connections: 1, ..SupervisorCounters::default() },
            last_failure: None,
            is_running: true,
        }));
        let connection = Connection::new(open, &settings)?;
        let started = Instant::now();
        let is_dropped = Arc::default();
        let send_loop = SendLoop {
            started,
            period: Duration::from_secs_f64(settings.period_s()),
            connection,
            shared: Arc::clone(&shared),
            shutdown,
            is_dropped: Arc::clone(&is_dropped),
            _sender: CountedSender::new(),
        };
        let thread = thread::Builder::new()
            .name("base supervisor".to_owned())
            .spawn(move || send_loop.run())
            .map_err(|error| BaseError::CannotOpen {
                port: "supervisor thread".to_owned(),
                reason: error.to_string(),
            })?;
        Ok(Self { started, shared, is_dropped, thread: Some(thread) })
    }

    /// The supervisor's clock, seconds since its start: the time base of [`Self::set_target`].
    #[must_use]
    pub fn now_s(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Number of bases of this process that have not got their last zero commands. A process that is asked to end waits until it is
    /// zero.
    #[must_use]
    pub fn running() -> usize {
        SENDERS.load(Ordering::SeqCst)
    }

    /// Replaces the target motion; `stamp_s` is its time stamp by [`Self::now_s`]. Does no I/O.
    ///
    /// # Errors
    /// Those of [`SafetyController::set_target`].
    pub fn set_target(&self, twist: &Twist, stamp_s: f64) -> Result<(), CommandRejected> {
        let now_s = self.now_s();
        lock(&self.shared).controller.set_target(twist, stamp_s, now_s)
    }

    /// From now on every target passes through this layer, which gets the scans of a lidar, if there is one.
    pub fn protect(&self, layer: ProtectiveLayer, scans: Option<ScanSource>) {
        let mut shared = lock(&self.shared);
        shared.scans = scans;
        shared.controller.protect(layer);
    }

    /// Latches a stop, which goes out with the next command.
    pub fn stop(&self) {
        lock(&self.shared).controller.stop(StopCause::Requested);
    }

    /// Ends a latched stop.
    ///
    /// # Errors
    /// Those of [`SafetyController::release`].
    pub fn release(&self) -> Result<(), CommandRejected> {
        lock(&self.shared).controller.release()
    }

    /// Stops the base and closes the connection: sends zero commands until the reports show a standstill for 0.3 s, for the braking
    /// time and one second at most. Returns the last status: [`SupervisorStatus::stop_cause`] tells of a base that still moves, and
    /// [`SupervisorStatus::is_running`] whether the supervisor ran until this call.
    #[must_use]
    pub fn end(mut self) -> SupervisorStatus {
        let is_running = self.status().is_running;
        self.join();
        SupervisorStatus { is_running, ..self.status() }
    }

    fn join(&mut self) {
        self.is_dropped.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has sent its zero commands while unwinding.
            let _ = thread.join();
        }
    }

    /// Returns a snapshot of the state.
    #[must_use]
    pub fn status(&self) -> SupervisorStatus {
        let shared = lock(&self.shared);
        let controller = &shared.controller;
        SupervisorStatus {
            drive_status: controller.status().clone(),
            stop_cause: controller.stop_cause().copied(),
            sent: *controller.sent(),
            resumed_s: controller.resumed_s(),
            feedback: shared.feedback,
            feedback_s: shared.feedback_s,
            pose: shared.odometer.pose(),
            travelled_m: shared.odometer.travelled_m(),
            is_odometry_uncertain: shared.odometer.is_uncertain(),
            counters: SupervisorCounters {
                rejected_targets: controller.rejected(),
                ..shared.counters
            },
            last_failure: shared.last_failure.clone(),
            is_running: shared.is_running,
        }
    }
}

impl Drop for BaseSupervisor {
    fn drop(&mut self) {
        self.join();
    }
}

/// The thread's state. Dropping it, for any reason, closes the connection.
struct SendLoop {
    started: Instant,
    period: Duration,
    connection: Connection,
    shared: Arc<Mutex<SharedState>>,
    shutdown: Arc<AtomicBool>,
    is_dropped: Arc<AtomicBool>,
    /// Dropped last: after the zero commands of the connection.
    _sender: CountedSender,
}

/// Counts a sending thread while it exists.
struct CountedSender;

impl CountedSender {
    fn new() -> Self {
        SENDERS.fetch_add(1, Ordering::SeqCst);
        Self
    }
}

impl Drop for CountedSender {
    fn drop(&mut self) {
        SENDERS.fetch_sub(1, Ordering::SeqCst);
    }
}

impl SendLoop {
    fn run(mut self) {
        let mut due = Instant::now();
        let is_set = |flag: &AtomicBool| flag.load(Ordering::Relaxed);
        loop {
            if is_set(&self.shutdown) || is_set(&self.is_dropped) {
                let now_s = self.started.elapsed().as_secs_f64();
                if lock(&self.shared).has_ended(now_s) {
                    return;
                }
            }
            self.cycle();
            due += self.period;
            let now = Instant::now();
            if due + self.period < now {
                // Missed cycles are not made up for by a burst.
                lock(&self.shared).counters.late_commands += 1;
                due = now;
            }
            thread::sleep(due.saturating_duration_since(now));
        }
    }

    fn cycle(&mut self) {
        let now_s = self.started.elapsed().as_secs_f64();
        let command = lock(&self.shared).next_command(now_s);
        let exchange = self.connection.exchange(command, now_s);
        let now_s = self.started.elapsed().as_secs_f64();
        lock(&self.shared).update(exchange, now_s);
    }
}

impl Drop for SendLoop {
    fn drop(&mut self) {
        lock(&self.shared).is_running = false;
    }
}

impl SharedState {
    fn next_command(&mut self, now_s: f64) -> OutgoingCommand {
        let scan = self.scans.as_mut().and_then(|newest| newest(now_s));
        if let Some((scan, end_s)) = scan.and_then(|scan| scan.end_s().map(|end_s| (scan, end_s))) {
            self.controller.update_scan(&scan, end_s);
        }
        self.controller.next_command(now_s)
    }

    /// Ends all motion, and tells whether the base stands, or its time for it is over.
    fn has_ended(&mut self, now_s: f64) -> bool {
        if self.is_running {
            self.is_running = false;
            self.controller.end(now_s);
        }
        self.controller.has_ended(now_s)
    }

    fn update(&mut self, exchange: Exchange, now_s: f64) {
        match exchange {
            Exchange::Done(feedback) => {
                self.counters.commands += 1;
                if let Some(feedback) = feedback {
                    self.feedback = Some(feedback);
                    self.odometer.update(&feedback, now_s);
                    self.controller.on_feedback(&feedback, now_s);
                    self.feedback_s = Some(self.controller.reported_s());
                }
            }
            Exchange::Waiting => {}
            Exchange::Opened => {
                self.counters.connections += 1;
                self.controller.on_connect();
            }
            Exchange::Lost(error) => {
                self.counters.connection_failures += 1;
                self.feedback = None;
                self.odometer.interrupt();
                self.last_failure = Some(error.clone());
                self.controller.on_disconnect(error);
            }
        }
    }
}

/// Locks the state. A thread that panicked while it held the lock left nothing half done that a stop depends on.
fn lock(shared: &Mutex<SharedState>) -> MutexGuard<'_, SharedState> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}
