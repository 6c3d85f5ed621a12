//! A way to walk: a line of points, and a place along it.

use crate::geometry::{Point, Vector};

/// Straight legs from point to point, measured along their length.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Route {
    points: Vec<Point>,
    /// Distance from the first point to each, metres.
    distances: Vec<f64>,
}

impl Route {
    /// A route from point to point, metres. One point alone is a place to stand.
    ///
    /// # Panics
    /// Without a point.
    pub(super) fn new(points: Vec<Point>) -> Self {
        assert!(!points.is_empty(), "a route has at least one point");
        let mut distances = vec![0.0; points.len()];
        for leg in 1..points.len() {
            distances[leg] = distances[leg - 1] + (points[leg] - points[leg - 1]).norm();
        }
        Self { points, distances }
    }

    pub(super) fn length_m(&self) -> f64 {
        self.distances[self.distances.len() - 1]
    }

    /// The point a distance along the route; its ends beyond them.
    pub(super) fn at(&self, distance: f64) -> Point {
        let end = self.leg_end(distance);
        if end == 0 {
            return self.points[0];
        }
        let (from, to) = (self.points[end - 1], self.points[end]);
        let length = self.distances[end] - self.distances[end - 1];
        if length > 0.0 {
            let share = ((distance - self.distances[end - 1]) / length).clamp(0.0, 1.0);
            from + (to - from) * share
        } else {
            to
        }
    }

    /// Unit vector along the route at a distance; zero where the route has no length.
    pub(super) fn direction(&self, distance: f64) -> Vector {
        let end = self.leg_end(distance);
        if end == 0 {
            return Vector::zeros();
        }
        let leg = self.points[end] - self.points[end - 1];
        leg.try_normalize(0.0).unwrap_or_else(Vector::zeros)
    }

    /// Points at equal distances of at most `spacing`, metres, both ends included.
    pub(super) fn samples(&self, spacing: f64) -> impl Iterator<Item = Point> + '_ {
        let count = (self.length_m() / spacing).ceil().max(1.0);
        (0..=count as usize).map(move |i| self.at(self.length_m() * i as f64 / count))
    }

    /// Position of the point that ends the leg holding a distance: the first not before it.
    fn leg_end(&self, distance: f64) -> usize {
        self.distances
            .partition_point(|&at| at < distance)
            .clamp(1.min(self.points.len() - 1), self.points.len() - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_along_an_elbow() {
        let route = Route::new(vec![
            Point::new(0.0, 0.0),
            Point::new(2.0, 0.0),
            Point::new(2.0, 3.0),
        ]);
        assert!((route.length_m() - 5.0).abs() < 1e-15);
        assert_eq!(route.at(-1.0), Point::new(0.0, 0.0));
        assert_eq!(route.at(3.0), Point::new(2.0, 1.0));
        assert_eq!(route.at(9.0), Point::new(2.0, 3.0));
        assert_eq!(route.direction(1.0), Vector::new(1.0, 0.0));
        assert_eq!(route.direction(4.0), Vector::new(0.0, 1.0));
        assert_eq!(route.samples(1.0).count(), 6);
    }

    #[test]
    fn one_point_is_a_place_to_stand() {
        let route = Route::new(vec![Point::new(1.0, 1.0)]);
        assert_eq!(route.at(0.5), Point::new(1.0, 1.0));
        assert_eq!(route.direction(0.5), Vector::zeros());
    }
}
