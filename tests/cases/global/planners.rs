//! Grid search, compared with an independent implementation, and its errors.

mod costs;
mod ends;

use inbye::geometry::{Point, Pose};
use inbye::global::{
    DIAGONAL, Heuristic, Plan, PlanError, PlanningSpace, STRAIGHT, Searcher, Settings, plan,
};
use inbye::map::{Cell, FreeSpace, GridFrame, ObstacleGrid, OccupancyGrid, UnknownPolicy};
use pathfinding::prelude::{bfs_reach, dijkstra};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

const HEURISTICS: [Heuristic; 14] = [
    Heuristic::Euclid,
    Heuristic::Octile,
    Heuristic::Theta { degrees: 1e-3 },
    Heuristic::Theta { degrees: 30.0 },
    Heuristic::Theta { degrees: 45.0 },
    Heuristic::Normalized { k: 0.0 },
    Heuristic::Literal { k: 0.0 },
    Heuristic::Manhattan,
    Heuristic::Theta { degrees: 60.0 },
    Heuristic::Normalized { k: 0.1 },
    Heuristic::Additive { k: 0.001 },
    Heuristic::Additive { k: 1e6 },
    Heuristic::Literal { k: 0.001 },
    Heuristic::Literal { k: 1e6 },
];

/// The neighbours of a cell with their move costs; diagonals only between two free cells.
fn moves(space: &FreeSpace, from: Cell) -> Vec<(Cell, u64)> {
    let mut moves = Vec::new();
    for dx in -1..=1 {
        for dy in -1..=1 {
            let to = Cell::new(from.column + dx, from.row + dy);
            let adjacent = [Cell::new(from.column, to.row), Cell::new(to.column, from.row)];
            if to != from && space.is_free(to) && adjacent.iter().all(|&cell| space.is_free(cell)) {
                let cost = if dx * dy == 0 { STRAIGHT } else { DIAGONAL };
                moves.push((to, cost));
            }
        }
    }
    moves
}

/// Total cost of the moves between consecutive cells; none if one of them is not allowed.
fn cost_of(space: &FreeSpace, cells: &[Cell]) -> Option<u64> {
    cells
        .windows(2)
        .map(|pair| {
            let allowed = moves(space, pair[0]);
            allowed.into_iter().find(|&(to, _)| to == pair[1]).map(|(_, cost)| cost)
        })
        .sum()
}

#[test]
fn heuristics_agree_with_dijkstra_on_random_grids() {
    let mut random = Pcg64Mcg::seed_from_u64(13);
    let (mut found_any, mut found_none, mut detours) = (0, 0, 0);
    let mut used = Searcher::default();
    for case in 0..600 {
        let obstacles = crate::support::random_grid::obstacles(&mut random, 36);
        let frame = obstacles.frame();
        let radius_m = [0.0, 0.0, 0.6][case % 3] * frame.resolution_m;
        let space = FreeSpace::new(&obstacles, radius_m);
        let start = crate::support::random_grid::cell(&mut random, frame);
        let goal = crate::support::random_grid::cell(&mut random, frame);
        if !(space.is_free(start) && space.is_free(goal)) {
            continue;
        }
        let expected = dijkstra(&start, |&cell| moves(&space, cell), |&cell| cell == goal);
        for heuristic in HEURISTICS {
            let found = used.astar(&space, start, goal, heuristic, None);
            let mut unused = Searcher::default();
            let again = unused.astar(&space, start, goal, heuristic, None);
            assert_eq!(found, again, "independent of earlier searches");
            match (&expected, found) {
                (Some((_, least)), Ok(found)) => {
                    found_any += 1;
                    assert_eq!(found.cells.first(), Some(&start));
                    assert_eq!(found.cells.last(), Some(&goal));
                    let cost = cost_of(&space, found.cells);
                    assert_eq!(cost, Some(found.cost), "case {case}, {heuristic:?}");
                    if heuristic.is_admissible() {
                        assert_eq!(found.cost, *least, "case {case}, {heuristic:?}");
                    } else {
                        assert!(found.cost >= *least, "case {case}, {heuristic:?}");
                        detours += u32::from(found.cost > *least);
                    }
                }
                (None, Err(not_found)) => {
                    found_none += 1;
                    let reached =
                        bfs_reach(start, |&cell| moves(&space, cell).into_iter().map(|(to, _)| to));
                    let reached = reached.count();
                    let expanded = not_found.expanded as usize;
                    // A cell may be expanded again if a cheaper path to it is found later.
                    assert!(
                        (reached..=reached + reached / 8).contains(&expanded),
                        "{expanded} of {reached}"
                    );
                }
                (expected, found) => panic!("case {case}, {heuristic:?}: {expected:?}, {found:?}"),
            }
        }
    }
    // The comparison is meaningful only if all three outcomes occur.
    let counts = [found_any, found_none, detours];
    assert!(counts.iter().all(|&count| count > 100), "{counts:?}");
}

/// Jump point search and A* agree on the shortest length; grid sides exceed the 64 cells of a word.
#[test]
fn jump_points_find_paths_as_short_as_a_star() {
    let mut random = Pcg64Mcg::seed_from_u64(14);
    let mut searcher = Searcher::default();
    let (mut found_any, mut found_none, mut jumped) = (0, 0, 0);
    for case in 0..6000 {
        let obstacles =
            crate::support::random_grid::obstacles(&mut random, [20, 70, 200][case % 3]);
        let frame = obstacles.frame();
        let space = FreeSpace::new(&obstacles, [0.0, 0.3][case % 2] * frame.resolution_m);
        let start = crate::support::random_grid::cell(&mut random, frame);
        let goal = crate::support::random_grid::cell(&mut random, frame);
        let expected = searcher.astar(&space, start, goal, Heuristic::Octile, None);
        let expected = expected.map(|found| (found.cost, found.expanded));
        match (expected, searcher.jump_points(&space, start, goal)) {
            (Ok((least, expanded)), Ok(found)) => {
                found_any += 1;
                jumped += u32::from(found.expanded < expanded);
                assert_eq!(found.cells.first(), Some(&start));
                assert_eq!(found.cells.last(), Some(&goal));
                assert_eq!(cost_of(&space, found.cells), Some(least), "case {case}");
                assert_eq!(found.cost, least, "case {case}");
            }
            (Err(_), Err(_)) => found_none += 1,
            (expected, found) => panic!("case {case}: {expected:?}, {found:?}"),
        }
    }
    let counts = [found_any, found_none, jumped];
    assert!(counts.iter().all(|&count| count > 500), "{counts:?}");
}

/// Row and column indices that use all their bits, and cells next to the last word of a row.
#[test]
fn search_handles_the_longest_grids() {
    let mut random = Pcg64Mcg::seed_from_u64(16);
    let mut searcher = Searcher::default();
    for (width, height) in [(32_767, 3), (3, 32_767), (32_767, 1), (1, 32_767)] {
        let frame = GridFrame::new(width, height, 0.1, Pose::default()).expect("valid sides");
        let mut obstacles = ObstacleGrid::filled(frame, false);
        // Posts that leave a free lane.
        if width > 1 && height > 1 {
            for at in (10..32_700).step_by(7) {
                let side = 2 * random.random_range(0..=1);
                let along = at + random.random_range(0..3);
                let post =
                    if width > height { Cell::new(along, side) } else { Cell::new(side, along) };
                obstacles.set(post, true);
            }
        }
        let space = FreeSpace::new(&obstacles, 0.0);
        let ends = [Cell::new(0, 0), Cell::new(width - 1, height - 1)];
        for [start, goal] in [ends, [ends[1], ends[0]]] {
            let shortest = searcher.astar(&space, start, goal, Heuristic::Octile, None);
            let shortest = shortest.map(|found| found.cost).expect("an open lane");
            let found = searcher.jump_points(&space, start, goal).expect("an open lane");
            assert_eq!(found.cost, shortest, "{width} by {height}");
            assert_eq!(cost_of(&space, found.cells), Some(shortest), "{width} by {height}");
        }
    }
}
/// Two drifts joined by cross-cuts, with some obstacles.
const WORKINGS: [&str; 14] = [
    "########################################",
    "#......................................#",
    "#.........##.......................#...#",
    "#...............#......................#",
    "####..########..##########..########..##",
    "####..########..##########..########..##",
    "####..########..####...###..########..##",
    "####..########..####...###..########..##",
    "####..########..##########..########..##",
    "#......................................#",
    "#.....#.....................##.........#",
    "#..................#...................#",
    "#......................................#",
    "########################################",
];

fn free_space(rows: &[impl AsRef<str>], radius_m: f64) -> FreeSpace {
    let map =
        OccupancyGrid::from_rows(rows, 0.5, Pose::new(-10.0, 20.0, 0.0)).expect("rows of text");
    FreeSpace::new(&map.obstacles(UnknownPolicy::Blocked), radius_m)
}

/// Detects changes of expansion order, ties or heuristics; lengths are in units of cost.
#[test]
fn expansions_of_each_heuristic_are_unchanged() {
    let space = free_space(&WORKINGS, 0.0);
    let (start, goal) = (Cell::new(2, 11), Cell::new(34, 1));
    let work = |heuristic| {
        let mut searcher = Searcher::default();
        let found = searcher.astar(&space, start, goal, heuristic, None);
        let found = found.expect("the drifts are joined");
        (found.expanded, found.cost)
    };
    let table = [
        (Heuristic::default(), (126, 541_525)),
        (Heuristic::Octile, (122, 541_525)),
        (Heuristic::Euclid, (187, 541_525)),
        (Heuristic::Manhattan, (39, 557_763)),
        (Heuristic::Theta { degrees: 30.0 }, (183, 541_525)),
        (Heuristic::Theta { degrees: 60.0 }, (114, 541_525)),
        (Heuristic::Additive { k: 0.001 }, (129, 541_525)),
        (Heuristic::Literal { k: 0.001 }, (265, 541_525)),
        (Heuristic::Literal { k: 1.0 }, (64, 541_525)),
        // Plain Dijkstra.
        (Heuristic::Literal { k: 0.0 }, (278, 541_525)),
    ];
    let measured = table.map(|(heuristic, _)| (heuristic, work(heuristic)));
    assert_eq!(measured, table);
}

#[test]
fn theta_interpolates_between_octile_and_manhattan() {
    let space = free_space(&WORKINGS, 0.0);
    let (start, goal) = (Cell::new(2, 11), Cell::new(37, 2));
    // Equal up to the rounding of an irrational slope, which may change the order of ties.
    let cost = |heuristic| {
        let mut searcher = Searcher::default();
        let found = searcher.astar(&space, start, goal, heuristic, None);
        found.map(|found| found.cost)
    };
    let theta = |degrees| cost(Heuristic::Theta { degrees });
    assert_eq!(theta(45.0), cost(Heuristic::Octile));
    assert_eq!(theta(90.0), cost(Heuristic::Manhattan));
}

#[test]
fn start_equal_to_goal_needs_no_expansion() {
    let space = free_space(&WORKINGS, 0.0);
    let here = Cell::new(2, 11);
    for heuristic in HEURISTICS {
        let mut searcher = Searcher::default();
        let found = searcher.astar(&space, here, here, heuristic, None);
        let found = found.expect("it is free");
        assert_eq!((found.cells, found.cost, found.expanded), (&[here][..], 0, 0));
    }
    let mut searcher = Searcher::default();
    let found = searcher.jump_points(&space, here, here);
    let found = found.expect("it is free");
    assert_eq!((found.cells, found.cost), (&[here][..], 0));
    let point = Point::new(-8.7, 21.3);
    let plan = query(&space, point, point).expect("it is free");
    for path in [&plan.raw, &plan.pruned, &plan.smoothed] {
        assert_eq!(path.points().first(), Some(&point));
        assert_eq!(path.points().last(), Some(&point));
    }
    assert_eq!(plan.smoothed.points(), [point]);
}

#[test]
fn search_rejects_ends_that_are_not_free() {
    let space = free_space(&WORKINGS, 0.0);
    let free = Cell::new(2, 11);
    for bad in [Cell::new(0, 0), Cell::new(-1, 3), Cell::new(40, 3), Cell::new(3, i32::MAX)] {
        for (start, goal) in [(bad, free), (free, bad), (bad, bad)] {
            let mut searcher = Searcher::default();
            let outcome = searcher.astar(&space, start, goal, Heuristic::Octile, None);
            assert_eq!(outcome.map_err(|not_found| not_found.expanded), Err(0), "{bad:?}");
            let outcome = searcher.jump_points(&space, start, goal);
            assert!(outcome.is_err(), "{bad:?}");
        }
    }
}

fn query(space: &FreeSpace, start: Point, goal: Point) -> Result<Plan, PlanError> {
    let ground = PlanningSpace { search: space, smoothing: space, costs: None };
    let settings = Settings::default();
    plan(&mut Searcher::default(), &ground, start, goal, &settings, &mut || 0.0)
}
