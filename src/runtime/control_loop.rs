//! A closed loop: the navigator in a simulated world, tick by tick, to the goal.

use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use super::mission::{Mission, MissionError, MissionResult, Observer, StopError, TickEvent};
use super::pose_source::{PoseEstimator, Seen};
use super::{Config, OdometryReading, Robot, Trace, TraceRow};
use crate::geometry::Pose;
use crate::local::{Engine, LocalPlanner};
use crate::localization::{DeskewedScan, PoseHistory};
use crate::map::{MovingDisc, Scan, TimedScan};
use crate::navigator::{Mode, Navigator, Observation, Waypoints};
use crate::sim::fault_injection::{Carried, spoil, spoilt};
use crate::sim::{MovingObstacles, World};

pub(super) struct Simulation<'a> {
    mission: &'a Mission,
    config: &'a Config,
    world: World,
    moving_obstacles: MovingObstacles,
    vehicle: &'a mut dyn Robot,
    carried: Carried,
    /// Whether the vehicle can go on.
    goes_on: bool,
    pose_source: PoseEstimator,
    /// Where it truly was, and where odometry had it, of late.
    truth: PoseHistory,
    odometry: PoseHistory,
    view: DeskewedScan,
    /// Whether the vehicle has a lidar of its own, and so is not in the simulated world.
    has_own_lidar: bool,
    navigator: Navigator,
    lidar_noise: Pcg64Mcg,
    trace: Trace,
    decision_s: Vec<f64>,
    stop_errors: Vec<StopError>,
    engine: String,
}

impl<'a> Simulation<'a> {
    pub fn new(
        mission: &'a Mission,
        config: &'a Config,
        engine: Box<dyn Engine>,
        vehicle: &'a mut dyn Robot,
        observer: &mut Observer<'_>,
    ) -> Result<Self, MissionError> {
        config.validate()?;
        let known = mission.map.obstacles(config.unknown);
        let truth = mission.truth.clone().unwrap_or_else(|| known.clone());
        let route_planner = config.route_planner(known.frame().resolution_m);
        let planner = LocalPlanner::new(engine, config.local.clone());
        let engine = planner.engine_name();
        let pose_source = PoseEstimator::new(config, &known, mission)?;
        let navigator = Navigator::new(
            known,
            &Waypoints {
                start: mission.start.position(),
                stops: mission.stops(),
            },
            config.robot.model(),
            planner,
            route_planner,
            config.navigator.clone(),
            observer.clock,
        )?;
        Ok(Self {
            mission,
            config,
            world: World::new(truth),
            moving_obstacles: mission.moving_obstacles.clone(),
            vehicle,
            carried: Carried::default(),
            goes_on: true,
            pose_source,
            truth: PoseHistory::new(),
            odometry: PoseHistory::new(),
            view: DeskewedScan::default(),
            has_own_lidar: false,
            navigator,
            lidar_noise: Pcg64Mcg::seed_from_u64(mission.seed),
            trace: Trace {
                moving_radii: mission.moving_obstacles.radii(),
                ..Trace::default()
            },
            decision_s: Vec::new(),
            stop_errors: Vec::new(),
            engine,
        })
    }

    pub fn run(mut self, observer: &mut Observer<'_>) -> MissionResult {
        let period_s = self.config.local.control_period_s;
        let ticks = (self.mission.time_limit_s / period_s).ceil() as u64;
        for tick in 0..ticks {
            let row = self.tick(tick as f64 * period_s, observer);
            let over = matches!(row.mode, Mode::Arrived | Mode::Failed)
                || row.gap_m <= 0.0
                || !self.goes_on
                || self.is_done(&row.pose);
            self.trace.rows.push(row);
            if over {
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

    /// Look, decide, record, move: in this order.
    fn tick(&mut self, time_s: f64, observer: &mut Observer<'_>) -> TraceRow {
        let (observation, odometry) = self.observe(time_s);
        let (decision, took_s) = self.navigator.step_by(&observation, observer.clock);
        self.decision_s.push(took_s);
        self.note_stop(decision.mode);
        let counts = decision.counts.unwrap_or_default();
        let footprint = &self.config.robot.footprint;
        let pose = self.pose();
        let row = TraceRow {
            time_s,
            pose,
            belief: observation.pose,
            twist: self.vehicle.twist(),
            command: decision.command,
            local_target: decision.local_target,
            gap_m: self.world.gap_m(footprint, &pose),
            admissible: counts.admissible,
            samples: counts.to_array().iter().sum(),
            mode: decision.mode,
            path: self.navigator.plans().len() - 1,
            moving: self
                .moving_obstacles
                .places()
                .iter()
                .map(|place| place.as_ref().map(MovingDisc::center))
                .collect(),
        };
        let period_s = self.config.local.control_period_s;
        self.goes_on = self.vehicle.drive(&decision.command, period_s);
        let trouble = self.vehicle.trouble();
        self.moving_obstacles
            .step(period_s, &self.pose(), footprint);
        (observer.on_tick)(&TickEvent {
            row: &row,
            observation: &observation,
            odometry: &odometry,
            fix: self.pose_source.fix(),
            decision: &decision,
            took_s,
            moving_radii: &self.trace.moving_radii,
            trouble: trouble.as_deref(),
            navigator: &self.navigator,
        });
        row
    }

    /// What the robot can know: its odometry, what its lidar sees, and where both have it in the map.
    fn observe(&mut self, time_s: f64) -> (Observation, OdometryReading) {
        self.world.moving = self.moving_obstacles.discs();
        let odometry = self.vehicle.odometry();
        let own = self.vehicle.sweep(time_s);
        self.has_own_lidar = own.is_some();
        let own_pose = self.vehicle.pose();
        let truth = self.carried.pose(&self.mission.faults, time_s, &own_pose);
        self.truth.record(time_s, &truth);
        self.odometry.record(time_s, &odometry.pose);
        let seen = own.map_or_else(|| self.simulated(time_s), Seen::Sweep);
        self.pose_source
            .observe(time_s, &odometry.pose, &truth, &seen);
        let (scan, scan_s) = match seen {
            Seen::Scan(scan) => (scan, time_s),
            Seen::Sweep(sweep) => (self.at_once(&sweep), sweep.end_s().unwrap_or(time_s)),
        };
        let observation = Observation {
            time_s,
            pose: self.pose_source.pose(),
            lost: self.pose_source.lost(),
            twist: odometry.twist,
            scan,
            scan_s,
        };
        (observation, odometry)
    }

    fn simulated(&mut self, time_s: f64) -> Seen {
        let lidar = &self.config.lidar;
        let (world, rng) = (&self.world, &mut self.lidar_noise);
        let truth = &self.truth;
        let pose_at = |time_s: f64| truth.at(time_s).unwrap_or_default();
        let faults = &self.mission.faults;
        if lidar.sweep_s > 0.0 {
            let mut sweep = lidar.sweep(world, pose_at, time_s, rng);
            for beam in &mut sweep.beams {
                beam.range = spoilt(faults, beam.time_s, beam.range);
            }
            return Seen::Sweep(sweep);
        }
        let mut scan = lidar.scan(world, &pose_at(time_s), rng).scan;
        spoil(faults, time_s, &mut scan);
        Seen::Scan(scan)
    }

    /// A revolution as the navigator takes it: as seen from the place of the last odometry.
    fn at_once(&mut self, sweep: &TimedScan) -> Scan {
        self.view.deskew(sweep, &self.odometry);
        self.view.to_scan(sweep.beams.len())
    }

    /// Where the vehicle truly is; where it believes to be, of one whose world is not simulated.
    fn pose(&self) -> Pose {
        if self.has_own_lidar {
            self.pose_source.pose()
        } else {
            self.carried.here(&self.vehicle.pose())
        }
    }

    /// Measures how well it stands at each stop but the last, once.
    fn note_stop(&mut self, mode: Mode) {
        let (stop, number) = self.navigator.stop();
        if mode == Mode::AtWaypoint && self.stop_errors.len() == number {
            let error = StopError::of(&self.pose(), stop);
            self.stop_errors.push(error);
        }
    }

    fn result(mut self) -> MissionResult {
        let plans = self.navigator.plans().to_vec();
        self.trace.paths = plans
            .iter()
            .map(|plan| plan.smoothed.points().to_vec())
            .collect();
        let rows = &self.trace.rows;
        let last = rows.last();
        let pose = last.map_or(self.mission.start, |row| row.pose);
        let step = |pair: &[TraceRow]| (pair[1].pose.position() - pair[0].pose.position()).norm();
        let error = StopError::of(&pose, &self.mission.goal);
        MissionResult {
            reached: last.is_some_and(|row| row.mode == Mode::Arrived || self.is_done(&row.pose)),
            collided: rows.iter().any(|row| row.gap_m <= 0.0),
            time_s: last.map_or(0.0, |row| row.time_s),
            travelled_m: rows
                .windows(2)
                .map(step)
                .fold(0.0, |sum, step_m| sum + step_m),
            min_clearance_m: rows
                .iter()
                .map(|row| row.gap_m)
                .fold(f64::INFINITY, f64::min),
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
