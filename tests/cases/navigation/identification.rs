//! Identification of a base's response from its commands and its odometry, on simulated bases that differ from the model.

use std::collections::VecDeque;

use inbye::geometry::{Pose, Twist};
use inbye::robot::{Limits, MotionEstimate, MotionIdentifier, TrackedDrive};
use inbye::sim::{DriveDynamics, OdometryNoise, SimBase, Slip};

const PERIOD_S: f64 = 0.1;
const ASSUMED_S: f64 = 0.3;

/// A base that differs from the model of the identifier.
struct Plant {
    command_delay_s: f64,
    motor_lag_s: f64,
    /// Age of the odometry, seconds, and whether its stamp shows it.
    sensing_s: f64,
    is_stamped: bool,
    /// Shares of the nominal acceleration and braking.
    acceleration: f64,
    braking: f64,
    width_ratio: f64,
}

const NOMINAL: Plant = Plant {
    command_delay_s: 0.03,
    motor_lag_s: 0.05,
    sensing_s: 0.0,
    is_stamped: true,
    acceleration: 1.0,
    braking: 1.0,
    width_ratio: 1.0,
};

/// Commands as a navigator gives them: they change by at most the limits from tick to tick.
fn commanded(time_s: f64) -> Twist {
    let phase = time_s % 6.0;
    let linear = match phase {
        0.0..2.0 => (phase - 0.5).clamp(0.0, 0.8),
        2.0..4.0 => 0.8,
        _ => (0.8 - (phase - 4.0)).max(0.0),
    };
    let angular = if (2.0..3.0).contains(&phase) { (2.0 * (phase - 2.0)).min(0.6) } else { 0.0 };
    Twist::new(linear, angular)
}

/// Drives for a time; the estimate after each tick.
fn drive(plant: &Plant, drive_s: f64, command: impl Fn(f64) -> Twist) -> Vec<MotionEstimate> {
    let nominal = Limits::default();
    let limits = nominal
        .acc_lim_x(nominal.acc_lim_x * plant.acceleration)
        .decel_lim_x(nominal.decel_lim_x * plant.braking);
    let slip = Slip::none().width_ratio(plant.width_ratio);
    let dynamics = DriveDynamics::default()
        .command_delay_s(plant.command_delay_s)
        .motor_lag_s(plant.motor_lag_s)
        .slip(slip);
    let tracks = TrackedDrive { track_width_m: 0.45 };
    let noise = OdometryNoise::default();
    let base = SimBase::new(tracks, limits, dynamics, noise, Pose::default(), 7);
    let mut base = base.expect("valid settings");
    let mut identifier = MotionIdentifier::new(&nominal, ASSUMED_S);
    let steps = |seconds: f64| (seconds / 0.01).round() as usize;
    let mut readings = VecDeque::from(vec![Twist::STOP; steps(plant.sensing_s) + 1]);
    let mut estimates = Vec::new();
    for tick in 0..steps(drive_s) / 10 {
        let time_s = PERIOD_S * tick as f64;
        let measured = readings.front().copied().unwrap_or(Twist::STOP);
        let stamp_s = if plant.is_stamped { time_s - plant.sensing_s } else { time_s };
        identifier.observe(stamp_s, &measured);
        estimates.push(*identifier.estimate());
        let sent = command(time_s);
        identifier.command(time_s, &sent);
        base.send(&sent).expect("a finite command");
        for _ in 0..10 {
            base.step(0.01);
            readings.push_back(base.odometry().twist);
            readings.pop_front();
        }
    }
    estimates
}

fn last(plant: &Plant) -> MotionEstimate {
    *drive(plant, 12.0, commanded).last().expect("ticks")
}

#[test]
fn latency_is_identified_within_20_ms() {
    // The odometry averages the speed over 0.05 s, which delays it by half of that.
    let by_averaging_s = 0.025;
    for (command_delay_s, motor_lag_s, sensing_s) in [
        (0.0, 0.02, 0.0),
        (0.03, 0.05, 0.0),
        (0.15, 0.05, 0.0),
        (0.1, 0.05, 0.15),
        (0.3, 0.15, 0.0),
    ] {
        for is_stamped in [true, false] {
            let plant = Plant { command_delay_s, motor_lag_s, sensing_s, is_stamped, ..NOMINAL };
            let hidden_s = if is_stamped { 0.0 } else { sensing_s };
            let truth_s = command_delay_s + motor_lag_s + hidden_s + by_averaging_s;
            let estimate = last(&plant);
            let delay_s = estimate.delay_s.expect("an identified latency");
            assert!((delay_s.value - truth_s).abs() < 0.02, "{truth_s}: {estimate:?}");
            assert!((delay_s.low..=delay_s.high).contains(&truth_s), "{truth_s}: {estimate:?}");
            assert!(estimate.safe_delay_s >= truth_s - 0.005, "{truth_s}: {estimate:?}");
            assert!(estimate.safe_delay_s <= truth_s + 0.05, "{truth_s}: {estimate:?}");
            assert_eq!(
                (estimate.acceleration_m_s2, estimate.braking_m_s2),
                (1.0, 1.0),
                "{truth_s}: {estimate:?}"
            );
        }
    }
}

#[test]
fn latency_is_assumed_until_the_first_second_of_motion_shows_it() {
    let estimates = drive(&NOMINAL, 2.0, commanded);
    assert!(estimates[..5].iter().all(|one| one.safe_delay_s == ASSUMED_S), "{estimates:?}");
    assert!(estimates.iter().all(|one| one.safe_delay_s >= 0.1), "{estimates:?}");
    // The robot moves from 0.5 s on.
    let after = &estimates[15];
    assert!(after.safe_delay_s < 0.16 && after.delay_s.is_some(), "{after:?}");
}

#[test]
fn weak_braking_and_acceleration_are_identified() {
    for (acceleration, braking) in [(1.0, 0.7), (0.7, 1.0), (0.75, 0.85)] {
        let estimate = last(&Plant { acceleration, braking, ..NOMINAL });
        assert!((estimate.acceleration_m_s2 - acceleration).abs() < 0.08, "{estimate:?}");
        assert!((estimate.braking_m_s2 - braking).abs() < 0.08, "{estimate:?}");
        let limits = estimate.limits(&Limits::default());
        assert_eq!(limits.decel_lim_x, -estimate.braking_m_s2);
        let delay_s = estimate.delay_s.expect("an identified latency");
        assert!((delay_s.value - 0.105).abs() < 0.04, "{estimate:?}");
    }
}

#[test]
fn gentle_commands_do_not_show_the_limits() {
    // At a third of the limits, a weak base follows as well as a strong one.
    let gentle = |time_s: f64| Twist::new(0.4 - 0.4 * libm::cos(0.8 * time_s), 0.0);
    let estimate = *drive(&NOMINAL, 20.0, gentle).last().expect("ticks");
    assert_eq!((estimate.acceleration_m_s2, estimate.braking_m_s2), (1.0, 1.0), "{estimate:?}");
    assert!(estimate.delay_s.is_some_and(|it| it.low < 0.11 && it.high > 0.1), "{estimate:?}");
}

#[test]
fn uncalibrated_width_shows_in_the_turn_ratio() {
    for width_ratio in [1.0, 1.35, 1.8] {
        let estimate = last(&Plant { width_ratio, ..NOMINAL });
        let ratio = estimate.turn_ratio.expect("the robot turned");
        assert!((ratio.value - 1.0 / width_ratio).abs() < 0.04, "{width_ratio}: {estimate:?}");
        assert!((ratio.low..ratio.high).contains(&(1.0 / width_ratio)), "{estimate:?}");
    }
}

#[test]
fn standing_base_keeps_the_assumption_and_a_stuck_one_is_not_explained() {
    let estimate = *drive(&NOMINAL, 5.0, |_| Twist::STOP).last().expect("ticks");
    assert_eq!((estimate.safe_delay_s, estimate.delay_s), (ASSUMED_S, None));
    let mut identifier = MotionIdentifier::new(&Limits::default(), ASSUMED_S);
    for tick in 0..100 {
        let time_s = PERIOD_S * f64::from(tick);
        identifier.observe(time_s, &Twist::STOP);
        identifier.command(time_s, &commanded(time_s));
    }
    let estimate = identifier.estimate();
    assert!(estimate.unexplained > 20 && estimate.safe_delay_s >= ASSUMED_S, "{estimate:?}");
}

#[test]
fn values_that_are_not_finite_and_jumps_of_the_clock_are_harmless() {
    let mut identifier = MotionIdentifier::new(&Limits::default(), ASSUMED_S);
    for time_s in [0.0, f64::NAN, 1.0, 1e300, -1e300, f64::INFINITY, 2.0, 1e9, 1e9 + 0.1, 0.0] {
        for speed in [0.5, f64::NAN, f64::NEG_INFINITY, 1e300, -0.5] {
            identifier.command(time_s, &Twist::new(speed, speed));
            identifier.observe(time_s, &Twist::new(speed, -speed));
            let estimate = identifier.estimate();
            assert!(estimate.safe_delay_s.is_finite(), "{estimate:?}");
            assert!((0.4..=1.0).contains(&estimate.braking_m_s2), "{estimate:?}");
        }
    }
}
