//! `geometry_msgs/TwistStamped`: the command sent to the base.

use crate::geometry::Twist;
use crate::recording::cdr::Encoder;
use crate::recording::parts::{self, BASE};

/// A command of a time.
pub fn command(time_s: f64, command: &Twist) -> Vec<u8> {
    let mut message = Encoder::new();
    parts::header(&mut message, time_s, BASE);
    parts::twist(&mut message, command);
    message.finish()
}
