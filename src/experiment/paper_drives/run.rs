//! One drive and its figures.

use serde::Serialize;

use super::{Course, Deviation};
use crate::bench::paper::PaperError;
use crate::experiment::outcome::outcome;
use crate::experiment::{RunOutcome, TrafficKind};
use crate::geometry::Pose;
use crate::local::CpuEngine;
use crate::robot::Footprint;
use crate::runtime::{Config, MissionResult, Observer, Trace, TraceRow};
use crate::sim::Simulation;

/// A person closer than this counts as near, metres between both edges.
pub const MET_WITHIN_M: f64 = 1.5;
/// Below this speed the robot stands: m/s and rad/s.
const STANDS_BELOW: f64 = 0.01;

/// The figures of one drive. The same seed gives the same figures on any machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DriveRun {
    /// The scene's name.
    pub scene: String,
    /// Seed of the people and of the noise.
    pub seed: u64,
    /// How the drive ended.
    pub outcome: RunOutcome,
    /// Deviation of the true final pose from the goal's.
    pub deviation: Deviation,
    /// Time to the end, simulated seconds.
    pub time_s: f64,
    /// Distance driven, metres.
    pub travelled_m: f64,
    /// Length of the first global path, metres.
    pub path_length_m: f64,
    /// Smallest gap to any obstacle, metres.
    pub min_clearance_m: f64,
    /// Smallest gap to a person, metres; none without people.
    pub nearest_person_m: Option<f64>,
    /// Number of global plans.
    pub plans: usize,
    /// Share of the time in which the robot stood.
    pub waited_share: f64,
    /// The longest time in which it stood, seconds.
    pub longest_wait_s: f64,
    /// The robot's speed at the end, m/s.
    pub final_speed_m_s: f64,
    /// Why the navigator gave up, if it did.
    pub fault: Option<String>,
    /// Digest of the trace.
    pub trace_digest: String,
}

/// One drive.
#[derive(Clone, Debug)]
pub struct Drive {
    /// Its figures.
    pub run: DriveRun,
    /// Every tick.
    pub trace: Trace,
}

impl Drive {
    /// Drives once through a course, on one thread.
    ///
    /// # Errors
    /// [`PaperError::Drive`] when the drive cannot start.
    pub fn new(
        course: &Course,
        traffic: TrafficKind,
        seed: u64,
        config: &Config,
    ) -> Result<Self, PaperError> {
        let simulation = course.simulation(traffic, seed, config)?;
        let engine = Box::new(CpuEngine::single_threaded());
        let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
        let result = simulation
            .run(config, engine, &mut observer)
            .map_err(|error| course.failed(seed, &error))?;
        Ok(Self { run: DriveRun::of(course, &simulation, &result, config), trace: result.trace })
    }
}

impl DriveRun {
    fn of(
        course: &Course,
        simulation: &Simulation,
        result: &MissionResult,
        config: &Config,
    ) -> Self {
        let trace = &result.trace;
        let last = trace.rows.last();
        let (position, yaw) = (course.goal.position, course.goal.yaw);
        let goal = Pose::new(position.x, position.y, yaw.unwrap_or_default());
        let pose = last.map_or(simulation.mission.start, |row| row.pose);
        let (waited_share, longest_wait_s) = waits(&trace.rows, config.local.control_period_s);
        Self {
            scene: course.name.clone(),
            seed: simulation.seed,
            outcome: outcome(simulation, config, result).0,
            deviation: Deviation::between(&pose, &goal, &course.start),
            time_s: result.time_s,
            travelled_m: result.travelled_m,
            path_length_m: course.plan.smoothed.length_m(),
            min_clearance_m: result.min_clearance_m,
            nearest_person_m: nearest_person_m(trace, &config.robot.footprint),
            plans: result.plans.len(),
            waited_share,
            longest_wait_s,
            final_speed_m_s: last.map_or(0.0, |row| row.twist.linear.abs()),
            fault: result.fault.as_ref().map(ToString::to_string),
            trace_digest: trace.digest(),
        }
    }

    /// Whether the drive reached its goal.
    #[must_use]
    pub fn reached(&self) -> bool {
        self.outcome == RunOutcome::Reached
    }

    /// Whether the drive ended in contact.
    #[must_use]
    pub fn collided(&self) -> bool {
        self.outcome == RunOutcome::Contact
    }

    /// Whether the robot moved at the end. If it stood, the other one moved.
    #[must_use]
    pub const fn was_moving(&self) -> bool {
        self.final_speed_m_s >= STANDS_BELOW
    }

    /// Whether a person came within [`MET_WITHIN_M`].
    #[must_use]
    pub fn is_near_person(&self) -> bool {
        self.nearest_person_m.is_some_and(|gap_m| gap_m <= MET_WITHIN_M)
    }
}

fn nearest_person_m(trace: &Trace, footprint: &Footprint) -> Option<f64> {
    let gaps = trace.rows.iter().flat_map(|row| {
        let people = row.moving.iter().zip(&trace.moving_radii);
        people.filter_map(|(center, &radius_m)| {
            Some(footprint.gap_to_disc_m(&row.pose, center.as_ref()?, radius_m))
        })
    });
    gaps.reduce(f64::min)
}

/// The share of ticks in which the robot stood, and the longest sequence of them in seconds.
fn waits(rows: &[TraceRow], period_s: f64) -> (f64, f64) {
    let stands = |row: &TraceRow| {
        row.twist.linear.abs() < STANDS_BELOW && row.twist.angular.abs() < STANDS_BELOW
    };
    let stood = rows.iter().filter(|row| stands(row)).count();
    let longest = rows
        .chunk_by(|a, b| stands(a) == stands(b))
        .filter(|stretch| stretch.first().is_some_and(stands))
        .map(<[TraceRow]>::len)
        .max();
    (stood as f64 / rows.len().max(1) as f64, longest.unwrap_or(0) as f64 * period_s)
}
