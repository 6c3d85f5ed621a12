//! Senses that lie, fail or say nothing.

use inbye::geometry::{Pose, Twist};
use inbye::navigator::{Fault, Mode, Observation};

use crate::Test;
use crate::script::{Script, straight};

pub const TESTS: &[Test] = &[
    (
        "numbers that are not finite stop it for good, with a fault",
        not_finite,
    ),
    (
        "ranges that are no measurement are no obstacle",
        no_measurement,
    ),
    ("a scan without beams changes nothing", no_beams),
    (
        "a false return is forgotten when it is seen through",
        seen_through,
    ),
];

/// Under way at some speed.
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
        |seen| seen.scan.angle_min = f64::NAN,
        |seen| seen.scan.angle_increment = 0.0,
        |seen| seen.scan.range_max = f64::NAN,
    ];
    for (number, put_in) in faults.iter().enumerate() {
        let mut script = under_way();
        let sound = script.observation.clone();
        let mut seen = sound.clone();
        put_in(&mut seen);
        let decision = script.navigator.step(&seen);
        assert_eq!(
            (decision.mode, decision.command),
            (Mode::Failed, Twist::STOP),
            "fault {number}"
        );
        let fault = script.navigator.fault().expect("it says why");
        assert_eq!(*fault, Fault::BadObservation);
        assert!(fault.to_string().starts_with("INVALID_OBSERVATION"));
        // It brakes on, and does not resume by itself.
        for _ in 0..30 {
            assert_eq!(script.step().mode, Mode::Failed);
        }
        assert_eq!(script.observation.twist, Twist::STOP);
    }
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
    for nonsense in [
        f64::NAN,
        f64::NEG_INFINITY,
        -1.0,
        -1e-300,
        10.000_001,
        1e300,
    ] {
        let poses = poses_with(|tick, seen| {
            for beam in (tick % 3..72).step_by(3) {
                seen.scan.ranges[beam] = nonsense;
            }
        });
        assert_eq!(poses, undisturbed, "{nonsense} was taken for an obstacle");
    }
    // A measurement in their place does change the drive.
    let disturbed = poses_with(|tick, seen| seen.scan.ranges[tick % 3] = 1.0);
    assert_ne!(disturbed, undisturbed);
}

fn no_beams() {
    let undisturbed = poses_with(|_, _| {});
    assert_eq!(poses_with(|_, seen| seen.scan.ranges.clear()), undisturbed);
    let nothing = poses_with(|_, seen| seen.scan = inbye::map::Scan::default());
    assert_eq!(nothing, undisturbed);
    // Marks made before stay, and nothing is read beyond the end.
    let mut script = under_way();
    script.observation.scan.ranges.fill(2.0);
    script.step();
    script.observation.scan = inbye::map::Scan::default();
    script.step();
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
    assert!(slowed < free, "the return was not minded: {slowed}, {free}");
    assert_eq!(script.navigator.fault(), None);
}
