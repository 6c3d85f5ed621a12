//! The simulated base: it obeys its limits, and moves as the equations say.

use core::f64::consts::TAU;

use inbye::base::{Base, BaseError};
use inbye::geometry::{Pose, Twist};
use inbye::robot::{Limits, TrackedDrive};
use inbye::sim::{DriveDynamics, SimBase};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

const DRIVE: TrackedDrive = TrackedDrive { track_width_m: 0.5 };

const LIMITS: Limits = Limits {
    min_vel_x: -0.3,
    max_vel_x: 1.0,
    max_vel_theta: 0.8,
    acc_lim_x: 0.5,
    decel_lim_x: -1.5,
    acc_lim_theta: 1.0,
    decel_lim_theta: -2.0,
};

fn base() -> SimBase {
    SimBase::new(DRIVE, LIMITS, DriveDynamics::default(), Pose::default()).expect("valid settings")
}

#[test]
fn the_base_never_exceeds_its_limits_whatever_it_is_told() {
    let mut rng = Pcg64Mcg::seed_from_u64(21);
    let mut base = base();
    let mut before = base.twist();
    for _ in 0..20_000 {
        if rng.random_bool(0.1) {
            let wild = Twist::new(rng.random_range(-5.0..5.0), rng.random_range(-5.0..5.0));
            base.send(&wild).unwrap();
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
fn going_forward_gains_and_brakes_each_have_their_own_limit() {
    let mut rng = Pcg64Mcg::seed_from_u64(22);
    let mut base = base();
    let mut before = base.twist().linear;
    let (mut gain, mut brake) = (0.0, 0.0);
    for _ in 0..20_000 {
        if rng.random_bool(0.02) {
            base.send(&Twist::new(rng.random_range(0.0..2.0), 0.0))
                .unwrap();
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
fn a_ramp_is_followed_with_the_stated_lag() {
    let mut base = base();
    base.send(&Twist::new(1.0, 0.0)).unwrap();
    base.step(0.5);
    // A first-order lag trails a ramp by its time constant times the slope: 0.25 m/s less 0.05 s of 0.5 m/s^2.
    assert!(
        (base.twist().linear - 0.225).abs() < 0.003,
        "{:?}",
        base.twist()
    );
    assert_eq!(base.feedback().unwrap().twist, base.twist());
}

#[test]
fn a_steady_turn_closes_its_circle() {
    let mut base = base();
    let turn = Twist::new(0.6, 0.5);
    let keep_on = |base: &mut SimBase, time_s: f64| {
        base.send(&turn).unwrap();
        base.step(time_s);
    };
    for _ in 0..100 {
        keep_on(&mut base, 0.1);
    }
    let from = *base.pose();
    for _ in 0..100 {
        keep_on(&mut base, TAU / 0.5 / 100.0);
    }
    let moved = base.pose().position() - from.position();
    assert!(moved.norm() < 1e-9, "{moved}");
}

#[test]
fn commands_that_are_not_finite_are_refused_and_change_nothing() {
    let (mut told, mut untold) = (base(), base());
    for command in [Twist::new(f64::NAN, 0.0), Twist::new(0.5, f64::INFINITY)] {
        assert!(matches!(
            told.send(&command),
            Err(BaseError::NotFinite { .. })
        ));
    }
    told.step(0.3);
    untold.step(0.3);
    assert_eq!(told.pose(), untold.pose());
}

#[test]
fn a_base_without_commands_brakes_by_itself() {
    let mut base = base();
    base.send(&Twist::new(0.5, 0.3)).unwrap();
    base.step(0.5);
    assert!(base.twist().linear > 0.2);
    base.step(2.0);
    assert!(base.twist().linear.abs() < 1e-6 && base.twist().angular.abs() < 1e-6);
}

#[test]
fn bad_settings_are_refused_by_name() {
    let lag = DriveDynamics {
        motor_lag_s: f64::NAN,
        ..DriveDynamics::default()
    };
    let error = SimBase::new(DRIVE, LIMITS, lag, Pose::default()).unwrap_err();
    assert!(
        error.to_string().starts_with("motor_lag_s is NaN"),
        "{error}"
    );
    let slow = Limits {
        acc_lim_x: 0.0,
        ..LIMITS
    };
    let error = SimBase::new(DRIVE, slow, DriveDynamics::default(), Pose::default()).unwrap_err();
    assert!(error.to_string().starts_with("acc_lim_x is 0"), "{error}");
}
