//! How near one can get to a goal that cannot be reached.

use crate::geometry::Point;
use crate::map::{Cell, FreeSpace};

/// The free cell that can be reached from `start` and whose centre is nearest to `goal`; of equally near ones, the first
/// in storage. None where the start is not free or lies outside the grid.
///
/// Only straight moves are followed: a diagonal one needs both cells beside it free, so it leads nowhere that two
/// straight ones do not.
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

    /// Against the search itself, from every cell to every place of a map with corners that only a diagonal would pass.
    #[test]
    fn it_is_the_nearest_cell_that_a_search_reaches() {
        let space = space(&[".#..#...", "..#.#.#.", "#...##.#", "..#..#.."]);
        let frame = *space.frame();
        let all = || (0..frame.len()).map(|index| frame.cell_at(index));
        let mut searcher = Searcher::default();
        for start in all() {
            let reached: Vec<Cell> = all()
                .filter(|&cell| searcher.jump_points(&space, start, cell).is_ok())
                .collect();
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
    fn nothing_is_reached_from_a_start_that_is_not_free() {
        let space = space(&["#.", ".."]);
        let goal = Point::new(0.5, 0.5);
        for start in [Cell::new(0, 1), Cell::new(-1, 0), Cell::new(0, 2)] {
            assert_eq!(nearest_reachable(&space, start, &goal), None);
        }
    }
}
