//! Pose sources of the simulated robot: drifting dead reckoning, and position fixes.

use inbye::geometry::{Pose, Twist, wrap_angle};
use inbye::robot::{Limits, TrackedDrive};
use inbye::sim::{DriveDynamics, FixSource, Fixes, OdometryNoise, SimBase, Slip};

const DRIVE: TrackedDrive = TrackedDrive { track_width_m: 0.5 };

const START: Pose = Pose::new(3.0, -2.0, 0.7);

fn base(dynamics: DriveDynamics, noise: OdometryNoise, seed: u64) -> SimBase {
    SimBase::new(DRIVE, Limits::default(), dynamics, noise, START, seed).expect("valid settings")
}

/// Drives a winding path for a time, seconds.
fn wind(base: &mut SimBase, time_s: f64) {
    for tick in 0..(time_s / 0.05) as u32 {
        let time_s = 0.05 * f64::from(tick);
        let turn = 0.6 * libm::sin(0.7 * time_s);
        base.send(&Twist::new(0.6 + 0.3 * libm::sin(0.3 * time_s), turn))
            .expect("a finite command");
        base.step(0.05);
    }
}

/// Drives straight ahead, or stands still, for a time, seconds.
fn drive_straight(base: &mut SimBase, speed: f64, time_s: f64) {
    for _ in 0..(time_s / 0.1) as u32 {
        base.send(&Twist::new(speed, 0.0)).expect("a finite command");
        base.step(0.1);
    }
}

fn deviation(errors: &[f64]) -> f64 {
    (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt()
}

fn yaw_error(base: &SimBase) -> f64 {
    wrap_angle(base.odometry().pose.yaw - base.pose().yaw)
}

#[test]
fn odometry_is_exact_without_noise_and_slip() {
    let dynamics = DriveDynamics::default().slip(Slip::none());
    let mut base = base(dynamics, OdometryNoise::none(), 1);
    assert_eq!(base.odometry().pose, START);
    wind(&mut base, 120.0);
    let apart = base.odometry().pose.position() - base.pose().position();
    assert!(apart.norm() < 1e-9, "{apart:?}");
    assert!(yaw_error(&base).abs() < 1e-9);
    let distance_m = (base.pose().position() - START.position()).norm();
    assert!(distance_m > 1.0, "the robot did not move: {distance_m}");
}

#[test]
fn odometry_misses_slip_and_measures_turns() {
    let slip = Slip::default().mean(0.1).variation(0.0);
    let dynamics = DriveDynamics::default().slip(slip);
    let mut base = base(dynamics, OdometryNoise::none(), 1);
    drive_straight(&mut base, 0.5, 20.0);
    let truth = (base.pose().position() - START.position()).norm();
    let estimated = (base.odometry().pose.position() - START.position()).norm();
    assert!((truth - 0.9 * estimated).abs() < 1e-9 && estimated > 9.0);
    wind(&mut base, 60.0);
    assert!(yaw_error(&base).abs() < 1e-9);
}

/// Yaw errors of robots that stand still for a minute, one for each seed.
fn standing_yaw_errors(noise: OdometryNoise) -> Vec<f64> {
    let error = |seed| {
        let mut base = base(DriveDynamics::default(), noise, seed);
        base.step(60.0);
        yaw_error(&base)
    };
    (0..400).map(error).collect()
}

#[test]
fn gyro_yaw_drifts_by_bias_and_noise() {
    let biased = OdometryNoise::none().gyro_bias_sigma_rad_s(0.002);
    // A constant for a minute.
    let found = deviation(&standing_yaw_errors(biased));
    assert!((found - 0.12).abs() < 0.012, "{found}");
    let noisy = OdometryNoise::none().gyro_sigma_rad_s(0.02);
    // 6000 samples of 10 ms: 0.02 rad/s * 0.01 s * sqrt(6000).
    let found = deviation(&standing_yaw_errors(noisy));
    assert!((found - 0.015_49).abs() < 0.001_6, "{found}");
}

#[test]
fn gyro_resolution_hides_rates_below_half_a_bit() {
    let coarse = OdometryNoise::none().gyro_bit_rad_s(0.1);
    let mut base = base(DriveDynamics::ideal(), coarse, 1);
    base.send(&Twist::new(0.0, 0.049)).unwrap();
    base.step(0.4);
    assert!(base.pose().yaw > START.yaw + 0.01);
    assert_eq!(base.odometry().pose.yaw, START.yaw);
    base.send(&Twist::new(0.0, 0.051)).unwrap();
    base.step(0.4);
    assert_eq!(base.odometry().twist.angular, 0.1);
}

#[test]
fn scale_errors_grow_with_distance_and_turn() {
    let scaled = OdometryNoise::none().travel_scale_sigma(0.02).gyro_scale_sigma(0.03);
    let (mut distances, mut turns) = (Vec::new(), Vec::new());
    for seed in 0..400 {
        let mut base = base(DriveDynamics::ideal(), scaled, seed);
        drive_straight(&mut base, 1.0, 10.0);
        let truth = (base.pose().position() - START.position()).norm();
        let estimated = (base.odometry().pose.position() - START.position()).norm();
        distances.push(estimated / truth - 1.0);
        base.send(&Twist::new(0.0, 1.0)).unwrap();
        base.step(0.5);
        let turned = wrap_angle(base.pose().yaw - START.yaw);
        turns.push(wrap_angle(base.odometry().pose.yaw - START.yaw) / turned - 1.0);
    }
    let (distance, turn) = (deviation(&distances), deviation(&turns));
    assert!((distance - 0.02).abs() < 0.002, "{distance}");
    assert!((turn - 0.03).abs() < 0.003, "{turn}");
}

#[test]
fn encoder_counts_whole_ticks_without_loss() {
    let coarse = OdometryNoise::none().encoder_tick_m(0.05);
    let ideal = DriveDynamics::ideal();
    let (mut base, start) = (base(ideal, coarse, 1), START.position());
    let mut steps = 0;
    let mut before = 0.0;
    for _ in 0..100 {
        drive_straight(&mut base, 0.2, 0.1);
        let counted = (base.odometry().pose.position() - start).norm();
        let truth = (base.pose().position() - start).norm();
        assert!(counted <= truth + 1e-9 && truth - counted < 0.05 + 1e-9);
        assert!((counted / 0.05 - (counted / 0.05).round()).abs() < 1e-6);
        steps += u32::from(counted > before + 1e-9);
        before = counted;
    }
    assert!((35..=40).contains(&steps), "{steps}");
}

/// Root mean square position error of default robots after a drive of one minute, relative to the distance.
#[test]
fn default_drift_is_a_few_percent_of_the_distance() {
    let errors: Vec<f64> = (0..100)
        .map(|seed| {
            let mut base = base(DriveDynamics::default(), OdometryNoise::default(), seed);
            drive_straight(&mut base, 0.8, 60.0);
            let apart = base.odometry().pose.position() - base.pose().position();
            apart.norm() / (base.pose().position() - START.position()).norm()
        })
        .collect();
    let fraction = deviation(&errors);
    assert!((0.01..0.06).contains(&fraction), "{fraction}");
}

/// Errors of the fixes that a standing robot receives during `ticks` ticks of 50 ms.
fn fixes_of(fixes: Fixes, seed: u64, ticks: u32) -> Vec<[f64; 3]> {
    let mut source = FixSource::new(fixes, seed).expect("valid settings");
    let truth = Pose::new(4.0, 5.0, 3.1);
    (0..ticks)
        .filter_map(|tick| source.fix(0.05 * f64::from(tick), &truth))
        .map(|fix| [fix.x - truth.x, fix.y - truth.y, wrap_angle(fix.yaw - truth.yaw)])
        .collect()
}

#[test]
fn fixes_have_the_configured_rate_and_deviation() {
    let fixes = Fixes::default().rate_hz(4.0).sigma_m(0.03).sigma_rad(0.01).dropout(0.0);
    let errors = fixes_of(fixes, 3, 40_000);
    assert_eq!(errors.len(), 8000, "four in each of 2000 s");
    for (axis, sigma) in [(0, 0.03), (1, 0.03), (2, 0.01)] {
        let errors: Vec<f64> = errors.iter().map(|error| error[axis]).collect();
        let found = deviation(&errors);
        assert!((found / sigma - 1.0).abs() < 0.04, "{axis}: {found}");
        let mean = errors.iter().sum::<f64>() / 8000.0;
        assert!(mean.abs() < 0.05 * sigma, "{axis}: {mean}");
    }
}

#[test]
fn fix_dropout_omits_the_configured_fraction() {
    let fixes = Fixes::default().dropout(0.3);
    let received = fixes_of(fixes, 3, 40_000).len() as f64 / 20_000.0;
    assert!((received - 0.7).abs() < 0.015, "{received}");
    let none = fixes.dropout(1.0);
    assert!(fixes_of(none, 3, 1000).is_empty());
    let never = fixes.rate_hz(0.0);
    assert!(fixes_of(never, 3, 1000).is_empty());
}

#[test]
fn fixes_are_limited_to_one_per_tick() {
    let fast = Fixes::default().rate_hz(100.0).dropout(0.0);
    assert_eq!(fixes_of(fast, 3, 500).len(), 500);
}

#[test]
fn fixes_depend_on_the_seed_only() {
    let fixes = Fixes::default();
    assert_eq!(fixes_of(fixes, 3, 500), fixes_of(fixes, 3, 500));
    assert_ne!(fixes_of(fixes, 3, 500), fixes_of(fixes, 4, 500));
}

#[test]
fn fix_source_rejects_bad_settings_by_name() {
    let (plain, bad) = (Fixes::default(), f64::NAN);
    for (fixes, name) in [
        (plain.rate_hz(bad), "rate_hz"),
        (plain.sigma_m(bad), "sigma_m"),
        (plain.sigma_rad(-0.1), "sigma_rad"),
        (plain.dropout(1.1), "dropout"),
    ] {
        let error = FixSource::new(fixes, 0).unwrap_err().to_string();
        assert!(error.starts_with(name), "{error}");
    }
}
