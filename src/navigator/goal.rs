//! Where a mission leads.

use crate::geometry::Point;

/// A place to reach, and the yaw to stand there with where one is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// Position, metres in the map frame.
    pub position: Point,
    /// Yaw, radians.
    pub yaw: Option<f64>,
}

/// A mission's start and stops: a tour where there are several, an inspection round say.
#[derive(Clone, Debug, PartialEq)]
pub struct Waypoints {
    /// Where the robot stands.
    pub start: Point,
    /// Where it shall go, one after the other; at least one.
    pub stops: Vec<Goal>,
}
