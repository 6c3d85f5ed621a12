//! Points, poses and twists.
//!
//! Conventions follow REP-103: metres, seconds and radians; x forward, y left, yaw counter-clockwise from the x axis. Poses and
//! points are in the map frame unless stated otherwise. Trigonometry uses `libm`, which gives identical results on every
//! platform, so that plans and drives can be replayed bit for bit.

use core::f64::consts::{PI, TAU};

use nalgebra::{Isometry2, Point2, Vector2};
use serde::{Deserialize, Serialize};

/// A position in metres.
pub type Point = Point2<f64>;

/// A displacement in metres.
pub type Vector = Vector2<f64>;

/// A position in metres and a heading in radians.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "[f64; 3]", into = "[f64; 3]")]
pub struct Pose {
    /// Position along the x axis, metres.
    pub x: f64,
    /// Position along the y axis, metres.
    pub y: f64,
    /// Heading, radians, counter-clockwise from the x axis.
    pub yaw: f64,
}

/// A planar velocity in the robot's frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Twist {
    /// Forward speed, metres per second.
    pub linear: f64,
    /// Turn rate, radians per second, counter-clockwise positive.
    pub angular: f64,
}

impl Pose {
    /// Creates a pose from its coordinates.
    #[must_use]
    pub const fn new(x: f64, y: f64, yaw: f64) -> Self {
        Self { x, y, yaw }
    }

    /// The position.
    #[must_use]
    pub const fn position(&self) -> Point {
        Point::new(self.x, self.y)
    }

    /// The rigid transform from this pose's frame to the parent frame.
    #[must_use]
    pub fn isometry(&self) -> Isometry2<f64> {
        Isometry2::new(Vector::new(self.x, self.y), self.yaw)
    }

    /// Transforms a point from this pose's frame to the parent frame.
    #[must_use]
    pub fn transform(&self, local: &Point) -> Point {
        self.isometry().transform_point(local)
    }

    /// Transforms a point from the parent frame to this pose's frame.
    #[must_use]
    pub fn inverse_transform(&self, point: &Point) -> Point {
        self.isometry().inverse_transform_point(point)
    }

    /// Transforms a pose from this pose's frame to the parent frame; its yaw is in (-pi, pi].
    #[must_use]
    pub fn transform_pose(&self, local: &Self) -> Self {
        let position = self.transform(&local.position());
        Self::new(position.x, position.y, wrap_angle(self.yaw + local.yaw))
    }

    /// Transforms a pose from the parent frame to this pose's frame; its yaw is in (-pi, pi].
    #[must_use]
    pub fn inverse_transform_pose(&self, pose: &Self) -> Self {
        let position = self.inverse_transform(&pose.position());
        Self::new(position.x, position.y, wrap_angle(pose.yaw - self.yaw))
    }

    /// The pose of a local frame's origin, given this pose of a body in the parent frame and its pose in the local frame. An
    /// example is the transform from map to odom. Its yaw is in (-pi, pi].
    #[must_use]
    pub fn frame_origin(&self, local: &Self) -> Self {
        let yaw = wrap_angle(self.yaw - local.yaw);
        let offset = Self::new(0.0, 0.0, yaw).transform(&local.position());
        Self::new(self.x - offset.x, self.y - offset.y, yaw)
    }

    /// The pose after motion with a constant twist for a time, seconds: an exact circular arc or straight line. Its yaw is in
    /// (-pi, pi].
    #[must_use]
    pub fn after(&self, twist: &Twist, time_s: f64) -> Self {
        let half_turn = twist.angular * time_s / 2.0;
        // The chord's direction is half the turn from the start heading.
        let chord = twist.linear * time_s * sinc(half_turn);
        let (sin, cos) = libm::sincos(self.yaw + half_turn);
        Self {
            x: self.x + chord * cos,
            y: self.y + chord * sin,
            yaw: wrap_angle(self.yaw + 2.0 * half_turn),
        }
    }

    /// Interpolates along a motion with constant twist, forward and sideways, to another pose; `fraction` is 0 to 1. The turn is
    /// the smaller of both directions; the yaw is in (-pi, pi].
    #[must_use]
    pub fn interpolate(&self, end: &Self, fraction: f64) -> Self {
        // The partial chord follows from the ratio of arc to chord of both parts, and from half of the turn.
        let half_turn = wrap_angle(end.yaw - self.yaw) / 2.0;
        let length = fraction * sinc(fraction * half_turn) / sinc(half_turn);
        let (sin, cos) = libm::sincos((fraction - 1.0) * half_turn);
        let (x, y) = (end.x - self.x, end.y - self.y);
        Self {
            x: self.x + length * (cos * x - sin * y),
            y: self.y + length * (sin * x + cos * y),
            yaw: wrap_angle(self.yaw + 2.0 * fraction * half_turn),
        }
    }

    /// Whether all three coordinates are finite.
    #[must_use]
    pub const fn is_finite(&self) -> bool {
        self.x.is_finite() && self.y.is_finite() && self.yaw.is_finite()
    }
}

impl From<[f64; 3]> for Pose {
    fn from([x, y, yaw]: [f64; 3]) -> Self {
        Self { x, y, yaw }
    }
}

impl From<Pose> for [f64; 3] {
    fn from(pose: Pose) -> Self {
        [pose.x, pose.y, pose.yaw]
    }
}

impl Twist {
    /// No motion.
    pub const STOP: Self = Self { linear: 0.0, angular: 0.0 };

    /// Creates a twist from its linear and angular rate.
    #[must_use]
    pub const fn new(linear: f64, angular: f64) -> Self {
        Self { linear, angular }
    }

    /// Whether both rates are finite.
    #[must_use]
    pub const fn is_finite(&self) -> bool {
        self.linear.is_finite() && self.angular.is_finite()
    }
}

/// Wraps an angle to (-pi, pi].
#[must_use]
pub fn wrap_angle(angle: f64) -> f64 {
    let wrapped = libm::fmod(angle, TAU);
    if wrapped > PI {
        wrapped - TAU
    } else if wrapped <= -PI {
        wrapped + TAU
    } else {
        wrapped
    }
}

/// The direction from one point to another, radians in (-pi, pi]; zero for equal points.
#[must_use]
pub fn bearing(from: &Point, to: &Point) -> f64 {
    libm::atan2(to.y - from.y, to.x - from.x)
}

/// The point of a segment nearest to a given point. The segment may be a single point.
#[must_use]
pub fn nearest_on_segment(from: &Point, to: &Point, point: &Point) -> Point {
    let whole = to - from;
    let squared = whole.norm_squared();
    let fraction =
        if squared > 0.0 { (whole.dot(&(point - from)) / squared).clamp(0.0, 1.0) } else { 0.0 };
    from + whole * fraction
}

/// The ratio of chord to arc length: sin(h) / h for an arc with a turn of 2 h, radians.
fn sinc(half_turn: f64) -> f64 {
    if half_turn.abs() < 1e-4 {
        1.0 - half_turn * half_turn / 6.0
    } else {
        libm::sin(half_turn) / half_turn
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
