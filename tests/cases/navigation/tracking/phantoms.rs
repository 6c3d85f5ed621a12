//! No static obstacle counts as moving, however the robot drives: such a phantom would stop it.

use inbye::geometry::Pose;
use inbye::map::ObstacleGrid;

use super::stage::{Errors, LOCALISED, ODOMETRY, Stage, disc, empty, ground};

/// Rooms with doorways, corners, and an oblique wall.
fn rooms() -> ObstacleGrid {
    ground(30.0, 30.0, |x, y| {
        let wall = |at: f64| at.abs() < 0.1;
        let is_door = |at: f64| (at - 4.0).rem_euclid(6.0) < 1.2;
        let outer = !(1.0..29.0).contains(&x) || !(1.0..29.0).contains(&y);
        let inner = wall((x - 7.0).rem_euclid(8.0)) && !is_door(y) && y > 8.0
            || wall((y - 8.0).rem_euclid(8.0)) && !is_door(x);
        let slant = wall((x - y - 3.0) * 0.7) && (4.0..7.0).contains(&y);
        outer || inner || slant
    })
}

/// Thin posts on a part of a lattice of 0.15 m, by a fixed rule, as in fields of random cylinders.
fn posts() -> ObstacleGrid {
    ground(30.0, 30.0, |x, y| {
        let (column, row) = ((x / 0.15) as i64, (y / 0.15) as i64);
        let is_post = (column * 7919 + row * 104_729 + column * row * 31) % 97 < 4;
        let centre = |place: i64| (place as f64 + 0.5) * 0.15;
        is_post && libm::hypot(x - centre(column), y - centre(row)) < 0.075
    })
}

/// Boxes of several sizes, some in groups.
fn boxes() -> ObstacleGrid {
    ground(30.0, 30.0, |x, y| {
        let (column, row) = ((x / 2.5) as i64, (y / 2.5) as i64);
        let size = 0.15 + 0.1 * ((column * 5 + row * 3) % 7) as f64;
        let (dx, dy) = (x - 2.5 * column as f64 - 1.2, y - 2.5 * row as f64 - 1.2);
        (column + 2 * row) % 3 != 0 && dx.abs() < size && dy.abs() < size / 2.0
    })
}

/// Drives along curves at up to 1 m/s and 1 rad/s, around static obstacles. Returns the number of ticks with a phantom, and of
/// all ticks.
fn phantom_ticks(truth: &ObstacleGrid, errors: Errors, seed: u64) -> (usize, usize) {
    let mut stage = Stage::new(truth.clone(), empty(truth), errors, seed);
    if seed % 2 == 1 {
        stage.lidar.beams = 720;
        stage.lidar.field_of_view_rad = 1.5 * core::f64::consts::PI;
        stage.lidar.range_max_m = 30.0;
        stage.period_s = 0.05;
    }
    let mut pose = Pose::new(4.0 + 2.0 * seed as f64, 5.0 + seed as f64, 0.4 * seed as f64);
    let (mut phantoms, mut ticks) = (0, 0);
    while stage.time_s < 60.0 {
        let time_s = stage.time_s;
        let found = stage.tick(&pose, &[]);
        ticks += 1;
        if !found.is_empty() {
            phantoms += 1;
        }
        let wanted = libm::sin(0.7 * time_s) + 0.3 * libm::sin(0.23 * time_s);
        let ahead = |turn: f64| {
            let yaw = pose.yaw + turn * stage.period_s;
            let step_m = 1.0 * stage.period_s;
            Pose::new(pose.x + step_m * libm::cos(yaw), pose.y + step_m * libm::sin(yaw), yaw)
        };
        let is_clear = |pose: &Pose| {
            let far = Pose::new(
                pose.x + 0.5 * libm::cos(pose.yaw),
                pose.y + 0.5 * libm::sin(pose.yaw),
                pose.yaw,
            );
            let round = inbye::robot::Footprint::round(0.2).expect("a radius");
            stage.world.gap_to_static_m(&round, &far) > 0.0
        };
        let next = [wanted.clamp(-1.0, 1.0), 1.0, -1.0].map(ahead).into_iter().find(is_clear);
        pose = next.unwrap_or(Pose::new(pose.x, pose.y, pose.yaw + stage.period_s));
    }
    (phantoms, ticks)
}

#[test]
fn static_obstacles_are_not_tracked_as_moving() {
    let (mut phantoms, mut ticks) = (0, 0);
    for truth in [rooms(), posts(), boxes()] {
        for errors in [LOCALISED, ODOMETRY] {
            for seed in 0..4 {
                let (found, all) = phantom_ticks(&truth, errors, seed);
                phantoms += found;
                ticks += all;
            }
        }
    }
    assert!(phantoms * 1000 <= ticks, "{phantoms} of {ticks}");
}

#[test]
fn count_of_phantoms_includes_a_moving_obstacle() {
    let truth = boxes();
    let mut stage = Stage::new(truth.clone(), empty(&truth), LOCALISED, 1);
    let mut counted = 0;
    for tick in 0..50 {
        let walker = disc(8.0, 5.0 + 0.08 * f64::from(tick), 0.3, 0.0, 0.8);
        counted += usize::from(!stage.tick(&Pose::new(5.0, 7.3, 0.0), &[walker]).is_empty());
    }
    assert!(counted > 25, "{counted}");
}
