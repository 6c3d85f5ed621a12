//! A mission, the events of its ticks and their faults, and its result.

use super::{
    Config, Contact, Encounters, MissionEnd, MissionRun, OdometryReading, Robot, Trace, TraceRow,
    ZoneCompliance,
};
use crate::base::ProtectiveAction;
use crate::geometry::{Pose, wrap_angle};
use crate::global::Plan;
use crate::local::{Engine, GpuFailureKind, Incidents, Sampling, TrajectoryFan};
use crate::localization::{LocalizationError, MapChanges, PoseEstimate};
use crate::map::{OccupancyGrid, UnknownPolicy, Zones};
use crate::navigator::{
    Controller, DeadlineStats, Decision, Fault, Goal, Mode, ModeTicks, NavigationMap, Navigator,
    Observation, ObservationFault,
};
use crate::robot::MotionEstimate;
use crate::settings::{SettingError, require};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A start, stops and a goal on a map.
#[derive(Clone, Debug)]
pub struct Mission {
    /// The map that the robot has.
    pub map: Arc<OccupancyGrid>,
    /// Zones on the cells of the map in which the robot must not drive, or only slowly.
    pub zones: Option<Arc<Zones>>,
    /// Pose at the start, where the robot stands still.
    pub start: Pose,
    /// Whether the robot's start pose is unknown to it. Its scans then give the pose, and `start` only serves the first plan.
    pub is_start_unknown: bool,
    /// Stops before the goal, in order.
    pub via: Vec<Goal>,
    /// The last stop.
    pub goal: Goal,
    /// Longest time of the mission, seconds; of real time for a robot with a clock. The time in which the robot waits for its operator
    /// does not count.
    pub time_limit_s: f64,
    /// Distance to the goal, metres, at which it counts as reached even while the robot moves, as in the rules of some
    /// benchmarks. None: the robot has to stand at its goal.
    pub done_within_m: Option<f64>,
    /// Ends the mission at the next tick once it is set, as a handler of Ctrl-C does.
    pub interrupt: Option<Arc<AtomicBool>>,
}

impl Mission {
    /// Creates a mission of at most an hour without stops before the goal.
    #[must_use]
    pub const fn new(map: Arc<OccupancyGrid>, start: Pose, goal: Goal) -> Self {
        Self {
            map,
            zones: None,
            start,
            is_start_unknown: false,
            via: Vec::new(),
            goal,
            time_limit_s: 3600.0,
            done_within_m: None,
            interrupt: None,
        }
    }

    /// Checks every number but the positions of the stops: the planner rejects those that are not on the map.
    ///
    /// # Errors
    /// Names the first number out of range.
    pub fn validate(&self) -> Result<(), SettingError> {
        let Pose { x, y, yaw } = self.start;
        for (name, value) in
            [("x of the start", x), ("y of the start", y), ("yaw of the start", yaw)]
        {
            require(value.is_finite(), name, value, "finite")?;
        }
        self.stops().iter().try_for_each(Goal::check_yaw)?;
        let limit_s = self.time_limit_s;
        require(limit_s >= 0.0, "time_limit_s", limit_s, "at least zero")?;
        let within_m = self.done_within_m.unwrap_or_default();
        let is_valid = within_m.is_finite() && within_m >= 0.0;
        require(is_valid, "done_within_m", within_m, "finite and at least zero")
    }

    /// The map for the navigator.
    #[must_use]
    pub fn navigation_map(&self, unknown: UnknownPolicy) -> NavigationMap {
        NavigationMap { obstacles: self.map.obstacles(unknown), zones: self.zones.clone() }
    }

    /// Whether the mission is to end now.
    pub(super) fn is_interrupted(&self) -> bool {
        self.interrupt.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed))
    }

    /// Number of ticks of this period, seconds, until the time limit.
    pub(crate) fn ticks(&self, period_s: f64) -> u64 {
        (self.time_limit_s / period_s).ceil() as u64
    }

    /// Whether a robot at this pose is done by [`Self::done_within_m`].
    pub(crate) fn is_done(&self, pose: &Pose) -> bool {
        let away_m = (pose.position() - self.goal.position).norm();
        self.done_within_m.is_some_and(|within_m| away_m <= within_m)
    }

    /// All stops in order, the goal last.
    #[must_use]
    pub fn stops(&self) -> Vec<Goal> {
        self.via.iter().chain([&self.goal]).copied().collect()
    }
}

/// What ends a mission early.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum EarlyEnd {
    /// [`Mission::interrupt`] was set.
    Interrupted,
    /// The robot's base does not execute commands.
    RobotStopped,
    /// The recording that is replayed ends before the drive did.
    RecordingTruncated,
}

impl EarlyEnd {
    const fn text(self) -> &'static str {
        match self {
            Self::Interrupted => "the drive was interrupted",
            Self::RobotStopped => "the base does not execute commands",
            Self::RecordingTruncated => "the recording is truncated: it ends before the drive did",
        }
    }
}

/// How a mission ended.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct MissionResult {
    /// Every tick.
    pub trace: Trace,
    /// Every global plan, in order.
    pub plans: Vec<Plan>,
    /// Whether the robot stood at its goal in the end.
    pub reached: bool,
    /// Whether the robot touched anything.
    pub collided: bool,
    /// The contact, in a simulated world.
    pub contact: Option<Contact>,
    /// Time of the mission, seconds.
    pub time_s: f64,
    /// Number of ticks that came over a control period late: [`TickTime::is_late`](crate::robot::TickTime::is_late).
    pub late_ticks: u64,
    /// Distance travelled, metres.
    pub travelled_m: f64,
    /// Smallest gap to anything solid, metres; infinite without one, as of a robot that stayed lost.
    pub min_clearance_m: f64,
    /// How the robot kept the zones, if there are any.
    pub zones: Option<ZoneCompliance>,
    /// The people that the robot met, where their positions are known.
    pub encounters: Encounters,
    /// Final position minus the goal's, along x and y.
    pub final_error_m: (f64, f64),
    /// Final yaw minus the goal's, radians, for a goal with a yaw.
    pub final_yaw_error: Option<f64>,
    /// Pose error at each stop before the goal where the robot stood.
    pub stop_errors: Vec<StopError>,
    /// Time of each decision by the observer's clock, seconds, one for each tick.
    pub decision_s: Vec<f64>,
    /// Why the navigator gave up, if it did.
    pub fault: Option<Fault>,
    /// What ended the mission before the navigator did, other than its time limit and contact.
    pub early_end: Option<EarlyEnd>,
    /// The fault of the robot at the end, as a sentence.
    pub robot_fault: Option<String>,
    /// Name of the engine at the start, or of the controller that decided in place of inbye's behaviours.
    pub engine: String,
    /// Observations that the navigator rejected, counted by cause.
    pub observation_faults: BTreeMap<ObservationFault, u64>,
    /// Ticks in which the protective layer changed the command, counted by the name of its action.
    pub protective_actions: BTreeMap<&'static str, u64>,
    /// Action of the protective layer in the last tick.
    pub last_action: ProtectiveAction,
    /// Why the controller of a caller gave no velocity in the end, if it did not.
    pub no_control: Option<String>,
    /// GPU failures; none for an engine without a CPU fallback.
    pub incidents: Option<Incidents>,
    /// Deadline statistics; none without a deadline.
    pub deadline_stats: Option<DeadlineStats>,
    /// What the drive has shown of the base's response: latency, acceleration, braking, speed and turn ratios.
    pub motion: MotionEstimate,
    /// Learned scale of odometry's distances and turns, for a pose from scans; below one for slipping tracks.
    pub odometry_scale: Option<(f64, f64)>,
    /// What the scans contradicted in the map for minutes, for a pose from scans.
    pub map_changes: Option<MapChanges>,
}

impl MissionResult {
    /// The result as far as rows, paths and navigator give it: without contact, stops, and the data that only the robot has.
    pub(crate) fn of_drive(
        mission: &Mission,
        mut trace: Trace,
        navigator: &Navigator,
        decision_s: Vec<f64>,
        engine: String,
    ) -> Self {
        let plans = navigator.plans().to_vec();
        trace.paths = plans.iter().map(|plan| plan.smoothed.points().to_vec()).collect();
        let rows = &trace.rows;
        let last = rows.last();
        let pose = last.map_or(mission.start, |row| row.pose);
        let error = StopError::of(&pose, &mission.goal);
        Self {
            reached: last.is_some_and(|row| row.mode == Mode::Arrived),
            contact: None,
            collided: rows.iter().any(|row| row.gap_m <= 0.0),
            time_s: last.map_or(0.0, |row| row.time_s),
            late_ticks: navigator.tick_clock().late_ticks(),
            travelled_m: trace.travelled_m(),
            zones: None,
            encounters: Encounters::default(),
            min_clearance_m: rows.iter().map(|row| row.gap_m).fold(f64::INFINITY, f64::min),
            final_error_m: (error.x_m, error.y_m),
            final_yaw_error: error.yaw_rad,
            stop_errors: Vec::new(),
            fault: navigator.fault().cloned(),
            early_end: None,
            robot_fault: None,
            observation_faults: navigator.observation_faults().clone(),
            protective_actions: BTreeMap::new(),
            last_action: ProtectiveAction::Pass,
            no_control: navigator.why_without_control(),
            incidents: navigator.planner().incidents(),
            deadline_stats: navigator.deadline_stats(),
            motion: *navigator.motion(),
            odometry_scale: None,
            map_changes: None,
            decision_s,
            engine,
            plans,
            trace,
        }
    }

    /// Sign changes of the turn rate per metre driven, see [`Trace::omega_sign_changes`]; none where the robot did not drive.
    #[must_use]
    pub fn omega_sign_changes_per_m(&self) -> Option<f64> {
        let changes = self.trace.omega_sign_changes() as f64;
        (self.travelled_m > 0.0).then(|| changes / self.travelled_m)
    }

    /// How the mission ended.
    #[must_use]
    pub const fn end(&self) -> MissionEnd {
        MissionEnd::new(self.collided, self.reached, self.fault.is_some())
    }

    /// Why the goal was not reached, and the robot's last mode and pose; `None` for a goal that was reached without contact.
    #[must_use]
    pub fn why(&self) -> Option<String> {
        if self.collided {
            let contact = self.contact.as_ref().map(ToString::to_string);
            return Some(contact.unwrap_or_else(|| "touched something".to_owned()));
        }
        if self.reached {
            return None;
        }
        let why = match (self.early_end, &self.fault, &self.robot_fault) {
            // An interrupt also ends the wait for a program, and so the mission.
            (Some(EarlyEnd::Interrupted), ..) => EarlyEnd::Interrupted.text().to_owned(),
            // A lost line to the base, say, is the cause of what the navigator lacked.
            (_, Some(fault), Some(cause)) => format!("{fault}; {cause}"),
            (_, Some(fault), None) => fault.to_string(),
            (None, None, _) => self.time_was_up(),
            (Some(EarlyEnd::RobotStopped), None, Some(fault)) => fault.clone(),
            (Some(early_end), None, _) => early_end.text().to_owned(),
        };
        let Some((last, earlier)) = self.trace.rows.split_last() else {
            return Some(format!("{why} before the first tick"));
        };
        // The last mode says only that the navigator gave up; the mode before is the reason.
        let before = earlier.iter().rev().find(|row| row.mode != Mode::Failed);
        let mode = before.map_or(last.mode, |row| row.mode).name();
        // A robot that waits for its operator does not do what its mode says.
        let waits = self.last_action.awaits_operator();
        let mode = if waits { self.last_action.name() } else { mode }.replace('_', " ");
        let Pose { x, y, yaw } = last.pose;
        Some(format!("{why}; {mode} at ({x:.2}, {y:.2}, {yaw:.2})"))
    }

    /// That the time was up, what the robot and the protective layer did in it, and what the controller lacked in the end.
    fn time_was_up(&self) -> String {
        let mut ticks = ModeTicks::default();
        self.trace.rows.iter().for_each(|row| ticks.count(row.mode, &row.command));
        for (action, count) in &self.protective_actions {
            (0..*count).for_each(|_| ticks.count_protection(action));
        }
        let did = (!self.trace.rows.is_empty()).then(|| format!(": {}", ticks.text()));
        let lacked = self.no_control.as_ref().map(|reason| format!("; {reason}"));
        format!("the time was up{}{}", did.unwrap_or_default(), lacked.unwrap_or_default())
    }
}

/// Pose of the robot minus that of a stop.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct StopError {
    /// Along x, metres.
    pub x_m: f64,
    /// Along y, metres.
    pub y_m: f64,
    /// Yaw, radians, for a stop with a yaw.
    pub yaw_rad: Option<f64>,
}

impl StopError {
    /// Returns the error of a pose at a stop.
    #[must_use]
    pub fn of(pose: &Pose, stop: &Goal) -> Self {
        Self {
            x_m: pose.x - stop.position.x,
            y_m: pose.y - stop.position.y,
            yaw_rad: stop.yaw.map(|yaw| wrap_angle(pose.yaw - yaw)),
        }
    }
}

/// Why a mission cannot start.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MissionError {
    /// A setting is out of range.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// The localizer cannot start.
    #[error(transparent)]
    Localization(#[from] LocalizationError),
    /// The navigator cannot start.
    #[error(transparent)]
    Fault(#[from] Fault),
}

/// One tick of a mission.
#[non_exhaustive]
pub struct TickEvent<'a> {
    /// The row of the trace.
    pub row: &'a TraceRow,
    /// What the navigator received.
    pub observation: &'a Observation,
    /// What the base measured: its pose is in the `odom` frame.
    pub odometry: &'a OdometryReading,
    /// The localizer's report, for a pose from scans.
    pub fix: Option<&'a PoseEstimate>,
    /// What the navigator decided.
    pub decision: &'a Decision,
    /// Time of the decision by the observer's clock, seconds.
    pub took_s: f64,
    /// Radius of each moving obstacle, metres, in the order of [`TraceRow::moving`].
    pub moving_radii: &'a [f64],
    /// What the protective layer did to the command.
    pub protective_action: &'a ProtectiveAction,
    /// Fault of the robot after the tick, as a sentence.
    pub robot_fault: Option<&'a str>,
    /// The map with what the scans contradicted, in the tick from which on the navigator uses it.
    pub updated_map: Option<&'a OccupancyGrid>,
    /// The navigator after the tick.
    pub navigator: &'a Navigator,
}

impl TickEvent<'_> {
    /// Samples of the dynamic window of the decision, at most this many along each axis; none if the decision needed no
    /// samples.
    #[must_use]
    pub fn fan(&self, most: Sampling) -> Option<TrajectoryFan> {
        self.decision.counts.as_ref()?;
        self.navigator.planner().trajectory_fan(most)
    }
}

/// A clock, and a callback for each tick.
pub struct Observer<'a> {
    /// Monotonic clock, seconds. It decides nothing unless the navigator has a deadline.
    pub clock: &'a mut dyn FnMut() -> f64,
    /// Called after each tick; it changes nothing in the mission.
    pub on_tick: &'a mut dyn FnMut(&TickEvent<'_>),
}

/// What decides the commands of a mission.
pub enum Decider {
    /// inbye's behaviours with this engine, unless the configuration names a program as controller.
    Navigator(Box<dyn Engine>),
    /// This controller.
    Controller(Box<dyn Controller>),
}

crate::settings::opaque_debug!(Decider);

impl From<Box<dyn Engine>> for Decider {
    fn from(engine: Box<dyn Engine>) -> Self {
        Self::Navigator(engine)
    }
}

impl<E: Engine + 'static> From<Box<E>> for Decider {
    fn from(engine: Box<E>) -> Self {
        Self::Navigator(engine)
    }
}

impl From<Box<dyn Controller>> for Decider {
    fn from(controller: Box<dyn Controller>) -> Self {
        Self::Controller(controller)
    }
}

/// Runs a mission with a robot that stands at the mission's start. It ends at the goal, at contact, at a fault, at the time
/// limit, or when the robot stops for good.
///
/// # Errors
/// Fails when a setting is out of range or no path leads to a stop.
pub fn run_mission(
    mission: &Mission,
    config: &Config,
    decider: impl Into<Decider>,
    robot: &mut dyn Robot,
    observer: &mut Observer<'_>,
) -> Result<MissionResult, MissionError> {
    let (mission, config) = (mission.clone(), Arc::new(config.clone()));
    Ok(MissionRun::new(mission, config, decider, robot, observer)?.run(observer))
}

/// Describes the faults of each tick of a drive. Takes the ticks in order.
#[derive(Clone, Debug, Default)]
pub struct FaultEvents {
    /// Number of GPU failures up to the last tick.
    incidents: u64,
}

impl FaultEvents {
    /// Returns a sentence for each fault of the next tick.
    pub fn update(&mut self, tick: &TickEvent<'_>) -> Vec<String> {
        let navigator = tick.navigator;
        let mut now: Vec<String> = navigator
            .observation_fault()
            .map(|fault| format!("sensors: {fault}"))
            .into_iter()
            .collect();
        let late = navigator.tick_clock().last().warning();
        now.extend(late.map(|late| format!("control loop: {late}")));
        now.extend(self.engine_events(tick));
        now.extend(tick.robot_fault.map(|words| format!("base: {words}")));
        if tick.row.gap_m <= 0.0 {
            now.push("contact: the robot touches something".to_owned());
        }
        let fault = navigator.fault().filter(|_| tick.row.mode == Mode::Failed);
        now.extend(fault.map(|fault| format!("gave up: {fault}")));
        now
    }

    /// Describes GPU failures since the last tick. A GPU that is absent from the start is no fault.
    fn engine_events(&mut self, tick: &TickEvent<'_>) -> Vec<String> {
        let Some(incidents) = tick.navigator.planner().incidents() else {
            return Vec::new();
        };
        let before = std::mem::replace(&mut self.incidents, incidents.total());
        (before..self.incidents)
            .filter_map(|index| match incidents.messages.get(index as usize) {
                Some(one) if one.kind == Some(GpuFailureKind::Absent) => None,
                Some(one) => Some(format!("engine: {}", one.message)),
                None => {
                    Some("engine: one more incident; only the first ones are described".to_owned())
                }
            })
            .collect()
    }
}
