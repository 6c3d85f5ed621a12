//! Robots without a pose, or with a wrong one, in a mine, and in rooms that look alike.

use core::f64::consts::{PI, TAU};

use inbye::geometry::{Point, Pose};
use inbye::localization::{
    LocalizationSettings, LocalizationStatus, Localizer, LostReason, PoseEstimate, PoseHint,
};
use inbye::map::{Cell, GridFrame, ObstacleGrid, TimedScan, UnknownPolicy};
use inbye::sim::{World, mine};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use super::room::{ROOM, ground, lidar};
use crate::support::carried::{Answers, Belief, carry};

#[test]
fn robot_without_a_pose_is_lost_and_says_so() {
    let localizer =
        Localizer::without_pose(&ground(Pose::default(), &ROOM), LocalizationSettings::default());
    let localizer = localizer.expect("valid settings");
    assert_eq!(localizer.estimate().status, LocalizationStatus::Lost(LostReason::NoPose));
}

#[test]
fn carried_robots_are_found_or_refused_in_a_mine() {
    let map = mine().map.obstacles(UnknownPolicy::Blocked);
    for belief in [Belief::None, Belief::Elsewhere] {
        let answers = carry(&map, 12, belief, 5).expect("the mine has room");
        let Answers { right, wrong, open, .. } = answers;
        assert!(wrong == 0 && open == 0 && right >= 6, "{belief:?}: {answers:?}");
    }
}

/// Two equal rooms, and one that no turn maps onto itself.
#[test]
fn twin_rooms_are_refused_and_a_third_one_is_found() {
    let room = |x: f64| [[x, 1.0, x + 4.0, 4.0], [x + 0.4, 4.0, x + 1.2, 4.8]];
    let corner = [[1.0, 7.0, 5.0, 10.0], [5.0, 7.0, 10.0, 8.4]];
    let map = ground(Pose::default(), &[room(1.0), room(7.0), corner].concat());
    let world = World::new(map.clone());
    let estimate_at = |truth: &Pose, hint: Option<Pose>| {
        let mut rng = Pcg64Mcg::seed_from_u64(8);
        let localizer = Localizer::without_pose(&map, LocalizationSettings::default());
        let mut localizer = localizer.expect("valid settings");
        if let Some(pose) = hint {
            let hint = PoseHint { pose, sigma_m: 0.3, sigma_rad: 0.2 };
            localizer.search_near(&hint).expect("a valid hint");
        }
        for tick in 0..20 {
            let time_s = 0.1 * f64::from(tick);
            localizer.predict(time_s, &Pose::default());
            let seen = lidar().scan(&world, truth, &mut rng);
            localizer.update(&TimedScan::from_scan(&seen.scan, time_s, 0.0));
        }
        *localizer.estimate()
    };
    for truth in [Pose::new(2.0, 2.1, 0.3), Pose::new(9.4, 3.0, -2.0)] {
        let status = estimate_at(&truth, None).status;
        assert_eq!(status, LocalizationStatus::Lost(LostReason::Ambiguous), "{truth:?}");
    }
    let truth = Pose::new(3.8, 7.9, 1.0);
    let is_found = |found: &PoseEstimate, at: &Pose| {
        assert_eq!(found.status, LocalizationStatus::Tracking);
        let error = found.pose.position() - Point::new(at.x, at.y);
        assert!(error.norm() < 0.03 && (found.pose.yaw - at.yaw).abs() < 0.02, "{found:?}");
    };
    is_found(&estimate_at(&truth, None), &truth);
    // A hint decides between the twins, and where nothing matches near it, it decides nothing.
    let (left, right) = (Pose::new(2.0, 2.1, 0.3), Pose::new(8.0, 2.1, 0.3));
    for twin in [&left, &right] {
        let hint = Pose::new(twin.x + 0.4, twin.y - 0.3, twin.yaw - 0.2);
        is_found(&estimate_at(&left, Some(hint)), twin);
    }
    is_found(&estimate_at(&truth, Some(left)), &truth);
}

/// Two equal rooms. The map lacks the right wall of the lower one, where the robot is.
#[test]
fn robot_that_tracked_its_pose_is_not_found_in_the_twin_of_a_room_that_has_changed() {
    let room = |y: f64| [[1.0, y, 7.0, y + 2.0], [5.4, y + 2.0, 6.2, y + 2.6]];
    let world = World::new(ground(Pose::default(), &[room(1.0), room(6.0)].concat()));
    let without_wall = [room(1.0), room(6.0), [[7.0, 1.0, 9.5, 3.0]; 2]].concat();
    let map = ground(Pose::default(), &without_wall);
    // The wall hides a part of what the second lidar sees that loses the pose.
    for (field_of_view_rad, from_wall_m) in [(TAU, 0.8), (PI, 0.5)] {
        let lidar = lidar().field_of_view_rad(field_of_view_rad);
        let mut rng = Pcg64Mcg::seed_from_u64(4);
        let start = Pose::new(1.6, 2.1, 0.0);
        let localizer = Localizer::new(&map, LocalizationSettings::default(), &start);
        let mut localizer = localizer.expect("valid settings");
        for tick in 0..160 {
            let time_s = 0.1 * f64::from(tick);
            let driven_m = (0.5 * time_s).min(7.0 - from_wall_m - start.x);
            localizer.predict(time_s, &Pose::new(driven_m, 0.0, 0.0));
            let truth = Pose::new(start.x + driven_m, start.y, 0.0);
            let seen = lidar.scan(&world, &truth, &mut rng);
            let estimate = localizer.update(&TimedScan::from_scan(&seen.scan, time_s, 0.0));
            let error_m = (estimate.pose.position() - truth.position()).norm();
            assert!(error_m < 0.1, "{from_wall_m} m, {time_s} s: {estimate:?}");
        }
        let is_lost = localizer.estimate().status.lost_reason().is_some();
        assert_eq!(is_lost, field_of_view_rad == PI, "{:?}", localizer.estimate());
    }
}

/// Two rooms, one with a bay. Most of the beams of a robot in the other one agree at the same place of that one too.
#[test]
fn wrong_hint_is_found_wrong_while_the_robot_stands() {
    // A niche, so that a turn does not map a room onto itself.
    let room = |x: f64| [[x, 1.0, x + 4.0, 4.0], [x - 0.5, 1.2, x, 2.2]];
    let bay = [[7.2, 4.0, 9.8, 5.2]; 2];
    let map = ground(Pose::default(), &[room(1.0), room(7.0), bay].concat());
    let (world, truth) = (World::new(map.clone()), Pose::new(2.6, 2.1, 0.3));
    let localizer = Localizer::without_pose(&map, LocalizationSettings::default());
    let mut localizer = localizer.expect("valid settings");
    let hint = PoseHint { pose: Pose::new(8.6, 2.1, 0.3), sigma_m: 0.3, sigma_rad: 0.1 };
    localizer.search_near(&hint).expect("a valid hint");
    let (mut rng, mut was_deceived) = (Pcg64Mcg::seed_from_u64(2), false);
    for tick in 0..40 {
        let time_s = 0.1 * f64::from(tick);
        localizer.predict(time_s, &Pose::default());
        let seen = lidar().scan(&world, &truth, &mut rng);
        let estimate = localizer.update(&TimedScan::from_scan(&seen.scan, time_s, 0.0));
        was_deceived |= (estimate.pose.position() - hint.pose.position()).norm() < 0.2
            && estimate.agreement.matching_fraction() > 0.76;
    }
    let found = localizer.estimate();
    let error_m = (found.pose.position() - truth.position()).norm();
    assert!(was_deceived, "the hinted place is too bad for this test");
    assert!(found.status == LocalizationStatus::Tracking && error_m < 0.03, "{found:?}");
}

#[test]
fn hint_of_an_invalid_number_is_rejected() {
    let map = ground(Pose::default(), &ROOM);
    let mut localizer =
        Localizer::without_pose(&map, LocalizationSettings::default()).expect("valid settings");
    let pose = Pose::new(2.0, 2.0, 0.0);
    let bad_pose = Pose::new(f64::NAN, 2.0, 0.0);
    for (pose, sigma_m, sigma_rad) in
        [(pose, 0.0, 0.1), (pose, 0.1, f64::NAN), (bad_pose, 0.1, 0.1)]
    {
        let hint = PoseHint { pose, sigma_m, sigma_rad };
        assert!(localizer.search_near(&hint).is_err(), "{hint:?}");
    }
}

/// A map that grows to the left: the same place has other coordinates in the grid.
#[test]
fn robot_stays_localized_on_a_larger_map() {
    let settings = LocalizationSettings::default();
    let (truth, mut rng) = (Pose::new(3.0, 4.1, 0.3), Pcg64Mcg::seed_from_u64(8));
    let map = ground(Pose::default(), &ROOM);
    let world = World::new(map.clone());
    let mut localizer = Localizer::new(&map, settings, &truth).expect("a valid pose");
    let mut drive = |localizer: &mut Localizer, ticks: core::ops::Range<u32>| {
        for tick in ticks {
            let time_s = 0.1 * f64::from(tick);
            localizer.predict(time_s, &Pose::new(5.0, 1.0, 0.2));
            let seen = lidar().scan(&world, &truth, &mut rng);
            let status = localizer.update(&TimedScan::from_scan(&seen.scan, time_s, 0.0)).status;
            assert!(status.lost_reason().is_none(), "{status:?}");
        }
    };
    drive(&mut localizer, 0..10);
    let frame = *map.frame();
    let grown = GridFrame {
        width: frame.width + 20,
        origin: Pose::new(-20.0 * frame.resolution_m, 0.0, 0.0),
        ..frame
    };
    let mut cells = vec![true; grown.len()];
    for row in 0..frame.height {
        for column in 0..frame.width {
            let from = frame.index(Cell::new(column, row));
            cells[grown.index(Cell::new(column + 20, row))] = map.cells()[from];
        }
    }
    let larger = ObstacleGrid::new(grown, cells);
    let mut after = Localizer::without_pose(&larger, settings).expect("valid settings");
    after.continue_from(&localizer);
    assert!((after.pose().position() - localizer.pose().position()).norm() < 1e-9);
    drive(&mut after, 10..20);
    let error = after.pose().position() - truth.position();
    assert!(error.norm() < 0.02, "{error:?}");
}
