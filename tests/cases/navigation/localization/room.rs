//! One revolution after the other in a room of known walls.

use std::f64::consts::TAU;

use inbye::geometry::{Point, Pose, wrap_angle};
use inbye::localization::{
    LocalizationError, LocalizationSettings, LocalizationStatus, Localizer, LostReason,
    PoseEstimate,
};
use inbye::map::{Cell, GridFrame, MovingDisc, ObstacleGrid, TimedScan};
use inbye::sim::{Lidar, World};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

const LIDAR: Lidar = Lidar {
    beams: 360,
    field_of_view_rad: TAU,
    range_min_m: 0.05,
    range_max_m: 12.0,
    range_sigma_m: 0.01,
    dropout: 0.01,
    sweep_s: 0.0,
};

/// Open boxes in rock, each from its lower left to its upper right corner, metres in the grid's frame; cells of 5 cm.
fn ground(origin: Pose, boxes: &[[f64; 4]]) -> ObstacleGrid {
    let frame = GridFrame::new(400, 300, 0.05, origin).expect("a frame");
    let mut obstacles = ObstacleGrid::new(frame, vec![true; frame.len()]);
    for row in 0..frame.height {
        for column in 0..frame.width {
            let center = Cell::new(column, row).center() * frame.resolution_m;
            let is_in = |[left, low, right, high]: &[f64; 4]| {
                (left..right).contains(&&center.x) && (low..high).contains(&&center.y)
            };
            if boxes.iter().any(is_in) {
                obstacles.set(Cell::new(column, row), false);
            }
        }
    }
    obstacles
}

/// A room of 6 by 4 m with a niche.
const ROOM: [[f64; 4]; 2] = [[2.0, 3.0, 8.0, 7.0], [4.0, 7.0, 5.5, 8.2]];

/// A roadway 3 m wide whose ends are out of the lidar's reach from its middle.
const ROADWAY: [[f64; 4]; 1] = [[0.5, 6.0, 19.5, 9.0]];

struct Stage {
    world: World,
    localizer: Localizer,
    rng: Pcg64Mcg,
}

impl Stage {
    fn new(obstacles: ObstacleGrid, start: &Pose) -> Self {
        let settings = LocalizationSettings::default();
        let localizer = Localizer::new(&obstacles, settings, start);
        Self {
            localizer: localizer.expect("good settings and a start"),
            world: World::new(obstacles),
            rng: Pcg64Mcg::seed_from_u64(3),
        }
    }

    fn update(&mut self, lidar: &Lidar, truth: &Pose, time_s: f64) -> PoseEstimate {
        let seen = lidar.scan(&self.world, truth, &mut self.rng);
        *self
            .localizer
            .update(&TimedScan::from_scan(&seen.scan, time_s, 0.0))
    }

    /// Stands for so many revolutions.
    fn stand(&mut self, truth: &Pose, times: u32) -> PoseEstimate {
        for tick in 0..times {
            let time_s = 0.1 * f64::from(tick);
            self.localizer.predict(time_s, &Pose::default());
            self.update(&LIDAR, truth, time_s);
        }
        *self.localizer.estimate()
    }
}

fn off(fix: &PoseEstimate, truth: &Pose) -> (f64, f64) {
    let off_m = (fix.pose.position() - truth.position()).norm();
    (off_m, wrap_angle(fix.pose.yaw - truth.yaw).abs())
}

#[test]
fn a_start_that_is_a_little_off_is_mended() {
    let truth = Pose::new(4.1, 4.3, 0.4);
    for (x, y, yaw) in [(0.15, -0.1, 0.08), (-0.2, 0.1, -0.06), (0.0, 0.0, 0.1)] {
        let start = Pose::new(truth.x + x, truth.y + y, truth.yaw + yaw);
        let fix = Stage::new(ground(Pose::default(), &ROOM), &start).stand(&truth, 10);
        let (off_m, off_rad) = off(&fix, &truth);
        assert!(off_m < 0.01 && off_rad < 0.004, "{fix:?}");
        assert_eq!(
            (fix.status, fix.unobservable_directions),
            (LocalizationStatus::Tracking, 0)
        );
        assert!(fix.agreement.matching_fraction() > 0.95, "{fix:?}");
    }
}

/// Each axis is as good as the other, on a map that lies turned as well.
#[test]
fn a_map_that_lies_turned_is_a_map() {
    let origin = Pose::new(-3.0, 5.0, 0.6);
    let place = origin.transform(&Point::new(4.1, 4.3));
    let truth = Pose::new(place.x, place.y, -2.0);
    let start = Pose::new(truth.x - 0.1, truth.y + 0.1, truth.yaw + 0.05);
    let fix = Stage::new(ground(origin, &ROOM), &start).stand(&truth, 10);
    let (off_m, off_rad) = off(&fix, &truth);
    assert!(off_m < 0.01 && off_rad < 0.004, "{fix:?}");
}

#[test]
fn people_do_not_pull_the_pose() {
    let truth = Pose::new(4.1, 4.3, 0.4);
    let mut stage = Stage::new(ground(Pose::default(), &ROOM), &truth);
    let person = |x, y| MovingDisc {
        x,
        y,
        radius: 0.3,
        vx: 0.0,
        vy: 0.0,
    };
    stage.world.moving = vec![person(5.0, 4.3), person(4.2, 5.2), person(3.2, 3.9)];
    let fix = stage.stand(&truth, 10);
    assert!(off(&fix, &truth).0 < 0.012, "{fix:?}");
    assert_eq!(fix.status, LocalizationStatus::Tracking);
    assert!(fix.agreement.unmapped() > 60, "{fix:?}");
}

/// A robot in the middle of a smooth roadway, driven by odometry that counts 5 % too much.
fn along_the_roadway(lidar: &Lidar) -> (PoseEstimate, Pose, f64) {
    let start = Pose::new(9.0, 7.5, 0.0);
    let mut stage = Stage::new(ground(Pose::default(), &ROADWAY), &start);
    let mut truth = start;
    for tick in 0..=100 {
        let way_m = 0.02 * f64::from(tick);
        truth = Pose::new(9.0 + way_m, 7.5, 0.0);
        let time_s = 0.1 * f64::from(tick);
        stage
            .localizer
            .predict(time_s, &Pose::new(way_m / 0.95, 0.0, 0.0));
        stage.update(lidar, &truth, time_s);
    }
    let (way_factor, _) = stage.localizer.odometry_scale();
    (*stage.localizer.estimate(), truth, way_factor)
}

#[test]
fn along_a_smooth_roadway_the_pose_is_left_to_odometry_and_said_to_be() {
    let short = Lidar {
        range_max_m: 6.0,
        ..LIDAR
    };
    let (fix, truth, way_factor) = along_the_roadway(&short);
    assert_eq!(fix.unobservable_directions, 1);
    // Off along by what slipped in 2 m, and not across.
    assert!((fix.pose.x - truth.x - 0.105).abs() < 0.01, "{fix:?}");
    assert!((fix.pose.y - truth.y).abs() < 0.005, "{fix:?}");
    assert!(off(&fix, &truth).1 < 0.003, "{fix:?}");
    assert!(fix.covariance[(0, 0)].sqrt() > 0.1, "{fix:?}");
    assert!(fix.covariance[(1, 1)].sqrt() < 0.02, "{fix:?}");
    assert_eq!(fix.status, LocalizationStatus::Uncertain);
    assert!((way_factor - 1.0).abs() < 1e-6, "{way_factor}");
}

#[test]
fn where_an_end_is_seen_the_slip_is_learned() {
    let (fix, truth, way_factor) = along_the_roadway(&LIDAR);
    assert_eq!(
        (fix.unobservable_directions, fix.status),
        (0, LocalizationStatus::Tracking)
    );
    assert!(off(&fix, &truth).0 < 0.02, "{fix:?}");
    assert!((way_factor - 0.95).abs() < 0.02, "{way_factor}");
}

/// The corrections are what keeps the pose: without them it goes where odometry goes.
#[test]
fn without_revolutions_the_pose_drifts() {
    let start = Pose::new(4.1, 4.3, 0.4);
    let mut stage = Stage::new(ground(Pose::default(), &ROOM), &start);
    for tick in 0..=100 {
        let yaw = 0.05 * f64::from(tick);
        stage
            .localizer
            .predict(0.1 * f64::from(tick), &Pose::new(0.0, 0.0, yaw));
    }
    let fix = stage.localizer.estimate();
    assert!((wrap_angle(fix.pose.yaw - 5.4)).abs() < 1e-9, "{fix:?}");
    assert!(fix.sigma_rad() > 0.1, "{fix:?}");
}

#[test]
fn what_was_covered_is_found_only_by_evidence() {
    let truth = Pose::new(4.1, 4.3, 0.4);
    let mut stage = Stage::new(ground(Pose::default(), &ROOM), &truth);
    stage.stand(&truth, 10);
    let blind = Lidar {
        dropout: 1.0,
        ..LIDAR
    };
    let mut states = Vec::new();
    for tick in 10..40 {
        let lidar = if tick < 20 { &blind } else { &LIDAR };
        states.push(stage.update(lidar, &truth, 0.1 * f64::from(tick)).status);
    }
    assert_eq!(states[3], LocalizationStatus::Uncertain);
    assert_eq!(
        states[4..10],
        [LocalizationStatus::Lost(LostReason::NoReturns); 6]
    );
    // Five revolutions that agree.
    assert_eq!(
        states[10..14],
        [LocalizationStatus::Lost(LostReason::NoReturns); 4]
    );
    assert!(
        states[15..]
            .iter()
            .all(|state| *state == LocalizationStatus::Tracking),
        "{states:?}"
    );
}

#[test]
fn what_cannot_be_a_localiser_is_refused() {
    let ground = ground(Pose::default(), &ROOM);
    let bad = LocalizationSettings {
        outlier_distance_m: f64::NAN,
        ..LocalizationSettings::default()
    };
    let refusal = Localizer::new(&ground, bad, &Pose::default()).expect_err("no number");
    assert_eq!(
        refusal.to_string(),
        "outlier_distance_m is NaN: it must be above zero and at most 1"
    );
    let nowhere = Pose::new(f64::NAN, 0.0, 0.0);
    let refusal = Localizer::new(&ground, LocalizationSettings::default(), &nowhere);
    assert!(matches!(refusal, Err(LocalizationError::BadStart { .. })));
}

/// Senses that are no numbers change nothing and end nothing.
#[test]
fn numbers_that_are_none_are_passed_over() {
    let truth = Pose::new(4.1, 4.3, 0.4);
    let mut stage = Stage::new(ground(Pose::default(), &ROOM), &truth);
    stage.stand(&truth, 5);
    let before = *stage.localizer.estimate();
    stage.localizer.predict(f64::NAN, &Pose::default());
    stage
        .localizer
        .predict(1.0, &Pose::new(f64::INFINITY, 0.0, 0.0));
    assert_eq!(*stage.localizer.estimate(), before);
    let seen = LIDAR.scan(&stage.world, &truth, &mut stage.rng);
    let mut sweep = TimedScan::from_scan(&seen.scan, 0.5, 0.0);
    for (number, beam) in sweep.beams.iter_mut().enumerate() {
        match number % 4 {
            0 => beam.angle = f64::NAN,
            1 => beam.range = f64::NAN,
            2 => beam.time_s = f64::NAN,
            _ => {}
        }
    }
    let fix = *stage.localizer.update(&sweep);
    assert!(
        fix.pose.is_finite() && off(&fix, &truth).0 < 0.02,
        "{fix:?}"
    );
    stage.localizer.update(&TimedScan::default());
    assert!(stage.localizer.pose().is_finite());
}
