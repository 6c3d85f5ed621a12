//! The faults of the matrix.

use core::f64::consts::{FRAC_PI_2, PI};

use super::drive::{Drive, End, FaultCase};
use super::faulty_engine::EngineFault;
use super::sites::{AT_S, door_that_closes, on_wrong_map, start_near_wall, trap};
use crate::experiment::ExperimentError;
use crate::geometry::Pose;
use crate::local::GpuFailureKind;
use crate::runtime::PoseSource;
use crate::sim::{FaultInjection, LidarChange, OdometryChange, WrongPlanner};

/// Another place in the roadways, more than ten metres away.
const ELSEWHERE: Pose = Pose { x: 20.0, y: 15.8, yaw: 0.3 };
/// Gap to an obstacle that appears ahead of the robot at speed, metres: it can just stop.
const AHEAD_M: f64 = 1.0;
/// The same for a robot that reacts or brakes later: 0.3 s of latency at 1 m/s, or 0.7 m/s^2.
const AHEAD_LATE_M: f64 = 1.3;
/// Gap to an obstacle ahead that a robot with scans of 2 s ago has not seen, metres.
const AHEAD_UNSEEN_M: f64 = 1.9;
/// Gap to the obstacles on all other sides, metres.
const BOX_GAP_M: f64 = 0.2;
/// Gap to an obstacle that appears next to the robot, metres: it nearly touches.
const TOUCHING_M: f64 = 0.01;
/// Half of a latency that no setting states, seconds: of the sensors, and of the base.
const HALF_LATENCY_S: f64 = 0.15;

/// Time until a fault of one scan or stamp is known, plus that of braking from 1 m/s at 1 m/s^2, seconds.
const KNOWN_AT_ONCE_S: f64 = 1.8;
/// The same for a stamp that is already too old when the fault begins.
const OLD_STAMP_S: f64 = 1.5;
/// The same for a fault that only a comparison of motions shows.
const BY_COMPARISON_S: f64 = 3.0;
/// The same for a pose that nothing corrects: it counts for a second.
const NO_FIX_S: f64 = 2.8;
/// The localizer detects within 3 s that the robot does not move. It finds the robot at the same place, so the robot tries again.
/// The third loss at one place is final.
const BOGGED_S: f64 = 9.0;
/// Time for which a wrong planner commands, seconds.
const WRONG_PLANNER_S: f64 = 60.0;

type Preparation = fn(&mut Drive) -> Result<(), ExperimentError>;

/// A fault after which the robot must stand within a time, seconds, and give up.
const fn stands(name: &'static str, limit_s: f64, prepare: Preparation) -> FaultCase {
    FaultCase { name, limit_s: Some(limit_s), end: End::Any, prepare }
}

/// A fault after which the robot may drive on.
const fn drives_on(name: &'static str, prepare: Preparation) -> FaultCase {
    FaultCase { name, limit_s: None, end: End::Any, prepare }
}

impl FaultCase {
    const fn with_reason(self, text: &'static str) -> Self {
        Self { end: End::Reason(text), ..self }
    }

    const fn without_contact(self) -> Self {
        Self { end: End::WithoutContact, ..self }
    }

    const fn at_goal(self) -> Self {
        Self { end: End::AtGoal, ..self }
    }
}

/// Every fault in simulation.
pub(super) fn cases() -> impl Iterator<Item = &'static FaultCase> {
    [LIDAR, POSE, SURROUNDINGS, PLANNER, PLANT].into_iter().flatten()
}

fn lidar(drive: &mut Drive, change: LidarChange) {
    drive.inject(FaultInjection::Lidar { from_s: AT_S, to_s: f64::INFINITY, change });
}

fn blind_sector(drive: &mut Drive, from_rad: f64, width_rad: f64) {
    let (from_s, to_s) = (AT_S, f64::INFINITY);
    drive.inject(FaultInjection::LidarSectorOccluded { from_s, to_s, from_rad, width_rad });
}

/// Faults of the odometry show only where nothing corrects it.
fn odometry(drive: &mut Drive, change: OdometryChange) {
    drive.config.simulation.fixes.rate_hz = 0.0;
    drive.inject(FaultInjection::Odometry { from_s: AT_S, to_s: f64::INFINITY, change });
}

fn clock_jump(drive: &mut Drive, by_s: f64) {
    drive.inject(FaultInjection::ClockJump { from_s: AT_S, to_s: f64::INFINITY, by_s });
}

/// Nothing ends such a drive but its time.
fn wrong_planner(drive: &mut Drive, planner: WrongPlanner) {
    drive.simulation.mission.time_limit_s = AT_S + WRONG_PLANNER_S;
    drive.inject(FaultInjection::WrongPlanner { from_s: AT_S, to_s: f64::INFINITY, planner });
}

const LIDAR: &[FaultCase] = &[
    stands("lidar sees no surface", KNOWN_AT_ONCE_S, |drive| {
        drive.inject(FaultInjection::LidarOccluded { from_s: AT_S, to_s: f64::INFINITY });
        Ok(())
    }),
    stands("lidar measures nothing", KNOWN_AT_ONCE_S, |drive| {
        drive.inject(FaultInjection::LidarSilent { from_s: AT_S, to_s: f64::INFINITY });
        Ok(())
    }),
    stands("lidar sends nothing", KNOWN_AT_ONCE_S, |drive| {
        lidar(drive, LidarChange::Stopped);
        Ok(())
    }),
    stands("lidar repeats a revolution", KNOWN_AT_ONCE_S, |drive| {
        drive.inject(FaultInjection::LidarFrozen { from_s: AT_S, to_s: f64::INFINITY });
        Ok(())
    }),
    drives_on("lidar is blind ahead", |drive| {
        blind_sector(drive, -0.8, 1.6);
        Ok(())
    }),
    drives_on("lidar is blind behind", |drive| {
        blind_sector(drive, 2.3, 1.6);
        Ok(())
    }),
    drives_on("lidar is blind on the left half", |drive| {
        blind_sector(drive, 0.0, PI);
        Ok(())
    }),
    drives_on("lidar measures with half of its beams", |drive| {
        lidar(drive, LidarChange::Dropout(0.5));
        Ok(())
    })
    .at_goal(),
    stands("lidar has negative ranges", KNOWN_AT_ONCE_S, |drive| {
        lidar(drive, LidarChange::Negative);
        Ok(())
    }),
    stands("scan has no beams", KNOWN_AT_ONCE_S, |drive| {
        lidar(drive, LidarChange::Empty);
        Ok(())
    }),
    drives_on("scan has a third of its beams", |drive| {
        lidar(drive, LidarChange::EveryNth(3));
        Ok(())
    })
    .at_goal(),
    drives_on("scan has half of its angle step", |drive| {
        drive.config.pose_source = PoseSource::Scans;
        lidar(drive, LidarChange::AngleScale(0.5));
        Ok(())
    }),
    stands("scans are 2 s old", OLD_STAMP_S, |drive| {
        lidar(drive, LidarChange::Late(2.0));
        Ok(())
    }),
    stands("scans are 2 s old and an obstacle appears 1.9 m ahead", OLD_STAMP_S, |drive| {
        lidar(drive, LidarChange::Late(2.0));
        drive.appearing.push((AHEAD_UNSEEN_M, 0.0));
        Ok(())
    }),
    stands("scans are 2 s from the future", OLD_STAMP_S, |drive| {
        lidar(drive, LidarChange::Ahead(2.0));
        Ok(())
    }),
    stands("sensors' clock jumps forwards by 5 s", OLD_STAMP_S, |drive| {
        clock_jump(drive, 5.0);
        Ok(())
    }),
    stands("sensors' clock jumps backwards by 5 s", OLD_STAMP_S, |drive| {
        clock_jump(drive, -5.0);
        Ok(())
    }),
    drives_on("dust returns a third of the beams for 5 s", |drive| {
        let change = LidarChange::Ghosts(0.3);
        drive.inject(FaultInjection::Lidar { from_s: AT_S, to_s: AT_S + 5.0, change });
        Ok(())
    })
    .at_goal(),
];

const POSE: &[FaultCase] = &[
    stands("odometry repeats a reading", BY_COMPARISON_S, |drive| {
        odometry(drive, OdometryChange::Frozen);
        Ok(())
    }),
    stands("odometry has the wrong sign", BY_COMPARISON_S, |drive| {
        odometry(drive, OdometryChange::Reversed);
        Ok(())
    }),
    stands("odometry is not finite", KNOWN_AT_ONCE_S, |drive| {
        odometry(drive, OdometryChange::NotFinite);
        Ok(())
    }),
    stands("odometry is 1 s old", OLD_STAMP_S, |drive| {
        odometry(drive, OdometryChange::Late(1.0));
        Ok(())
    }),
    drives_on("odometry jumps by 5 m", |drive| {
        odometry(drive, OdometryChange::Shifted(5.0));
        Ok(())
    }),
    stands("positioning repeats a pose", BY_COMPARISON_S, |drive| {
        drive.inject(FaultInjection::PoseFrozen { from_s: AT_S, to_s: f64::INFINITY });
        Ok(())
    }),
    stands("positioning has no fixes", NO_FIX_S, |drive| {
        drive.inject(FaultInjection::NoFixes { from_s: AT_S, to_s: f64::INFINITY });
        Ok(())
    }),
    drives_on("robot is carried away", |drive| {
        drive.config.pose_source = PoseSource::Scans;
        drive.inject(FaultInjection::Kidnapped { at_s: AT_S, to: ELSEWHERE });
        Ok(())
    }),
    stands("belts spin and the robot stands", BOGGED_S, |drive| {
        drive.config.pose_source = PoseSource::Scans;
        drive.stands_by_command = true;
        drive.inject(FaultInjection::Bogged { from_s: AT_S, to_s: f64::INFINITY });
        Ok(())
    }),
    drives_on("map is of another mine", |drive| {
        drive.config.pose_source = PoseSource::Scans;
        on_wrong_map(&mut drive.simulation, &drive.config);
        Ok(())
    })
    .with_reason("the robot is lost"),
];

const SURROUNDINGS: &[FaultCase] = &[
    drives_on("person appears 1 m ahead", |drive| {
        drive.appearing.push((AHEAD_M, 0.0));
        Ok(())
    }),
    drives_on("obstacle appears 1 cm beside the robot", |drive| {
        drive.appearing.push((TOUCHING_M, FRAC_PI_2));
        Ok(())
    }),
    drives_on("obstacles appear on all sides", |drive| {
        drive.appearing.extend([
            (AHEAD_M, 0.0),
            (BOX_GAP_M, FRAC_PI_2),
            (BOX_GAP_M, PI),
            (BOX_GAP_M, -FRAC_PI_2),
        ]);
        Ok(())
    }),
    drives_on("the only door closes", |drive| door_that_closes(&mut drive.simulation))
        .with_reason("NO_VALID_PATH"),
    drives_on("trap on the path that is not on the map", |drive| {
        trap(&mut drive.simulation, &drive.config)
    })
    .at_goal(),
    drives_on("start is nearer to a wall than a path may be", |drive| {
        start_near_wall(&mut drive.simulation, &drive.config);
        Ok(())
    })
    .at_goal(),
];

const PLANNER: &[FaultCase] = &[
    stands("decisions take 1 s", OLD_STAMP_S, |drive| {
        drive.config.navigator.deadline_s = Some(drive.config.local.control_period_s);
        drive.decision_s = 1.0;
        Ok(())
    }),
    drives_on("a search of paths takes 5 s", |drive| {
        drive.config.navigator.planning_budget_s = 5.0;
        drive.appearing.push((AHEAD_M, 0.0));
        Ok(())
    }),
    drives_on("a search of paths never ends", |drive| {
        drive.config.navigator.planning_budget_s = 10_000.0;
        drive.appearing.push((AHEAD_M, 0.0));
        Ok(())
    }),
    stands("commands are not finite", KNOWN_AT_ONCE_S, |drive| {
        wrong_planner(drive, WrongPlanner::NotFinite);
        Ok(())
    })
    .without_contact(),
    drives_on("commands are 1000 m/s", |drive| {
        wrong_planner(drive, WrongPlanner::TooFast);
        Ok(())
    })
    .without_contact(),
    drives_on("commands drive at walls", |drive| {
        wrong_planner(drive, WrongPlanner::Obstacles);
        Ok(())
    })
    .without_contact(),
    drives_on("commands drive at a person", |drive| {
        wrong_planner(drive, WrongPlanner::Obstacles);
        drive.appearing.push((AHEAD_UNSEEN_M, 0.0));
        Ok(())
    })
    .without_contact(),
    drives_on("commands are 10 s old", |drive| {
        wrong_planner(drive, WrongPlanner::Old);
        Ok(())
    })
    .without_contact(),
    stands("engine gives no answer and has no fallback", KNOWN_AT_ONCE_S, |drive| {
        drive.engine = Some((EngineFault::NoAnswer(GpuFailureKind::DeviceLost), false));
        Ok(())
    })
    .with_reason("gave no answer"),
    drives_on("GPU is lost", |drive| {
        drive.engine = Some((EngineFault::NoAnswer(GpuFailureKind::DeviceLost), true));
        Ok(())
    })
    .at_goal(),
    drives_on("GPU does not answer in time", |drive| {
        drive.engine = Some((EngineFault::NoAnswer(GpuFailureKind::TimedOut), true));
        Ok(())
    })
    .at_goal(),
    drives_on("GPU answers wrongly", |drive| {
        drive.engine = Some((EngineFault::WrongAnswer, true));
        Ok(())
    })
    .at_goal(),
];

const PLANT: &[FaultCase] = &[
    drives_on("person appears 1.3 m ahead, latency of 0.3 s is unknown", |drive| {
        let simulation = &mut drive.config.simulation;
        simulation.sensing_delay_s = HALF_LATENCY_S;
        simulation.stamps_sensing_delay = false;
        simulation.dynamics.command_delay_s = HALF_LATENCY_S;
        drive.appearing.push((AHEAD_LATE_M, 0.0));
        Ok(())
    }),
    drives_on("person appears 1.3 m ahead, brakes have 0.7 of their force", |drive| {
        drive.config.simulation.dynamics.braking_ratio = 0.7;
        drive.appearing.push((AHEAD_LATE_M, 0.0));
        Ok(())
    }),
    drives_on("person appears 1 m ahead, tracks slip by 0.3", |drive| {
        drive.config.simulation.dynamics.slip.mean = 0.3;
        drive.appearing.push((AHEAD_M, 0.0));
        Ok(())
    }),
    drives_on("base does not move", |drive| {
        drive.config.simulation.dynamics.deadband_m_s = 1.0;
        Ok(())
    })
    .with_reason("FAILED_TO_MAKE_PROGRESS"),
];
