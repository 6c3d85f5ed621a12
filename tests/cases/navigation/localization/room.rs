//! Consecutive revolutions in a room with known walls.

use core::f64::consts::PI;

use inbye::geometry::{Point, Pose, wrap_angle};
use inbye::localization::{
    LocalizationError, LocalizationSettings, LocalizationStatus, Localizer, LostReason,
    PoseEstimate,
};
use inbye::map::{Cell, GridFrame, MovingDisc, ObstacleGrid, TimedScan};
use inbye::sim::{Lidar, World};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

pub use crate::support::carried::lidar;

/// Free boxes in solid rock, each from lower left to upper right corner, metres in the grid's frame; cells of 5 cm.
pub fn ground(origin: Pose, boxes: &[[f64; 4]]) -> ObstacleGrid {
    let frame = GridFrame::new(400, 300, 0.05, origin).expect("a frame");
    let mut obstacles = ObstacleGrid::filled(frame, true);
    for row in 0..frame.height {
        for column in 0..frame.width {
            let center = Cell::new(column, row).center().to_vector() * frame.resolution_m;
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

/// A room of 6 m by 4 m with a niche.
pub const ROOM: [[f64; 4]; 2] = [[2.0, 3.0, 8.0, 7.0], [4.0, 7.0, 5.5, 8.2]];

/// A roadway 3 m wide.
const ROADWAY: [[f64; 4]; 1] = [[0.5, 6.0, 19.5, 9.0]];

pub struct Stage {
    pub world: World,
    pub localizer: Localizer,
    pub rng: Pcg64Mcg,
}

impl Stage {
    pub fn new(obstacles: ObstacleGrid, start: &Pose) -> Self {
        let settings = LocalizationSettings::default();
        let localizer = Localizer::new(&obstacles, settings, start);
        Self {
            localizer: localizer.expect("valid settings and start"),
            world: World::new(obstacles),
            rng: Pcg64Mcg::seed_from_u64(3),
        }
    }

    fn update(&mut self, lidar: &Lidar, truth: &Pose, time_s: f64) -> PoseEstimate {
        let seen = lidar.scan(&self.world, truth, &mut self.rng);
        *self.localizer.update(&TimedScan::from_scan(&seen.scan, time_s, 0.0))
    }

    /// Updates with several revolutions at one pose.
    fn stand_still(&mut self, truth: &Pose, times: u32) -> PoseEstimate {
        self.stand_still_with(&lidar(), truth, times)
    }

    fn stand_still_with(&mut self, lidar: &Lidar, truth: &Pose, times: u32) -> PoseEstimate {
        for tick in 0..times {
            let time_s = 0.1 * f64::from(tick);
            self.localizer.predict(time_s, &Pose::default());
            self.update(lidar, truth, time_s);
        }
        *self.localizer.estimate()
    }
}

fn errors(estimate: &PoseEstimate, truth: &Pose) -> (f64, f64) {
    let error_m = (estimate.pose.position() - truth.position()).norm();
    (error_m, wrap_angle(estimate.pose.yaw - truth.yaw).abs())
}

#[test]
fn start_error_is_corrected() {
    let truth = Pose::new(4.1, 4.3, 0.4);
    for (x, y, yaw) in [(0.15, -0.1, 0.08), (-0.2, 0.1, -0.06), (0.0, 0.0, 0.1)] {
        let start = Pose::new(truth.x + x, truth.y + y, truth.yaw + yaw);
        let estimate = Stage::new(ground(Pose::default(), &ROOM), &start).stand_still(&truth, 10);
        let (error_m, error_rad) = errors(&estimate, &truth);
        assert!(error_m < 0.01 && error_rad < 0.004, "{estimate:?}");
        assert_eq!(
            (estimate.status, estimate.unobservable_directions),
            (LocalizationStatus::Tracking, 0)
        );
        assert!(estimate.agreement.matching_fraction() > 0.95, "{estimate:?}");
    }
}

/// Checks that the axes of a rotated map are not confused.
#[test]
fn rotated_map_is_supported() {
    let origin = Pose::new(-3.0, 5.0, 0.6);
    let place = origin.transform(&Point::new(4.1, 4.3));
    let truth = Pose::new(place.x, place.y, -2.0);
    let start = Pose::new(truth.x - 0.1, truth.y + 0.1, truth.yaw + 0.05);
    let estimate = Stage::new(ground(origin, &ROOM), &start).stand_still(&truth, 10);
    let (error_m, error_rad) = errors(&estimate, &truth);
    assert!(error_m < 0.01 && error_rad < 0.004, "{estimate:?}");
}

/// Half of the beams leave the map, which has walls in the south only, through free space.
#[test]
fn beams_that_leave_the_map_do_not_contradict_it() {
    let yard = [[0.0, 3.0, 20.0, 15.0], [4.0, 2.0, 5.5, 3.0], [12.0, 1.5, 14.0, 3.0]];
    let truth = Pose::new(9.0, 10.0, 0.4);
    let estimate = Stage::new(ground(Pose::default(), &yard), &truth).stand_still(&truth, 10);
    assert_eq!(estimate.status, LocalizationStatus::Tracking, "{estimate:?}");
    assert_eq!(estimate.agreement.through_walls, 0, "{estimate:?}");
    assert!(estimate.agreement.off_map > 120, "{estimate:?}");
    assert!(errors(&estimate, &truth).0 < 0.02, "{estimate:?}");
    // From a pose turned round, beams leave the map through the rock in the south.
    let truth = Pose::new(9.0, 4.5, 0.4);
    let turned = Pose::new(truth.x, truth.y, truth.yaw + PI);
    let estimate = Stage::new(ground(Pose::default(), &yard), &turned).stand_still(&truth, 2);
    assert!(estimate.agreement.through_walls > 60, "{estimate:?}");
    assert_ne!(estimate.status, LocalizationStatus::Tracking, "{estimate:?}");
}

#[test]
fn unmapped_people_do_not_bias_the_pose() {
    let truth = Pose::new(4.1, 4.3, 0.4);
    let mut stage = Stage::new(ground(Pose::default(), &ROOM), &truth);
    let person = |x, y| MovingDisc { x, y, radius: 0.3, vx: 0.0, vy: 0.0 };
    stage.world.moving = vec![person(5.0, 4.3), person(4.2, 5.2), person(3.2, 3.9)];
    let estimate = stage.stand_still(&truth, 10);
    assert!(errors(&estimate, &truth).0 < 0.012, "{estimate:?}");
    assert_eq!(estimate.status, LocalizationStatus::Tracking);
    assert!(estimate.agreement.unmapped() > 60, "{estimate:?}");
}

/// Two people hide more than half of what a lidar with a field of view of 180 degrees sees. One of them is at its edge.
#[test]
fn people_who_hide_most_of_the_map_do_not_lose_a_robot() {
    let truth = Pose::new(4.1, 4.3, 0.4);
    let lidar = lidar().field_of_view_rad(PI);
    let at = |x: f64, y: f64| truth.transform(&Point::new(x, y));
    let mut stage = Stage::new(ground(Pose::default(), &ROOM), &truth);
    stage.stand_still_with(&lidar, &truth, 10);
    let person =
        |place: Point| MovingDisc { x: place.x, y: place.y, radius: 0.3, vx: 0.0, vy: 0.0 };
    stage.world.moving = vec![person(at(0.5, 0.15)), person(at(0.25, -0.8))];
    let estimate = stage.stand_still_with(&lidar, &truth, 40);
    assert!(estimate.agreement.matching < estimate.agreement.beams / 2, "{estimate:?}");
    assert!(estimate.agreement.alone > 60, "{estimate:?}");
    assert!(estimate.status.lost_reason().is_none(), "{estimate:?}");
    assert!(errors(&estimate, &truth).0 < 0.012, "{estimate:?}");
}

/// Drives a number of metres along the middle of a smooth roadway from an x, metres; odometry reads 5 % too much.
fn along_the_roadway(lidar: &Lidar, from_x: f64, metres: f64) -> (PoseEstimate, Pose, f64) {
    let start = Pose::new(from_x, 7.5, 0.0);
    let mut stage = Stage::new(ground(Pose::default(), &ROADWAY), &start);
    let mut truth = start;
    for tick in 0..=100 {
        let distance_m = 0.01 * metres * f64::from(tick);
        truth = Pose::new(from_x + distance_m, 7.5, 0.0);
        let time_s = 0.1 * f64::from(tick);
        stage.localizer.predict(time_s, &Pose::new(distance_m / 0.95, 0.0, 0.0));
        let status = stage.update(lidar, &truth, time_s).status;
        assert_eq!(status.lost_reason(), None, "{truth:?}");
    }
    let (distance_scale, _) = stage.localizer.odometry_scale();
    (*stage.localizer.estimate(), truth, distance_scale)
}

#[test]
fn smooth_roadway_leaves_the_pose_along_it_to_odometry() {
    let short = lidar().range_max_m(6.0);
    let (estimate, truth, distance_scale) = along_the_roadway(&short, 9.0, 2.0);
    assert_eq!(estimate.unobservable_directions, 1);
    // The slip over 2 m remains along the roadway; there is no error across it.
    assert!((estimate.pose.x - truth.x - 0.105).abs() < 0.01, "{estimate:?}");
    assert!((estimate.pose.y - truth.y).abs() < 0.005, "{estimate:?}");
    assert!(errors(&estimate, &truth).1 < 0.003, "{estimate:?}");
    assert!(estimate.covariance[0][0].sqrt() > 0.1, "{estimate:?}");
    assert!(estimate.covariance[1][1].sqrt() < 0.02, "{estimate:?}");
    assert_eq!(estimate.status, LocalizationStatus::Uncertain);
    assert!((distance_scale - 1.0).abs() < 1e-6, "{distance_scale}");
}

#[test]
fn visible_roadway_end_lets_the_filter_learn_slip() {
    let (estimate, truth, distance_scale) = along_the_roadway(&lidar(), 9.0, 2.0);
    assert_eq!(
        (estimate.unobservable_directions, estimate.status),
        (0, LocalizationStatus::Tracking)
    );
    assert!(errors(&estimate, &truth).0 < 0.02, "{estimate:?}");
    assert!((distance_scale - 0.95).abs() < 0.02, "{distance_scale}");
}

/// The error along the walls is 0.5 m when their end comes into view.
#[test]
fn end_of_a_smooth_roadway_corrects_the_pose_at_once() {
    let short = lidar().range_max_m(4.0);
    let (estimate, truth, distance_scale) = along_the_roadway(&short, 5.0, 11.0);
    assert!(errors(&estimate, &truth).0 < 0.03, "{estimate:?}");
    assert!((distance_scale - 0.95).abs() < 0.02, "{distance_scale}");
}

/// Without corrections, the pose follows odometry.
#[test]
fn pose_drifts_without_scans() {
    let start = Pose::new(4.1, 4.3, 0.4);
    let mut stage = Stage::new(ground(Pose::default(), &ROOM), &start);
    for tick in 0..=100 {
        let yaw = 0.05 * f64::from(tick);
        stage.localizer.predict(0.1 * f64::from(tick), &Pose::new(0.0, 0.0, yaw));
    }
    let estimate = stage.localizer.estimate();
    assert!((wrap_angle(estimate.pose.yaw - 5.4)).abs() < 1e-9, "{estimate:?}");
    assert!(estimate.sigma_rad() > 0.1, "{estimate:?}");
}

#[test]
fn occluded_lidar_relocalises_after_consecutive_matches() {
    let truth = Pose::new(4.1, 4.3, 0.4);
    let mut stage = Stage::new(ground(Pose::default(), &ROOM), &truth);
    stage.stand_still(&truth, 10);
    let occluded = lidar().dropout(1.0);
    let mut statuses = Vec::new();
    for tick in 10..40 {
        let used = if tick < 20 { occluded } else { lidar() };
        statuses.push(stage.update(&used, &truth, 0.1 * f64::from(tick)).status);
    }
    assert_eq!(statuses[3], LocalizationStatus::Uncertain);
    assert_eq!(statuses[4..10], [LocalizationStatus::Lost(LostReason::NoReturns); 6]);
    // Five matching revolutions confirm the pose.
    assert_eq!(statuses[10..14], [LocalizationStatus::Lost(LostReason::NoReturns); 4]);
    assert!(
        statuses[15..].iter().all(|status| *status == LocalizationStatus::Tracking),
        "{statuses:?}"
    );
}

/// A late revolution moves the pose by centimetres. Seen from its other end, the roadway looks the same.
#[test]
fn robot_off_by_centimetres_is_found_where_the_map_has_two_such_places() {
    let truth = Pose::new(5.0, 7.5, 0.0);
    let mut stage = Stage::new(ground(Pose::default(), &ROADWAY), &truth);
    assert_eq!(stage.stand_still(&truth, 20).status, LocalizationStatus::Tracking);
    let beside = Pose::new(5.1, 7.6, 0.0);
    let estimate = stage.stand_still(&beside, 6);
    assert_eq!(estimate.status.lost_reason(), Some(LostReason::PoseJump), "{estimate:?}");
    let estimate = stage.stand_still(&beside, 15);
    assert_eq!(estimate.status.lost_reason(), None, "{estimate:?}");
    assert!(errors(&estimate, &beside).0 < 0.02, "{estimate:?}");
}

/// The encoders have another resolution than the settings say: the robot would drive at twice its limits.
#[test]
fn robot_that_moves_farther_than_its_tracks_say_is_lost_with_the_cause() {
    let drive = |share: f64| {
        let start = Pose::new(4.0, 7.5, 0.0);
        let mut stage = Stage::new(ground(Pose::default(), &ROADWAY), &start);
        for tick in 0..=60 {
            let (time_s, distance_m) = (0.1 * f64::from(tick), 0.05 * f64::from(tick));
            stage.localizer.predict(time_s, &Pose::new(share * distance_m, 0.0, 0.0));
            stage.update(&lidar(), &Pose::new(4.0 + distance_m, 7.5, 0.0), time_s);
        }
        stage.localizer.estimate().status.lost_reason()
    };
    assert_eq!(drive(0.5), Some(LostReason::OdometryScale));
    assert_eq!(drive(0.9), None);
    assert_eq!(drive(1.4), None, "slip");
}

#[test]
fn localizer_rejects_bad_settings_and_start() {
    let ground = ground(Pose::default(), &ROOM);
    let bad = LocalizationSettings::default().outlier_distance_m(f64::NAN);
    let error = Localizer::new(&ground, bad, &Pose::default()).expect_err("NaN is invalid");
    assert_eq!(error.to_string(), "outlier_distance_m is NaN: it must be above zero and at most 1");
    let not_finite = Pose::new(f64::NAN, 0.0, 0.0);
    let error = Localizer::new(&ground, LocalizationSettings::default(), &not_finite);
    assert!(matches!(error, Err(LocalizationError::BadStart { .. })));
}

/// Sensor values that are not finite change nothing and cause no panic.
#[test]
fn localizer_ignores_values_that_are_not_finite() {
    let truth = Pose::new(4.1, 4.3, 0.4);
    let mut stage = Stage::new(ground(Pose::default(), &ROOM), &truth);
    stage.stand_still(&truth, 5);
    let before = *stage.localizer.estimate();
    stage.localizer.predict(f64::NAN, &Pose::default());
    stage.localizer.predict(1.0, &Pose::new(f64::INFINITY, 0.0, 0.0));
    assert_eq!(*stage.localizer.estimate(), before);
    let seen = lidar().scan(&stage.world, &truth, &mut stage.rng);
    let mut scan = TimedScan::from_scan(&seen.scan, 0.5, 0.0);
    for (number, beam) in scan.beams.iter_mut().enumerate() {
        match number % 4 {
            0 => beam.angle = f64::NAN,
            1 => beam.range = f64::NAN,
            2 => beam.time_s = f64::NAN,
            _ => {}
        }
    }
    let estimate = *stage.localizer.update(&scan);
    assert!(estimate.pose.is_finite() && errors(&estimate, &truth).0 < 0.02, "{estimate:?}");
    stage.localizer.update(&TimedScan::default());
    assert!(stage.localizer.pose().is_finite());
}

/// A robot that stands, drives or is moved, with the time of its last revolution, seconds.
struct Moved {
    stage: Stage,
    time_s: f64,
    odometry: Pose,
}

impl Moved {
    fn standing(truth: &Pose) -> Self {
        let stage = Stage::new(ground(Pose::default(), &ROADWAY), truth);
        let mut moved = Self { stage, time_s: 0.0, odometry: Pose::default() };
        (0..20).for_each(|_| _ = moved.revolution(&lidar(), truth));
        moved
    }

    fn revolution(&mut self, used: &Lidar, truth: &Pose) -> PoseEstimate {
        self.time_s += 0.1;
        self.stage.localizer.predict(self.time_s, &self.odometry);
        self.stage.update(used, truth, self.time_s)
    }

    /// Repeats revolutions until the pose is lost. Returns the reason, and by how much the variances of position and yaw grow
    /// with the loss and with the rejected revolution before it.
    fn until_lost(&mut self, used: &Lidar, truth: &Pose) -> (LostReason, [f64; 2], [f64; 2]) {
        let variances = |estimate: &PoseEstimate| [0, 2].map(|at| estimate.covariance[at][at]);
        let (mut last, mut before) = (variances(self.stage.localizer.estimate()), [0.0; 2]);
        for _ in 0..12 {
            let estimate = self.revolution(used, truth);
            let now = variances(&estimate);
            let grown = [now[0] - last[0], now[1] - last[1]];
            if let Some(reason) = estimate.status.lost_reason() {
                return (reason, grown, before);
            }
            (last, before) = (now, grown);
        }
        panic!("not lost: {:?}", self.stage.localizer.estimate());
    }
}

/// A variance of 0.03 m or rad squared, and what odometry adds.
fn is_widened(grown: [f64; 2]) -> bool {
    grown.iter().all(|grown| (0.0009 - 1e-9..0.001).contains(grown))
}

fn is_kept(grown: [f64; 2]) -> bool {
    grown.iter().all(|grown| (-1e-4..1e-4).contains(grown))
}

#[test]
fn pose_that_is_lost_by_a_jump_is_less_certain_by_the_jump_and_by_nothing_else() {
    let truth = Pose::new(5.0, 7.5, 0.0);
    let beside = Pose::new(5.1, 7.6, 0.0);
    let (reason, at_loss, before) = Moved::standing(&truth).until_lost(&lidar(), &beside);
    assert_eq!(reason, LostReason::PoseJump);
    assert!(is_widened(at_loss) && is_kept(before), "{at_loss:?} {before:?}");
    let occluded = lidar().dropout(1.0);
    let (reason, at_loss, before) = Moved::standing(&truth).until_lost(&occluded, &truth);
    assert_eq!(reason, LostReason::NoReturns);
    assert!(is_kept(at_loss) && is_kept(before), "{at_loss:?} {before:?}");
}

/// A pose that was found may be wrong: a jump soon after speaks against it.
#[test]
fn jump_soon_after_the_pose_was_found_does_not_widen_it() {
    let jump_after = |steps: u32| {
        let mut truth = Pose::new(5.0, 7.5, 0.0);
        let mut moved = Moved::standing(&truth);
        truth = Pose::new(5.1, 7.6, 0.0);
        assert_eq!(moved.until_lost(&lidar(), &truth).0, LostReason::PoseJump);
        (0..15).for_each(|_| _ = moved.revolution(&lidar(), &truth));
        for _ in 0..steps {
            truth.x += 0.05;
            moved.odometry.x += 0.05;
            moved.revolution(&lidar(), &truth);
        }
        assert_eq!(moved.stage.localizer.estimate().status, LocalizationStatus::Tracking);
        truth = Pose::new(truth.x + 0.1, truth.y - 0.1, 0.0);
        let (reason, grown, _) = moved.until_lost(&lidar(), &truth);
        assert_eq!(reason, LostReason::PoseJump, "after {steps} steps");
        grown
    };
    let (soon, later) = (jump_after(16), jump_after(26));
    assert!(is_kept(soon) && is_widened(later), "{soon:?} {later:?}");
}
