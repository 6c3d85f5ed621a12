//! The headings of the lattice: directions in which a straight move ends on a lattice point.

use core::f64::consts::TAU;

/// Lattice points along each side of a cell: a passage of any number of cells has its axis on lattice points.
pub(super) const PARTS: i32 = 2;

/// Directions from 0 to 45 degrees, both included, in lattice points. Their multiples by symmetry are all headings.
const FIRST_OCTANT: [(i32, i32); 5] = [(1, 0), (3, 1), (2, 1), (3, 2), (1, 1)];

/// Number of headings.
pub(super) const COUNT: usize = 32;

/// Most lattice points that a move crosses along one axis.
pub(super) const LONGEST: i32 = 3;

/// A heading of the lattice.
#[derive(Clone, Copy, Debug)]
pub(super) struct Heading {
    /// Its straight move, in lattice points.
    pub step: (i32, i32),
    /// Length of that move, lattice points.
    pub length: f64,
    /// Angle from the grid's x axis, radians, 0 to 2 pi.
    pub angle: f64,
}

/// All headings, counter-clockwise from the grid's x axis.
pub(super) fn headings() -> [Heading; COUNT] {
    let mut steps: Vec<(i32, i32)> = Vec::with_capacity(4 * COUNT);
    for (x, y) in FIRST_OCTANT {
        for (x, y) in [(x, y), (y, x)] {
            steps.extend([(x, y), (-y, x), (-x, -y), (y, -x)]);
        }
    }
    let heading = |step: (i32, i32)| {
        let (x, y) = (f64::from(step.0), f64::from(step.1));
        let angle = libm::atan2(y, x);
        Heading {
            step,
            length: libm::hypot(x, y),
            angle: if angle < 0.0 { angle + TAU } else { angle },
        }
    };
    let mut all: Vec<Heading> = steps.into_iter().map(heading).collect();
    all.sort_by(|one, other| one.angle.total_cmp(&other.angle));
    all.dedup_by_key(|heading| heading.step);
    core::array::from_fn(|index| all[index])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_are_distinct_and_at_most_nineteen_degrees_apart() {
        let all = headings();
        for (index, heading) in all.iter().enumerate() {
            let next = &all[(index + 1) % COUNT];
            let apart = (next.angle - heading.angle).rem_euclid(TAU);
            assert!(apart > 0.12 && apart < 0.33, "{heading:?} {next:?}");
            let (x, y) = heading.step;
            assert!(x.abs() <= LONGEST && y.abs() <= LONGEST);
        }
    }
}
