//! Directions of a turn, and values by direction.

use core::f64::consts::TAU;
use std::sync::LazyLock;

use crate::geometry::Point;

/// Directions of a turn for which earlier free space is remembered.
pub(super) const BINS: usize = 360;

/// Parts of a turn, by [`part_of`].
const PARTS: usize = 720;

/// Index of the direction to a point from the origin, and its distance, metres.
pub(super) fn polar(point: &Point) -> (usize, f64) {
    (bin_of(libm::atan2(point.y, point.x), BINS), point.to_vector().norm())
}

/// Index of a direction among equal parts of a turn.
pub(super) fn bin_of(direction: f64, bins: usize) -> usize {
    // As `rem_euclid`, without a division for a direction within a turn.
    let rest = if direction.abs() < TAU { direction } else { direction % TAU };
    let turn = (if rest < 0.0 { rest + TAU } else { rest }) / TAU;
    ((turn * bins as f64) as usize).min(bins - 1)
}

/// The largest of some values around each direction. It bounds the value in the direction of a point without an arc tangent, which
/// takes longer than everything else that most points need.
#[derive(Clone, Debug)]
pub(super) struct Largest(Vec<f64>);

impl Largest {
    /// The largest of these values, one for each of [`BINS`] directions, with a few neighbours on each side.
    pub fn of(values: &[f64], neighbours: usize) -> Self {
        // What lies beyond a whole turn, on both sides, needs no remainder of a division.
        let turns = values.repeat(3);
        let around = |(first, last): &(usize, usize)| {
            let bins = &turns[first - neighbours..=last + neighbours];
            bins.iter()
                .fold(f64::NEG_INFINITY, |most, &value| if value > most { value } else { most })
        };
        Self(BINS_OF_PARTS.iter().map(around).collect())
    }

    /// At least the value in the direction of a point from the origin.
    pub fn at(&self, point: &Point) -> f64 {
        part_of(point).and_then(|part| self.0.get(part)).copied().unwrap_or(f64::INFINITY)
    }
}

/// Index of the direction to a point among the parts of a turn; none to the origin itself. The parts are nearly equal: they are
/// equal on the outline of a square that stands on a corner.
fn part_of(point: &Point) -> Option<usize> {
    let share = point.x / (point.x.abs() + point.y.abs());
    let along = if point.y >= 0.0 { 1.0 - share } else { 3.0 + share };
    (!along.is_nan()).then(|| ((along * (PARTS / 4) as f64) as usize).min(PARTS - 1))
}

/// The first and the last of [`BINS`] directions that a part may contain, with one more on each side for rounding. They are in the
/// second of three turns, or next to it.
static BINS_OF_PARTS: LazyLock<Vec<(usize, usize)>> = LazyLock::new(|| {
    // The direction at which a part begins, as an index of directions.
    let begin = |part: usize| {
        let along = part as f64 / (PARTS / 4) as f64;
        let (x, y) = if along <= 2.0 {
            (1.0 - along, 1.0 - (1.0 - along).abs())
        } else {
            (along - 3.0, (along - 3.0).abs() - 1.0)
        };
        let direction = libm::atan2(y, x);
        let turn = if direction < 0.0 || part == PARTS { direction + TAU } else { direction };
        (turn / TAU * BINS as f64) as usize
    };
    (0..PARTS).map(|part| (begin(part) + BINS - 1, begin(part + 1) + BINS + 1)).collect()
});

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn largest_is_at_least_the_value_in_the_direction_of_any_point() {
        let only = |bin: usize| {
            let mut values = vec![0.0; BINS];
            values[bin] = 1.0;
            values
        };
        let all: Vec<Largest> = (0..BINS).map(|bin| Largest::of(&only(bin), 0)).collect();
        let wide = Largest::of(&only(10), 3);
        let mut bounded = 0;
        for step in 0..36_000 {
            let direction = f64::from(step - 18_000) * TAU / 36_000.0;
            let distance_m = 1.0 + f64::from(step % 7);
            let (sin, cos) = libm::sincos(direction);
            let point = Point::new(distance_m * cos, distance_m * sin);
            let (bin, _) = polar(&point);
            assert_eq!(all[bin].at(&point), 1.0, "{direction}");
            bounded += all.iter().filter(|largest| largest.at(&point) == 0.0).count();
            if (7..=13).contains(&bin) {
                assert_eq!(wide.at(&point), 1.0, "{direction}");
            }
        }
        // The bound is of use: it is the value of few directions.
        assert!(bounded >= 36_000 * (BINS - 5), "{bounded}");
        for (x, y) in [(0.0, 0.0), (-0.0, 0.0), (1.0, -0.0), (-1.0, -0.0), (-1.0, 0.0), (0.0, -2.0)]
        {
            let point = Point::new(x, y);
            assert!(all[polar(&point).0].at(&point) >= 1.0, "{x}, {y}");
        }
    }
}
