//! The robot's footprint: discs, and the body that they cover.

use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::ser::SerializeStruct;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::disc_cover::{cover, slim_cover, uncovered_point, usual_radius_m};
use super::{Polygon, RobotError};
use crate::geometry::{Point, Pose, Twist, Vector};
use crate::map::MovingDisc;

/// A disc in the robot's frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Disc {
    /// x coordinate of the centre, forward, metres.
    pub x: f64,
    /// y coordinate of the centre, to the left, metres.
    pub y: f64,
    /// Radius, metres, above zero.
    pub radius: f64,
}

/// The shape of a robot. The planners check discs, which cover the body. Contact is judged by the body: a polygon, or the discs
/// themselves where no polygon is given.
///
/// In a file it is one of these:
/// - the corners of the body, `[[0.35, 0.25], [0.35, -0.25], ...]`, or a text with them as in Nav2, which up to 8 discs then cover;
/// - discs, `[{ x = 0.0, y = 0.0, radius = 0.3 }]`;
/// - both, `{ body = [[0.35, 0.25], ...], discs = [{ x = 0.0, y = 0.0, radius = 0.5 }] }`.
#[derive(Clone, Debug, PartialEq)]
pub struct Footprint {
    discs: Vec<Disc>,
    body: Option<Polygon>,
}

impl Footprint {
    /// Creates a footprint from discs.
    ///
    /// # Errors
    /// Returns an error without discs, or for a disc with a value that is not finite or a radius not above zero.
    pub fn new(discs: Vec<Disc>) -> Result<Self, RobotError> {
        if discs.is_empty() {
            return Err(RobotError::EmptyFootprint);
        }
        for (index, &Disc { x, y, radius }) in discs.iter().enumerate() {
            if !(x.is_finite() && y.is_finite() && radius.is_finite() && radius > 0.0) {
                return Err(RobotError::BadDisc { index, x, y, radius });
            }
        }
        Ok(Self { discs, body: None })
    }

    /// Creates the footprint of a body: discs that cover it, few and with little overhang.
    #[must_use]
    pub fn covering(body: Polygon) -> Self {
        Self { discs: cover(&body), body: Some(body) }
    }

    /// The footprint for narrow passages: a body is covered by discs that stand out little to the sides, and more at the ends.
    #[must_use]
    pub(crate) fn slim(&self) -> Self {
        match &self.body {
            Some(body) => Self { discs: slim_cover(body), body: Some(body.clone()) },
            None => self.clone(),
        }
    }

    /// The discs in the frame of a robot that looks the other way.
    #[must_use]
    pub(crate) fn turned_around(&self) -> Self {
        let turn = |disc: &Disc| Disc { x: -disc.x, y: -disc.y, ..*disc };
        Self { discs: self.discs.iter().map(turn).collect(), body: None }
    }

    /// Creates a footprint from a body and the discs that cover it.
    ///
    /// # Errors
    /// As [`Self::new`], or when a point of the body is in none of the discs.
    pub fn with_body(body: Polygon, discs: Vec<Disc>) -> Result<Self, RobotError> {
        let discs = Self::new(discs)?.discs;
        match uncovered_point(&body, &discs) {
            Some(Point { x, y }) => Err(RobotError::UncoveredBody { x, y }),
            None => Ok(Self { discs, body: Some(body) }),
        }
    }

    /// Creates the footprint of a round robot: one disc around its origin.
    ///
    /// # Errors
    /// Returns an error if the radius, in metres, is not finite and above zero.
    pub fn round(radius: f64) -> Result<Self, RobotError> {
        Self::new(vec![Disc { x: 0.0, y: 0.0, radius }])
    }

    /// The discs, at least one.
    #[must_use]
    pub fn discs(&self) -> &[Disc] {
        &self.discs
    }

    /// The body; `None` where it is the discs.
    #[must_use]
    pub const fn body(&self) -> Option<&Polygon> {
        self.body.as_ref()
    }

    /// The footprint whose body is the discs.
    #[must_use]
    pub fn without_body(&self) -> Self {
        Self { discs: self.discs.clone(), body: None }
    }

    /// Radius of the circle around the robot's origin that contains the body, metres.
    #[must_use]
    pub fn body_radius_m(&self) -> f64 {
        match &self.body {
            Some(body) => {
                let reach = |corner: &Point| corner.to_vector().norm();
                body.corners().iter().map(reach).fold(0.0, f64::max)
            }
            None => self.circumscribed_radius_m(),
        }
    }

    /// Radius of the circle around the robot's origin that contains the discs, metres.
    #[must_use]
    pub fn circumscribed_radius_m(&self) -> f64 {
        let reach = |disc: &Disc| libm::hypot(disc.x, disc.y) + disc.radius;
        self.discs.iter().map(reach).fold(0.0, f64::max)
    }

    /// x coordinate of the foremost point of the body, metres.
    #[cfg(feature = "report")]
    #[must_use]
    pub(crate) fn front_m(&self) -> f64 {
        match &self.body {
            Some(body) => body.bounds().1.x,
            None => self.discs.iter().map(|disc| disc.x + disc.radius).fold(0.0, f64::max),
        }
    }

    /// Radius of the largest disc, metres.
    #[must_use]
    pub fn max_disc_radius_m(&self) -> f64 {
        self.discs.iter().map(|disc| disc.radius).fold(0.0, f64::max)
    }

    /// Radius of the largest circle around the robot's origin within the body, metres; zero for an origin outside.
    #[must_use]
    pub(crate) fn inscribed_radius_m(&self) -> f64 {
        if let Some(body) = &self.body {
            return (-body.signed_distance(&Point::default())).max(0.0);
        }
        let depth = |disc: &Disc| disc.radius - libm::hypot(disc.x, disc.y);
        self.discs.iter().map(depth).fold(0.0, f64::max)
    }

    /// Radius of a disc that needs as much room as the body that drives straight ahead, metres. Given discs may be smaller, side by
    /// side.
    #[must_use]
    pub(crate) fn passing_radius_m(&self) -> f64 {
        self.body.as_ref().map_or(0.0, usual_radius_m).max(self.max_disc_radius_m())
    }

    /// Distance between the body at this pose and another disc, metres; zero or less means contact.
    #[must_use]
    pub fn gap_to_disc_m(&self, pose: &Pose, center: &Point, radius_m: f64) -> f64 {
        if let Some(body) = &self.body {
            return body.distance(&pose.inverse_transform(center)) - radius_m;
        }
        self.at(pose)
            .map(|(own, own_radius)| (center - own).norm() - own_radius - radius_m)
            .fold(f64::INFINITY, f64::min)
    }

    /// The shortest distance from the robot's origin in a direction of its frame, radians, at which a disc has at least this gap to
    /// the body, to 5 mm. All lengths in metres; radius and gap are finite.
    #[must_use]
    pub fn distance_with_gap_m(&self, direction: f64, radius_m: f64, gap_m: f64) -> f64 {
        const STEP_M: f64 = 0.005;
        let (sin, cos) = libm::sincos(direction);
        let mut away_m = 0.0;
        let center = |away_m: f64| Point::new(away_m * cos, away_m * sin);
        while self.gap_to_disc_m(&Pose::default(), &center(away_m), radius_m) < gap_m {
            away_m += STEP_M;
        }
        away_m
    }

    /// Distance between the body at this pose and a moving obstacle, metres; zero or less means contact.
    #[must_use]
    pub fn gap_to_moving_m(&self, pose: &Pose, disc: &MovingDisc) -> f64 {
        self.gap_to_disc_m(pose, &disc.center(), disc.radius)
    }

    /// Speed at which a motion of the robot brings the part of its body that is nearest to a point closer to it, m/s.
    #[must_use]
    pub fn closing_speed_m_s(&self, pose: &Pose, twist: &Twist, center: &Point) -> f64 {
        let nearest = if let Some(body) = &self.body {
            let local = pose.inverse_transform(center);
            pose.transform(&body.nearest_on_outline(&local))
        } else {
            // The rotation of a disc about its own centre closes no gap; its centre moves with the robot.
            let gap = |(own, radius_m): &(Point, f64)| (center - own).norm() - radius_m;
            let nearest = self.at(pose).min_by(|one, other| gap(one).total_cmp(&gap(other)));
            nearest.map_or(*center, |(own, _)| own)
        };
        let arm = nearest - pose.position();
        let heading = Vector::new(1.0, 0.0).rotated(libm::sincos(pose.yaw));
        let velocity = heading * twist.linear + Vector::new(-arm.y, arm.x) * twist.angular;
        let towards = center - nearest;
        let distance_m = towards.norm();
        let is_inside =
            self.body.as_ref().is_some_and(|body| body.contains(&pose.inverse_transform(center)));
        if distance_m > 0.0 && !is_inside {
            velocity.dot(&towards) / distance_m
        } else {
            velocity.norm()
        }
    }

    /// The discs with a margin, metres, added to each radius. A negative margin shrinks the discs, down to 1 mm.
    #[must_use]
    pub fn padded(&self, margin_m: f64) -> Self {
        let grow = |disc: &Disc| Disc { radius: (disc.radius + margin_m).max(1e-3), ..*disc };
        Self { discs: self.discs.iter().map(grow).collect(), body: None }
    }

    /// The speed that no part of the robot exceeds at a velocity, m/s.
    pub(crate) fn fastest_part(&self, twist: &Twist) -> f64 {
        twist.linear.abs() + twist.angular.abs() * self.circumscribed_radius_m()
    }

    /// Centre and radius of each disc in the map frame, for a robot at a pose.
    pub fn at(&self, pose: &Pose) -> impl Iterator<Item = (Point, f64)> + '_ {
        let (center, turn) = (pose.position(), libm::sincos(pose.yaw));
        self.discs
            .iter()
            .map(move |disc| (center + Vector::new(disc.x, disc.y).rotated(turn), disc.radius))
    }
}

impl Serialize for Footprint {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match &self.body {
            None => self.discs.serialize(serializer),
            Some(body) if cover(body) == self.discs => body.serialize(serializer),
            Some(body) => {
                let mut table = serializer.serialize_struct("Footprint", 2)?;
                table.serialize_field("body", body)?;
                table.serialize_field("discs", &self.discs)?;
                table.end()
            }
        }
    }
}

impl<'de> Deserialize<'de> for Footprint {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(FootprintVisitor)
    }
}

struct FootprintVisitor;

/// An element of a list: a disc, or a corner of the body.
struct Element(Result<Disc, Point>);

impl<'de> Visitor<'de> for FootprintVisitor {
    type Value = Footprint;

    fn expecting(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        formatter.write_str("a list of discs, or of the body's corners")
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Footprint, E> {
        let corners: Result<Vec<Point>, _> = serde_json::from_str(text);
        let corners = corners.map_err(|_| {
            E::custom(format!(
                "{text:?} is no list of corners such as \"[[0.3, 0.2], [0.3, -0.2], [-0.3, 0.0]]\""
            ))
        })?;
        Polygon::new(corners).map(Footprint::covering).map_err(Error::custom)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Footprint, A::Error> {
        let (mut discs, mut corners) = (Vec::new(), Vec::new());
        while let Some(Element(element)) = list.next_element()? {
            match element {
                Ok(disc) => discs.push(disc),
                Err(corner) => corners.push(corner),
            }
        }
        if corners.is_empty() {
            return Footprint::new(discs).map_err(Error::custom);
        }
        if !discs.is_empty() {
            return Err(Error::custom("the footprint mixes discs and corners: give one of them"));
        }
        Polygon::new(corners).map(Footprint::covering).map_err(Error::custom)
    }

    fn visit_map<A: MapAccess<'de>>(self, table: A) -> Result<Footprint, A::Error> {
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        struct Parts {
            body: Polygon,
            discs: Vec<Disc>,
        }
        let Parts { body, discs } =
            Parts::deserialize(serde::de::value::MapAccessDeserializer::new(table))?;
        Footprint::with_body(body, discs).map_err(Error::custom)
    }
}

impl<'de> Deserialize<'de> for Element {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ElementVisitor;

        impl<'de> Visitor<'de> for ElementVisitor {
            type Value = Element;

            fn expecting(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                formatter.write_str("a disc {x, y, radius}, or a corner [x, y]")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Element, A::Error> {
                let list = serde::de::value::SeqAccessDeserializer::new(list);
                Point::deserialize(list).map(|corner| Element(Err(corner)))
            }

            fn visit_map<A: MapAccess<'de>>(self, table: A) -> Result<Element, A::Error> {
                let table = serde::de::value::MapAccessDeserializer::new(table);
                Disc::deserialize(table).map(|disc| Element(Ok(disc)))
            }
        }

        deserializer.deserialize_any(ElementVisitor)
    }
}
