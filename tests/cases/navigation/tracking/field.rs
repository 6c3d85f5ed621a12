//! A robot that drives through an open field of moving cylinders, as in the `DynaBARN` benchmark.

use inbye::geometry::Pose;
use inbye::map::MovingDisc;
use rand::RngExt;

use super::stage::{
    Errors, LOCALISED, ODOMETRY, Sample, Stage, disc, empty, ground, nearest, quantile, reversed,
};

/// Drives through the field. Returns the samples of discs within 6 m that nothing nearer covers, the number of found discs, and
/// the number of those that match no true one.
fn drive_through(errors: Errors, count: usize, seed: u64) -> (Vec<Sample>, usize, usize) {
    let truth = ground(40.0, 40.0, |_, _| false);
    let mut stage = Stage::new(empty(&truth), truth, errors, seed);
    let mut discs: Vec<MovingDisc> = (0..count)
        .map(|_| {
            let mut draw = |least: f64, most: f64| stage.random.random_range(least..most);
            let (x, y, yaw, speed) =
                (draw(12.0, 28.0), draw(12.0, 28.0), draw(-3.1, 3.1), draw(0.5, 1.9));
            disc(x, y, 0.5, speed * libm::cos(yaw), speed * libm::sin(yaw))
        })
        .collect();
    let (mut samples, mut found_all, mut wrong) = (Vec::new(), 0, 0);
    let mut clear_since = vec![0.0; count];
    while stage.time_s < 20.0 {
        let now = stage.time_s;
        let pose = Pose::new(
            20.0 + 6.0 * libm::cos(0.15 * now),
            20.0 + 6.0 * libm::sin(0.15 * now),
            0.15 * now + 1.57 + 0.5 * libm::sin(now),
        );
        // A cylinder does not move over the robot.
        for disc in &mut discs {
            let away = disc.center() - pose.position();
            if away.norm() < 1.2 && away.x * disc.vx + away.y * disc.vy < 0.0 {
                (disc.vx, disc.vy) = (-disc.vx, -disc.vy);
            }
        }
        let found = stage.tick(&pose, &discs);
        for (index, truth) in discs.iter().enumerate() {
            if !is_uncovered(index, &discs, &pose) {
                clear_since[index] = now;
            }
            let distance = (truth.center() - pose.position()).norm();
            if distance < 6.0 && now - clear_since[index] > 0.75 {
                samples.push(Sample::new(now, stage.as_estimated(truth), &found));
            }
        }
        let estimated: Vec<MovingDisc> =
            discs.iter().map(|disc| stage.as_estimated(disc)).collect();
        found_all += found.len();
        wrong += found.iter().filter(|found| nearest(found, &estimated).is_none()).count();
        for disc in &mut discs {
            disc.x += disc.vx * stage.period_s;
            disc.y += disc.vy * stage.period_s;
            if !(12.0..28.0).contains(&disc.x) {
                disc.vx = disc.vx.abs().copysign(20.0 - disc.x);
            }
            if !(12.0..28.0).contains(&disc.y) {
                disc.vy = disc.vy.abs().copysign(20.0 - disc.y);
            }
        }
    }
    (samples, found_all, wrong)
}

/// Whether no nearer disc hides a part of this one.
fn is_uncovered(index: usize, discs: &[MovingDisc], pose: &Pose) -> bool {
    let place = |disc: &MovingDisc| {
        let away = disc.center() - pose.position();
        let distance = away.norm();
        let half = libm::asin((disc.radius / distance).min(1.0));
        (libm::atan2(away.y, away.x), distance, half)
    };
    let (bearing, distance, half) = place(&discs[index]);
    discs.iter().enumerate().all(|(other, disc)| {
        let (other_bearing, other_distance, other_half) = place(disc);
        let apart = inbye::geometry::wrap_angle(other_bearing - bearing).abs();
        other == index || other_distance > distance || apart > half + other_half
    })
}

fn share_tracked(samples: &[Sample]) -> f64 {
    let good = samples.iter().filter(|sample| sample.velocity_error() < 0.4);
    good.count() as f64 / samples.len() as f64
}

#[test]
fn moving_robot_tracks_moving_cylinders() {
    for (name, errors) in [("localised", LOCALISED), ("odometry", ODOMETRY)] {
        for count in [5, 12, 24] {
            let (mut samples, mut found, mut wrong) = (Vec::new(), 0, 0);
            for seed in 0..6 {
                let run = drive_through(errors, count, seed);
                samples.extend(run.0);
                found += run.1;
                wrong += run.2;
            }
            let share = share_tracked(&samples);
            let speeds: Vec<f64> = samples.iter().map(Sample::velocity_error).collect();
            let median = quantile(speeds, 0.5);
            assert!(median < 0.1, "{name}, {count}: {median}");
            assert!(share > 0.9, "{name}, {count}: {share}");
            assert!(wrong * 50 <= found, "{wrong} of {found}");
            assert!(share_tracked(&reversed(&samples)) < 0.1);
        }
    }
}
