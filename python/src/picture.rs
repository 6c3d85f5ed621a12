//! Pictures of robots on their missions, seen from above.

use inbye::geometry::{Point, Pose};
use inbye::global::Path;
use inbye::map::{OccupancyGrid, Scan};
use inbye::robot::Footprint;
use numpy::ndarray::Array3;

/// Longest side of a picture, pixels.
const LONGEST_PX: f64 = 512.0;
/// Smallest radius of what is drawn, pixels.
const DOT_PX: f64 = 1.5;
const GOAL_PX: f64 = 4.0;

const PATH: [u8; 3] = [80, 140, 220];
const GOAL: [u8; 3] = [40, 160, 60];
const RETURN: [u8; 3] = [220, 50, 40];
const ROBOT: [u8; 3] = [30, 60, 140];
const NOSE: [u8; 3] = [255, 210, 60];

/// What a picture shows.
pub struct Scene<'a> {
    pub map: &'a OccupancyGrid,
    pub path: &'a Path,
    pub goal: Point,
    pub footprint: &'a Footprint,
    pub pose: Pose,
    pub scan: &'a Scan,
}

impl Scene<'_> {
    /// Rows of pixels, red, green and blue, the highest row first. The longest side has 512 pixels, and both are even, as encoders of
    /// videos want them.
    pub fn picture(&self) -> Array3<u8> {
        let mut canvas = Canvas::new(self.map);
        for place in self.path.samples(canvas.pixel_m) {
            canvas.disc(&place, 0.0, PATH);
        }
        canvas.disc(&self.goal, GOAL_PX * canvas.pixel_m, GOAL);
        for disc in self.footprint.discs() {
            let center = self.pose.transform(&Point::new(disc.x, disc.y));
            canvas.disc(&center, disc.radius, ROBOT);
        }
        let nose_m = self.footprint.circumscribed_radius_m();
        canvas.disc(&self.pose.transform(&Point::new(nose_m, 0.0)), 0.0, NOSE);
        for hit in self.scan.hits(&self.pose) {
            canvas.disc(&hit, 0.0, RETURN);
        }
        canvas.pixels
    }
}

/// Pixels of a part of the map frame.
struct Canvas {
    pixels: Array3<u8>,
    /// Place of the left upper corner.
    left_m: f64,
    top_m: f64,
    /// Side of a pixel.
    pixel_m: f64,
}

impl Canvas {
    /// A map: walls black, unknown cells grey, and everything beyond it.
    fn new(map: &OccupancyGrid) -> Self {
        let [low, high] = Point::bounds(map.frame().corners()).unwrap_or_default();
        let size = high - low;
        let pixel_m = size.x.max(size.y) / LONGEST_PX;
        let side = |length_m: f64| 2 * ((length_m / pixel_m / 2.0).round() as usize).max(1);
        let shape = (side(size.y), side(size.x), 3);
        let pixels = Array3::zeros(shape);
        let mut canvas = Self { pixels, left_m: low.x, top_m: high.y, pixel_m };
        for row in 0..shape.0 {
            for column in 0..shape.1 {
                let cell = map.frame().cell_of(&canvas.place(row, column));
                let value = cell.and_then(|cell| map.get(cell)).map_or(-1, |value| *value);
                let grey = if value < 0 { 190 } else { 255 - (255 * i32::from(value) / 100) };
                canvas.set(row, column, [grey as u8; 3]);
            }
        }
        canvas
    }

    /// The middle of a pixel.
    fn place(&self, row: usize, column: usize) -> Point {
        let middle_m = |index: usize| (index as f64 + 0.5) * self.pixel_m;
        Point::new(self.left_m + middle_m(column), self.top_m - middle_m(row))
    }

    fn set(&mut self, row: usize, column: usize, colour: [u8; 3]) {
        for (channel, value) in colour.into_iter().enumerate() {
            self.pixels[[row, column, channel]] = value;
        }
    }

    /// Fills a disc, as far as it is in the picture.
    fn disc(&mut self, center: &Point, radius_m: f64, colour: [u8; 3]) {
        let radius_m = radius_m.max(DOT_PX * self.pixel_m);
        let (rows, columns, _) = self.pixels.dim();
        let range = |middle_m: f64, count: usize| {
            let index = |at_m: f64| (at_m / self.pixel_m).clamp(0.0, count as f64) as usize;
            index(middle_m - radius_m)..index(middle_m + radius_m + self.pixel_m)
        };
        let across = range(center.x - self.left_m, columns);
        for row in range(self.top_m - center.y, rows) {
            for column in across.clone() {
                if (self.place(row, column) - center).norm() <= radius_m {
                    self.set(row, column, colour);
                }
            }
        }
    }
}
