//! Which part of the ground a picture shows, and where a point of it lies in the drawing.

use crate::geometry::Point;
use crate::map::GridFrame;

/// Width of the map picture in drawing units.
pub(super) const MAP_WIDTH: f64 = 720.0;

/// Least room around what happened, metres, and as a share of its larger side.
const ROOM_M: f64 = 1.5;
const ROOM_SHARE: f64 = 0.12;

/// A map whose longer side is not above this many times that of what happened on it is shown whole.
const WHOLE_MAP: f64 = 1.8;

/// Bounds of height by width.
const FLATTEST: f64 = 0.42;
const TALLEST: f64 = 1.15;

/// A rectangle of the map frame, its y axis pointing up in the drawing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Viewport {
    /// Lower left corner, metres.
    pub(super) low: Point,
    /// Upper right corner, metres.
    pub(super) high: Point,
}

impl Viewport {
    /// Around points of interest on a map: the whole map where it is not much larger, else their neighbourhood.
    /// Points that are not finite do not count.
    pub(super) fn around(points: impl IntoIterator<Item = Point>, frame: &GridFrame) -> Self {
        let whole = bounds(frame.corners());
        let view = match bounds(points) {
            Some(part) => {
                let room = (part.longer_side() * ROOM_SHARE).max(ROOM_M);
                let near = part.grown(room, room);
                whole
                    .filter(|whole| whole.longer_side() <= WHOLE_MAP * near.longer_side())
                    .map_or(near, |whole| whole.joined(&part))
            }
            None => whole.unwrap_or(Self {
                low: Point::new(0.0, 0.0),
                high: Point::new(1.0, 1.0),
            }),
        };
        view.shaped()
    }

    /// Drawing units for a metre.
    pub(super) fn scale(&self) -> f64 {
        MAP_WIDTH / (self.high.x - self.low.x)
    }

    /// Height of the drawing.
    pub(super) fn height(&self) -> f64 {
        (self.high.y - self.low.y) * self.scale()
    }

    /// Where a point of the map frame lies in the drawing.
    pub(super) fn at(&self, point: &Point) -> [f64; 2] {
        let scale = self.scale();
        [
            (point.x - self.low.x) * scale,
            (self.high.y - point.y) * scale,
        ]
    }

    /// Whether a point is finite and shown.
    pub(super) fn shows(&self, point: &Point) -> bool {
        (self.low.x..=self.high.x).contains(&point.x)
            && (self.low.y..=self.high.y).contains(&point.y)
    }

    /// The four corners, metres.
    pub(super) fn corners(&self) -> [Point; 4] {
        let Self { low, high } = self;
        [
            *low,
            Point::new(high.x, low.y),
            *high,
            Point::new(low.x, high.y),
        ]
    }

    /// The same without its outermost hundredth, which nobody sees.
    pub(super) fn shrunk(&self) -> Self {
        let edge = -0.01 * self.longer_side();
        self.grown(edge, edge)
    }

    fn longer_side(&self) -> f64 {
        (self.high.x - self.low.x).max(self.high.y - self.low.y)
    }

    fn grown(&self, by_x: f64, by_y: f64) -> Self {
        Self {
            low: Point::new(self.low.x - by_x, self.low.y - by_y),
            high: Point::new(self.high.x + by_x, self.high.y + by_y),
        }
    }

    fn joined(&self, other: &Self) -> Self {
        Self {
            low: self.low.inf(&other.low),
            high: self.high.sup(&other.high),
        }
    }

    /// Grown in one direction until it is neither too flat nor too tall.
    fn shaped(&self) -> Self {
        let (width, height) = (self.high.x - self.low.x, self.high.y - self.low.y);
        let by_y = (width * FLATTEST - height).max(0.0) / 2.0;
        let by_x = (height / TALLEST - width).max(0.0) / 2.0;
        self.grown(by_x, by_y)
    }
}

/// The least viewport that holds the finite ones of some points; none where there are none.
fn bounds(points: impl IntoIterator<Item = Point>) -> Option<Viewport> {
    points
        .into_iter()
        .filter(|point| point.x.is_finite() && point.y.is_finite())
        .map(|point| Viewport {
            low: point,
            high: point,
        })
        .reduce(|all, point| all.joined(&point))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;

    fn frame(width: i32, height: i32) -> GridFrame {
        GridFrame {
            width,
            height,
            resolution_m: 0.5,
            origin: Pose::new(-2.0, 3.0, 0.0),
        }
    }

    #[test]
    fn a_small_map_is_shown_whole_and_a_large_one_in_part() {
        let path = [Point::new(0.0, 5.0), Point::new(10.0, 9.0)];
        let small = Viewport::around(path, &frame(30, 20));
        assert!(small.corners().iter().all(|corner| {
            let [x, y] = small.at(corner);
            (-1e-9..=MAP_WIDTH + 1e-9).contains(&x) && (-1e-9..=small.height() + 1e-9).contains(&y)
        }));
        assert!(small.shows(&Point::new(-2.0, 3.0)) && small.shows(&Point::new(13.0, 13.0)));
        let large = Viewport::around(path, &frame(3000, 2000));
        assert!(path.iter().all(|point| large.shows(point)));
        assert!(large.longer_side() < 15.0);
    }

    #[test]
    fn up_in_the_world_is_up_in_the_drawing() {
        let view = Viewport::around(
            [Point::new(0.0, 5.0), Point::new(10.0, 9.0)],
            &frame(99, 99),
        );
        assert!(view.at(&Point::new(1.0, 9.0))[1] < view.at(&Point::new(1.0, 5.0))[1]);
    }

    #[test]
    fn points_that_are_not_finite_do_not_stretch_it() {
        let nowhere = [Point::new(f64::NAN, 0.0), Point::new(0.0, f64::INFINITY)];
        let view = Viewport::around(nowhere, &frame(10, 10));
        assert!(view.height().is_finite() && view.shows(&Point::new(-2.0, 3.0)));
    }
}
