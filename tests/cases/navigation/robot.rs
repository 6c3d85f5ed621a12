//! Limits of base and tracks, kinematics of the tracked drive, the mixer, and odometry from encoders.

use std::f64::consts::PI;

use inbye::geometry::{Pose, Twist};
use inbye::robot::{
    Limits, Mixer, PerTrack, TrackLimits, TrackOdometry, TrackSpeeds, TrackedDrive, travel_m,
};

const DRIVE: TrackedDrive = TrackedDrive { track_width_m: 0.5 };

fn track_limits() -> TrackLimits {
    TrackLimits::default()
        .max_track_speed(1.0)
        .acc_lim_track(1.0)
        .decel_lim_track(-2.0)
        .deadband(0.05)
}

#[test]
fn braking_keeps_the_curvature_as_far_as_the_limits_allow() {
    let limits = Limits::default();
    let twist = Twist::new(0.8, -0.6);
    let braked = limits.brake(&twist, 0.1);
    assert!((braked.angular / braked.linear + 0.75).abs() < 1e-12, "{braked:?}");
    assert_eq!(braked.linear, limits.reachable(&twist, &Twist::STOP, 0.1).linear);
    // The arc is too sharp: angular deceleration takes longer than linear.
    let sharp = Twist::new(0.01, 0.9);
    let expected = limits.reachable(&sharp, &Twist::STOP, 0.1);
    assert_eq!(limits.brake(&sharp, 0.1), expected);
    assert_eq!(limits.brake(&Twist::STOP, 0.1), Twist::STOP);
    let backwards = limits.brake(&Twist::new(-0.3, 0.3), 0.1);
    assert!((backwards.angular + backwards.linear).abs() < 1e-12);
}

#[test]
fn acceleration_and_deceleration_limits_apply_in_both_directions() {
    let limits = Limits::default().acc_lim_x(1.0).decel_lim_x(-2.0);
    let reach =
        |from, to| limits.reachable(&Twist::new(from, 0.0), &Twist::new(to, 0.0), 0.1).linear;
    assert!((reach(0.5, 1.0) - 0.6).abs() < 1e-12);
    assert!((reach(0.5, 0.0) - 0.3).abs() < 1e-12);
    assert!((reach(-0.5, -1.0) + 0.6).abs() < 1e-12);
    assert!((reach(-0.5, 0.0) + 0.3).abs() < 1e-12);
}

#[test]
fn limits_reject_a_positive_deceleration_by_name() {
    let limits = Limits::default().decel_lim_x(0.5);
    let message = limits.validate().unwrap_err().to_string();
    assert!(message.contains("decel_lim_x is 0.5"), "{message}");
}

#[test]
fn twist_and_tracks_are_inverse() {
    let twist = Twist::new(0.7, -0.4);
    let back = DRIVE.twist(&DRIVE.tracks(&twist));
    assert!((back.linear - 0.7).abs() < 1e-15 && (back.angular + 0.4).abs() < 1e-15);
}

#[test]
fn max_curvature_is_the_smaller_of_eq_12_and_the_turn_rate_limit() {
    // 2 / 0.5 * (1.0 / 0.9 - 1) = 0.444..; at 0.5 m/s the rate 1.0 rad/s allows only 2.0, eq. 12 would give 4.0.
    assert!((DRIVE.max_curvature(0.9, 1.0, 1.0) - 4.0 / 9.0).abs() < 1e-12);
    assert!((DRIVE.max_curvature(0.5, 1.0, 1.0) - 2.0).abs() < 1e-12);
}

#[test]
fn max_speed_is_the_inverse_of_max_curvature() {
    for curvature in [0.01, 0.4, 1.0, 3.0, 50.0] {
        for max_vel_theta in [0.2, 1.0, 1e9] {
            let speed = DRIVE.max_speed(curvature, 1.2, max_vel_theta);
            let back = DRIVE.max_curvature(speed, 1.2, max_vel_theta);
            assert!((back / curvature - 1.0).abs() < 1e-12, "{back} of {curvature}");
        }
    }
}

#[test]
fn top_track_speed_combines_both_limits() {
    let limits = Limits::default().max_vel_x(0.8).max_vel_theta(1.2);
    let top = DRIVE.top_track_speed(&limits);
    assert!((top - (0.8 + 1.2 * 0.25)).abs() < 1e-15);
    assert!((DRIVE.max_curvature(0.8, top, 1.2) - 1.5).abs() < 1e-12);
}

/// Else no command, and no layer, could make it stand.
#[test]
fn limits_permit_a_robot_to_stand() {
    let error = |limits: Limits| limits.validate().expect_err("out of range").to_string();
    let (faster, slower) = (Limits::default().min_vel_x(0.1), Limits::default().max_vel_x(-0.1));
    assert_eq!(error(faster), "min_vel_x is 0.1: it must be -15.99 to 0");
    assert_eq!(error(slower.min_vel_x(-0.3)), "max_vel_x is -0.1: it must be 0 to 15.99");
    Limits::default().max_vel_x(0.0).validate().expect("a robot that may only turn");
}

#[test]
fn travel_wraps_with_the_counters_in_both_directions() {
    let ticks = |before: u32, now: u32| {
        travel_m(&PerTrack::both(before), &PerTrack::both(now), &PerTrack::both(1.0))
    };
    assert_eq!(ticks(u32::MAX - 1, 3), PerTrack::both(5.0));
    assert_eq!(ticks(3, u32::MAX - 1), PerTrack::both(-5.0));
    assert_eq!(ticks(0x7FFF_FFFE, 0x8000_0003), PerTrack::both(5.0));
    assert_eq!(ticks(7, 7), PerTrack::both(0.0));
}

#[test]
fn odometry_measures_a_half_turn_in_place() {
    let mut odometry = TrackOdometry::new(DRIVE, PerTrack::new(1000.0, 2000.0), Pose::default());
    odometry.update(PerTrack::new(100, u32::MAX - 99));
    // Each track travels pi / 2 times 0.5 m = 0.7854 m: 785 and 1571 ticks, across both wraps.
    let moved = odometry.update(PerTrack::new(100_u32.wrapping_sub(785), 1471));
    assert!(moved.linear.abs() < 3e-4 && (moved.angular - PI).abs() < 2e-3, "{moved:?}");
    assert!(odometry.pose().x.abs() < 1e-3 && odometry.pose().yaw.abs() > PI - 2e-3);
}

#[test]
fn odometry_ignores_a_counter_reset() {
    let mut odometry = TrackOdometry::new(DRIVE, PerTrack::both(1000.0), Pose::default());
    odometry.update(PerTrack::both(500));
    odometry.update(PerTrack::both(1500));
    odometry.reset_counters();
    assert_eq!(odometry.update(PerTrack::both(0)), Twist::STOP);
    assert!((odometry.pose().x - 1.0).abs() < 1e-12);
}

fn mixer() -> Mixer {
    Mixer::new(DRIVE, track_limits().decel_lim_track(-1.0))
}

#[test]
fn ramp_of_small_steps_leaves_the_deadband() {
    let mut mixer = mixer();
    let commanded: Vec<f64> =
        (0..10).map(|_| mixer.mix(&Twist::new(0.5, 0.0), 0.01).left).collect();
    assert_eq!(commanded[3], 0.0, "0.04 m/s is within the deadband");
    assert!((commanded[9] - 0.1).abs() < 1e-12, "{commanded:?}");
}

#[test]
fn target_that_is_not_finite_brakes() {
    let mut mixer = mixer();
    mixer.mix(&Twist::new(0.5, 0.0), 1.0);
    let commanded = mixer.mix(&Twist::new(f64::NAN, 0.2), 0.1);
    assert!((commanded.left - 0.4).abs() < 1e-12 && (commanded.right - 0.4).abs() < 1e-12);
    mixer.reset();
    assert_eq!(mixer.mix(&Twist::STOP, 0.0), TrackSpeeds::default());
}

#[test]
fn scale_to_max_keeps_the_ratio() {
    let scaled = |left, right| track_limits().scale_to_max(&PerTrack::new(left, right));
    assert_eq!(scaled(0.8, 1.6), PerTrack::new(0.5, 1.0));
    assert_eq!(scaled(-4.0, 2.0), PerTrack::new(-1.0, 0.5));
    assert_eq!(scaled(0.8, 0.9), PerTrack::new(0.8, 0.9));
}

#[test]
fn reachable_keeps_the_curvature_at_start_and_the_stopping_time() {
    let (standing, target) = (PerTrack::both(0.0), PerTrack::new(0.4, 0.8));
    // 0.1 s at 1 m/s^2 is 0.1 m/s for the right track, and half of it for the left.
    let started = track_limits().reachable(&standing, &target, 0.1);
    assert!((started.left - 0.05).abs() < 1e-12 && (started.right - 0.1).abs() < 1e-12);
    // 0.1 s at 2 m/s^2 is a fourth of the right track's 0.8 m/s.
    let braked = track_limits().reachable(&target, &standing, 0.1);
    assert!((braked.left - 0.3).abs() < 1e-12 && (braked.right - 0.6).abs() < 1e-12);
    assert_eq!(track_limits().reachable(&target, &standing, 0.4), standing);
}

#[test]
fn reversal_decelerates_before_it_accelerates() {
    // 0.1 s to stop from 0.2 m/s at 2 m/s^2; then 0.1 s at 1 m/s^2 gives 0.1 m/s.
    let turned = track_limits().reachable(&PerTrack::both(0.2), &PerTrack::both(-1.0), 0.2);
    assert!((turned.left + 0.1).abs() < 1e-12 && (turned.right + 0.1).abs() < 1e-12);
}

#[test]
fn speeds_within_the_deadband_become_zero() {
    let kept = track_limits().apply_deadband(&PerTrack::new(0.049, -0.05));
    assert_eq!(kept, PerTrack::new(0.0, -0.05));
}

#[test]
fn track_limits_reject_bad_values_by_name() {
    for (limits, start) in [
        (track_limits().max_track_speed(0.0), "max_track_speed is 0"),
        (track_limits().acc_lim_track(f64::NAN), "acc_lim_track is NaN"),
        (track_limits().decel_lim_track(1.0), "decel_lim_track is 1"),
        (track_limits().deadband(1.0), "deadband is 1"),
    ] {
        let message = limits.validate().unwrap_err().to_string();
        assert!(message.starts_with(start), "{message}");
    }
    TrackLimits::default().validate().expect("valid limits");
}
