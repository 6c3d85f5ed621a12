//! An open field of cylinders that all move, as in the `DynaBARN` benchmark, and a robot that drives through.

use inbye::geometry::Pose;
use inbye::map::MovingDisc;
use rand::RngExt;

use super::stage::{
    Errors, LOCALISED, Look, ODOMETRY, Stage, disc, empty, ground, nearest, quantile, turned_round,
};

/// The looks at discs within 6 m that nothing nearer covers, and the numbers of found discs and of those that are no
/// true one.
fn drive_through(errors: Errors, count: usize, seed: u64) -> (Vec<Look>, usize, usize) {
    let truth = ground(40.0, 40.0, |_, _| false);
    let mut stage = Stage::new(empty(&truth), truth, errors, seed);
    let mut discs: Vec<MovingDisc> = (0..count)
        .map(|_| {
            let mut draw = |least: f64, most: f64| stage.random.random_range(least..most);
            let (x, y, yaw, speed) = (
                draw(12.0, 28.0),
                draw(12.0, 28.0),
                draw(-3.1, 3.1),
                draw(0.5, 1.9),
            );
            disc(x, y, 0.5, speed * libm::cos(yaw), speed * libm::sin(yaw))
        })
        .collect();
    let (mut looks, mut found_all, mut wrong) = (Vec::new(), 0, 0);
    let mut clear_since = vec![0.0; count];
    while stage.time_s < 20.0 {
        let now = stage.time_s;
        let pose = Pose::new(
            20.0 + 6.0 * libm::cos(0.15 * now),
            20.0 + 6.0 * libm::sin(0.15 * now),
            0.15 * now + 1.57 + 0.5 * libm::sin(now),
        );
        // A cylinder does not walk over the robot.
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
                looks.push(Look::new(now, stage.astray(truth), &found));
            }
        }
        let believed: Vec<MovingDisc> = discs.iter().map(|disc| stage.astray(disc)).collect();
        found_all += found.len();
        wrong += found
            .iter()
            .filter(|found| nearest(found, &believed).is_none())
            .count();
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
    (looks, found_all, wrong)
}

/// Whether no nearer disc covers any part of this one.
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

fn share_tracked(looks: &[Look]) -> f64 {
    let good = looks.iter().filter(|look| look.velocity_error() < 0.4);
    good.count() as f64 / looks.len() as f64
}

#[test]
fn moving_cylinders_are_tracked_by_a_moving_robot() {
    for (name, errors) in [("localised", LOCALISED), ("odometry", ODOMETRY)] {
        for count in [5, 12, 24] {
            let (mut looks, mut found, mut wrong) = (Vec::new(), 0, 0);
            for seed in 0..6 {
                let run = drive_through(errors, count, seed);
                looks.extend(run.0);
                found += run.1;
                wrong += run.2;
            }
            let share = share_tracked(&looks);
            let speeds: Vec<f64> = looks.iter().map(Look::velocity_error).collect();
            let median = quantile(speeds, 0.5);
            assert!(median < 0.1, "{name}, {count}: {median}");
            assert!(share > 0.9, "{name}, {count}: {share}");
            assert!(wrong * 50 <= found, "{wrong} of {found}");
            assert!(share_tracked(&turned_round(&looks)) < 0.1);
        }
    }
}
