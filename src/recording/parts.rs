//! What messages are made of: times, headers, points, poses.

use super::cdr::Encoder;
use crate::geometry::{Point, Pose, Twist};

/// REP-105's fixed frame.
pub const MAP: &str = "map";
/// The frame in which odometry never jumps.
pub const ODOM: &str = "odom";
/// The robot's own frame; the lidar is at its origin.
pub const BASE: &str = "base_link";

const NANOSECONDS: u64 = 1_000_000_000;

/// A time in seconds as nanoseconds, to the nearest; zero for times before zero and what is no time.
pub fn nanoseconds(time_s: f64) -> u64 {
    (time_s * NANOSECONDS as f64).round() as u64
}

/// `builtin_interfaces/Time`.
pub fn time(to: &mut Encoder, time_s: f64) {
    let nanoseconds = nanoseconds(time_s);
    to.i32(i32::try_from(nanoseconds / NANOSECONDS).unwrap_or(i32::MAX));
    to.u32((nanoseconds % NANOSECONDS) as u32);
}

/// `std_msgs/Header`.
pub fn header(to: &mut Encoder, time_s: f64, frame: &str) {
    time(to, time_s);
    to.text(frame);
}

/// `geometry_msgs/Point` on the ground.
pub fn point(to: &mut Encoder, point: &Point) {
    to.all_f64([point.x, point.y, 0.0]);
}

/// `geometry_msgs/Quaternion` of a turn about the vertical, radians.
pub fn turn(to: &mut Encoder, yaw: f64) {
    let (sin, cos) = libm::sincos(yaw / 2.0);
    to.all_f64([0.0, 0.0, sin, cos]);
}

/// `geometry_msgs/Pose` on the ground.
pub fn pose(to: &mut Encoder, pose: &Pose) {
    point(to, &pose.position());
    turn(to, pose.yaw);
}

/// `geometry_msgs/Twist`.
pub fn twist(to: &mut Encoder, twist: &Twist) {
    to.all_f64([twist.linear, 0.0, 0.0, 0.0, 0.0, twist.angular]);
}

/// `float64[36]` of a covariance that nobody knows.
pub fn covariance(to: &mut Encoder) {
    to.all_f64([0.0; 36]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_to_the_nearest_nanosecond() {
        assert_eq!(nanoseconds(0.1), 100_000_000);
        assert_eq!(nanoseconds(3_600.3), 3_600_300_000_000);
        assert_eq!(nanoseconds(-1.0), 0);
        assert_eq!(nanoseconds(f64::NAN), 0);
        let mut message = Encoder::new();
        time(&mut message, 2.5);
        assert_eq!(message.finish()[4..], [2, 0, 0, 0, 0, 0x65, 0xCD, 0x1D]);
    }
}
