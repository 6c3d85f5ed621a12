//! The reachable cell nearest to a goal.

use inbye::geometry::{Point, Pose};
use inbye::global::{Searcher, nearest_reachable};
use inbye::map::{Cell, FreeSpace, OccupancyGrid, UnknownPolicy};

fn space(rows: &[&str]) -> FreeSpace {
    let map = OccupancyGrid::from_rows(rows, 1.0, Pose::default()).expect("sound rows");
    FreeSpace::new(&map.obstacles(UnknownPolicy::Blocked), 0.0)
}

/// Compares with the search itself, from every cell to every place of a map with diagonal-only gaps.
#[test]
fn nearest_reachable_equals_the_nearest_cell_found_by_search() {
    let space = space(&[".#..#...", "..#.#.#.", "#...##.#", "..#..#.."]);
    let frame = *space.frame();
    let mut searcher = Searcher::default();
    for start in frame.cells() {
        let reached: Vec<Cell> = frame
            .cells()
            .filter(|&cell| searcher.jump_points(&space, start, cell).is_ok())
            .collect();
        for goal in frame.cells().map(|cell| frame.center_of(cell)) {
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
