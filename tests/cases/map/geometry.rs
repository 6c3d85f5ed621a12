//! Poses, twists and angles.

use core::f64::consts::{PI, TAU};

use inbye::geometry::{Point, Pose, Twist, wrap_angle};

#[test]
fn wrap_angle_gives_the_half_open_range() {
    assert_eq!(wrap_angle(0.0), 0.0);
    assert_eq!(wrap_angle(PI), PI);
    assert_eq!(wrap_angle(-PI), PI);
    assert!((wrap_angle(3.0 * PI) - PI).abs() < 1e-12);
    assert!((wrap_angle(-0.5 - TAU) + 0.5).abs() < 1e-12);
}

#[test]
fn transform_rotates_by_the_yaw() {
    let pose = Pose::new(1.0, 2.0, PI / 2.0);
    let ahead = pose.transform(&Point::new(3.0, 0.0));
    assert!((ahead - Point::new(1.0, 5.0)).norm() < 1e-12);
    assert!((pose.inverse_transform(&ahead) - Point::new(3.0, 0.0)).norm() < 1e-12);
}

#[test]
fn half_circle_ends_one_diameter_to_the_left() {
    // 1 m/s at 0.5 rad/s is a circle of radius 2 m; half of it takes 2 pi seconds.
    let end = Pose::default().after(&Twist::new(1.0, 0.5), 2.0 * PI);
    assert!(end.x.abs() < 1e-12 && (end.y - 4.0).abs() < 1e-12);
    assert!((end.yaw.abs() - PI).abs() < 1e-12);
}

#[test]
fn pose_transforms_are_inverse() {
    let frame = Pose::new(3.0, -1.0, 2.5);
    let there = frame.transform_pose(&Pose::new(1.0, 0.5, 1.5));
    assert!((there.position() - frame.transform(&Point::new(1.0, 0.5))).norm() < 1e-12);
    assert!((there.yaw - (4.0 - 2.0 * PI)).abs() < 1e-12);
    let back = frame.inverse_transform_pose(&there);
    assert!((back.position() - Point::new(1.0, 0.5)).norm() < 1e-12);
    assert!((back.yaw - 1.5).abs() < 1e-12);
    let found = there.frame_origin(&back);
    assert!((found.position() - frame.position()).norm() < 1e-12);
    assert!((found.yaw - frame.yaw).abs() < 1e-12);
}

#[test]
fn frame_origin_of_odometry_maps_to_the_robot() {
    let (belief, odometry) = (Pose::new(3.0, -1.0, 2.9), Pose::new(2.5, 0.5, -3.0));
    let frame = belief.frame_origin(&odometry);
    let robot = frame.transform(&odometry.position());
    assert!((robot - belief.position()).norm() < 1e-12);
    assert!(wrap_angle(frame.yaw + odometry.yaw - belief.yaw).abs() < 1e-12);
}

#[test]
fn interpolated_poses_are_on_the_arc() {
    let start = Pose::new(3.0, -1.0, 2.5);
    for (linear, angular) in [(1.0, 0.5), (-0.4, 1.3), (0.7, 0.0), (0.0, -2.0)] {
        let twist = Twist::new(linear, angular);
        let end = start.after(&twist, 1.0);
        for fraction in [0.0, 0.25, 0.6, 1.0] {
            let (interpolated, there) =
                (start.interpolate(&end, fraction), start.after(&twist, fraction));
            assert!((interpolated.position() - there.position()).norm() < 1e-12);
            assert!(wrap_angle(interpolated.yaw - there.yaw).abs() < 1e-12);
        }
    }
}

#[test]
fn after_is_continuous_at_the_small_angle_limit() {
    let x_of = |angular| Pose::default().after(&Twist::new(1.0, angular), 1.0).x;
    assert!((x_of(1.999e-4) - x_of(2.001e-4)).abs() < 2e-11);
    assert!((x_of(0.0) - 1.0).abs() < 1e-15);
}
