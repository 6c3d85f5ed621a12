//! Farthest-point sampling of connected free cells.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::map::{Cell, FreeSpace};

/// Returns cells of the largest connected part of a space, each as far as possible from those before it; the seed determines
/// the first. None if there are too few.
pub(super) fn farthest_points(space: &FreeSpace, count: usize, seed: u64) -> Option<Vec<Cell>> {
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

/// The largest connected set of free cells. A diagonal move needs both adjacent cells, so moves to the four neighbours
/// suffice.
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
                let neighbour = Cell::new(column + right, row + up);
                if space.is_free(neighbour) && !seen[frame.index(neighbour)] {
                    seen[frame.index(neighbour)] = true;
                    part.push(neighbour);
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
    fn farthest_points_are_in_the_largest_connected_part() {
        // Two parts that touch only at a corner, which no path may cut.
        let parts = space(&["..#...", "..#...", "##...."]);
        assert_eq!(largest_part(&parts).len(), 10);
        let places = farthest_points(&parts, 4, 1).expect("room for four");
        assert!(places.iter().all(|cell| cell.column > 1));
        assert_eq!(farthest_points(&parts, 4, 1), Some(places));
        assert_eq!(farthest_points(&parts, 99, 1), None);
        assert_eq!(farthest_points(&space(&["##"]), 1, 1), None);
    }

    #[test]
    fn farthest_points_are_far_from_each_other() {
        let places =
            farthest_points(&space(&["...................."]), 4, 7).expect("room for four");
        // For any first cell, both ends are among the next ones, and the fourth halves the longest gap.
        let columns: Vec<i32> = places.iter().map(|cell| cell.column).collect();
        assert!(columns[1..].contains(&0) && columns[1..].contains(&19), "{columns:?}");
    }
}
