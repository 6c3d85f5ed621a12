//! Places spread over all ground that can be reached from one another.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::map::{Cell, FreeSpace};

/// So many cells of the largest connected part of a space, each as far from those before it as can be; the seed draws the
/// first. None where there are too few.
pub(super) fn spread(space: &FreeSpace, count: usize, seed: u64) -> Option<Vec<Cell>> {
    let part = largest_part(space);
    if part.is_empty() || part.len() < count {
        return None;
    }
    let squared = |one: Cell, other: Cell| {
        let (columns, rows) = (one.column - other.column, one.row - other.row);
        i64::from(columns).pow(2) + i64::from(rows).pow(2)
    };
    let first = Pcg64Mcg::seed_from_u64(seed).random_range(0..part.len());
    let mut chosen = vec![part[first]];
    let mut nearest = vec![i64::MAX; part.len()];
    while let (Some(&last), true) = (chosen.last(), chosen.len() < count) {
        let mut farthest = (0, 0);
        for (index, (&cell, nearest)) in part.iter().zip(&mut nearest).enumerate() {
            *nearest = (*nearest).min(squared(cell, last));
            if *nearest > farthest.0 {
                farthest = (*nearest, index);
            }
        }
        chosen.push(part[farthest.1]);
    }
    Some(chosen)
}

/// The largest set of free cells in which each can be reached from each. Since a diagonal move needs both cells beside it,
/// moves to the four nearest tell.
fn largest_part(space: &FreeSpace) -> Vec<Cell> {
    let frame = space.frame();
    let mut seen = vec![false; frame.len()];
    let mut largest = Vec::new();
    for index in 0..frame.len() {
        let first = frame.cell_at(index);
        if seen[index] || !space.is_free(first) {
            continue;
        }
        seen[index] = true;
        let mut part = vec![first];
        let mut next = 0;
        while let Some(&Cell { column, row }) = part.get(next) {
            next += 1;
            for (right, up) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
                let beside = Cell::new(column + right, row + up);
                if space.is_free(beside) && !seen[frame.index(beside)] {
                    seen[frame.index(beside)] = true;
                    part.push(beside);
                }
            }
        }
        if part.len() > largest.len() {
            largest = part;
        }
    }
    largest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::map::{OccupancyGrid, UnknownPolicy};

    fn space(rows: &[&str]) -> FreeSpace {
        let map = OccupancyGrid::from_rows(rows, 1.0, Pose::default()).expect("a sound drawing");
        FreeSpace::new(&map.obstacles(UnknownPolicy::Blocked), 0.0)
    }

    #[test]
    fn only_what_can_be_reached_counts() {
        // Two parts that meet at a corner only, which no path may cut.
        let parts = space(&["..#...", "..#...", "##...."]);
        assert_eq!(largest_part(&parts).len(), 10);
        let places = spread(&parts, 4, 1).expect("room for four");
        assert!(places.iter().all(|cell| cell.column > 1));
        assert_eq!(spread(&parts, 4, 1), Some(places));
        assert_eq!(spread(&parts, 99, 1), None);
        assert_eq!(spread(&space(&["##"]), 1, 1), None);
    }

    #[test]
    fn each_place_is_far_from_the_others() {
        let places = spread(&space(&["...................."]), 4, 7).expect("room for four");
        // Wherever the first is, both ends are among the next, and the fourth halves the longest gap.
        let columns: Vec<i32> = places.iter().map(|cell| cell.column).collect();
        assert!(
            columns[1..].contains(&0) && columns[1..].contains(&19),
            "{columns:?}"
        );
    }
}
