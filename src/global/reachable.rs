//! Flood fill of the cells reachable from a start.

use crate::geometry::Point;
use crate::map::{Cell, FreeSpace};

/// The free cell that is reachable from `start` and nearest to `goal` by its centre; ties go to the first in storage order.
/// None if the start is not free or outside the grid.
///
/// Only straight moves are needed: a diagonal move requires both adjacent cells to be free, so two straight moves replace it.
#[must_use]
pub fn nearest_reachable(space: &FreeSpace, start: Cell, goal: &Point) -> Option<Cell> {
    if !space.is_free(start) {
        return None;
    }
    let frame = space.frame();
    let goal = frame.to_cell_units(goal);
    let key = |cell: Cell| ((cell.center() - goal).norm_squared(), frame.index(cell));
    let mut best = (key(start), start);
    let mut seen = vec![false; frame.len()];
    seen[frame.index(start)] = true;
    let mut open = vec![start];
    while let Some(cell) = open.pop() {
        if key(cell) < best.0 {
            best = (key(cell), cell);
        }
        for (dx, dy) in [(1, 0), (0, 1), (-1, 0), (0, -1)] {
            let next = Cell::new(cell.column + dx, cell.row + dy);
            if space.is_free(next) && !seen[frame.index(next)] {
                seen[frame.index(next)] = true;
                open.push(next);
            }
        }
    }
    Some(best.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::global::Searcher;
    use crate::map::OccupancyGrid;
    use crate::map::UnknownPolicy;

    fn space(rows: &[&str]) -> FreeSpace {
        let map = OccupancyGrid::from_rows(rows, 1.0, Pose::default()).expect("sound rows");
        FreeSpace::new(&map.obstacles(UnknownPolicy::Blocked), 0.0)
    }

    /// Compares with the search itself, from every cell to every place of a map with diagonal-only gaps.
    #[test]
    fn nearest_reachable_equals_the_nearest_cell_found_by_search() {
        let space = space(&[".#..#...", "..#.#.#.", "#...##.#", "..#..#.."]);
        let frame = *space.frame();
        let all = || (0..frame.len()).map(|index| frame.cell_at(index));
        let mut searcher = Searcher::default();
        for start in all() {
            let reached: Vec<Cell> =
                all().filter(|&cell| searcher.jump_points(&space, start, cell).is_ok()).collect();
            for goal in all().map(|cell| frame.center_of(cell)) {
                let distance = |cell: Cell| (frame.center_of(cell) - goal).norm_squared();
                let nearest = reached
                    .iter()
                    .copied()
                    .min_by(|&one, &other| distance(one).total_cmp(&distance(other)));
                assert_eq!(nearest_reachable(&space, start, &goal), nearest);
            }
        }
    }

    #[test]
    fn nearest_reachable_is_none_from_a_blocked_start() {
        let space = space(&["#.", ".."]);
        let goal = Point::new(0.5, 0.5);
        for start in [Cell::new(0, 1), Cell::new(-1, 0), Cell::new(0, 2)] {
            assert_eq!(nearest_reachable(&space, start, &goal), None);
        }
    }
}
