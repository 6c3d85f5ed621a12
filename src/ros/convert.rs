//! Conversions to ROS messages.

use super::msg::{
    Header, Path, Point, Pose, PoseStamped, Quaternion, Time, Transform, Twist, TwistStamped,
    Vector3,
};
use crate::geometry::{self, bearing};

const NANOSECONDS: u64 = 1_000_000_000;

/// Converts seconds to the nearest nanosecond. Negative times and NaN become zero.
#[must_use]
pub(crate) fn nanoseconds(time_s: f64) -> u64 {
    (time_s * NANOSECONDS as f64).round() as u64
}

impl Time {
    /// Converts seconds to the nearest nanosecond. Negative times and NaN become zero.
    #[must_use]
    pub fn from_seconds(time_s: f64) -> Self {
        let nanoseconds = nanoseconds(time_s);
        Self {
            sec: i32::try_from(nanoseconds / NANOSECONDS).unwrap_or(i32::MAX),
            nanosec: (nanoseconds % NANOSECONDS) as u32,
        }
    }
}

impl From<&geometry::Point> for Point {
    fn from(point: &geometry::Point) -> Self {
        Self { x: point.x, y: point.y, z: 0.0 }
    }
}

impl From<&geometry::Pose> for Pose {
    fn from(pose: &geometry::Pose) -> Self {
        let (sin, cos) = libm::sincos(pose.yaw / 2.0);
        Self {
            position: Point::from(&pose.position()),
            orientation: Quaternion { x: 0.0, y: 0.0, z: sin, w: cos },
        }
    }
}

impl From<&geometry::Pose> for Transform {
    fn from(pose: &geometry::Pose) -> Self {
        let Pose { position: Point { x, y, z }, orientation: rotation } = Pose::from(pose);
        Self { translation: Vector3 { x, y, z }, rotation }
    }
}

impl From<&geometry::Twist> for Twist {
    fn from(twist: &geometry::Twist) -> Self {
        Self {
            linear: Vector3 { x: twist.linear, ..Vector3::default() },
            angular: Vector3 { z: twist.angular, ..Vector3::default() },
        }
    }
}

impl TwistStamped {
    /// A velocity with time and frame.
    #[must_use]
    pub fn new(twist: &geometry::Twist, stamp: Time, frame: &str) -> Self {
        Self { header: Header { stamp, frame_id: frame.to_owned() }, twist: Twist::from(twist) }
    }
}

/// A path whose poses face the next point. The last pose has the direction of the one before.
#[must_use]
pub(crate) fn path(points: &[geometry::Point], header: &Header) -> Path {
    let pose = |(index, point): (usize, &geometry::Point)| {
        let from = index.min(points.len().saturating_sub(2));
        let yaw = match points.get(from..from + 2) {
            Some([here, next]) => bearing(here, next),
            _ => 0.0,
        };
        PoseStamped {
            header: header.clone(),
            pose: Pose::from(&geometry::Pose::new(point.x, point.y, yaw)),
        }
    };
    Path { header: header.clone(), poses: points.iter().enumerate().map(pose).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_rounded_to_nanoseconds() {
        assert_eq!(nanoseconds(0.1), 100_000_000);
        assert_eq!(nanoseconds(3_600.3), 3_600_300_000_000);
        assert_eq!(nanoseconds(-1.0), 0);
        assert_eq!(nanoseconds(f64::NAN), 0);
        let time = Time { sec: 2, nanosec: 500_000_000 };
        assert_eq!(Time::from_seconds(2.5), time);
    }
}
