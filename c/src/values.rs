//! Plain values.

use inbye::geometry::{MAX_COORDINATE, Point, Pose, Twist};
use inbye::map::MovingDisc;

/// A point in the map frame, metres.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct InbyePoint {
    pub x: f64,
    pub y: f64,
}

/// A pose: metres, and the yaw in radians, counter-clockwise.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct InbyePose {
    pub x: f64,
    pub y: f64,
    pub yaw: f64,
}

/// A velocity: m/s forward, and rad/s counter-clockwise.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub struct InbyeTwist {
    pub linear: f64,
    pub angular: f64,
}

/// A moving obstacle in the map frame: centre and radius in metres, velocity in m/s.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct InbyeMovingDisc {
    pub x: f64,
    pub y: f64,
    pub radius: f64,
    pub vx: f64,
    pub vy: f64,
}

/// Checks coordinates, metres, and yaws, radians.
pub fn check_coordinates<const N: usize>(numbers: [f64; N], name: &str) -> Result<(), String> {
    let is_finite = numbers.iter().all(|number| number.is_finite());
    finite((), is_finite, name)?;
    if numbers.iter().any(|number| number.abs() > MAX_COORDINATE) {
        return Err(format!(
            "{name} has a number beyond {MAX_COORDINATE:e}: write metres and radians"
        ));
    }
    Ok(())
}

impl InbyePoint {
    pub fn checked(&self, name: &str) -> Result<Point, String> {
        check_coordinates([self.x, self.y], name).map(|()| Point::new(self.x, self.y))
    }
}

impl From<&Point> for InbyePoint {
    fn from(point: &Point) -> Self {
        Self { x: point.x, y: point.y }
    }
}

impl InbyePose {
    pub fn checked(&self, name: &str) -> Result<Pose, String> {
        let Self { x, y, yaw } = *self;
        check_coordinates([x, y, yaw], name).map(|()| Pose::new(x, y, yaw))
    }
}

impl InbyeTwist {
    pub fn checked(&self, name: &str) -> Result<Twist, String> {
        let twist = Twist::new(self.linear, self.angular);
        finite(twist, twist.is_finite(), name)
    }
}

impl From<&Twist> for InbyeTwist {
    fn from(twist: &Twist) -> Self {
        Self { linear: twist.linear, angular: twist.angular }
    }
}

impl From<&InbyeMovingDisc> for MovingDisc {
    fn from(disc: &InbyeMovingDisc) -> Self {
        Self { x: disc.x, y: disc.y, radius: disc.radius, vx: disc.vx, vy: disc.vy }
    }
}

fn finite<T>(value: T, is_finite: bool, name: &str) -> Result<T, String> {
    if is_finite { Ok(value) } else { Err(format!("{name} is not finite")) }
}
