//! Robots without a pose, or with a wrong one, in a mine, and in rooms that look alike.

use inbye::geometry::{Point, Pose};
use inbye::localization::{LocalizationSettings, LocalizationStatus, Localizer, LostReason};
use inbye::map::{TimedScan, UnknownPolicy};
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
    let status_at = |truth: &Pose| {
        let mut rng = Pcg64Mcg::seed_from_u64(8);
        let localizer = Localizer::without_pose(&map, LocalizationSettings::default());
        let mut localizer = localizer.expect("valid settings");
        for tick in 0..20 {
            let time_s = 0.1 * f64::from(tick);
            localizer.predict(time_s, &Pose::default());
            let seen = lidar().scan(&world, truth, &mut rng);
            localizer.update(&TimedScan::from_scan(&seen.scan, time_s, 0.0));
        }
        *localizer.estimate()
    };
    for truth in [Pose::new(2.0, 2.1, 0.3), Pose::new(9.4, 3.0, -2.0)] {
        let status = status_at(&truth).status;
        assert_eq!(status, LocalizationStatus::Lost(LostReason::Ambiguous), "{truth:?}");
    }
    let truth = Pose::new(3.8, 7.9, 1.0);
    let found = status_at(&truth);
    assert_eq!(found.status, LocalizationStatus::Tracking);
    let error = found.pose.position() - Point::new(truth.x, truth.y);
    assert!(error.norm() < 0.03 && (found.pose.yaw - truth.yaw).abs() < 0.02, "{found:?}");
}
