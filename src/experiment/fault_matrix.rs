//! The fault matrix: each fault is injected while the robot drives at speed. The robot must stand in time, or drive on without
//! contact.

use core::cell::Cell;
use core::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::outcome::outcome;
use super::{ContactCause, ExperimentError, RunOutcome};
use crate::bench::columns::columns;
use crate::geometry::{Point, Pose};
use crate::local::CpuEngine;
use crate::navigator::Goal;
use crate::runtime::{Config, Mission, Observer, PoseSource, TickEvent, TraceRow};
use crate::sim::{
    FaultInjection, MovingObstacle, MovingObstacles, OdometryChange, SimError, Simulation,
    SpawnTrigger, roadway,
};

/// Begin of each fault, seconds: the robot has its cruising speed.
const AT_S: f64 = 6.0;
/// Duration of a drive, seconds. The navigator gives up earlier.
const TIME_LIMIT_S: f64 = 60.0;
/// Speed and turn rate below which a robot stands, m/s and rad/s.
const STANDING: f64 = 0.02;
/// Another place in the scene, more than ten metres away.
const ELSEWHERE: Pose = Pose { x: 20.0, y: 15.8, yaw: 0.3 };
/// Radius of an obstacle that appears, metres.
const BODY_RADIUS_M: f64 = 0.3;
/// Gap to an obstacle that appears ahead of the robot at speed, metres: it can just stop.
const AHEAD_M: f64 = 1.0;
/// Gap to the obstacles on all other sides, metres.
const BOX_GAP_M: f64 = 0.2;
/// Step of the search for a place with a gap, metres.
const STEP_M: f64 = 0.005;

columns! {
    /// What a robot did after a fault.
    #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
    pub struct FaultRow {
        /// Name of the fault.
        pub fault: String,
        /// `simulation`, or the protocol of an emulated serial line.
        pub place: String,
        /// Number of drives.
        pub runs: usize,
        /// Longest time from the fault until the robot stood for good, seconds; none where it drove on.
        pub stood_s: Option<f64> => 2,
        /// Time within which it must stand or park, seconds; none where it may drive on.
        pub limit_s: Option<f64> => 2,
        /// Least true gap to anything after the fault, metres; none where it was not measured.
        pub min_gap_m: Option<f64> => 3,
        /// Number of contacts that the robot caused.
        pub contacts_robot: usize,
        /// True distance to the goal at the end, metres; none where the robot need not reach it.
        pub final_error_m: Option<f64> => 4,
        /// True difference to the yaw of the goal at the end, radians; none without one.
        pub final_yaw_error_rad: Option<f64> => 4,
        /// Time from the first pose near the goal to the end of a mission without a fault, seconds; none with one.
        pub parking_s: Option<f64> => 1,
        /// Whether every drive met the requirement.
        pub passed: bool,
        /// The reason of the last drive that did not reach its goal.
        pub reason: Option<String>,
    }
}

impl FaultRow {
    /// The row of a fault before any drive.
    #[must_use]
    pub fn new(fault: &str, place: &str) -> Self {
        Self { fault: fault.to_owned(), place: place.to_owned(), ..Self::default() }
    }
}

/// A fault of the matrix.
#[derive(Clone, Copy, Debug)]
struct FaultCase {
    name: &'static str,
    /// Time within which the robot must stand, seconds; none where it may drive on.
    limit_s: Option<f64>,
    kind: Kind,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    /// Faults of a sensor.
    Injected(fn() -> FaultInjection),
    /// The robot is moved to the other end of the map, localized by scans.
    Kidnapped,
    /// Each decision takes this long from the fault on, seconds, with a deadline of one control period.
    LateDecisions(f64),
    /// A person appears at this distance ahead of the robot, metres.
    PersonAhead(f64),
    /// Obstacles appear on all sides of the robot.
    BoxedIn,
}

const fn lidar(fault: fn() -> FaultInjection) -> Kind {
    Kind::Injected(fault)
}

fn odometry(change: OdometryChange) -> FaultInjection {
    FaultInjection::Odometry { from_s: AT_S, to_s: f64::INFINITY, change }
}

fn sector(from_rad: f64, width_rad: f64) -> FaultInjection {
    FaultInjection::LidarSectorOccluded { from_s: AT_S, to_s: f64::INFINITY, from_rad, width_rad }
}

/// Every fault in simulation. A limit is the time until the fault is known plus that of braking from 1 m/s at 1 m/s^2.
const CASES: [FaultCase; 14] = [
    FaultCase {
        name: "lidar sees no surface",
        limit_s: Some(1.8),
        kind: lidar(|| FaultInjection::LidarOccluded { from_s: AT_S, to_s: f64::INFINITY }),
    },
    FaultCase {
        name: "lidar is silent",
        limit_s: Some(1.8),
        kind: lidar(|| FaultInjection::LidarSilent { from_s: AT_S, to_s: f64::INFINITY }),
    },
    FaultCase {
        name: "lidar repeats a revolution",
        limit_s: Some(1.8),
        kind: lidar(|| FaultInjection::LidarFrozen { from_s: AT_S, to_s: f64::INFINITY }),
    },
    FaultCase { name: "lidar is blind ahead", limit_s: None, kind: lidar(|| sector(-0.8, 1.6)) },
    FaultCase { name: "lidar is blind behind", limit_s: None, kind: lidar(|| sector(2.3, 1.6)) },
    FaultCase {
        name: "odometry repeats a reading",
        limit_s: Some(3.0),
        kind: Kind::Injected(|| odometry(OdometryChange::Frozen)),
    },
    FaultCase {
        name: "odometry has the wrong sign",
        limit_s: Some(3.0),
        kind: Kind::Injected(|| odometry(OdometryChange::Reversed)),
    },
    FaultCase {
        name: "odometry is not finite",
        limit_s: Some(1.8),
        kind: Kind::Injected(|| odometry(OdometryChange::NotFinite)),
    },
    FaultCase {
        name: "odometry is 1 s old",
        limit_s: Some(1.5),
        kind: Kind::Injected(|| odometry(OdometryChange::Late(1.0))),
    },
    FaultCase {
        name: "odometry jumps by 5 m",
        limit_s: None,
        kind: Kind::Injected(|| odometry(OdometryChange::Shifted(5.0))),
    },
    FaultCase { name: "robot is carried away", limit_s: None, kind: Kind::Kidnapped },
    FaultCase { name: "decisions take 1 s", limit_s: Some(1.5), kind: Kind::LateDecisions(1.0) },
    FaultCase { name: "person appears 1 m ahead", limit_s: None, kind: Kind::PersonAhead(AHEAD_M) },
    FaultCase { name: "obstacles appear on all sides", limit_s: None, kind: Kind::BoxedIn },
];

/// Drives every case with these seeds. `progress` is called after each drive.
///
/// # Errors
/// [`ExperimentError`] when a drive cannot start.
pub fn simulated_faults(
    seeds: &[u64],
    mut progress: impl FnMut(),
) -> Result<Vec<FaultRow>, ExperimentError> {
    let mut rows = Vec::new();
    for case in &CASES {
        let mut row = FaultRow {
            limit_s: case.limit_s,
            passed: true,
            ..FaultRow::new(case.name, "simulation")
        };
        for &seed in seeds {
            case.drive(seed, &mut row)?;
            progress();
        }
        rows.push(row);
    }
    Ok(rows)
}

/// Number of drives for each seed.
#[must_use]
pub const fn simulated_fault_count() -> usize {
    CASES.len()
}

impl FaultCase {
    /// Drives with a seed, and adds the drive to the row.
    fn drive(&self, seed: u64, row: &mut FaultRow) -> Result<(), ExperimentError> {
        let (mut config, mut simulation) = (Config::default(), mission(seed));
        let mut late_s = 0.0;
        match self.kind {
            Kind::Injected(fault) => {
                // Faults of the odometry show only where nothing corrects it.
                let fault = fault();
                if matches!(fault, FaultInjection::Odometry { .. }) {
                    config.simulation.fixes.rate_hz = 0.0;
                }
                simulation.faults.push(fault);
            }
            Kind::Kidnapped => {
                config.pose_source = PoseSource::Scans;
                simulation.faults.push(FaultInjection::Kidnapped { at_s: AT_S, to: ELSEWHERE });
            }
            Kind::LateDecisions(took_s) => {
                config.navigator.deadline_s = Some(config.local.control_period_s);
                late_s = took_s;
            }
            Kind::PersonAhead(gap_m) => {
                appear_around(&mut simulation, &config, &[(gap_m, 0.0)])?;
            }
            Kind::BoxedIn => {
                let sides = [
                    (AHEAD_M, 0.0),
                    (BOX_GAP_M, FRAC_PI_2),
                    (BOX_GAP_M, PI),
                    (BOX_GAP_M, -FRAC_PI_2),
                ];
                appear_around(&mut simulation, &config, &sides)?;
            }
        }
        let (time_s, mut now_s, mut is_end) = (Cell::new(0.0), 0.0, true);
        // It is read at the begin and at the end of each decision.
        let mut clock = || {
            is_end = !is_end;
            now_s += if is_end && time_s.get() >= AT_S { late_s } else { 0.0 };
            now_s
        };
        let mut on_tick = |event: &TickEvent<'_>| time_s.set(event.row.time_s);
        let mut observer = Observer { clock: &mut clock, on_tick: &mut on_tick };
        let engine = Box::new(CpuEngine::single_threaded());
        let result = simulation.run(&config, engine, &mut observer)?;
        let (ended, cause, reason) = outcome(&simulation, &config, &result);
        let rows = &result.trace.rows;
        let moves = |row: &&TraceRow| {
            row.twist.linear.abs() >= STANDING || row.twist.angular.abs() >= STANDING
        };
        let last_s = rows.iter().rev().find(moves).map_or(0.0, |row| row.time_s);
        let stood_s = (last_s + config.local.control_period_s - AT_S).max(0.0);
        let after = rows.iter().filter(|row| row.time_s >= AT_S);
        let gap_m = after.map(|row| row.gap_m).fold(f64::INFINITY, f64::min);
        let is_robot = ended == RunOutcome::Contact && cause == Some(ContactCause::Robot);
        row.runs += 1;
        row.contacts_robot += usize::from(is_robot);
        if let Some(limit_s) = self.limit_s {
            row.stood_s = Some(row.stood_s.map_or(stood_s, |longest_s| longest_s.max(stood_s)));
            row.passed &= stood_s <= limit_s;
        }
        row.min_gap_m = Some(row.min_gap_m.map_or(gap_m, |least_m| least_m.min(gap_m)));
        row.passed &= !is_robot;
        row.reason = reason.or(row.reason.take());
        Ok(())
    }
}

/// A drive through the scene of the mine's roadways.
fn mission(seed: u64) -> Simulation {
    let scene = roadway();
    let goal = Goal { position: scene.goal, yaw: None };
    let mission = Mission {
        time_limit_s: TIME_LIMIT_S,
        ..Mission::new(Arc::new(scene.map), scene.start, goal)
    };
    Simulation { seed, ..Simulation::new(mission) }
}

/// Lets standing obstacles appear around the robot at the time of the fault, each at a gap, metres, to its outline in a direction
/// of its frame, radians.
fn appear_around(
    simulation: &mut Simulation,
    config: &Config,
    sides: &[(f64, f64)],
) -> Result<(), SimError> {
    let mut no_clock = || 0.0;
    let mut observer = Observer { clock: &mut no_clock, on_tick: &mut |_| {} };
    let engine = Box::new(CpuEngine::single_threaded());
    let undisturbed = simulation.run(config, engine, &mut observer)?;
    let rows = &undisturbed.trace.rows;
    let robot =
        rows.iter().find(|row| row.time_s >= AT_S).map_or(simulation.mission.start, |row| row.pose);
    let footprint = &config.robot.footprint;
    let body = |&(gap_m, direction): &(f64, f64)| {
        let (sin, cos) = libm::sincos(direction);
        // From the outline outwards, until the gap is as wanted.
        let at = |away_m: f64| robot.transform(&Point::new(away_m * cos, away_m * sin));
        let gap_at = |away_m| footprint.gap_to_disc_m(&robot, &at(away_m), BODY_RADIUS_M);
        let mut away_m = 0.0;
        while gap_at(away_m) < gap_m {
            away_m += STEP_M;
        }
        let stands = MovingObstacle::patrol(BODY_RADIUS_M, 0.0, vec![at(away_m)])?;
        stands.yielding(false).spawned_by(SpawnTrigger::AtTime(AT_S))
    };
    let bodies: Vec<MovingObstacle> = sides.iter().map(body).collect::<Result<_, _>>()?;
    simulation.moving_obstacles = MovingObstacles::new(bodies);
    Ok(())
}
