//! Points, poses and twists.
//!
//! Conventions follow REP-103: metres, seconds and radians; x forward, y left, yaw counter-clockwise from the x axis. Poses and
//! points are in the map frame unless stated otherwise. Trigonometry uses `libm`, which gives identical results on every
//! platform, so that plans and drives can be replayed bit for bit.

mod unit_square;

use core::f64::consts::{PI, TAU};
use core::ops::{Add, Div, Mul, Sub};

use serde::{Deserialize, Serialize};

pub(crate) use unit_square::{point_to_unit_square, segment_to_unit_square};

/// Largest coordinate and largest yaw that an input may have, metres and radians.
pub const MAX_COORDINATE: f64 = 1e9;

/// A position in metres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "[f64; 2]", into = "[f64; 2]")]
pub struct Point {
    /// Coordinate along the x axis, metres.
    pub x: f64,
    /// Coordinate along the y axis, metres.
    pub y: f64,
}

/// A displacement in metres, or a velocity in metres per second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "[f64; 2]", into = "[f64; 2]")]
pub struct Vector {
    /// Component along the x axis.
    pub x: f64,
    /// Component along the y axis.
    pub y: f64,
}

/// A position in metres and a heading in radians.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "[f64; 3]", into = "[f64; 3]")]
pub struct Pose {
    /// Position along the x axis, metres.
    pub x: f64,
    /// Position along the y axis, metres.
    pub y: f64,
    /// Heading, radians, counter-clockwise from the x axis.
    pub yaw: f64,
}

/// A planar velocity in the robot's frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Twist {
    /// Forward speed, metres per second.
    pub linear: f64,
    /// Turn rate, radians per second, counter-clockwise positive.
    pub angular: f64,
}

/// Implements the constructor and the conversions of a pair of coordinates.
macro_rules! pair {
    ($Pair:ident) => {
        impl $Pair {
            /// Creates it from its coordinates.
            #[must_use]
            #[inline]
            pub const fn new(x: f64, y: f64) -> Self {
                Self { x, y }
            }
        }

        impl From<[f64; 2]> for $Pair {
            #[inline]
            fn from([x, y]: [f64; 2]) -> Self {
                Self { x, y }
            }
        }

        impl From<$Pair> for [f64; 2] {
            #[inline]
            fn from(pair: $Pair) -> Self {
                [pair.x, pair.y]
            }
        }
    };
}

pair!(Point);
pair!(Vector);

/// Implements an operator, component by component, for values and references.
macro_rules! operator {
    ($Left:ident $sign:tt $Right:ident = $Output:ident, $Trait:ident::$method:ident) => {
        operator!(($Left) $sign ($Right) = $Output, $Trait::$method);
        operator!(($Left) $sign (&$Right) = $Output, $Trait::$method);
        operator!((&$Left) $sign ($Right) = $Output, $Trait::$method);
        operator!((&$Left) $sign (&$Right) = $Output, $Trait::$method);
    };
    (($Left:ty) $sign:tt ($Right:ty) = $Output:ident, $Trait:ident::$method:ident) => {
        impl $Trait<$Right> for $Left {
            type Output = $Output;

            #[inline]
            fn $method(self, right: $Right) -> $Output {
                $Output::new(self.x $sign right.x, self.y $sign right.y)
            }
        }
    };
}

operator!(Point - Point = Vector, Sub::sub);
operator!(Point + Vector = Point, Add::add);
operator!(Point - Vector = Point, Sub::sub);
operator!(Vector + Vector = Vector, Add::add);
operator!(Vector - Vector = Vector, Sub::sub);

impl Mul<f64> for Vector {
    type Output = Self;

    #[inline]
    fn mul(self, factor: f64) -> Self {
        Self::new(self.x * factor, self.y * factor)
    }
}

impl Div<f64> for Vector {
    type Output = Self;

    #[inline]
    fn div(self, divisor: f64) -> Self {
        Self::new(self.x / divisor, self.y / divisor)
    }
}

impl Point {
    /// The displacement from the origin to this point.
    #[must_use]
    #[inline]
    pub const fn to_vector(&self) -> Vector {
        Vector::new(self.x, self.y)
    }

    /// Whether both coordinates are finite.
    #[must_use]
    #[inline]
    pub const fn is_finite(&self) -> bool {
        self.x.is_finite() && self.y.is_finite()
    }

    /// The lower left and the upper right corner of the smallest rectangle around points; `None` without any.
    #[must_use]
    pub fn bounds(points: impl IntoIterator<Item = Self>) -> Option<[Self; 2]> {
        let corners = points.into_iter().map(|point| [point, point]);
        corners.reduce(|[low, high], [point, _]| [low.min(&point), high.max(&point)])
    }

    /// Points on a circle around this one, at equal angles counter-clockwise from the x axis.
    pub(crate) fn circle(self, radius: f64, count: u32) -> impl Iterator<Item = Self> {
        (0..count).map(move |number| {
            let (sin, cos) = libm::sincos(TAU * f64::from(number) / f64::from(count));
            self + Vector::new(cos, sin) * radius
        })
    }

    /// The smaller of each coordinate. Of a positive and a negative zero it keeps its own.
    #[inline]
    pub(crate) fn min(&self, other: &Self) -> Self {
        let least = |own: f64, other: f64| if own <= other { own } else { other };
        Self::new(least(self.x, other.x), least(self.y, other.y))
    }

    /// The greater of each coordinate. Of a positive and a negative zero it keeps its own.
    #[inline]
    pub(crate) fn max(&self, other: &Self) -> Self {
        let greatest = |own: f64, other: f64| if own >= other { own } else { other };
        Self::new(greatest(self.x, other.x), greatest(self.y, other.y))
    }
}

impl Vector {
    /// No displacement.
    pub const ZERO: Self = Self::new(0.0, 0.0);

    /// The scalar product.
    #[must_use]
    #[inline]
    pub const fn dot(&self, other: &Self) -> f64 {
        self.x * other.x + self.y * other.y
    }

    /// The z component of the cross product: positive where the other vector is to the left.
    #[must_use]
    #[inline]
    pub const fn perp(&self, other: &Self) -> f64 {
        self.x * other.y - self.y * other.x
    }

    /// The squared length.
    #[must_use]
    #[inline]
    pub const fn norm_squared(&self) -> f64 {
        self.dot(self)
    }

    /// The length.
    #[must_use]
    #[inline]
    pub fn norm(&self) -> f64 {
        libm::sqrt(self.norm_squared())
    }

    /// The vector turned counter-clockwise by the angle of this sine and cosine.
    #[inline]
    pub(crate) const fn rotated(&self, (sin, cos): (f64, f64)) -> Self {
        Self::new(cos * self.x - sin * self.y, sin * self.x + cos * self.y)
    }

    /// The column for products with matrices.
    pub(crate) const fn to_column(self) -> nalgebra::Vector2<f64> {
        nalgebra::Vector2::new(self.x, self.y)
    }
}

/// A pose with the sine and cosine of its yaw.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    origin: Point,
    sin_cos: (f64, f64),
}

impl Frame {
    /// As [`Pose::transform`], to the bit.
    #[inline]
    pub(crate) fn transform(&self, local: &Point) -> Point {
        self.origin + local.to_vector().rotated(self.sin_cos)
    }

    /// As [`Pose::inverse_transform`], to the bit.
    #[inline]
    pub(crate) fn inverse_transform(&self, point: &Point) -> Point {
        let (sin, cos) = self.sin_cos;
        let Vector { x, y } = (point - self.origin).rotated((-sin, cos));
        Point::new(x, y)
    }
}

impl Pose {
    /// Creates a pose from its coordinates.
    #[must_use]
    #[inline]
    pub const fn new(x: f64, y: f64, yaw: f64) -> Self {
        Self { x, y, yaw }
    }

    /// The position.
    #[must_use]
    #[inline]
    pub const fn position(&self) -> Point {
        Point::new(self.x, self.y)
    }

    /// This pose for many transforms of points.
    #[inline]
    pub(crate) fn to_frame(self) -> Frame {
        Frame { origin: self.position(), sin_cos: libm::sincos(self.yaw) }
    }

    /// Transforms a point from this pose's frame to the parent frame.
    #[must_use]
    #[inline]
    pub fn transform(&self, local: &Point) -> Point {
        self.to_frame().transform(local)
    }

    /// Transforms a point from the parent frame to this pose's frame.
    #[must_use]
    #[inline]
    pub fn inverse_transform(&self, point: &Point) -> Point {
        self.to_frame().inverse_transform(point)
    }

    /// Transforms a pose from this pose's frame to the parent frame; its yaw is in (-pi, pi].
    #[must_use]
    #[inline]
    pub fn transform_pose(&self, local: &Self) -> Self {
        let position = self.transform(&local.position());
        Self::new(position.x, position.y, wrap_angle(self.yaw + local.yaw))
    }

    /// Transforms a pose from the parent frame to this pose's frame; its yaw is in (-pi, pi].
    #[must_use]
    #[inline]
    pub fn inverse_transform_pose(&self, pose: &Self) -> Self {
        let position = self.inverse_transform(&pose.position());
        Self::new(position.x, position.y, wrap_angle(pose.yaw - self.yaw))
    }

    /// The pose of a local frame's origin, given this pose of a body in the parent frame and its pose in the local frame. An
    /// example is the transform from map to odom. Its yaw is in (-pi, pi].
    #[must_use]
    pub fn frame_origin(&self, local: &Self) -> Self {
        let yaw = wrap_angle(self.yaw - local.yaw);
        let offset = Self::new(0.0, 0.0, yaw).transform(&local.position());
        Self::new(self.x - offset.x, self.y - offset.y, yaw)
    }

    /// The pose after motion with a constant twist for a time, seconds: an exact circular arc or straight line. Its yaw is in
    /// (-pi, pi].
    #[must_use]
    pub fn after(&self, twist: &Twist, time_s: f64) -> Self {
        let half_turn = twist.angular * time_s / 2.0;
        // The chord's direction is half the turn from the start heading.
        let chord = twist.linear * time_s * sinc(half_turn);
        let (sin, cos) = libm::sincos(self.yaw + half_turn);
        Self {
            x: self.x + chord * cos,
            y: self.y + chord * sin,
            yaw: wrap_angle(self.yaw + 2.0 * half_turn),
        }
    }

    /// Points along a motion with a constant twist for a time, seconds, at equal intervals: `parts + 1`, both ends among them; without
    /// parts the start alone.
    pub fn arc(
        &self,
        twist: &Twist,
        time_s: f64,
        parts: u32,
    ) -> impl Iterator<Item = Point> + use<> {
        let (start, twist) = (*self, *twist);
        let part_s = move |part: u32| time_s * f64::from(part) / f64::from(parts.max(1));
        (0..=parts).map(move |part| start.after(&twist, part_s(part)).position())
    }

    /// Interpolates along a motion with constant twist, forward and sideways, to another pose; `fraction` is 0 to 1. The turn is
    /// the smaller of both directions; the yaw is in (-pi, pi].
    #[must_use]
    pub fn interpolate(&self, end: &Self, fraction: f64) -> Self {
        // The partial chord follows from the ratio of arc to chord of both parts, and from half of the turn.
        let half_turn = wrap_angle(end.yaw - self.yaw) / 2.0;
        let length = fraction * sinc(fraction * half_turn) / sinc(half_turn);
        let (sin, cos) = libm::sincos((fraction - 1.0) * half_turn);
        let (x, y) = (end.x - self.x, end.y - self.y);
        Self {
            x: self.x + length * (cos * x - sin * y),
            y: self.y + length * (sin * x + cos * y),
            yaw: wrap_angle(self.yaw + 2.0 * fraction * half_turn),
        }
    }

    /// Whether all three coordinates are finite.
    #[must_use]
    #[inline]
    pub const fn is_finite(&self) -> bool {
        self.x.is_finite() && self.y.is_finite() && self.yaw.is_finite()
    }
}

impl From<[f64; 3]> for Pose {
    #[inline]
    fn from([x, y, yaw]: [f64; 3]) -> Self {
        Self { x, y, yaw }
    }
}

impl From<Pose> for [f64; 3] {
    #[inline]
    fn from(pose: Pose) -> Self {
        [pose.x, pose.y, pose.yaw]
    }
}

impl Twist {
    /// No motion.
    pub const STOP: Self = Self { linear: 0.0, angular: 0.0 };

    /// Speed and turn rate below which a robot stands, m/s and rad/s.
    pub const STANDING: f64 = 0.02;

    /// Creates a twist from its linear and angular rate.
    #[must_use]
    #[inline]
    pub const fn new(linear: f64, angular: f64) -> Self {
        Self { linear, angular }
    }

    /// The twist half-way between this one and another.
    #[inline]
    pub(crate) const fn mean(&self, other: &Self) -> Self {
        Self {
            linear: f64::midpoint(self.linear, other.linear),
            angular: f64::midpoint(self.angular, other.angular),
        }
    }

    /// Whether a robot with this motion stands: both rates are below [`Self::STANDING`]. NaN does not stand.
    #[must_use]
    pub const fn stands(&self) -> bool {
        self.is_below(Self::STANDING)
    }

    /// Whether both rates are below a limit, m/s and rad/s. NaN is not.
    #[must_use]
    pub const fn is_below(&self, limit: f64) -> bool {
        self.linear.abs() < limit && self.angular.abs() < limit
    }

    /// Whether both rates are finite.
    #[must_use]
    #[inline]
    pub const fn is_finite(&self) -> bool {
        self.linear.is_finite() && self.angular.is_finite()
    }
}

/// Wraps an angle to (-pi, pi].
#[must_use]
pub fn wrap_angle(angle: f64) -> f64 {
    let wrapped = libm::fmod(angle, TAU);
    if wrapped > PI {
        wrapped - TAU
    } else if wrapped <= -PI {
        wrapped + TAU
    } else {
        wrapped
    }
}

/// The direction from one point to another, radians in (-pi, pi]; zero for equal points.
#[must_use]
pub fn bearing(from: &Point, to: &Point) -> f64 {
    libm::atan2(to.y - from.y, to.x - from.x)
}

/// The point of a segment nearest to a given point. The segment may be a single point.
#[must_use]
#[inline]
pub fn nearest_on_segment(from: &Point, to: &Point, point: &Point) -> Point {
    let whole = to - from;
    let squared = whole.norm_squared();
    let fraction =
        if squared > 0.0 { (whole.dot(&(point - from)) / squared).clamp(0.0, 1.0) } else { 0.0 };
    from + whole * fraction
}

/// Whether a point is inside the polygon with these corners in order, by the even-odd rule.
pub(crate) fn is_in_polygon(corners: &[Point], point: &Point) -> bool {
    let next = corners.iter().skip(1).chain(corners.first());
    corners.iter().zip(next).fold(false, |inside, (from, to)| {
        let is_crossed = (from.y > point.y) != (to.y > point.y)
            && point.x < from.x + (to.x - from.x) * (point.y - from.y) / (to.y - from.y);
        inside != is_crossed
    })
}

/// The ratio of chord to arc length: sin(h) / h for an arc with a turn of 2 h, radians.
fn sinc(half_turn: f64) -> f64 {
    if half_turn.abs() < 1e-4 {
        1.0 - half_turn * half_turn / 6.0
    } else {
        libm::sin(half_turn) / half_turn
    }
}
