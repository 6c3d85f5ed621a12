//! Any motion through the mixer: within the limits of each track, with the curvature that was wanted.

use inbye::geometry::{Pose, Twist};
use inbye::robot::{Mixer, PerTrack, TrackLimits, TrackOdometry, TrackSpeeds, TrackedDrive};
use proptest::prelude::{Strategy, prop_assert};
use proptest::test_runner::TestCaseError;

use super::sure::{counterexample, for_all};

fn limits() -> impl Strategy<Value = TrackLimits> {
    (0.1..3.0, 0.1..5.0, 0.1..5.0).prop_map(|(max_track_speed, gain, brake): (f64, f64, f64)| {
        TrackLimits {
            max_track_speed,
            acc_lim_track: gain,
            decel_lim_track: -brake,
            deadband: 0.0,
        }
    })
}

fn twist() -> impl Strategy<Value = Twist> {
    (-3.0..3.0, -6.0..6.0).prop_map(|(linear, angular)| Twist::new(linear, angular))
}

const DRIVE: TrackedDrive = TrackedDrive { track_width_m: 0.6 };

/// Both speeds within the highest, in the ratio of those wanted.
fn keeps_the_ratio(
    wanted: &TrackSpeeds,
    found: &TrackSpeeds,
    most: f64,
) -> Result<(), TestCaseError> {
    prop_assert!(
        found.left.abs() <= most && found.right.abs() <= most,
        "{found:?}"
    );
    let cross = wanted.left * found.right - wanted.right * found.left;
    prop_assert!(cross.abs() < 1e-12, "{found:?} for {wanted:?}");
    prop_assert!(wanted.left * found.left >= 0.0 && wanted.right * found.right >= 0.0);
    Ok(())
}

#[test]
fn what_is_too_fast_keeps_its_curvature() {
    for_all(2000, (limits(), twist()), |(limits, twist)| {
        let wanted = DRIVE.tracks(&twist);
        let found = limits.within(&wanted);
        keeps_the_ratio(&wanted, &found, limits.max_track_speed)
    });
}

/// The property must be able to fail: tracks limited each for itself.
#[test]
fn tracks_limited_each_for_itself_are_caught() {
    let failure = counterexample(2000, (limits(), twist()), |(limits, twist)| {
        let wanted = DRIVE.tracks(&twist);
        let most = limits.max_track_speed;
        let found = TrackSpeeds {
            left: wanted.left.clamp(-most, most),
            right: wanted.right.clamp(-most, most),
        };
        keeps_the_ratio(&wanted, &found, most)
    });
    assert!(failure.is_some());
}

#[test]
fn ramps_obey_each_track_and_arrive() {
    for_all(
        500,
        (limits(), twist(), twist()),
        |(limits, first, second)| {
            let mut mixer = Mixer::new(DRIVE, limits);
            let time_s = 0.02;
            let mut last = TrackSpeeds::default();
            let steepest = limits.acc_lim_track.max(-limits.decel_lim_track);
            for wanted in [first, second] {
                let target = limits.within(&DRIVE.tracks(&wanted));
                let from = last;
                // Brake and gain again: twice the way from the highest speed to none.
                let longest_s = 2.0 * limits.max_track_speed
                    / limits.acc_lim_track.min(-limits.decel_lim_track);
                for _ in 0..(longest_s / time_s).ceil() as usize + 2 {
                    let told = mixer.mix(&wanted, time_s);
                    for (told, last) in [(told.left, last.left), (told.right, last.right)] {
                        prop_assert!((told - last).abs() <= steepest * time_s + 1e-12);
                        let gained = told.abs() - last.abs();
                        prop_assert!(gained <= limits.acc_lim_track * time_s + 1e-12, "{gained}");
                    }
                    // On the straight way from one pair of speeds to the other.
                    let cross = (told.left - from.left) * (target.right - from.right)
                        - (told.right - from.right) * (target.left - from.left);
                    prop_assert!(cross.abs() < 1e-9, "{told:?}");
                    last = told;
                }
                prop_assert!(last == target, "{last:?} for {target:?}");
            }
            Ok(())
        },
    );
}

#[test]
fn ticks_of_a_drive_lead_where_the_drive_led() {
    for_all(300, (twist(), 0..u32::MAX), |(twist, start)| {
        let per_m = PerTrack::new(20_000.0, 30_000.0);
        let mut odometry = TrackOdometry::new(DRIVE, per_m, Pose::default());
        let tracks = PerTrack::from(DRIVE.tracks(&twist));
        for tick in 0..=50 {
            let time_s = 0.02 * f64::from(tick);
            odometry.read(tracks.zip(per_m, |speed, per_m| {
                start.wrapping_add((speed * time_s * per_m).round() as i64 as u32)
            }));
        }
        let truth = Pose::default().after(&twist, 1.0);
        let apart = (odometry.pose().position() - truth.position()).norm();
        // A tick is 0.05 mm, and turns this base by 0.08 mrad.
        prop_assert!(apart < 1e-3, "{apart}");
        Ok(())
    });
}
