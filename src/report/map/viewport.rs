//! The part of a map that a picture shows, and the position of map points in the drawing.

use crate::geometry::Point;
use crate::map::GridFrame;

/// Width of a map picture, drawing units.
pub(crate) const MAP_WIDTH: f64 = 720.0;

/// Margin around the points of interest: at least, m, and as a share of their longer side.
const MIN_MARGIN_M: f64 = 1.5;
const MARGIN_SHARE: f64 = 0.12;

/// A map is shown whole if its longer side is at most this many times that of the points of interest.
const WHOLE_MAP: f64 = 1.8;

/// Bounds of height divided by width.
const MIN_ASPECT: f64 = 0.42;
const MAX_ASPECT: f64 = 1.15;

/// A rectangle of the map frame. Its y axis points up in the drawing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Viewport {
    /// Lower left corner, metres.
    pub(crate) low: Point,
    /// Upper right corner, metres.
    pub(crate) high: Point,
}

impl Viewport {
    /// Shows points of interest: on the whole map if it is not much larger, else with a margin. Ignores points that
    /// are not finite.
    pub(crate) fn around(points: impl IntoIterator<Item = Point>, frame: &GridFrame) -> Self {
        let whole = bounds(frame.corners());
        let view = match bounds(points) {
            Some(part) => {
                let margin = (part.longer_side() * MARGIN_SHARE).max(MIN_MARGIN_M);
                let near = part.grown(margin, margin);
                whole
                    .filter(|whole| whole.longer_side() <= WHOLE_MAP * near.longer_side())
                    .map_or(near, |whole| whole.joined(&part))
            }
            None => whole.unwrap_or(Self { low: Point::new(0.0, 0.0), high: Point::new(1.0, 1.0) }),
        };
        view.shaped()
    }

    /// The area within a reach of some positions, m, as far as the map extends; none without positions or outside the map.
    pub(crate) fn within_reach(
        positions: impl IntoIterator<Item = Point>,
        reach_m: f64,
        frame: &GridFrame,
    ) -> Option<Self> {
        let (reached, map) = (bounds(positions)?.grown(reach_m, reach_m), bounds(frame.corners())?);
        let (low, high) = (reached.low.max(&map.low), reached.high.min(&map.high));
        (low.x < high.x && low.y < high.y).then_some(Self { low, high })
    }

    /// Drawing units per metre.
    pub(crate) fn scale(&self) -> f64 {
        MAP_WIDTH / (self.high.x - self.low.x)
    }

    /// Height of the drawing.
    pub(crate) fn height(&self) -> f64 {
        (self.high.y - self.low.y) * self.scale()
    }

    /// The position of a point of the map frame in the drawing.
    pub(crate) fn at(&self, point: &Point) -> [f64; 2] {
        let scale = self.scale();
        [(point.x - self.low.x) * scale, (self.high.y - point.y) * scale]
    }

    /// Whether a point is finite and inside.
    pub(crate) fn shows(&self, point: &Point) -> bool {
        (self.low.x..=self.high.x).contains(&point.x)
            && (self.low.y..=self.high.y).contains(&point.y)
    }

    /// The four corners, metres.
    pub(crate) fn corners(&self) -> [Point; 4] {
        let Self { low, high } = self;
        [*low, Point::new(high.x, low.y), *high, Point::new(low.x, high.y)]
    }

    /// The rectangle without its outermost hundredth, which is not visible.
    pub(crate) fn shrunk(&self) -> Self {
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
        Self { low: self.low.min(&other.low), high: self.high.max(&other.high) }
    }

    /// Grows one side until the aspect is within its bounds.
    fn shaped(&self) -> Self {
        let (width, height) = (self.high.x - self.low.x, self.high.y - self.low.y);
        let by_y = (width * MIN_ASPECT - height).max(0.0) / 2.0;
        let by_x = (height / MAX_ASPECT - width).max(0.0) / 2.0;
        self.grown(by_x, by_y)
    }
}

/// The smallest rectangle around the finite points; none without any.
fn bounds(points: impl IntoIterator<Item = Point>) -> Option<Viewport> {
    let [low, high] = Point::bounds(points.into_iter().filter(Point::is_finite))?;
    Some(Viewport { low, high })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;

    #[test]
    fn area_within_reach_ends_at_the_map() {
        let frame = GridFrame::new(20, 10, 0.5, Pose::new(0.0, 0.0, 0.0)).expect("a frame");
        let area = Viewport::within_reach([Point::new(8.0, 2.0)], 3.0, &frame).expect("an area");
        assert_eq!((area.low, area.high), (Point::new(5.0, 0.0), Point::new(10.0, 5.0)));
        assert!(Viewport::within_reach([Point::new(20.0, 2.0)], 3.0, &frame).is_none());
        assert!(Viewport::within_reach([], 3.0, &frame).is_none());
    }
}
