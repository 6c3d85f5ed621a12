//! What to do in a simulated world, and what came of it.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::control_loop::Simulation;
use super::{Config, OdometryReading, Robot, Trace, TraceRow};
use crate::geometry::{Pose, wrap_angle};
use crate::local::{Engine, Incidents, Sampling, TrajectoryFan};
use crate::localization::PoseEstimate;
use crate::map::{ObstacleGrid, OccupancyGrid};
use crate::navigator::{
    DeadlineStats, Decision, Fault, Goal, Navigator, Observation, ObservationFault,
};
use crate::sim::{FaultInjection, MovingObstacles, SimError};

/// What to do, and in which world.
#[derive(Clone, Debug)]
pub struct Mission {
    /// The map that the robot has.
    pub map: Arc<OccupancyGrid>,
    /// What truly stands there, where it differs from the map.
    pub truth: Option<ObstacleGrid>,
    /// Where the robot starts, standing.
    pub start: Pose,
    /// Stops on the way, in order.
    pub via: Vec<Goal>,
    /// Where it shall go in the end.
    pub goal: Goal,
    /// The moving obstacles.
    pub moving_obstacles: MovingObstacles,
    /// What befalls the robot.
    pub faults: Vec<FaultInjection>,
    /// Seed of all noise.
    pub seed: u64,
    /// The run ends after this long, seconds of simulated time.
    pub time_limit_s: f64,
    /// A run counts as done as soon as the robot truly is so near to its goal, metres, and not only when it stands there:
    /// as some benchmarks have it.
    pub done_within_m: Option<f64>,
}

impl Mission {
    /// From a start to a goal where the map is the truth and nothing moves, for at most an hour.
    #[must_use]
    pub fn new(map: Arc<OccupancyGrid>, start: Pose, goal: Goal) -> Self {
        Self {
            map,
            truth: None,
            start,
            via: Vec::new(),
            goal,
            moving_obstacles: MovingObstacles::default(),
            faults: Vec::new(),
            seed: 0,
            time_limit_s: 3600.0,
            done_within_m: None,
        }
    }

    /// All stops in order, the goal last.
    #[must_use]
    pub fn stops(&self) -> Vec<Goal> {
        self.via.iter().chain([&self.goal]).copied().collect()
    }
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
    /// True pose less the goal of each stop before, where the robot stood at it: along x and y, and the yaw where it was
    /// given.
    pub stop_errors: Vec<StopError>,
    /// What each decision took by the clock that was given, seconds; one for each tick.
    pub decision_s: Vec<f64>,
    /// Why the mission was given up, if it was.
    pub fault: Option<Fault>,
    /// What the decisions were computed on, to begin with.
    pub engine: String,
    /// How many observations were not believed, by why.
    pub observation_faults: BTreeMap<ObservationFault, u64>,
    /// What happened to an engine with a stand-in; none for one without.
    pub incidents: Option<Incidents>,
    /// Whether decisions came in time; none where there was no deadline.
    pub deadline_stats: Option<DeadlineStats>,
}

/// How far from a stop the robot truly stood.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StopError {
    /// Along x, metres.
    pub x_m: f64,
    /// Along y, metres.
    pub y_m: f64,
    /// Of the yaw, radians, where one was asked for.
    pub yaw_rad: Option<f64>,
}

impl StopError {
    /// Of a robot that stands at a pose, where it shall stand at a stop.
    #[must_use]
    pub fn of(pose: &Pose, stop: &Goal) -> Self {
        Self {
            x_m: pose.x - stop.position.x,
            y_m: pose.y - stop.position.y,
            yaw_rad: stop.yaw.map(|yaw| wrap_angle(pose.yaw - yaw)),
        }
    }
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

/// One tick: what was seen, decided and driven.
pub struct TickEvent<'a> {
    /// The truth, and what leaves the simulation.
    pub row: &'a TraceRow,
    /// What the robot saw.
    pub observation: &'a Observation,
    /// What its base knows of its own motion: the pose in the `odom` frame.
    pub odometry: &'a OdometryReading,
    /// What its localiser says of the pose, of a robot that has one.
    pub fix: Option<&'a PoseEstimate>,
    /// What it decided.
    pub decision: &'a Decision,
    /// How long that took by the observer's clock, seconds.
    pub took_s: f64,
    /// Radius of each moving obstacle, metres, in the order of [`TraceRow::moving`].
    pub moving_radii: &'a [f64],
    /// What was wrong with the base after it, for a base that can tell.
    pub trouble: Option<&'a str>,
    /// The navigator after it.
    pub navigator: &'a Navigator,
}

impl TickEvent<'_> {
    /// At most so many samples along each axis of the window that was decided on; none in a tick that needed no sampling.
    #[must_use]
    pub fn fan(&self, most: Sampling) -> Option<TrajectoryFan> {
        self.decision.counts.as_ref()?;
        self.navigator.planner().trajectory_fan(most)
    }
}

/// Time, and who is told what happens.
pub struct Observer<'a> {
    /// Wall clock, seconds; only differences are used, and nothing depends on it unless the navigator has a deadline.
    pub clock: &'a mut dyn FnMut() -> f64,
    /// Called after each tick: by progress bars and recorders. What it does changes nothing in the run.
    pub on_tick: &'a mut dyn FnMut(&TickEvent<'_>),
}

/// Runs a mission with a base of the caller's, which stands at the mission's start; also to the end that it sets itself.
///
/// # Errors
/// When the world cannot be built or there is no path to begin with.
pub fn run_mission(
    mission: &Mission,
    config: &Config,
    engine: Box<dyn Engine>,
    vehicle: &mut dyn Robot,
    observer: &mut Observer<'_>,
) -> Result<MissionResult, MissionError> {
    Ok(Simulation::new(mission, config, engine, vehicle, observer)?.run(observer))
}
