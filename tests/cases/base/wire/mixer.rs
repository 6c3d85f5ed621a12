//! The mixer keeps every motion within the limits of each track and at the requested curvature.

use inbye::geometry::{Pose, Twist};
use inbye::robot::{Mixer, PerTrack, TrackLimits, TrackOdometry, TrackSpeeds, TrackedDrive};
use proptest::prelude::{Strategy, prop_assert};
use proptest::test_runner::TestCaseError;

use super::property::{counterexample, for_all};

fn limits() -> impl Strategy<Value = TrackLimits> {
    (0.1..3.0, 0.1..5.0, 0.1..5.0).prop_map(|(max_track_speed, gain, brake): (f64, f64, f64)| {
        TrackLimits::default()
            .max_track_speed(max_track_speed)
            .acc_lim_track(gain)
            .decel_lim_track(-brake)
            .deadband(0.0)
    })
}

fn twist() -> impl Strategy<Value = Twist> {
    (-3.0..3.0, -6.0..6.0).prop_map(|(linear, angular)| Twist::new(linear, angular))
}

const DRIVE: TrackedDrive = TrackedDrive { track_width_m: 0.6 };

/// Checks that both speeds are within the limit and in the requested ratio.
fn keeps_ratio(target: &TrackSpeeds, found: &TrackSpeeds, max: f64) -> Result<(), TestCaseError> {
    prop_assert!(found.left.abs() <= max && found.right.abs() <= max, "{found:?}");
    let cross = target.left * found.right - target.right * found.left;
    prop_assert!(cross.abs() < 1e-12, "{found:?} for {target:?}");
    prop_assert!(target.left * found.left >= 0.0 && target.right * found.right >= 0.0);
    Ok(())
}

#[test]
fn limit_keeps_curvature() {
    for_all(2000, (limits(), twist()), |(limits, twist)| {
        let target = DRIVE.tracks(&twist);
        let found = limits.scale_to_max(&target);
        keeps_ratio(&target, &found, limits.max_track_speed)
    });
}

/// The property must be able to fail: here each track is limited on its own.
#[test]
fn independently_limited_tracks_fail_the_property() {
    let failure = counterexample(2000, (limits(), twist()), |(limits, twist)| {
        let target = DRIVE.tracks(&twist);
        let max = limits.max_track_speed;
        let found = TrackSpeeds {
            left: target.left.clamp(-max, max),
            right: target.right.clamp(-max, max),
        };
        keeps_ratio(&target, &found, max)
    });
    assert!(failure.is_some());
}

#[test]
fn ramps_respect_track_limits_and_reach_target() {
    for_all(500, (limits(), twist(), twist()), |(limits, first, second)| {
        let mut mixer = Mixer::new(DRIVE, limits);
        let time_s = 0.02;
        let mut last = TrackSpeeds::default();
        let steepest = limits.acc_lim_track.max(-limits.decel_lim_track);
        for twist in [first, second] {
            let target = limits.scale_to_max(&DRIVE.tracks(&twist));
            let from = last;
            // Brake and accelerate: twice the time from the highest speed to zero.
            let longest_s =
                2.0 * limits.max_track_speed / limits.acc_lim_track.min(-limits.decel_lim_track);
            for _ in 0..(longest_s / time_s).ceil() as usize + 2 {
                let speeds = mixer.mix(&twist, time_s);
                for (speed, last) in [(speeds.left, last.left), (speeds.right, last.right)] {
                    prop_assert!((speed - last).abs() <= steepest * time_s + 1e-12);
                    let gained = speed.abs() - last.abs();
                    prop_assert!(gained <= limits.acc_lim_track * time_s + 1e-12, "{gained}");
                }
                // On the straight line between the two pairs of speeds.
                let cross = (speeds.left - from.left) * (target.right - from.right)
                    - (speeds.right - from.right) * (target.left - from.left);
                prop_assert!(cross.abs() < 1e-9, "{speeds:?}");
                last = speeds;
            }
            prop_assert!(last == target, "{last:?} for {target:?}");
        }
        Ok(())
    });
}

#[test]
fn odometry_follows_drive() {
    for_all(300, (twist(), 0..u32::MAX), |(twist, start)| {
        let per_m = PerTrack::new(20_000.0, 30_000.0);
        let mut odometry = TrackOdometry::new(DRIVE, per_m, Pose::default());
        let tracks = DRIVE.tracks(&twist);
        for tick in 0..=50 {
            let time_s = 0.02 * f64::from(tick);
            odometry.update(tracks.zip(per_m, |speed, per_m| {
                start.wrapping_add((speed * time_s * per_m).round() as i64 as u32)
            }));
        }
        let truth = Pose::default().after(&twist, 1.0);
        let error_m = (odometry.pose().position() - truth.position()).norm();
        // A tick is 0.05 mm, and turns this base by 0.08 mrad.
        prop_assert!(error_m < 1e-3, "{error_m}");
        Ok(())
    });
}
