//! Faulty observations.

use inbye::geometry::{Pose, Twist};
use inbye::localization::LostReason;
use inbye::map::ScanError;
use inbye::navigator::{Decision, Fault, Mode, Observation, ObservationFault};

use super::Test;
use super::script::{Script, straight};

pub const TESTS: &[Test] = &[
    ("numbers that are not finite brake the robot and fail the mission when they last", not_finite),
    ("scan in degrees brakes the robot and fails the mission when it lasts", degrees),
    ("old scan brakes the robot until there is a new one", old_scan),
    ("old odometry and an old pose brake the robot", old_odometry_and_pose),
    ("pose that jumps is rejected unless it stays", jumps),
    ("frozen pose fails the mission", frozen),
    ("pose that moves against the speed is a fault", reversed),
    ("clock jump costs one tick", clocks),
    ("invalid ranges are no obstacles", no_measurement),
    ("lost robot stands until it is localised", lost),
    ("scan without beams counts as none", no_beams),
    ("false return is cleared when a scan sees through it", seen_through),
];

/// A robot that drives.
fn under_way() -> Script {
    let mut script = straight();
    for _ in 0..20 {
        script.step();
    }
    assert!(script.observation.twist.linear > 0.3);
    script
}

fn not_finite() {
    let faults: [fn(&mut Observation); 9] = [
        |seen| seen.pose.x = f64::NAN,
        |seen| seen.pose.y = f64::INFINITY,
        |seen| seen.pose.yaw = f64::NAN,
        |seen| seen.twist.linear = f64::NAN,
        |seen| seen.twist.angular = f64::NEG_INFINITY,
        |seen| seen.time_s = f64::NAN,
        |seen| seen.scan_s = f64::INFINITY,
        |seen| seen.odometry_s = f64::NAN,
        |seen| seen.pose_s = f64::NEG_INFINITY,
    ];
    for (number, disturb) in faults.iter().enumerate() {
        drives_on_after_a_few_and_fails_after_many(ObservationFault::NotFinite, &|_, seen| {
            disturb(seen);
        })
        .unwrap_or_else(|what| panic!("fault {number}: {what}"));
    }
}

fn degrees() {
    let too_wide = ObservationFault::InvalidScan(ScanError::TooWide);
    drives_on_after_a_few_and_fails_after_many(too_wide, &|_, seen| {
        seen.scan.angle_increment = seen.scan.angle_increment.to_degrees();
    })
    .unwrap_or_else(|what| panic!("{what}"));
}

/// Changes an observation, given the number of the tick since the begin of the disturbance.
type Disturbance<'a> = &'a dyn Fn(u32, &mut Observation);

/// Drives with disturbed observations for a number of ticks; returns the decisions and the robot.
fn disturbed(ticks: u32, disturb: Disturbance<'_>) -> (Vec<Decision>, Script) {
    let mut script = under_way();
    let decisions = (0..ticks)
        .map(|tick| {
            let sound = script.observation.clone();
            disturb(tick, &mut script.observation);
            let seen = core::mem::replace(&mut script.observation, sound);
            script.step_on(&seen)
        })
        .collect();
    (decisions, script)
}

/// Checks that the robot brakes at each faulty tick and drives on after half a second, and that it fails after many ticks.
fn drives_on_after_a_few_and_fails_after_many(
    expected: ObservationFault,
    disturb: Disturbance<'_>,
) -> Result<(), String> {
    let (decisions, mut script) = disturbed(5, disturb);
    let mut speed = f64::INFINITY;
    for (tick, decision) in decisions.iter().enumerate() {
        if decision.mode != Mode::SensorFault || decision.command.linear.abs() >= speed {
            return Err(format!("{tick}: {decision:?} after {speed} m/s"));
        }
        speed = decision.command.linear.abs().max(f64::MIN_POSITIVE);
    }
    if script.navigator.observation_faults().get(&expected) != Some(&5) {
        return Err(format!("{:?}", script.navigator.observation_faults()));
    }
    script.finish(45.0);
    let (decisions, script) = disturbed(60, disturb);
    let last = decisions.last().map(|decision| (decision.mode, decision.command));
    let fault = script.navigator.fault();
    match (last, fault) {
        (
            Some((Mode::Failed, Twist::STOP)),
            Some(Fault::FaultyObservation { fault: found, count }),
        ) if *found == expected
            && *count == 31
            && fault.is_some_and(|fault| fault.to_string().starts_with("INVALID_OBSERVATION")) =>
        {
            Ok(())
        }
        _ => Err(format!("{last:?}, {fault:?}")),
    }
}

/// A robot without a known pose stands for as long as its patience lasts, and goes on when it is localised, also elsewhere.
fn lost() {
    let (decisions, mut script) =
        disturbed(100, &|_, seen| seen.lost = Some(LostReason::NoReturns));
    assert!(decisions.iter().all(|decision| decision.mode == Mode::SensorFault));
    assert_eq!(decisions[20].command, Twist::STOP);
    let fault = ObservationFault::Lost(LostReason::NoReturns);
    // The key of an object in the JSON of a drive.
    let counts = serde_json::to_value(script.navigator.observation_faults());
    assert_eq!(counts.expect("an object"), serde_json::json!({ "lost_no_returns": 100 }));
    assert_eq!(script.navigator.observation_faults().get(&fault), Some(&100));
    script.finish(45.0);
    let (decisions, script) = disturbed(310, &|_, seen| seen.lost = Some(LostReason::NoReturns));
    assert_eq!(decisions.last().map(|last| last.mode), Some(Mode::Failed));
    let fault = script.navigator.fault().map(ToString::to_string);
    assert_eq!(
        fault.unwrap_or_default(),
        "INVALID_OBSERVATION: the robot is lost: the lidar has no returns where the map shows walls, 301 times in a row; \
         the robot stops"
    );
}

fn old_scan() {
    // The first two ticks the last scan is not too old yet.
    let (decisions, mut script) =
        disturbed(8, &|tick, seen| seen.scan_s -= f64::from(tick + 1) * 0.1);
    for (tick, decision) in decisions.iter().enumerate() {
        assert_eq!(decision.mode == Mode::SensorFault, tick > 1, "{tick}");
    }
    assert_eq!(script.navigator.observation_faults().get(&ObservationFault::NoScan), Some(&6));
    script.finish(45.0);
    // A scan without a measurement counts as none.
    let (decisions, script) = disturbed(60, &|_, seen| seen.scan.ranges.fill(f64::NAN));
    assert_eq!(decisions[1].mode, Mode::Driving);
    assert_eq!(
        script.navigator.fault().map(ToString::to_string).unwrap_or_default().split(',').next(),
        Some("INVALID_OBSERVATION: there is no fresh scan with a measurement")
    );
}

/// A steadily late stream counts as late: the stamps decide, not the arrival.
fn old_odometry_and_pose() {
    drives_on_after_a_few_and_fails_after_many(ObservationFault::NoOdometry, &|_, seen| {
        seen.odometry_s -= 0.35;
    })
    .expect("late odometry");
    drives_on_after_a_few_and_fails_after_many(ObservationFault::NoPose, &|_, seen| {
        seen.pose_s -= 1.1;
    })
    .expect("a late pose");
    let (decisions, _) = disturbed(8, &|_, seen| {
        seen.odometry_s -= 0.25;
        seen.pose_s -= 0.9;
    });
    assert!(decisions.iter().all(|decision| decision.mode != Mode::SensorFault));
}

fn jumps() {
    let back_and_forth = |tick: u32, seen: &mut Observation| {
        seen.pose.y += if tick.is_multiple_of(2) { 3.0 } else { -3.0 };
    };
    drives_on_after_a_few_and_fails_after_many(ObservationFault::PoseJump, &back_and_forth)
        .expect("jumps");
    // A correction is no jump, and a place that stays is accepted.
    let (decisions, _) = disturbed(8, &|_, seen| seen.pose.y += 0.3);
    assert!(decisions.iter().all(|decision| decision.mode != Mode::SensorFault));
    let (decisions, _) = disturbed(8, &|_, seen| seen.pose.y += 3.2);
    let faulty = decisions.iter().filter(|decision| decision.mode == Mode::SensorFault);
    assert_eq!(faulty.count(), 4);
}

fn frozen() {
    let place = under_way().observation.pose;
    let (decisions, script) = disturbed(60, &|_, seen| seen.pose = place);
    let first = decisions.iter().position(|decision| decision.mode == Mode::SensorFault);
    assert_eq!(first, Some(6), "half a second after it stopped changing");
    assert_eq!(
        script.navigator.observation_faults().keys().collect::<Vec<_>>(),
        [&ObservationFault::PoseFrozen]
    );
    assert!(matches!(
        script.navigator.fault(),
        Some(Fault::FaultyObservation { fault: ObservationFault::PoseFrozen, .. })
    ));
    assert_eq!(script.observation.twist, Twist::STOP);
}

fn reversed() {
    let begin = under_way().observation.pose;
    let (_, script) = disturbed(60, &|_, seen| seen.pose.x = 2.0 * begin.x - seen.pose.x);
    assert!(script.navigator.observation_faults().contains_key(&ObservationFault::MotionReversed));
    let moved_m = script.observation.pose.position() - begin.position();
    assert!(moved_m.norm() < 1.5, "{moved_m:?}");
}

fn clocks() {
    // An hour forwards, once: one tick is lost.
    let (decisions, _) = disturbed(6, &|_, seen| {
        seen.time_s += 3600.0;
        seen.scan_s += 3600.0;
        seen.odometry_s += 3600.0;
        seen.pose_s += 3600.0;
    });
    let faulty: Vec<bool> =
        decisions.iter().map(|decision| decision.mode == Mode::SensorFault).collect();
    assert_eq!(faulty, [true, false, false, false, false, false]);
    drives_on_after_a_few_and_fails_after_many(ObservationFault::ClockJump, &|_, seen| {
        seen.scan_s += 1.0;
    })
    .expect("scans from the future");
    drives_on_after_a_few_and_fails_after_many(ObservationFault::ClockJump, &|_, seen| {
        seen.odometry_s += 1.0;
    })
    .expect("odometry from the future");
    // A localisation dates its transforms ahead.
    let (decisions, _) = disturbed(6, &|_, seen| seen.pose_s += 0.5);
    assert!(decisions.iter().all(|decision| decision.mode != Mode::SensorFault));
}

/// The poses of a drive with the scan changed at each tick.
fn poses_with(change: impl Fn(usize, &mut Observation)) -> Vec<Pose> {
    let mut script = straight();
    (0..150)
        .map(|tick| {
            change(tick, &mut script.observation);
            script.step();
            script.observation.pose
        })
        .collect()
}

fn no_measurement() {
    let undisturbed = poses_with(|_, _| {});
    for nonsense in [f64::NAN, f64::NEG_INFINITY, -1.0, -1e-300, 10.000_001, 1e300] {
        let poses = poses_with(|tick, seen| {
            for beam in (tick % 2..72).step_by(3) {
                seen.scan.ranges[beam] = nonsense;
            }
        });
        assert_eq!(poses, undisturbed, "{nonsense} counts as an obstacle");
    }
    // A measurement in their place does change the drive.
    let disturbed = poses_with(|tick, seen| seen.scan.ranges[tick % 3] = 1.0);
    assert_ne!(disturbed, undisturbed);
}

fn no_beams() {
    let undisturbed = poses_with(|_, _| {});
    // Within the timeout the robot drives on, and reads nothing beyond the end.
    let nothing = poses_with(|tick, seen| {
        if tick % 3 == 1 {
            seen.scan = inbye::map::Scan::default();
        } else {
            seen.scan = super::script::empty_scan();
        }
    });
    assert_eq!(nothing, undisturbed);
    let blind = poses_with(|_, seen| seen.scan.ranges.clear());
    assert_ne!(blind, undisturbed);
}

fn seen_through() {
    let mut script = under_way();
    let ahead_m = 1.0;
    for beam in [70, 71, 0, 1, 2] {
        script.observation.scan.ranges[beam] = ahead_m;
    }
    script.step();
    let slowed = script.step().command.linear;
    script.observation.scan.ranges.fill(f64::INFINITY);
    script.finish(45.0);
    let free = {
        let mut script = under_way();
        script.step();
        script.step().command.linear
    };
    assert!(slowed < free, "the robot ignored the return: {slowed}, {free}");
    assert_eq!(script.navigator.fault(), None);
}
