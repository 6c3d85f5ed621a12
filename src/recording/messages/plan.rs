//! `nav_msgs/Path`: a global path.

use crate::geometry::{Point, Pose};
use crate::global::Path;
use crate::recording::cdr::Encoder;
use crate::recording::parts::{self, MAP};

/// A path that is followed from a time on, each pose facing the next.
pub fn plan(time_s: f64, path: &Path) -> Vec<u8> {
    let points = path.points();
    let mut message = Encoder::new();
    parts::header(&mut message, time_s, MAP);
    message.count(points.len());
    for (index, point) in points.iter().enumerate() {
        parts::header(&mut message, time_s, MAP);
        let facing = Pose::new(point.x, point.y, yaw(points, index));
        parts::pose(&mut message, &facing);
    }
    message.finish()
}

/// From a point to the next, or to the last from the one before.
fn yaw(points: &[Point], index: usize) -> f64 {
    let from = index.min(points.len().saturating_sub(2));
    let Some([here, next]) = points.get(from..from + 2) else {
        return 0.0;
    };
    crate::geometry::bearing(here, next)
}
