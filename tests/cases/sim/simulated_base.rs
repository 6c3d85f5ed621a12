//! The simulated base against its limits and equations of motion.

use core::f64::consts::TAU;

use inbye::base::BaseError;
use inbye::geometry::{Pose, Twist};
use inbye::robot::{Limits, TrackedDrive};
use inbye::sim::{DriveDynamics, OdometryNoise, SimBase, Slip};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

const DRIVE: TrackedDrive = TrackedDrive { track_width_m: 0.5 };

fn limits() -> Limits {
    Limits::default()
        .min_vel_x(-0.3)
        .max_vel_x(1.0)
        .max_vel_theta(0.8)
        .acc_lim_x(0.5)
        .decel_lim_x(-1.5)
        .acc_lim_theta(1.0)
        .decel_lim_theta(-2.0)
}

fn base_with(dynamics: DriveDynamics, noise: OdometryNoise, seed: u64) -> SimBase {
    SimBase::new(DRIVE, limits(), dynamics, noise, Pose::default(), seed).expect("valid settings")
}

/// A base with motor lag, commands without delay, and ground without slip.
fn base() -> SimBase {
    let lagging = DriveDynamics::ideal().motor_lag_s(0.05);
    base_with(lagging, OdometryNoise::none(), 0)
}

/// Repeats a command for a time, seconds.
fn repeat_command(base: &mut SimBase, command: Twist, time_s: f64) {
    let sends = (time_s / 0.1).ceil();
    for _ in 0..sends as u32 {
        base.send(&command).expect("a finite command");
        base.step(time_s / sends);
    }
}

#[test]
fn base_stays_within_limits_for_random_commands() {
    let mut rng = Pcg64Mcg::seed_from_u64(21);
    let mut base = base();
    let mut before = base.twist();
    for _ in 0..20_000 {
        if rng.random_bool(0.1) {
            let command = Twist::new(rng.random_range(-5.0..5.0), rng.random_range(-5.0..5.0));
            base.send(&command).unwrap();
        }
        let time_s = 0.01;
        base.step(time_s);
        let now = base.twist();
        let change = (now.linear - before.linear) / time_s;
        let turn_change = (now.angular - before.angular) / time_s;
        assert!(change.abs() <= 1.5 + 1e-9 && turn_change.abs() <= 2.0 + 1e-9);
        assert!(now.linear >= -0.3 - 1e-9 && now.linear <= 1.0 + 1e-9);
        assert!(now.angular.abs() <= 0.8 + 1e-9);
        before = now;
    }
}

#[test]
fn acceleration_and_braking_have_separate_limits() {
    let mut rng = Pcg64Mcg::seed_from_u64(22);
    let mut base = base();
    let mut before = base.twist().linear;
    let (mut gain, mut brake) = (0.0, 0.0);
    for _ in 0..20_000 {
        if rng.random_bool(0.02) {
            base.send(&Twist::new(rng.random_range(0.0..2.0), 0.0)).unwrap();
        }
        base.step(0.01);
        let change = (base.twist().linear - before) / 0.01;
        before = base.twist().linear;
        gain = change.max(gain);
        brake = change.min(brake);
    }
    assert!((0.49..=0.5 + 1e-9).contains(&gain), "{gain}");
    assert!((-1.5 - 1e-9..=-1.49).contains(&brake), "{brake}");
}

#[test]
fn ramp_is_followed_with_configured_lag() {
    let mut base = base();
    base.send(&Twist::new(1.0, 0.0)).unwrap();
    base.step(0.5);
    // A first-order lag trails a ramp by its time constant times the slope: 0.25 m/s minus 0.05 s times 0.5 m/s^2.
    assert!((base.twist().linear - 0.225).abs() < 0.003, "{:?}", base.twist());
    // The sensors give the mean over their last 10 ms, which is the value of 5 ms ago.
    let measured = base.odometry().twist.linear;
    assert!((base.twist().linear - 0.005 * 0.5 - measured).abs() < 1e-4);
}

#[test]
fn belt_within_the_deadband_stands() {
    for (speed, moves) in [(0.019, false), (0.021, true)] {
        let dynamics = DriveDynamics::ideal().deadband_m_s(0.02);
        let (drive, noise) = (TrackedDrive { track_width_m: 0.5 }, OdometryNoise::none());
        let (limits, start) = (Limits::default(), Pose::default());
        let mut base = SimBase::new(drive, limits, dynamics, noise, start, 0).unwrap();
        repeat_command(&mut base, Twist::new(speed, 0.0), 1.0);
        assert_eq!(base.pose().x > 0.0, moves, "{speed} m/s");
        // A rotation in place needs that speed at each belt.
        let mut base = SimBase::new(drive, limits, dynamics, noise, start, 0).unwrap();
        repeat_command(&mut base, Twist::new(0.0, speed / 0.25), 1.0);
        assert_eq!(base.pose().yaw > 0.0, moves, "{} rad/s", speed / 0.25);
    }
}

#[test]
fn steady_turn_closes_its_circle() {
    let mut base = base();
    let turn = Twist::new(0.6, 0.5);
    repeat_command(&mut base, turn, 10.0);
    let from = *base.pose();
    repeat_command(&mut base, turn, TAU / 0.5);
    let moved = base.pose().position() - from.position();
    assert!(moved.norm() < 1e-9, "{moved:?}");
}

#[test]
fn base_rejects_non_finite_commands_without_effect() {
    let (mut commanded, mut idle) = (base(), base());
    for command in [Twist::new(f64::NAN, 0.0), Twist::new(0.5, f64::INFINITY)] {
        assert!(matches!(commanded.send(&command), Err(BaseError::NotFinite { .. })));
    }
    commanded.step(0.3);
    idle.step(0.3);
    assert_eq!(commanded.pose(), idle.pose());
}

#[test]
fn base_brakes_after_command_timeout() {
    let mut base = base();
    base.send(&Twist::new(0.5, 0.3)).unwrap();
    base.step(0.5);
    assert!(base.twist().linear > 0.2);
    base.step(2.0);
    assert!(base.twist().linear.abs() < 1e-6 && base.twist().angular.abs() < 1e-6);
}

#[test]
fn command_acts_exactly_after_its_delay() {
    // The delay is no multiple of the sub-step, and longer than the time between two commands.
    let delay_s = 0.1337;
    let mut base =
        base_with(DriveDynamics::ideal().command_delay_s(delay_s), OdometryNoise::none(), 0);
    // The command is 0.4 m/s for 0.1 s, then zero: the ramp rises at 0.5 m/s^2 for 0.1 s and falls at 1.5 m/s^2.
    let expected = |time_s: f64| {
        let since = time_s - delay_s;
        if since <= 0.1 { (0.5 * since).max(0.0) } else { (0.05 - 1.5 * (since - 0.1)).max(0.0) }
    };
    base.send(&Twist::new(0.4, 0.0)).unwrap();
    for tick in 1..=60 {
        base.step(0.005);
        let time_s = 0.005 * f64::from(tick);
        let speed = base.twist().linear;
        assert!((speed - expected(time_s)).abs() < 1e-9, "{speed} at {time_s} s");
        if tick == 20 {
            base.send(&Twist::STOP).unwrap();
        }
    }
}

#[test]
fn later_of_two_simultaneous_commands_counts() {
    let mut base = base_with(DriveDynamics::default(), OdometryNoise::none(), 0);
    base.send(&Twist::new(1.0, 0.0)).unwrap();
    base.send(&Twist::new(-0.2, 0.0)).unwrap();
    base.step(0.5);
    assert!(base.twist().linear < -0.1);
}

#[test]
fn steady_slip_and_width_scale_speed_and_turn_rate() {
    let slip =
        Slip::default().mean(0.1).width_ratio(1.6).calibrated_width_ratio(1.2).variation(0.0);
    let dynamics = DriveDynamics::default().slip(slip);
    let mut base = base_with(dynamics, OdometryNoise::none(), 0);
    repeat_command(&mut base, Twist::new(0.6, 0.4), 8.0);
    let truth = base.twist();
    assert!((truth.linear - 0.6 * 0.9).abs() < 1e-9, "{truth:?}");
    assert!((truth.angular - 0.4 * 0.9 * 1.2 / 1.6).abs() < 1e-9, "{truth:?}");
    // The controller sets the belts by its calibrated width. The encoders measure the belts, the gyro the true turn.
    let tracks = base.track_speeds();
    assert!((tracks.right - tracks.left - 0.4 * 0.5 * 1.2).abs() < 1e-9);
    let measured = base.odometry().twist;
    assert!((measured.linear - 0.6).abs() < 1e-9);
    assert!((measured.angular - truth.angular).abs() < 1e-9);
}

/// Returns true speed and turn rate divided by the commanded ones, for each metre of a steady drive.
fn ground_ratios(variation: f64, seed: u64) -> Vec<[f64; 2]> {
    let slip = Slip::default()
        .mean(0.05)
        .width_ratio(1.5)
        .calibrated_width_ratio(1.5)
        .variation(variation)
        .variation_length_m(2.0);
    let dynamics = DriveDynamics::ideal().slip(slip);
    let mut base = base_with(dynamics, OdometryNoise::none(), seed);
    let command = Twist::new(1.0, 0.5);
    repeat_command(&mut base, command, 5.0);
    let sample = |_| {
        repeat_command(&mut base, command, 1.0);
        let truth = base.twist();
        [truth.linear, truth.angular / 0.5]
    };
    (0..4000).map(sample).collect()
}

#[test]
fn slip_variation_has_configured_deviation_and_length() {
    let ratios = ground_ratios(0.03, 5);
    let count = ratios.len() as f64;
    let slip: Vec<f64> = ratios.iter().map(|[speed, _]| 1.0 - speed).collect();
    let width: Vec<f64> = ratios.iter().map(|[speed, turn]| speed / turn).collect();
    for (varying, mean) in [(slip, 0.05), (width, 1.0)] {
        let found = varying.iter().sum::<f64>() / count;
        assert!((found - mean).abs() < 0.005, "{found} for {mean}");
        let covariance = |apart: usize| {
            let pairs = varying.iter().zip(&varying[apart..]);
            pairs.map(|(a, b)| (a - found) * (b - found)).sum::<f64>() / count
        };
        let deviation = covariance(0).sqrt();
        assert!((deviation - 0.03).abs() < 0.004, "{deviation}");
        // After 2 m the correlation has fallen to 1/e.
        let kept = covariance(2) / covariance(0);
        assert!((kept - 0.368).abs() < 0.08, "{kept}");
    }
}

#[test]
fn slip_without_variation_is_equal_for_every_seed() {
    assert_eq!(ground_ratios(0.0, 1), ground_ratios(0.0, 2));
    assert_ne!(ground_ratios(0.01, 1), ground_ratios(0.01, 2));
}

#[test]
fn drive_depends_on_the_seed() {
    let run = |seed| {
        let mut base = base_with(DriveDynamics::default(), OdometryNoise::default(), seed);
        let mut states = Vec::new();
        for tick in 0..200 {
            let turn = 0.4 * libm::sin(0.1 * f64::from(tick));
            repeat_command(&mut base, Twist::new(0.5, turn), 0.05);
            states.push((*base.pose(), base.twist(), base.odometry()));
        }
        states
    };
    assert_eq!(run(7), run(7));
    let (one, other) = (run(7), run(8));
    assert_ne!(one[199].0, other[199].0);
    assert_ne!(one[199].2, other[199].2);
}

#[test]
fn base_rejects_bad_settings_by_name() {
    let message = |limits, dynamics, noise| {
        SimBase::new(DRIVE, limits, dynamics, noise, Pose::default(), 0).unwrap_err().to_string()
    };
    let plain = DriveDynamics::default();
    let lag = plain.motor_lag_s(f64::NAN);
    let early = plain.command_delay_s(-0.1);
    let slipping = |slip| plain.slip(slip);
    let lossy = slipping(Slip::default().mean(1.0));
    let varying = slipping(Slip::default().variation(0.3));
    let noise = OdometryNoise::default();
    for (dynamics, words) in [
        (lag, "motor_lag_s is NaN"),
        (early, "command_delay_s is -0.1"),
        (lossy, "[slip] mean is 1"),
        (varying, "[slip] variation is 0.3"),
    ] {
        let error = message(limits(), dynamics, noise);
        assert!(error.starts_with(words), "{error}");
    }
    let slow = limits().acc_lim_x(0.0);
    let error = message(slow, plain, noise);
    assert!(error.starts_with("acc_lim_x is 0"), "{error}");
    let coarse = noise.encoder_tick_m(f64::INFINITY);
    let error = message(limits(), plain, coarse);
    assert!(error.starts_with("encoder_tick_m is inf"), "{error}");
}
