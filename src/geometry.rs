//! Points, poses and twists, and the axis conventions of the whole crate.
//!
//! Conventions follow REP-103: metres, seconds and radians; x forward, y left, yaw counter-clockwise from the
//! x axis. A pose or point is in the map frame unless its name says otherwise. Trigonometry goes through `libm`,
//! whose results are the same on every platform, so that a plan can be replayed bit for bit elsewhere.

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

/// A planar velocity in the robot's own frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Twist {
    /// Forward speed, metres per second.
    pub linear: f64,
    /// Turn rate, radians per second, counter-clockwise.
    pub angular: f64,
}

impl Pose {
    /// A pose from its three coordinates.
    #[must_use]
    pub const fn new(x: f64, y: f64, yaw: f64) -> Self {
        Self { x, y, yaw }
    }

    /// The position alone.
    #[must_use]
    pub const fn position(&self) -> Point {
        Point::new(self.x, self.y)
    }

    /// The rigid motion that takes coordinates in this pose's frame to the frame the pose is given in.
    #[must_use]
    pub fn isometry(&self) -> Isometry2<f64> {
        Isometry2::new(Vector::new(self.x, self.y), self.yaw)
    }

    /// A point given in this pose's frame, in the frame the pose is given in.
    #[must_use]
    pub fn transform(&self, local: &Point) -> Point {
        self.isometry().transform_point(local)
    }

    /// A point given in the frame of the pose, in this pose's own frame.
    #[must_use]
    pub fn inverse_transform(&self, point: &Point) -> Point {
        self.isometry().inverse_transform_point(point)
    }

    /// A pose given in this pose's frame, in the frame the pose is given in; its yaw is in (-pi, pi].
    #[must_use]
    pub fn transform_pose(&self, local: &Self) -> Self {
        let place = self.transform(&local.position());
        Self::new(place.x, place.y, wrap_angle(self.yaw + local.yaw))
    }

    /// A pose given in the frame of the pose, in this pose's own frame; its yaw is in (-pi, pi].
    #[must_use]
    pub fn inverse_transform_pose(&self, pose: &Self) -> Self {
        let place = self.inverse_transform(&pose.position());
        Self::new(place.x, place.y, wrap_angle(pose.yaw - self.yaw))
    }

    /// The frame in which what is at this pose is at a local one; its yaw is in (-pi, pi].
    #[must_use]
    pub fn frame_origin(&self, local: &Self) -> Self {
        let yaw = wrap_angle(self.yaw - local.yaw);
        let way = Self::new(0.0, 0.0, yaw).transform(&local.position());
        Self::new(self.x - way.x, self.y - way.y, yaw)
    }

    /// The pose after moving with a constant twist for a time, seconds: along an arc of a circle, exact also where it is
    /// straight. Its yaw is in (-pi, pi].
    #[must_use]
    pub fn after(&self, twist: &Twist, time_s: f64) -> Self {
        let half_turn = twist.angular * time_s / 2.0;
        // The chord points half the turn away from the start.
        let chord = twist.linear * time_s * chord_share(half_turn);
        let (sin, cos) = libm::sincos(self.yaw + half_turn);
        Self {
            x: self.x + chord * cos,
            y: self.y + chord * sin,
            yaw: wrap_angle(self.yaw + 2.0 * half_turn),
        }
    }

    /// The pose after a share, 0 to 1, of a motion with constant twist, forward and sideways, that ends at another pose. It turns
    /// the shorter way round; its yaw is in (-pi, pi].
    #[must_use]
    pub fn interpolate(&self, end: &Self, share: f64) -> Self {
        // As long as the arc is to its chord, and half the turn away from it, so is the part to its own chord.
        let half_turn = wrap_angle(end.yaw - self.yaw) / 2.0;
        let length = share * chord_share(share * half_turn) / chord_share(half_turn);
        let (sin, cos) = libm::sincos((share - 1.0) * half_turn);
        let (x, y) = (end.x - self.x, end.y - self.y);
        Self {
            x: self.x + length * (cos * x - sin * y),
            y: self.y + length * (sin * x + cos * y),
            yaw: wrap_angle(self.yaw + 2.0 * share * half_turn),
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
    pub const STOP: Self = Self {
        linear: 0.0,
        angular: 0.0,
    };

    /// A twist from its two rates.
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

/// The same direction as an angle in (-pi, pi].
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

/// The direction from one point to another, radians in (-pi, pi]; zero where the points coincide.
#[must_use]
pub fn bearing(from: &Point, to: &Point) -> f64 {
    libm::atan2(to.y - from.y, to.x - from.x)
}

/// The point of a segment, which may be a single point, that is nearest to another point.
#[must_use]
pub fn nearest_on_segment(from: &Point, to: &Point, point: &Point) -> Point {
    let whole = to - from;
    let squared = whole.norm_squared();
    let share = if squared > 0.0 {
        (whole.dot(&(point - from)) / squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    from + whole * share
}

/// What share of an arc of a circle its chord is as long as: sin(h) / h, where the arc turns by 2 h, radians.
fn chord_share(half_turn: f64) -> f64 {
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
    fn wrapping_keeps_the_direction_and_the_half_open_range() {
        assert_eq!(wrap_angle(0.0), 0.0);
        assert_eq!(wrap_angle(PI), PI);
        assert_eq!(wrap_angle(-PI), PI);
        assert!((wrap_angle(3.0 * PI) - PI).abs() < 1e-12);
        assert!((wrap_angle(-0.5 - TAU) + 0.5).abs() < 1e-12);
    }

    #[test]
    fn a_pose_turns_its_own_forward_axis_to_the_left_of_the_map() {
        let pose = Pose::new(1.0, 2.0, PI / 2.0);
        let ahead = pose.transform(&Point::new(3.0, 0.0));
        assert!((ahead - Point::new(1.0, 5.0)).norm() < 1e-12);
        assert!((pose.inverse_transform(&ahead) - Point::new(3.0, 0.0)).norm() < 1e-12);
    }

    #[test]
    fn a_half_circle_ends_a_diameter_to_the_left_facing_back() {
        // 1 m/s at 0.5 rad/s is a circle of radius 2 m; half of it takes 2 pi seconds.
        let end = Pose::default().after(&Twist::new(1.0, 0.5), 2.0 * PI);
        assert!(end.x.abs() < 1e-12 && (end.y - 4.0).abs() < 1e-12);
        assert!((end.yaw.abs() - PI).abs() < 1e-12);
    }

    #[test]
    fn a_pose_in_a_frame_and_back_is_itself() {
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
    fn the_frame_of_odometry_leads_to_the_robot() {
        let (belief, odometry) = (Pose::new(3.0, -1.0, 2.9), Pose::new(2.5, 0.5, -3.0));
        let frame = belief.frame_origin(&odometry);
        let robot = frame.transform(&odometry.position());
        assert!((robot - belief.position()).norm() < 1e-12);
        assert!(wrap_angle(frame.yaw + odometry.yaw - belief.yaw).abs() < 1e-12);
    }

    #[test]
    fn on_the_way_along_an_arc_one_is_on_the_arc() {
        let start = Pose::new(3.0, -1.0, 2.5);
        for (linear, angular) in [(1.0, 0.5), (-0.4, 1.3), (0.7, 0.0), (0.0, -2.0)] {
            let twist = Twist::new(linear, angular);
            let end = start.after(&twist, 1.0);
            for share in [0.0, 0.25, 0.6, 1.0] {
                let (on_the_way, there) =
                    (start.interpolate(&end, share), start.after(&twist, share));
                assert!((on_the_way.position() - there.position()).norm() < 1e-12);
                assert!(wrap_angle(on_the_way.yaw - there.yaw).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn the_arc_has_no_seam_where_it_turns_straight() {
        let x_of = |angular| Pose::default().after(&Twist::new(1.0, angular), 1.0).x;
        assert!((x_of(1.999e-4) - x_of(2.001e-4)).abs() < 2e-11);
        assert!((x_of(0.0) - 1.0).abs() < 1e-15);
    }
}
