//! `tf2_msgs/TFMessage`: the frames of REP-105, `map` to `odom` to `base_link`.

use crate::geometry::Pose;
use crate::recording::cdr::Encoder;
use crate::recording::parts::{self, BASE, MAP, ODOM};

/// Of a robot that believes to be at a pose of the map while its odometry has it at another.
pub fn transforms(time_s: f64, belief: &Pose, odometry: &Pose) -> Vec<u8> {
    let mut message = Encoder::new();
    let frames = [
        (MAP, ODOM, belief.frame_origin(odometry)),
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
