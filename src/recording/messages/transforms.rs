//! `tf2_msgs/TFMessage`: the frames of REP-105, `map` to `odom` to `base_link`.

use crate::geometry::{Pose, wrap_angle};
use crate::recording::cdr::Encoder;
use crate::recording::parts::{self, BASE, MAP, ODOM};

/// Of a robot that believes to be at a pose of the map while its odometry has it at another.
pub fn transforms(time_s: f64, belief: &Pose, odometry: &Pose) -> Vec<u8> {
    let mut message = Encoder::new();
    let frames = [
        (MAP, ODOM, odometry_frame(belief, odometry)),
        (ODOM, BASE, *odometry),
    ];
    message.count(frames.len());
    for (parent, child, pose) in &frames {
        parts::header(&mut message, time_s, parent);
        message.text(child);
        parts::pose(&mut message, pose);
    }
    message.finish()
}

/// Where the odometry's frame lies on the map, so that both say the same of the robot.
fn odometry_frame(belief: &Pose, odometry: &Pose) -> Pose {
    let turned = Pose::new(0.0, 0.0, wrap_angle(belief.yaw - odometry.yaw));
    let way = turned.transform(&odometry.position());
    Pose::new(belief.x - way.x, belief.y - way.y, turned.yaw)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_two_frames_together_lead_to_the_robot() {
        let (belief, odometry) = (Pose::new(3.0, -1.0, 2.9), Pose::new(2.5, 0.5, -3.0));
        let frame = odometry_frame(&belief, &odometry);
        let robot = frame.transform(&odometry.position());
        assert!((robot - belief.position()).norm() < 1e-12);
        assert!(wrap_angle(frame.yaw + odometry.yaw - belief.yaw).abs() < 1e-12);
    }
}
