//! What the simulated robot knows of where it is: dead reckoning that drifts, and fixes that correct it.

use inbye::base::Base;
use inbye::geometry::{Pose, Twist, wrap_angle};
use inbye::robot::{Limits, TrackedDrive};
use inbye::sim::{DriveDynamics, FixSource, Fixes, OdometryNoise, SimBase, Slip};

const DRIVE: TrackedDrive = TrackedDrive { track_width_m: 0.5 };

const START: Pose = Pose::new(3.0, -2.0, 0.7);

fn base(dynamics: DriveDynamics, noise: OdometryNoise, seed: u64) -> SimBase {
    SimBase::new(DRIVE, Limits::default(), dynamics, noise, START, seed).expect("valid settings")
}

/// Drives to and fro and round for a time, seconds.
fn wind(base: &mut SimBase, time_s: f64) {
    for tick in 0..(time_s / 0.05) as u32 {
        let time_s = 0.05 * f64::from(tick);
        let turn = 0.6 * libm::sin(0.7 * time_s);
        base.send(&Twist::new(0.6 + 0.3 * libm::sin(0.3 * time_s), turn))
            .expect("a finite command");
        base.step(0.05);
    }
}

/// Drives straight ahead, or stands, for a time, seconds.
fn go(base: &mut SimBase, speed: f64, time_s: f64) {
    for _ in 0..(time_s / 0.1) as u32 {
        base.send(&Twist::new(speed, 0.0))
            .expect("a finite command");
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
fn perfect_sensors_on_ground_without_slip_never_err() {
    let dynamics = DriveDynamics {
        slip: Slip::none(),
        ..DriveDynamics::default()
    };
    let mut base = base(dynamics, OdometryNoise::none(), 1);
    assert_eq!(base.odometry().pose, START);
    wind(&mut base, 120.0);
    let apart = base.odometry().pose.position() - base.pose().position();
    assert!(apart.norm() < 1e-9, "{apart}");
    assert!(yaw_error(&base).abs() < 1e-9);
    let way = (base.pose().position() - START.position()).norm();
    assert!(way > 1.0, "nothing was driven: {way}");
}

#[test]
fn slip_is_not_seen_and_turns_are() {
    let slip = Slip {
        mean: 0.1,
        wander: 0.0,
        ..Slip::default()
    };
    let dynamics = DriveDynamics {
        slip,
        ..DriveDynamics::default()
    };
    let mut base = base(dynamics, OdometryNoise::none(), 1);
    go(&mut base, 0.5, 20.0);
    let truth = (base.pose().position() - START.position()).norm();
    let believed = (base.odometry().pose.position() - START.position()).norm();
    assert!((truth - 0.9 * believed).abs() < 1e-9 && believed > 9.0);
    wind(&mut base, 60.0);
    assert!(yaw_error(&base).abs() < 1e-9);
}

/// Errors of the yaw of robots that stand for a minute, one for each seed.
fn standing_yaw_errors(noise: OdometryNoise) -> Vec<f64> {
    let error = |seed| {
        let mut base = base(DriveDynamics::default(), noise, seed);
        base.step(60.0);
        yaw_error(&base)
    };
    (0..400).map(error).collect()
}

#[test]
fn the_gyro_drifts_by_its_bias_and_walks_by_its_noise() {
    let biased = OdometryNoise {
        gyro_bias_sigma_rad_s: 0.002,
        ..OdometryNoise::none()
    };
    // A constant for a minute.
    let found = deviation(&standing_yaw_errors(biased));
    assert!((found - 0.12).abs() < 0.012, "{found}");
    let noisy = OdometryNoise {
        gyro_sigma_rad_s: 0.02,
        ..OdometryNoise::none()
    };
    // 6000 samples of 10 ms: 0.02 rad/s * 0.01 s * sqrt(6000).
    let found = deviation(&standing_yaw_errors(noisy));
    assert!((found - 0.015_49).abs() < 0.001_6, "{found}");
}

#[test]
fn a_gyro_of_coarse_bits_does_not_feel_less_than_half_a_bit() {
    let coarse = OdometryNoise {
        gyro_bit_rad_s: 0.1,
        ..OdometryNoise::none()
    };
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
fn scales_err_in_proportion_to_way_and_turn() {
    let scaled = OdometryNoise {
        travel_scale_sigma: 0.02,
        gyro_scale_sigma: 0.03,
        ..OdometryNoise::none()
    };
    let (mut ways, mut turns) = (Vec::new(), Vec::new());
    for seed in 0..400 {
        let mut base = base(DriveDynamics::ideal(), scaled, seed);
        go(&mut base, 1.0, 10.0);
        let truth = (base.pose().position() - START.position()).norm();
        let believed = (base.odometry().pose.position() - START.position()).norm();
        ways.push(believed / truth - 1.0);
        base.send(&Twist::new(0.0, 1.0)).unwrap();
        base.step(0.5);
        let turned = wrap_angle(base.pose().yaw - START.yaw);
        turns.push(wrap_angle(base.odometry().pose.yaw - START.yaw) / turned - 1.0);
    }
    let (way, turn) = (deviation(&ways), deviation(&turns));
    assert!((way - 0.02).abs() < 0.002, "{way}");
    assert!((turn - 0.03).abs() < 0.003, "{turn}");
}

#[test]
fn an_encoder_counts_whole_ticks_and_loses_none() {
    let coarse = OdometryNoise {
        encoder_tick_m: 0.05,
        ..OdometryNoise::none()
    };
    let ideal = DriveDynamics::ideal();
    let (mut base, start) = (base(ideal, coarse, 1), START.position());
    let mut steps = 0;
    let mut before = 0.0;
    for _ in 0..100 {
        go(&mut base, 0.2, 0.1);
        let counted = (base.odometry().pose.position() - start).norm();
        let truth = (base.pose().position() - start).norm();
        assert!(counted <= truth + 1e-9 && truth - counted < 0.05 + 1e-9);
        assert!((counted / 0.05 - (counted / 0.05).round()).abs() < 1e-6);
        steps += u32::from(counted > before + 1e-9);
        before = counted;
    }
    assert!((35..=40).contains(&steps), "{steps}");
}

/// How far off robots believe to be after a winding drive of two minutes by default, metres, root mean square.
#[test]
fn the_default_drift_is_some_percent_of_the_way() {
    let errors: Vec<f64> = (0..100)
        .map(|seed| {
            let mut base = base(DriveDynamics::default(), OdometryNoise::default(), seed);
            go(&mut base, 0.8, 60.0);
            let apart = base.odometry().pose.position() - base.pose().position();
            apart.norm() / (base.pose().position() - START.position()).norm()
        })
        .collect();
    let share = deviation(&errors);
    assert!((0.01..0.06).contains(&share), "{share}");
}

/// Errors of the fixes of a robot that stands, and how many came, in so many ticks of 50 ms.
fn fixes_of(fixes: Fixes, seed: u64, ticks: u32) -> Vec<[f64; 3]> {
    let mut source = FixSource::new(fixes, seed).expect("valid settings");
    let truth = Pose::new(4.0, 5.0, 3.1);
    (0..ticks)
        .filter_map(|tick| source.fix(0.05 * f64::from(tick), &truth))
        .map(|fix| {
            [
                fix.x - truth.x,
                fix.y - truth.y,
                wrap_angle(fix.yaw - truth.yaw),
            ]
        })
        .collect()
}

#[test]
fn fixes_come_at_their_rate_with_their_spread() {
    let fixes = Fixes {
        rate_hz: 4.0,
        sigma_m: 0.03,
        sigma_rad: 0.01,
        dropout: 0.0,
    };
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
fn a_share_of_the_fixes_does_not_come() {
    let fixes = Fixes {
        dropout: 0.3,
        ..Fixes::default()
    };
    let came = fixes_of(fixes, 3, 40_000).len() as f64 / 20_000.0;
    assert!((came - 0.7).abs() < 0.015, "{came}");
    let none = Fixes {
        dropout: 1.0,
        ..fixes
    };
    assert!(fixes_of(none, 3, 1000).is_empty());
    let never = Fixes {
        rate_hz: 0.0,
        ..fixes
    };
    assert!(fixes_of(never, 3, 1000).is_empty());
}

#[test]
fn fixes_faster_than_the_ticks_come_once_a_tick() {
    let fast = Fixes {
        rate_hz: 100.0,
        dropout: 0.0,
        ..Fixes::default()
    };
    assert_eq!(fixes_of(fast, 3, 500).len(), 500);
}

#[test]
fn the_same_seed_fixes_the_same_and_another_does_not() {
    let fixes = Fixes::default();
    assert_eq!(fixes_of(fixes, 3, 500), fixes_of(fixes, 3, 500));
    assert_ne!(fixes_of(fixes, 3, 500), fixes_of(fixes, 4, 500));
}

#[test]
fn bad_fixes_are_refused_by_name() {
    let (plain, bad) = (Fixes::default(), f64::NAN);
    for (fixes, name) in [
        (
            Fixes {
                rate_hz: bad,
                ..plain
            },
            "rate_hz",
        ),
        (
            Fixes {
                sigma_m: bad,
                ..plain
            },
            "sigma_m",
        ),
        (
            Fixes {
                sigma_rad: -0.1,
                ..plain
            },
            "sigma_rad",
        ),
        (
            Fixes {
                dropout: 1.1,
                ..plain
            },
            "dropout",
        ),
    ] {
        let error = FixSource::new(fixes, 0).unwrap_err().to_string();
        assert!(error.starts_with(name), "{error}");
    }
}
