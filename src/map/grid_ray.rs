//! The cells along a straight ray.

use super::Cell;
use crate::geometry::{Point, Vector};

/// An endless iterator of the cells along a ray, each with the distance at which the ray enters it.
///
/// The traversal of Amanatides and Woo (1987). Start, direction and distances are in cell units; the direction has
/// unit length. A ray through a corner enters the column's neighbour first. Start and direction must be finite.
pub(crate) struct GridRay {
    cell: Cell,
    entered: f64,
    across_columns: Crossing,
    across_rows: Crossing,
}

/// Crossings of a ray with the cell borders of one axis.
struct Crossing {
    /// -1, 0 or 1 cells.
    step: i32,
    /// Distance to the next border; infinite for a ray across the axis.
    next: f64,
    /// Distance between two borders.
    pitch: f64,
}

impl GridRay {
    pub(crate) fn new(start: &Point, direction: &Vector) -> Self {
        Self {
            cell: Cell::new(start.x.floor() as i32, start.y.floor() as i32),
            entered: 0.0,
            across_columns: Crossing::new(start.x, direction.x),
            across_rows: Crossing::new(start.y, direction.y),
        }
    }
}

#[cfg(feature = "sim")]
impl GridRay {
    /// The present cell, and the distance at which the ray enters it.
    pub(crate) const fn present(&self) -> (Cell, f64) {
        (self.cell, self.entered)
    }

    /// Crosses every border up to a distance. The result is that of as many calls of `next`, to the bit, and faster: the borders of
    /// one axis follow those of the other.
    pub(crate) fn advance_to(&mut self, distance: f64) {
        let columns = self.across_columns.cross_up_to(distance, &mut self.cell.column);
        let rows = self.across_rows.cross_up_to(distance, &mut self.cell.row);
        self.entered = self.entered.max(columns).max(rows);
    }
}

impl Crossing {
    /// Crosses the borders up to a distance; returns the distance of the last one, or zero.
    #[cfg(feature = "sim")]
    fn cross_up_to(&mut self, distance: f64, coordinate: &mut i32) -> f64 {
        let (mut at, mut crossed) = (0.0, 0);
        while self.next <= distance {
            crossed += self.step;
            at = self.next;
            self.next += self.pitch;
        }
        *coordinate = coordinate.saturating_add(crossed);
        at
    }

    fn new(start: f64, direction: f64) -> Self {
        let within = start - start.floor();
        if direction > 0.0 {
            Self { step: 1, next: (1.0 - within) / direction, pitch: 1.0 / direction }
        } else if direction < 0.0 {
            Self { step: -1, next: within / -direction, pitch: 1.0 / -direction }
        } else {
            Self { step: 0, next: f64::INFINITY, pitch: f64::INFINITY }
        }
    }

    /// Crosses the next border; returns its distance.
    fn cross(&mut self, coordinate: &mut i32) -> f64 {
        *coordinate = coordinate.saturating_add(self.step);
        let at = self.next;
        self.next += self.pitch;
        at
    }
}

impl Iterator for GridRay {
    type Item = (Cell, f64);

    fn next(&mut self) -> Option<Self::Item> {
        let entry = (self.cell, self.entered);
        self.entered = if self.across_columns.next <= self.across_rows.next {
            self.across_columns.cross(&mut self.cell.column)
        } else {
            self.across_rows.cross(&mut self.cell.row)
        };
        Some(entry)
    }
}

#[cfg(all(test, feature = "sim"))]
mod tests {
    use super::*;

    #[test]
    fn advanced_ray_equals_one_that_took_each_step_to_the_bit() {
        for tenth_degrees in 0..3600 {
            let angle = f64::from(tenth_degrees).to_radians() / 10.0;
            let direction = Vector::new(libm::cos(angle), libm::sin(angle));
            let start = Point::new(3.25, -7.6);
            for distance in [0.0, 0.3, 5.0, 41.7] {
                let mut stepped = GridRay::new(&start, &direction);
                while stepped.across_columns.next.min(stepped.across_rows.next) <= distance {
                    stepped.next();
                }
                let mut advanced = GridRay::new(&start, &direction);
                advanced.advance_to(distance / 3.0);
                advanced.advance_to(distance);
                let bits = |ray: &mut GridRay| {
                    let mut following = || ray.next().map(|(cell, at)| (cell, at.to_bits()));
                    [following(), following(), following(), following()]
                };
                assert_eq!(advanced.present(), stepped.present());
                assert_eq!(bits(&mut advanced), bits(&mut stepped), "{angle} rad, {distance}");
            }
        }
    }
}
