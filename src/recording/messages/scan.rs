//! `sensor_msgs/LaserScan`: what the lidar saw.

use crate::map::Scan;
use crate::recording::cdr::Encoder;
use crate::recording::parts::{self, BASE};

/// A scan measured at a time by a lidar that sees from `range_min_m` on. Numbers are rounded to float32.
pub fn scan(time_s: f64, scan: &Scan, range_min_m: f64) -> Vec<u8> {
    let mut message = Encoder::new();
    parts::header(&mut message, time_s, BASE);
    message.f32(scan.angle_min);
    message.f32(scan.angle(scan.ranges.len().saturating_sub(1)));
    message.f32(scan.angle_increment);
    // A scan of the simulated lidar is taken at one instant.
    message.f32(0.0);
    message.f32(0.0);
    message.f32(range_min_m);
    message.f32(scan.range_max);
    message.count(scan.ranges.len());
    scan.ranges.iter().for_each(|&range| message.f32(range));
    message.count(0);
    message.finish()
}
