//! The closed loop of a mission: sense, decide, record and drive, tick by tick.

use core::ops::ControlFlow;
use std::collections::BTreeMap;
use std::sync::Arc;

use super::lidar_data::CompensatedScan;
use super::map_update::{ChangedMap, ContradictedMap, MapUpdate};
use super::mission::{
    Decider, EarlyEnd, Mission, MissionError, MissionResult, Observer, StopError, TickEvent,
};
use super::pose_estimator::PoseEstimator;
use super::start_pose::check_start;
use super::{
    Config, Contact, Encounters, GroundTruth, LidarData, MissionEnd, ObstacleGap, OdometryReading,
    Robot, RobotConfig, Trace, TraceRow, ZoneCompliance,
};
use crate::base::ProtectiveAction;
use crate::geometry::{Pose, Twist};
use crate::local::{CpuEngine, Engine};
use crate::map::{OccupancyGrid, ScanChange};
use crate::navigator::{Fault, MapSource, Mode, NavigationMap, Navigator, Observation, Waypoints};

/// Longest time for which a robot that gave up brakes within the mission, seconds: from 2 m/s at 0.7 m/s^2.
const BRAKING_S: f64 = 3.0;

/// A mission that runs tick by tick, as a caller wants to run it among others. [`run_mission`](super::run_mission) runs a whole one.
///
/// ```
/// use std::sync::Arc;
///
/// use inbye::local::CpuEngine;
/// use inbye::navigator::Goal;
/// use inbye::runtime::{Config, Mission, MissionRun, Observer};
/// use inbye::sim::{Simulation, dead_end};
///
/// let scene = dead_end();
/// let mission = Mission::new(Arc::new(scene.map), scene.start, Goal::at(scene.goal));
/// let config = Arc::new(Config::default());
/// let robot = Simulation::new(mission.clone()).robot(&config)?;
/// let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
/// let engine = Box::new(CpuEngine::single_threaded());
/// let mut run = MissionRun::new(mission, config, engine, robot, &mut observer)?;
/// while run.step(&mut observer).is_continue() && run.trace().rows.len() < 3 {}
/// assert_eq!(run.result().trace.rows.len(), 3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct MissionRun<R> {
    mission: Mission,
    config: Arc<Config>,
    robot: R,
    pose_estimator: PoseEstimator,
    scan: CompensatedScan,
    scan_change: ScanChange,
    /// Time of the newest scan, and of the newest one that differed from the one before, seconds.
    scan_s: Option<f64>,
    scan_changed_s: f64,
    navigator: Navigator,
    contradicted: ContradictedMap,
    map_update: MapUpdate,
    /// The map in preparation.
    coming_map: Option<OccupancyGrid>,
    /// When the navigator gave up, seconds.
    failed_s: Option<f64>,
    /// Gaps to the map, for a robot without the true gaps; prepared when first needed.
    map_gap: Option<ObstacleGap>,
    trace: Trace,
    decision_s: Vec<f64>,
    stop_errors: Vec<StopError>,
    contact: Option<Contact>,
    early_end: Option<EarlyEnd>,
    protective_actions: BTreeMap<&'static str, u64>,
    last_action: ProtectiveAction,
    /// Number of ticks in which the robot waited for its operator.
    waiting_ticks: u64,
    engine: String,
    /// Number of ticks until the time limit.
    ticks: u64,
    /// Time of the first tick by the robot's clock, seconds, if it has one.
    began_s: Option<f64>,
    is_over: bool,
    /// Whether the answers of a program turned out not to be valid at the end.
    is_invalid: bool,
}

crate::settings::opaque_debug!(MissionRun<R>);

impl<R: Robot> MissionRun<R> {
    /// Prepares a mission of a robot that stands at the mission's start.
    ///
    /// # Errors
    /// Fails when a setting is out of range or no path leads to a stop.
    pub fn new(
        mission: Mission,
        config: Arc<Config>,
        decider: impl Into<Decider>,
        robot: R,
        observer: &mut Observer<'_>,
    ) -> Result<Self, MissionError> {
        config.validate()?;
        mission.validate()?;
        let map = mission.navigation_map(config.unknown);
        let pose_estimator = PoseEstimator::new(&config, &map.obstacles, &mission)?;
        let waypoints = Waypoints { start: mission.start.position(), goals: mission.stops() };
        let real_time = robot.now_s().map(|_| Config::clone(&config).in_real_time());
        // A real robot stands where there is room, whatever the cells of its map cover.
        if real_time.is_none() && !mission.is_start_unknown {
            let footprint = &config.robot.footprint;
            check_start(&mission.start, &map.obstacles, footprint).map_err(Fault::from)?;
        }
        let navigator_config = real_time.as_ref().unwrap_or(&config);
        let (engine, controller) = match decider.into() {
            Decider::Navigator(engine) => (engine, navigator_config.new_controller(&map)?),
            // The local planner is not used.
            Decider::Controller(controller) => {
                (Box::new(CpuEngine::single_threaded()) as Box<dyn Engine>, Some(controller))
            }
        };
        let navigator = navigator_config.new_navigator_with(
            map,
            &waypoints,
            engine,
            controller,
            observer.clock,
        )?;
        let engine = match navigator.controller_name() {
            Some(name) => format!("controller {name}"),
            None => navigator.planner().engine_name(),
        };
        let moving_radii = robot.moving_radii_m();
        let ticks = mission.ticks(config.local.control_period_s);
        Ok(Self {
            ticks,
            began_s: None,
            is_over: ticks == 0,
            is_invalid: false,
            mission,
            config,
            robot,
            pose_estimator,
            scan: CompensatedScan::new(),
            scan_change: ScanChange::default(),
            scan_s: None,
            scan_changed_s: 0.0,
            navigator,
            contradicted: ContradictedMap::default(),
            map_update: MapUpdate::default(),
            coming_map: None,
            failed_s: None,
            map_gap: None,
            trace: Trace { moving_radii, ..Trace::default() },
            decision_s: Vec::new(),
            stop_errors: Vec::new(),
            contact: None,
            early_end: None,
            protective_actions: BTreeMap::new(),
            last_action: ProtectiveAction::Pass,
            waiting_ticks: 0,
            engine,
        })
    }

    /// Runs the next tick. Returns a break where the mission is over: at the goal, at contact, at a fault, at the time limit, or
    /// when the robot stops for good.
    pub fn step(&mut self, observer: &mut Observer<'_>) -> ControlFlow<()> {
        if !self.is_over && self.mission.is_interrupted() {
            self.early_end = Some(EarlyEnd::Interrupted);
            self.is_over = true;
        }
        if self.is_over {
            return ControlFlow::Break(());
        }
        if self.trace.rows.is_empty() {
            self.began_s = self.robot.now_s();
        }
        let (row, has_stopped) = self.tick(self.now_s(), observer);
        self.is_over = row.mode == Mode::Arrived
            || self.has_failed_and_stands(&row)
            || row.gap_m <= 0.0
            || has_stopped
            || self.mission.is_done(&row.pose);
        // The robot, or the wait for a program, may end by the same signal before the mission does.
        let has_ended = has_stopped || row.mode == Mode::Failed;
        self.early_end = if has_ended && self.mission.is_interrupted() {
            Some(EarlyEnd::Interrupted)
        } else {
            has_stopped.then_some(EarlyEnd::RobotStopped)
        };
        self.trace.rows.push(row);
        self.is_over |= self.is_time_up();
        if self.is_over && self.early_end != Some(EarlyEnd::Interrupted) {
            self.finish();
        }
        if self.is_over { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Ends the programs of the user's own. One that turns out to have answered other messages than it was asked makes the mission fail,
    /// wherever the robot stands.
    fn finish(&mut self) {
        let has_programs = self.config.controller.is_set() || self.config.global_planner.is_set();
        if has_programs && self.robot.now_s().is_some() {
            // A real robot must not drive on while its programs end.
            let _ = self.robot.drive(&Twist::STOP, self.config.local.control_period_s);
        }
        let had_fault = self.navigator.fault().is_some();
        self.navigator.finish();
        self.is_invalid = !had_fault && self.navigator.fault().is_some();
        if self.robot.finish().is_break() {
            self.early_end = self.early_end.or(Some(EarlyEnd::RobotStopped));
            self.is_invalid = true;
        }
    }

    /// Time since the first tick, seconds: measured by the robot's clock, else by counting ticks.
    fn now_s(&self) -> f64 {
        let counted_s = || self.trace.rows.len() as f64 * self.config.local.control_period_s;
        let measured = self.robot.now_s().zip(self.began_s);
        measured.map_or_else(counted_s, |(now_s, began_s)| now_s - began_s)
    }

    fn is_time_up(&self) -> bool {
        let waited_s = self.waiting_ticks as f64 * self.config.local.control_period_s;
        match self.began_s {
            Some(_) => self.now_s() - waited_s >= self.mission.time_limit_s,
            None => self.trace.rows.len() as u64 >= self.ticks.saturating_add(self.waiting_ticks),
        }
    }

    /// Runs the rest of the mission.
    pub fn run(mut self, observer: &mut Observer<'_>) -> MissionResult {
        while self.step(observer).is_continue() {}
        self.result()
    }

    /// The ticks so far; it has no paths before the end.
    #[must_use]
    pub const fn trace(&self) -> &Trace {
        &self.trace
    }

    /// The navigator.
    #[must_use]
    pub const fn navigator(&self) -> &Navigator {
        &self.navigator
    }

    /// Whether the navigator has given up and the robot stands. It may give up at speed: what happens until the robot stands
    /// belongs to the mission.
    fn has_failed_and_stands(&mut self, row: &TraceRow) -> bool {
        if row.mode != Mode::Failed {
            return false;
        }
        let failed_s = *self.failed_s.get_or_insert(row.time_s);
        row.twist.stands() || row.time_s - failed_s >= BRAKING_S
    }

    /// Runs one tick. Returns its row, and whether the robot has stopped for good.
    fn tick(&mut self, time_s: f64, observer: &mut Observer<'_>) -> (TraceRow, bool) {
        let (observation, odometry) = self.observe(time_s);
        let updated_map = self.update_map(time_s);
        let (decision, took_s) = self.navigator.step_by(&observation, observer.clock);
        self.decision_s.push(took_s);
        let truth = self.robot.ground_truth();
        let truth = truth.unwrap_or_else(|| GroundTruth::of(&observation, odometry.twist));
        self.contact = self.contact.or(truth.contact);
        self.record_stop(decision.mode, &truth.pose);
        let gap_m = truth.gap_m.unwrap_or_else(|| self.gap_on_map_m(&truth.pose));
        let path = self.navigator.plans().len() - 1;
        let row = TraceRow::new(&observation, &decision, truth, gap_m, path);
        let period_s = self.config.local.control_period_s;
        let has_stopped = self.robot.drive(&decision.command, period_s).is_break();
        let protective_action = self.robot.protective_action();
        if !protective_action.passes() {
            *self.protective_actions.entry(protective_action.name()).or_default() += 1;
            self.navigator.count_protection(protective_action.name());
        }
        (observer.on_tick)(&TickEvent {
            row: &row,
            observation: &observation,
            odometry: &odometry,
            fix: self.pose_estimator.fix(),
            decision: &decision,
            took_s,
            moving_radii: &self.trace.moving_radii,
            protective_action: &protective_action,
            robot_fault: self.robot.fault().as_deref(),
            updated_map: updated_map.as_ref(),
            navigator: &self.navigator,
        });
        if protective_action.awaits_operator() {
            self.navigator.restart_progress();
            self.waiting_ticks += 1;
        }
        self.last_action = protective_action;
        (row, has_stopped)
    }

    /// Gives navigator and localizer the map with what the scans contradicted for minutes, and returns it. A map that cannot be
    /// prepared is left out: they keep the one that they have.
    ///
    /// To prepare a map takes time in proportion to its area. A real robot drives on meanwhile; simulated time stands still.
    fn update_map(&mut self, time_s: f64) -> Option<OccupancyGrid> {
        let (config, mission) = (&self.config, &self.mission);
        if !config.navigator.features.map_changes {
            return None;
        }
        let on = |grid: &OccupancyGrid| NavigationMap {
            obstacles: grid.obstacles(config.unknown),
            zones: mission.zones.clone(),
        };
        if !self.map_update.is_running() {
            let changes = || self.pose_estimator.map_changes(&mission.map);
            let extent = (mission.map.frame(), config.robot.footprint.body_radius_m());
            let (changes, is_large) = self.contradicted.look(time_s, extent, changes)?;
            if !is_large {
                return None;
            }
            let updated = changes.applied_to(&mission.map);
            if self.robot.now_s().is_none() {
                let changed = ChangedMap::new(on(&updated), config).ok()?;
                return Some(self.replace_map(changed, updated));
            }
            self.map_update.start(&on(&updated), config);
            self.coming_map = Some(updated);
        }
        let changed = self.map_update.take(|| None, config).ok()??;
        let updated = self.coming_map.take()?;
        Some(self.replace_map(changed, updated))
    }

    fn replace_map(&mut self, changed: ChangedMap, updated: OccupancyGrid) -> OccupancyGrid {
        self.navigator.replace_map(changed.for_navigator, MapSource::Scans);
        self.pose_estimator.adopt_changes(changed.for_localizer);
        if let Some(gap) = &mut self.map_gap {
            *gap = ObstacleGap::new(updated.obstacles(self.config.unknown));
        }
        updated
    }

    /// Senses, and estimates the pose in the map.
    fn observe(&mut self, time_s: f64) -> (Observation, OdometryReading) {
        let sensed = self.robot.sense(time_s);
        let odometry = sensed.odometry;
        self.pose_estimator.update(&sensed);
        let lidar = sensed.lidar.as_ref();
        let scan_s = lidar.and_then(|lidar| lidar.end_s(sensed.odometry_s)).unwrap_or(time_s);
        self.note_scan_change(scan_s, lidar);
        let scan = self.scan.update((sensed.odometry_s, &odometry.pose), sensed.lidar);
        let observation = Observation {
            time_s,
            pose: self.pose_estimator.pose(),
            pose_s: self.pose_estimator.pose_s(sensed.odometry_s),
            lost: self.pose_estimator.lost(),
            twist: self.pose_estimator.ground_twist(&odometry.twist),
            odometry_s: sensed.odometry_s,
            scan,
            scan_s,
            scan_changed_s: self.scan_changed_s,
            sent: sensed.sent,
        };
        (observation, odometry)
    }

    /// Compares a new scan, as measured, with the one before.
    fn note_scan_change(&mut self, scan_s: f64, lidar: Option<&LidarData>) {
        if self.scan_s.replace(scan_s) != Some(scan_s) {
            let changed_s = |lidar: &LidarData| self.scan_change.update(scan_s, lidar.ranges());
            self.scan_changed_s = lidar.map_or(scan_s, changed_s);
        }
    }

    fn gap_on_map_m(&mut self, pose: &Pose) -> f64 {
        let (map, unknown) = (&self.mission.map, self.config.unknown);
        self.map_gap
            .get_or_insert_with(|| ObstacleGap::new(map.obstacles(unknown)))
            .gap_m(&self.config.robot.footprint, pose)
    }

    /// Records the pose error at each stop before the goal, once, when the robot stands there.
    fn record_stop(&mut self, mode: Mode, pose: &Pose) {
        let number = self.navigator.goals_passed();
        if mode == Mode::AtWaypoint && self.stop_errors.len() == number {
            self.stop_errors.push(StopError::of(pose, self.navigator.goal()));
        }
    }

    /// Whether the robot is at its goal, by the rule of the mission.
    #[must_use]
    pub fn is_reached(&self) -> bool {
        let at_goal = |row: &TraceRow| row.mode == Mode::Arrived || self.mission.is_done(&row.pose);
        !self.is_invalid && self.trace.rows.last().is_some_and(at_goal)
    }

    /// How the mission ended; none while it runs.
    #[must_use]
    pub fn end(&self) -> Option<MissionEnd> {
        let collided = self.trace.rows.last().is_some_and(|row| row.gap_m <= 0.0);
        let has_failed = self.navigator.fault().is_some();
        self.is_over.then(|| MissionEnd::new(collided, self.is_reached(), has_failed))
    }

    /// The result of the mission up to now.
    #[must_use]
    pub fn result(self) -> MissionResult {
        let reached = self.is_reached();
        let drive = MissionResult::of_drive(
            &self.mission,
            self.trace,
            &self.navigator,
            self.decision_s,
            self.engine,
        );
        let encounters = if drive.trace.moving_radii.is_empty() {
            Encounters::default()
        } else {
            let map = self.mission.map.obstacles(self.config.unknown);
            Encounters::of(&drive.trace, &map, self.config.local.control_period_s)
        };
        let RobotConfig { footprint, limits, .. } = &self.config.robot;
        let zones = self
            .mission
            .zones
            .as_ref()
            .map(|zones| ZoneCompliance::of(&drive.trace, zones, footprint, limits.max_vel_x));
        MissionResult {
            zones,
            encounters,
            reached,
            contact: self.contact,
            stop_errors: self.stop_errors,
            early_end: self.early_end,
            robot_fault: self.robot.fault(),
            protective_actions: self.protective_actions,
            last_action: self.last_action,
            odometry_scale: self.pose_estimator.odometry_scale(),
            map_changes: self.pose_estimator.map_changes(&self.mission.map),
            ..drive
        }
    }
}
