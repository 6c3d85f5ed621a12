//! A real robot: a tracked base on a serial line and, if there is one, an LD19 lidar.

use core::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use thiserror::Error;

use super::{LidarData, OdometryReading, Robot, SensorData};
use crate::base::ld19::{LidarReader, LidarSettings, LidarStatus, OpenLidar};
use crate::base::{
    BaseConfig, BaseError, BaseSettings, BaseSupervisor, DriveStatus, OpenBase, ProtectiveAction,
    ProtectiveLayer, Protocol, ScanSource, StopCause, SupervisorStatus,
};
use crate::geometry::{Pose, Twist};
use crate::map::TimedScan;
use crate::robot::Limits;

/// Longest time from opening the base's port to its first report, seconds.
const FIRST_REPORT_S: f64 = 3.0;

/// What a silent `RoboClaw` may need.
const STATUS_HINT: &str =
    " A RoboClaw whose status has two bytes needs status_bytes = 2 in [base.roboclaw]";

/// Longest time from opening the lidar's port to its first whole revolution, seconds: its motor has to reach its speed.
const FIRST_REVOLUTION_S: f64 = 5.0;

/// Longest silence of the base during a mission, seconds.
const LONGEST_SILENCE_S: f64 = 10.0;

/// Time between two checks of a device that starts.
const POLL: Duration = Duration::from_millis(20);

/// Why a device cannot be used.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum HardwareError {
    /// The port cannot be opened, or a setting is out of range.
    #[error(transparent)]
    Base(#[from] BaseError),
    /// The base does not report.
    #[error(
        "{port}: no answer within {FIRST_REPORT_S} s: is the base switched on, and does it speak the protocol {protocol}?{}",
        if *.protocol == Protocol::Roboclaw { STATUS_HINT } else { "" }
    )]
    NoReport {
        /// Name of the port.
        port: String,
        /// The protocol.
        protocol: Protocol,
    },
    /// The lidar completes no revolution.
    #[error("{port}: no revolution within {FIRST_REVOLUTION_S} s: {reason}")]
    NoRevolution {
        /// Name of the port.
        port: String,
        /// The report of the lidar's reader.
        reason: String,
    },
    /// The flag that ends the program was set before the device answered.
    #[error("{port}: stopped by a signal before the device answered")]
    Interrupted {
        /// Name of the port.
        port: String,
    },
}

/// A base on a serial port.
#[derive(Clone, Debug, PartialEq)]
pub struct SerialLine {
    /// Name of the port.
    pub port: String,
    /// The protocol of the base.
    pub protocol: Protocol,
    /// The settings of the base and of its supervisor.
    pub config: BaseConfig,
}

impl SerialLine {
    /// Creates the description of a base with the default settings.
    #[must_use]
    pub fn new(port: &str, protocol: Protocol) -> Self {
        Self { port: port.to_owned(), protocol, config: BaseConfig::default() }
    }

    /// The largest speed of the tracks, m/s, if the base has no watchdog.
    #[must_use]
    pub fn speed_cap_m_s(&self) -> Option<f64> {
        let base = &self.config.base;
        let has_watchdog = self.protocol.has_watchdog() || base.has_watchdog;
        (!has_watchdog).then_some(base.max_speed_without_watchdog_m_s)
    }

    /// Warns of a base without a watchdog, in one line.
    #[must_use]
    pub fn warning(&self) -> Option<String> {
        let cap = self.speed_cap_m_s()?;
        Some(format!(
            "{} firmware has no watchdog: the base drives on if this program is killed, so it drives at most {cap} m/s; set has_watchdog = true in [base] if yours has one",
            self.protocol
        ))
    }

    /// The settings of the base, with tracks as fast as it may drive.
    #[must_use]
    pub fn base(&self) -> BaseSettings {
        let mut base = self.config.base;
        if let Some(cap) = self.speed_cap_m_s() {
            base.tracks.max_track_speed = base.tracks.max_track_speed.min(cap);
        }
        base
    }

    /// Lowers a robot's limits to the speed that a base without a watchdog may drive.
    pub fn cap_speed(&self, limits: &mut Limits) {
        if let Some(cap) = self.speed_cap_m_s() {
            limits.max_vel_x = limits.max_vel_x.min(cap);
            limits.min_vel_x = limits.min_vel_x.clamp(-cap, cap);
        }
    }

    /// Opens the port and starts the supervisor. The base stands until a target is set. It stops again when the flag is set,
    /// for example by a signal handler.
    ///
    /// # Errors
    /// [`HardwareError::Base`].
    pub fn supervise(&self, end: Arc<AtomicBool>) -> Result<BaseSupervisor, HardwareError> {
        let supervisor = self.config.supervisor;
        Ok(BaseSupervisor::start(self.opener(), &self.base(), supervisor, end)?)
    }

    /// Waits for the first report of the base.
    ///
    /// # Errors
    /// [`HardwareError::NoReport`], and [`HardwareError::Interrupted`] at the end of the supervisor.
    pub fn await_report(&self, supervisor: &BaseSupervisor) -> Result<(), HardwareError> {
        loop {
            let status = supervisor.status();
            if !status.is_running {
                return Err(HardwareError::Interrupted { port: self.port.clone() });
            }
            if status.feedback.is_some() {
                return Ok(());
            }
            if supervisor.now_s() > FIRST_REPORT_S {
                return Err(HardwareError::NoReport {
                    port: self.port.clone(),
                    protocol: self.protocol,
                });
            }
            thread::sleep(POLL);
        }
    }

    /// Starts the supervisor as [`Self::supervise`], and waits for the base as [`Self::await_report`].
    ///
    /// # Errors
    /// Those of both.
    pub fn connect(&self, end: Arc<AtomicBool>) -> Result<BaseSupervisor, HardwareError> {
        let supervisor = self.supervise(end)?;
        self.await_report(&supervisor)?;
        Ok(supervisor)
    }

    #[cfg(feature = "serial")]
    fn opener(&self) -> OpenBase {
        use crate::base::{SamePort, SerialBase, SerialSettings};
        let Self { port, protocol, config } = self.clone();
        // One exchange must fit into the period of the commands.
        let settings = SerialSettings {
            request_timeout: Duration::from_millis(10),
            ..SerialSettings::default()
        };
        let mut port = SamePort::new(port);
        Box::new(move || {
            let session = protocol.session(config.base)?;
            Ok(Box::new(port.open(|name| SerialBase::open(name, session, settings))?))
        })
    }

    #[cfg(not(feature = "serial"))]
    fn opener(&self) -> OpenBase {
        let port = self.port.clone();
        Box::new(move || Err(without_serial(&port)))
    }
}

/// Opens the port of an LD19 and waits for its first whole revolution, unless the flag is set, for example by a signal handler.
///
/// # Errors
/// [`HardwareError::Base`], [`HardwareError::NoRevolution`] and [`HardwareError::Interrupted`].
pub fn connect_lidar(
    port: &str,
    settings: LidarSettings,
    end: &AtomicBool,
) -> Result<LidarReader, HardwareError> {
    let reader = LidarReader::start(lidar_opener(port.to_owned()), settings)?;
    loop {
        let status = reader.status();
        if status.scan.is_some() {
            return Ok(reader);
        }
        if end.load(Ordering::Relaxed) {
            return Err(HardwareError::Interrupted { port: port.to_owned() });
        }
        if reader.now_s() > FIRST_REVOLUTION_S {
            let reason = status.fault.map(|why| why.to_string());
            return Err(HardwareError::NoRevolution {
                port: port.to_owned(),
                reason: reason.unwrap_or_default(),
            });
        }
        thread::sleep(POLL);
    }
}

#[cfg(feature = "serial")]
fn lidar_opener(port: String) -> OpenLidar {
    let mut port = crate::base::SamePort::new(port);
    Box::new(move || port.open(crate::base::open_lidar_port))
}

#[cfg(not(feature = "serial"))]
fn lidar_opener(port: String) -> OpenLidar {
    Box::new(move || Err(without_serial(&port)))
}

#[cfg(not(feature = "serial"))]
fn without_serial(port: &str) -> BaseError {
    BaseError::CannotOpen {
        port: port.to_owned(),
        reason: "this program was built without its feature `serial`".to_owned(),
    }
}

/// A supervised base and its lidar, driven in real time.
///
/// Its pose is dead reckoning from the mission's start. With a lidar, set [`Config::pose_source`](super::Config) to scans.
pub struct HardwareRobot {
    base: BaseSupervisor,
    lidar: Option<Lidar>,
    start: Pose,
    /// The odometer's pose at the first command; none before.
    origin: Option<Pose>,
    /// Time of the last observation by the clock of the base.
    observed_s: f64,
    /// Time of the next tick by the clock of the base.
    due_s: f64,
    last_report_s: f64,
    /// Time of the last report by the clock of the base, and by that of the mission.
    odometry_s: [f64; 2],
}

crate::settings::opaque_debug!(HardwareRobot);

struct Lidar {
    reader: Arc<LidarReader>,
    /// The newest revolution by the clock of the mission, and its number.
    newest: (u64, TimedScan),
    /// Time of the first beam of that revolution by the clock of the base; none before the first revolution.
    began_s: Option<f64>,
}

impl HardwareRobot {
    /// Creates a robot that stands at a pose of the map.
    ///
    /// Every command passes the protective layer, which gets the raw scans of the lidar on the thread that sends. Nothing moves
    /// before the layer is armed. Without a lidar only its switch acts.
    #[must_use]
    pub fn new(
        base: BaseSupervisor,
        lidar: Option<LidarReader>,
        layer: ProtectiveLayer,
        start: Pose,
    ) -> Self {
        let reader = lidar.map(Arc::new);
        match &reader {
            Some(reader) => base.protect(layer, Some(newest_revolution(reader))),
            None => base.protect(layer.without_lidar(), None),
        }
        let newest = (0, TimedScan::default());
        Self {
            base,
            lidar: reader.map(|reader| Lidar { reader, newest, began_s: None }),
            start,
            origin: None,
            observed_s: 0.0,
            due_s: 0.0,
            last_report_s: 0.0,
            odometry_s: [f64::NAN; 2],
        }
    }

    /// The base's status.
    #[must_use]
    pub fn base_status(&self) -> SupervisorStatus {
        self.base.status()
    }

    /// Stops the base, as [`BaseSupervisor::end`], and returns its last status.
    #[must_use]
    pub fn end(self) -> SupervisorStatus {
        self.base.end()
    }

    /// The lidar's status; none without a lidar.
    #[must_use]
    pub fn lidar_status(&self) -> Option<LidarStatus> {
        self.lidar.as_ref().map(|lidar| lidar.reader.status())
    }

    /// The base's pose in the map by dead reckoning.
    fn pose(&self, status: &SupervisorStatus) -> Pose {
        self.origin.map_or(self.start, |origin| {
            self.start.transform_pose(&origin.inverse_transform_pose(&status.pose))
        })
    }
}

/// The revolutions of a lidar for the protective layer, each once, by the clock of the base.
fn newest_revolution(reader: &Arc<LidarReader>) -> ScanSource {
    let reader = Arc::clone(reader);
    let mut revolutions = 0;
    Box::new(move |now_s: f64| {
        let status = reader.status();
        if status.revolutions == revolutions {
            return None;
        }
        revolutions = status.revolutions;
        let mut sweep = TimedScan::clone(status.scan.as_ref()?);
        let ahead_s = now_s - reader.now_s();
        sweep.beams.iter_mut().for_each(|beam| beam.time_s += ahead_s);
        Some(sweep)
    })
}

impl Lidar {
    /// Returns the newest revolution by a clock whose present time is given, seconds. Its times are set once, when it is new.
    /// `base_now_s` is the present time by the clock of the base.
    fn newest(&mut self, now_s: f64, base_now_s: f64) -> TimedScan {
        let status = self.reader.status();
        let reader_now_s = self.reader.now_s();
        let ahead_s = now_s - reader_now_s;
        if let Some(sweep) = status.scan.filter(|_| status.revolutions != self.newest.0) {
            let mut sweep = TimedScan::clone(&sweep);
            let first = sweep.beams.first();
            self.began_s = first.map(|beam| beam.time_s + base_now_s - reader_now_s);
            for beam in &mut sweep.beams {
                beam.time_s += ahead_s;
            }
            self.newest = (status.revolutions, sweep);
        }
        self.newest.1.clone()
    }
}

impl Robot for HardwareRobot {
    fn sense(&mut self, time_s: f64) -> SensorData {
        let now_s = self.base.now_s();
        self.observed_s = now_s;
        let status = self.base.status();
        let twist = status.feedback.map_or(Twist::STOP, |report| report.twist);
        let pose = self.pose(&status);
        let now_s = self.base.now_s();
        let feedback_s = status.feedback_s.unwrap_or(0.0);
        if self.odometry_s[0] != feedback_s {
            // Once for each report: the two clocks are read at slightly different times, and the time must not go back.
            self.odometry_s = [feedback_s, time_s - (now_s - feedback_s)];
        }
        let lidar = self.lidar.as_mut();
        SensorData {
            odometry: OdometryReading { pose, twist },
            odometry_s: self.odometry_s[1],
            lidar: lidar.map(|lidar| LidarData::TimedScan(lidar.newest(time_s, now_s))),
            pose: None,
            pose_s: None,
            sent: Some(status.sent),
        }
    }

    fn now_s(&self) -> Option<f64> {
        Some(self.base.now_s())
    }

    /// Sets the command with the time of its observation, and waits until the next tick is due. After a gap of the base's
    /// commands or reports it sets none until the lidar has completed a new revolution. Breaks when a stop is latched, when
    /// the supervisor ends, or when the base is silent for 10 s.
    fn drive(&mut self, command: &Twist, period_s: f64) -> ControlFlow<()> {
        let now_s = self.base.now_s();
        if self.origin.is_none() {
            self.origin = Some(self.base.status().pose);
            (self.due_s, self.last_report_s) = (now_s, now_s);
        }
        let resumed_s = self.base.status().resumed_s;
        let began_s = self.lidar.as_ref().and_then(|lidar| lidar.began_s);
        if began_s.is_none_or(|began_s| began_s >= resumed_s) {
            // A rejected command means a latched stop, which breaks below.
            let _ = self.base.set_target(command, self.observed_s);
        }
        self.due_s += period_s;
        if self.due_s + period_s < now_s {
            // Missed ticks are skipped.
            self.due_s = now_s;
        }
        thread::sleep(Duration::from_secs_f64((self.due_s - now_s).max(0.0)));
        let (status, now_s) = (self.base.status(), self.base.now_s());
        if status.feedback.is_some() {
            self.last_report_s = now_s;
        }
        let is_silent = now_s - self.last_report_s >= LONGEST_SILENCE_S;
        if status.stop_cause.is_some() || !status.is_running || is_silent {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }

    fn protective_action(&self) -> ProtectiveAction {
        match self.base.status().drive_status {
            DriveStatus::Protected(action) => action,
            _ => ProtectiveAction::Pass,
        }
    }

    fn fault(&self) -> Option<String> {
        let status = self.base.status();
        let reported = || {
            let faults = status.feedback.as_ref()?.faults;
            (!faults.is_empty()).then(|| StopCause::Fault(faults).to_string())
        };
        stop_cause(&status).or_else(reported)
    }
}

/// Describes why a base does not execute commands: a latched stop, a lost line, or silence.
#[must_use]
pub fn stop_cause(status: &SupervisorStatus) -> Option<String> {
    match (&status.stop_cause, &status.drive_status) {
        (Some(reason), _) => Some(reason.to_string()),
        (None, DriveStatus::Disconnected(why)) => Some(why.to_string()),
        (None, DriveStatus::AwaitingFeedback) if status.feedback.is_none() => {
            Some("the base does not answer".to_owned())
        }
        _ => None,
    }
}
