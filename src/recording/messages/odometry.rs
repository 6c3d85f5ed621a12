//! `nav_msgs/Odometry`: what the base knows of its own motion.

use crate::recording::cdr::Encoder;
use crate::recording::parts::{self, BASE, ODOM};
use crate::runtime::OdometryReading;

/// A reading at a time.
pub fn odometry(time_s: f64, reading: &OdometryReading) -> Vec<u8> {
    let mut message = Encoder::new();
    parts::header(&mut message, time_s, ODOM);
    message.text(BASE);
    parts::pose(&mut message, &reading.pose);
    parts::covariance(&mut message);
    parts::twist(&mut message, &reading.twist);
    parts::covariance(&mut message);
    message.finish()
}
