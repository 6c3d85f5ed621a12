//! One drive and its figures.

use serde::Serialize;

use super::{Course, Deviation, Traffic};
use crate::bench::paper::PaperError;
use crate::geometry::Pose;
use crate::local::CpuEngine;
use crate::robot::Footprint;
use crate::runtime::{Config, MissionResult, Observer, Trace, TraceRow};
use crate::sim::Simulation;

/// Somebody nearer than this was met, metres between the robot's edge and theirs.
pub const MET_WITHIN_M: f64 = 1.5;
/// Slower than this the robot stands: m/s, and rad/s.
const STANDS_BELOW: f64 = 0.01;

/// The figures of one drive. The same seed gives the same ones on any machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DriveRun {
    /// The scene's name.
    pub scene: String,
    /// Seed of the people and of the noise.
    pub seed: u64,
    /// Whether the robot stood at its goal in the end, as far as it knows.
    pub reached: bool,
    /// Whether it touched anything: the drive ends there.
    pub collided: bool,
    /// The true final pose against the goal's.
    pub deviation: Deviation,
    /// Time to the end, simulated seconds.
    pub time_s: f64,
    /// Way driven, metres.
    pub travelled_m: f64,
    /// Length of the path that it set out with, metres.
    pub path_length_m: f64,
    /// Smallest gap to anything solid, metres.
    pub min_clearance_m: f64,
    /// Smallest gap to anybody, metres; missing where nobody is about.
    pub nearest_person_m: Option<f64>,
    /// Global plans, the first one counted.
    pub plans: usize,
    /// Share of the time for which it stood still.
    pub waited_share: f64,
    /// The longest time for which it stood still, seconds.
    pub longest_wait_s: f64,
    /// Its speed at the end, m/s: in a contact that of the robot, which may have been standing.
    pub final_speed_m_s: f64,
    /// Why it gave up, if it did.
    pub fault: Option<String>,
    /// A digest of every tick.
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
    /// Drives once through a course, on this thread, its samples evaluated on this one core.
    ///
    /// # Errors
    /// [`PaperError::Drive`] when the drive cannot begin.
    pub fn new(
        course: &Course,
        traffic: Traffic,
        seed: u64,
        config: &Config,
    ) -> Result<Self, PaperError> {
        let simulation = course.simulation(traffic, seed, config)?;
        let engine = Box::new(CpuEngine::single_threaded());
        let mut observer = Observer {
            clock: &mut || 0.0,
            on_tick: &mut |_| {},
        };
        let result = simulation
            .run(config, engine, &mut observer)
            .map_err(|error| course.failed(seed, &error))?;
        Ok(Self {
            run: DriveRun::of(course, &simulation, &result, config),
            trace: result.trace,
        })
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
            reached: result.reached,
            collided: result.collided,
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

    /// How it ended, in a word or two.
    #[must_use]
    pub const fn ending(&self) -> &'static str {
        match (self.collided, self.reached) {
            (true, _) => "contact",
            (false, true) => "reached",
            (false, false) => "not reached",
        }
    }

    /// Whether the robot still moved at the end: one that stood was touched, and did not touch.
    #[must_use]
    pub const fn was_moving(&self) -> bool {
        self.final_speed_m_s >= STANDS_BELOW
    }

    /// Whether somebody came within [`MET_WITHIN_M`].
    #[must_use]
    pub fn met_somebody(&self) -> bool {
        self.nearest_person_m
            .is_some_and(|gap_m| gap_m <= MET_WITHIN_M)
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

/// The share of ticks for which the robot stood, and the longest stretch of them in seconds.
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
    (
        stood as f64 / rows.len().max(1) as f64,
        longest.unwrap_or(0) as f64 * period_s,
    )
}
