//! The body that the layer sweeps: its polygon, or the discs where no polygon is given.

use crate::geometry::{Point, Vector, nearest_on_segment};
use crate::robot::{Disc, Footprint, Polygon};

/// Least motion towards a place that counts as one, square metres: rounding.
const LEAST_CLOSING: f64 = 1e-6;

/// A part of the body in its own frame. Distances are in metres, and negative within the part.
#[derive(Clone, Debug)]
pub(super) enum Part {
    Disc(Disc),
    Polygon(Polygon),
}

/// The parts of a body, at least one.
#[derive(Clone, Debug)]
pub(super) struct Body {
    pub parts: Vec<Part>,
    /// Radius of the circle around the robot's origin that contains all parts, metres.
    pub radius_m: f64,
}

impl Body {
    pub fn new(footprint: &Footprint) -> Self {
        let parts = match footprint.body() {
            Some(polygon) => vec![Part::Polygon(polygon.clone())],
            None => footprint.discs().iter().copied().map(Part::Disc).collect(),
        };
        Self { parts, radius_m: footprint.body_radius_m() }
    }

    /// Distance of the nearest part to a place.
    pub fn distance_m(&self, place: &Point) -> f64 {
        self.parts.iter().map(|part| part.distance_m(place)).fold(f64::INFINITY, f64::min)
    }

    /// Distance along a ray from a point to the farthest place of the body; zero where the ray does not meet it. `direction` has
    /// the length one.
    pub fn extent_m(&self, from: &Point, direction: &Vector) -> f64 {
        self.parts.iter().map(|part| part.extent_m(from, direction)).fold(0.0, f64::max)
    }
}

impl Part {
    /// Distance to a place.
    pub fn distance_m(&self, place: &Point) -> f64 {
        match self {
            Self::Disc(disc) => (place - center(disc)).norm() - disc.radius,
            Self::Polygon(polygon) => polygon.signed_distance(place),
        }
    }

    /// Distance to a segment.
    pub fn distance_to_segment_m(&self, from: &Point, to: &Point) -> f64 {
        match self {
            Self::Disc(disc) => self.distance_m(&nearest_on_segment(from, to, &center(disc))),
            Self::Polygon(polygon) => polygon.signed_distance_to_segment(from, to),
        }
    }

    /// Share of a place's motion that closes the gap to this part: the cosine of the angle between both; zero where the gap
    /// grows.
    pub fn closing_share(&self, from: &Point, to: &Point) -> f64 {
        let towards = match self {
            Self::Disc(disc) => center(disc) - from,
            Self::Polygon(polygon) => {
                let outwards = polygon.nearest_on_outline(from) - from;
                if polygon.contains(from) { outwards * -1.0 } else { outwards }
            }
        };
        let step = to - from;
        let closing = step.dot(&towards);
        if closing > LEAST_CLOSING { closing / (step.norm() * towards.norm()) } else { 0.0 }
    }

    fn extent_m(&self, from: &Point, direction: &Vector) -> f64 {
        match self {
            Self::Disc(disc) => {
                let to_center = center(disc) - from;
                let across = direction.perp(&to_center);
                let half = disc.radius * disc.radius - across * across;
                if half < 0.0 { 0.0 } else { direction.dot(&to_center) + libm::sqrt(half) }
            }
            Self::Polygon(polygon) => farthest_along(polygon, from, direction),
        }
    }
}

const fn center(disc: &Disc) -> Point {
    Point::new(disc.x, disc.y)
}

/// Distance along a ray from a point to the farthest place of a polygon's outline; zero where the ray does not meet it.
fn farthest_along(polygon: &Polygon, from: &Point, direction: &Vector) -> f64 {
    let along = |(start, end): (&Point, &Point)| {
        let (to_start, to_end) = (start - from, end - from);
        let (side, other) = (direction.perp(&to_start), direction.perp(&to_end));
        if side * other > 0.0 {
            return 0.0;
        }
        let (near, far) = (direction.dot(&to_start), direction.dot(&to_end));
        if side == other { near.max(far) } else { near + (far - near) * side / (side - other) }
    };
    polygon.edges().map(along).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of 2 m with a notch from the right to its middle.
    #[test]
    fn ray_ends_at_the_farthest_place_of_the_outline() {
        let corners = [
            (-1.0, -1.0),
            (1.0, -1.0),
            (1.0, -0.2),
            (0.0, 0.0),
            (1.0, 0.2),
            (1.0, 1.0),
            (-1.0, 1.0),
        ];
        let corners = corners.map(|(x, y)| Point::new(x, y)).to_vec();
        let part = Part::Polygon(Polygon::new(corners).expect("a polygon"));
        let along = |x: f64, y: f64| part.extent_m(&Point::new(-0.5, 0.0), &Vector::new(x, y));
        assert!((along(1.0, 0.0) - 0.5).abs() < 1e-12, "the notch");
        assert!((along(-1.0, 0.0) - 0.5).abs() < 1e-12);
        assert!((along(0.8, 0.6) - 5.0 / 3.0).abs() < 1e-12, "{}", along(0.8, 0.6));
        let outside = part.extent_m(&Point::new(3.0, 0.0), &Vector::new(1.0, 0.0));
        assert_eq!(outside, 0.0);
    }
}
