//! A closed loop: the navigator in a simulated world, tick by tick, to the goal.

use std::sync::Arc;

use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use super::{Config, SimBase, SimError, Trace, TraceRow, Walkers, World};
use crate::base::Base;
use crate::geometry::{Point, Pose, wrap_angle};
use crate::local::{Engine, LocalPlanner};
use crate::map::{MovingDisc, ObstacleGrid, OccupancyGrid};
use crate::navigator::{Fault, Goal, Journey, Mode, Navigator, Observation};

/// What to do, and in which world.
#[derive(Clone, Debug)]
pub struct Mission {
    /// The map that the robot has.
    pub map: Arc<OccupancyGrid>,
    /// What truly stands there, where it differs from the map.
    pub truth: Option<ObstacleGrid>,
    /// Where the robot starts, standing.
    pub start: Pose,
    /// Where it shall go.
    pub goal: Goal,
    /// The moving obstacles.
    pub walkers: Walkers,
    /// Seed of the lidar's noise.
    pub seed: u64,
    /// The run ends after this long, seconds of simulated time.
    pub time_limit_s: f64,
}

/// How a mission ended.
#[derive(Clone, Debug)]
pub struct MissionResult {
    /// Every tick.
    pub trace: Trace,
    /// Every global plan, in order.
    pub plans: Vec<crate::global::Plan>,
    /// Whether the robot stood at its goal at the end.
    pub reached: bool,
    /// Whether it touched anything on the way.
    pub collided: bool,
    /// Simulated time, seconds.
    pub time_s: f64,
    /// Way driven, metres.
    pub travelled_m: f64,
    /// Smallest gap on the way, metres.
    pub min_clearance_m: f64,
    /// Final pose less goal, along x and y.
    pub final_error_m: (f64, f64),
    /// Final yaw less the goal's, where it has one.
    pub final_yaw_error: Option<f64>,
    /// What each decision took by the clock that was given, seconds; one for each tick.
    pub decision_s: Vec<f64>,
    /// Why the mission was given up, if it was.
    pub fault: Option<Fault>,
    /// What the decisions were computed on.
    pub engine: String,
}

/// What kept a mission from starting.
#[derive(Debug, thiserror::Error)]
pub enum MissionError {
    /// The world could not be built.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// The navigator could not start.
    #[error(transparent)]
    Fault(#[from] Fault),
}

/// Time and what to tell of it: `clock` in seconds, `progress` after each tick with simulated time and way left.
pub struct Observer<'a> {
    /// Wall clock, seconds; only differences are used, and no decision depends on it.
    pub clock: &'a mut dyn FnMut() -> f64,
    /// Called after each tick.
    pub progress: &'a mut dyn FnMut(&TraceRow),
}

/// Runs a mission to its end: the goal, contact, a fault or the time limit.
///
/// # Errors
/// When the world cannot be built or there is no path to begin with.
pub fn run_mission(
    mission: &Mission,
    config: &Config,
    engine: Box<dyn Engine>,
    observer: &mut Observer<'_>,
) -> Result<MissionResult, MissionError> {
    Ok(Simulation::new(mission, config, engine, observer)?.run(observer))
}

struct Simulation<'a> {
    mission: &'a Mission,
    config: &'a Config,
    world: World,
    walkers: Walkers,
    base: SimBase,
    navigator: Navigator,
    lidar_noise: Pcg64Mcg,
    trace: Trace,
    decision_s: Vec<f64>,
    engine: String,
}

impl<'a> Simulation<'a> {
    fn new(
        mission: &'a Mission,
        config: &'a Config,
        engine: Box<dyn Engine>,
        observer: &mut Observer<'_>,
    ) -> Result<Self, MissionError> {
        config.validate()?;
        let known = mission.map.obstacles(config.unknown);
        let truth = mission.truth.clone().unwrap_or_else(|| known.clone());
        let robot = config.robot.model();
        let route_planner = config.route_planner(known.frame().resolution_m);
        let planner = LocalPlanner::new(engine, config.local.clone());
        let engine = planner.engine_name();
        let navigator = Navigator::new(
            known,
            Journey {
                start: mission.start.position(),
                goal: mission.goal,
            },
            robot,
            planner,
            route_planner,
            config.navigator.clone(),
            observer.clock,
        )?;
        let base = SimBase::new(
            config.robot.drive(),
            config.robot.limits,
            config.dynamics,
            config.odometry,
            mission.start,
            mission.seed,
        )?;
        Ok(Self {
            mission,
            config,
            world: World::new(truth),
            walkers: mission.walkers.clone(),
            base,
            navigator,
            lidar_noise: Pcg64Mcg::seed_from_u64(mission.seed),
            trace: Trace {
                moving_radii: mission.walkers.radii(),
                ..Trace::default()
            },
            decision_s: Vec::new(),
            engine,
        })
    }

    fn run(mut self, observer: &mut Observer<'_>) -> MissionResult {
        let period_s = self.config.local.control_period_s;
        let ticks = (self.mission.time_limit_s / period_s).ceil() as u64;
        for tick in 0..ticks {
            let row = self.tick(tick as f64 * period_s, observer);
            (observer.progress)(&row);
            let over = matches!(row.mode, Mode::Arrived | Mode::Failed) || row.gap_m <= 0.0;
            self.trace.rows.push(row);
            if over {
                break;
            }
        }
        self.result()
    }

    /// Look, decide, record, move: in this order.
    fn tick(&mut self, time_s: f64, observer: &mut Observer<'_>) -> TraceRow {
        let observation = self.observe(time_s);
        let began = (observer.clock)();
        let decision = self.navigator.step(&observation);
        self.decision_s.push((observer.clock)() - began);
        let counts = decision.counts.unwrap_or_default();
        let footprint = &self.config.robot.footprint;
        let row = TraceRow {
            time_s,
            pose: *self.base.pose(),
            twist: self.base.twist(),
            command: decision.command,
            local_target: decision.local_target,
            gap_m: self.world.gap_m(footprint, self.base.pose()),
            admissible: counts.admissible,
            samples: counts.to_array().iter().sum(),
            mode: decision.mode,
            path: self.navigator.plans().len() - 1,
            moving: self
                .walkers
                .places()
                .iter()
                .map(|place| place.as_ref().map(MovingDisc::center))
                .collect(),
        };
        // The simulated base refuses only commands that are not finite, and the navigator sends none.
        let sent = self.base.send(&decision.command);
        debug_assert!(sent.is_ok());
        let period_s = self.config.local.control_period_s;
        self.base.step(period_s);
        self.walkers.step(period_s, self.base.pose(), footprint);
        row
    }

    fn observe(&mut self, time_s: f64) -> Observation {
        self.world.moving = self.walkers.discs();
        let pose = *self.base.pose();
        let seen = self
            .config
            .lidar
            .scan(&self.world, &pose, &mut self.lidar_noise);
        let moving = seen
            .visible
            .iter()
            .map(|&index| self.world.moving[index])
            .collect();
        Observation {
            time_s,
            pose,
            twist: self.base.twist(),
            scan: seen.scan,
            moving,
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
        let goal: Point = self.mission.goal.position;
        MissionResult {
            reached: last.is_some_and(|row| row.mode == Mode::Arrived),
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
            final_error_m: (pose.x - goal.x, pose.y - goal.y),
            final_yaw_error: self.mission.goal.yaw.map(|yaw| wrap_angle(pose.yaw - yaw)),
            fault: self.navigator.fault().cloned(),
            decision_s: self.decision_s,
            engine: self.engine,
            plans,
            trace: self.trace,
        }
    }
}
