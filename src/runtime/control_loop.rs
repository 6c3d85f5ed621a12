//! The closed loop of a mission: sense, decide, record and drive, tick by tick.

use super::mission::{Mission, MissionError, MissionResult, Observer, StopError, TickEvent};
use super::{
    Config, GroundTruth, LidarData, ObstacleGap, OdometryReading, PoseSource, Robot, Trace,
    TraceRow,
};
use crate::geometry::Pose;
use crate::local::Engine;
use crate::localization::{
    DeskewedScan, LocalizationError, Localizer, LostReason, PoseEstimate, PoseHistory,
};
use crate::map::{ObstacleGrid, Scan, TimedScan};
use crate::navigator::{Mode, Navigator, Observation, Waypoints};

pub(super) struct ControlLoop<'a> {
    mission: &'a Mission,
    config: &'a Config,
    robot: &'a mut dyn Robot,
    pose_estimator: PoseEstimator,
    odometry: PoseHistory,
    deskewed: DeskewedScan,
    navigator: Navigator,
    /// Gaps on the map, for a robot that does not know the true ones; prepared when first needed.
    map_gap: Option<ObstacleGap>,
    trace: Trace,
    decision_s: Vec<f64>,
    stop_errors: Vec<StopError>,
    engine: String,
}

impl<'a> ControlLoop<'a> {
    pub fn new(
        mission: &'a Mission,
        config: &'a Config,
        engine: Box<dyn Engine>,
        robot: &'a mut dyn Robot,
        observer: &mut Observer<'_>,
    ) -> Result<Self, MissionError> {
        config.validate()?;
        let known = mission.map.obstacles(config.unknown);
        let pose_estimator = PoseEstimator::new(config, &known, mission.start)?;
        let waypoints = Waypoints { start: mission.start.position(), goals: mission.stops() };
        let navigator = config.new_navigator(known, &waypoints, engine, observer.clock)?;
        let engine = navigator.planner().engine_name();
        let moving_radii = robot.moving_radii_m();
        Ok(Self {
            mission,
            config,
            robot,
            pose_estimator,
            odometry: PoseHistory::new(),
            deskewed: DeskewedScan::default(),
            navigator,
            map_gap: None,
            trace: Trace { moving_radii, ..Trace::default() },
            decision_s: Vec::new(),
            stop_errors: Vec::new(),
            engine,
        })
    }

    pub fn run(mut self, observer: &mut Observer<'_>) -> MissionResult {
        let period_s = self.config.local.control_period_s;
        let ticks = (self.mission.time_limit_s / period_s).ceil() as u64;
        for tick in 0..ticks {
            let (row, has_stopped) = self.tick(tick as f64 * period_s, observer);
            let is_over = matches!(row.mode, Mode::Arrived | Mode::Failed)
                || row.gap_m <= 0.0
                || has_stopped
                || self.is_done(&row.pose);
            self.trace.rows.push(row);
            if is_over {
                break;
            }
        }
        self.result()
    }

    fn is_done(&self, pose: &Pose) -> bool {
        let away_m = (pose.position() - self.mission.goal.position).norm();
        let within_m = self.mission.done_within_m;
        within_m.is_some_and(|within_m| away_m <= within_m)
    }

    /// Runs one tick. Returns its row, and whether the robot has stopped for good.
    fn tick(&mut self, time_s: f64, observer: &mut Observer<'_>) -> (TraceRow, bool) {
        let (observation, odometry) = self.observe(time_s);
        let (decision, took_s) = self.navigator.step_by(&observation, observer.clock);
        self.decision_s.push(took_s);
        let truth = self.robot.ground_truth().unwrap_or_else(|| GroundTruth {
            pose: observation.pose,
            twist: odometry.twist,
            gap_m: None,
            moving: Vec::new(),
        });
        self.record_stop(decision.mode, &truth.pose);
        let counts = decision.counts.unwrap_or_default();
        let row = TraceRow {
            time_s,
            pose: truth.pose,
            belief: observation.pose,
            twist: truth.twist,
            command: decision.command,
            local_target: decision.local_target,
            gap_m: truth.gap_m.unwrap_or_else(|| self.gap_on_map_m(&truth.pose)),
            admissible: counts.admissible,
            samples: counts.to_array().iter().sum(),
            mode: decision.mode,
            path: self.navigator.plans().len() - 1,
            moving: truth.moving,
        };
        let period_s = self.config.local.control_period_s;
        let has_stopped = self.robot.drive(&decision.command, period_s).is_break();
        (observer.on_tick)(&TickEvent {
            row: &row,
            observation: &observation,
            odometry: &odometry,
            fix: self.pose_estimator.fix(),
            decision: &decision,
            took_s,
            moving_radii: &self.trace.moving_radii,
            robot_fault: self.robot.fault().as_deref(),
            navigator: &self.navigator,
        });
        (row, has_stopped)
    }

    /// Senses, and estimates the pose in the map.
    fn observe(&mut self, time_s: f64) -> (Observation, OdometryReading) {
        let sensed = self.robot.sense(time_s);
        let odometry = sensed.odometry;
        self.odometry.record(time_s, &odometry.pose);
        let lidar = sensed.lidar.as_ref();
        self.pose_estimator.update(time_s, &odometry.pose, sensed.pose, lidar);
        let (scan, scan_s) = match sensed.lidar {
            Some(LidarData::Scan(scan)) => (scan, time_s),
            // The navigator takes a revolution as seen from the newest odometry.
            Some(LidarData::TimedScan(sweep)) => {
                self.deskewed.deskew(&sweep, &self.odometry);
                let scan = self.deskewed.to_scan(sweep.beams.len());
                (scan, sweep.end_s().unwrap_or(time_s))
            }
            None => (Scan::default(), time_s),
        };
        let observation = Observation {
            time_s,
            pose: self.pose_estimator.pose(),
            lost: self.pose_estimator.lost(),
            twist: odometry.twist,
            scan,
            scan_s,
        };
        (observation, odometry)
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

    fn result(mut self) -> MissionResult {
        let plans = self.navigator.plans().to_vec();
        self.trace.paths = plans.iter().map(|plan| plan.smoothed.points().to_vec()).collect();
        let rows = &self.trace.rows;
        let last = rows.last();
        let pose = last.map_or(self.mission.start, |row| row.pose);
        let step = |pair: &[TraceRow]| (pair[1].pose.position() - pair[0].pose.position()).norm();
        let error = StopError::of(&pose, &self.mission.goal);
        MissionResult {
            reached: last.is_some_and(|row| row.mode == Mode::Arrived || self.is_done(&row.pose)),
            collided: rows.iter().any(|row| row.gap_m <= 0.0),
            time_s: last.map_or(0.0, |row| row.time_s),
            travelled_m: rows.windows(2).map(step).fold(0.0, |sum, step_m| sum + step_m),
            min_clearance_m: rows.iter().map(|row| row.gap_m).fold(f64::INFINITY, f64::min),
            final_error_m: (error.x_m, error.y_m),
            final_yaw_error: error.yaw_rad,
            stop_errors: self.stop_errors,
            fault: self.navigator.fault().cloned(),
            observation_faults: self.navigator.observation_faults().clone(),
            incidents: self.navigator.planner().incidents().cloned(),
            deadline_stats: self.navigator.deadline_stats(),
            decision_s: self.decision_s,
            engine: self.engine,
            plans,
            trace: self.trace,
        }
    }
}

/// The robot's pose in the map: from its own positioning, or from scans that are matched to the map.
enum PoseEstimator {
    /// The pose that the robot reported last.
    Fixes(Pose),
    Scans {
        localizer: Box<Localizer>,
        /// End of the last revolution that was matched, seconds.
        matched_s: Option<f64>,
    },
}

impl PoseEstimator {
    fn new(config: &Config, known: &ObstacleGrid, start: Pose) -> Result<Self, LocalizationError> {
        Ok(match config.pose_source {
            PoseSource::Fixes => Self::Fixes(start),
            PoseSource::Scans => Self::Scans {
                localizer: Box::new(Localizer::new(known, config.localization, &start)?),
                matched_s: None,
            },
        })
    }

    /// Updates the estimate with one tick. Without positioning of its own, the robot's pose is that of its odometry.
    fn update(
        &mut self,
        time_s: f64,
        odometry: &Pose,
        reported: Option<Pose>,
        lidar: Option<&LidarData>,
    ) {
        match self {
            Self::Fixes(pose) => *pose = reported.unwrap_or(*odometry),
            Self::Scans { localizer, matched_s } => {
                localizer.predict(time_s, odometry);
                match lidar {
                    Some(LidarData::Scan(scan)) => {
                        localizer.update(&TimedScan::from_scan(scan, time_s, 0.0));
                    }
                    Some(LidarData::TimedScan(sweep)) => {
                        let end_s = sweep.end_s();
                        if end_s.is_some() && end_s != *matched_s {
                            localizer.update(sweep);
                            *matched_s = end_s;
                        }
                    }
                    None => {}
                }
            }
        }
    }

    fn pose(&self) -> Pose {
        match self {
            Self::Fixes(pose) => *pose,
            Self::Scans { localizer, .. } => *localizer.pose(),
        }
    }

    /// The localizer's own report.
    fn fix(&self) -> Option<&PoseEstimate> {
        match self {
            Self::Fixes(_) => None,
            Self::Scans { localizer, .. } => Some(localizer.estimate()),
        }
    }

    fn lost(&self) -> Option<LostReason> {
        self.fix()?.status.lost_reason()
    }
}
