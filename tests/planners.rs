//! Grid search against an independent one, and what it says when it cannot search.

#[path = "support/random_ground.rs"]
mod random_ground;

use inbye::geometry::{Point, Pose};
use inbye::global::{
    ClearanceCosts, DIAGONAL, Ground, Heuristic, Path, Plan, PlanError, STRAIGHT, Searcher,
    Settings, min_clearance_m, plan,
};
use inbye::map::{Cell, FreeSpace, ObstacleGrid, OccupancyGrid, UnknownPolicy};
use pathfinding::prelude::{bfs_reach, dijkstra};
use rand::SeedableRng;
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

/// The cells that one move leads to, with its cost: all eight, diagonals between two free cells only.
fn moves(space: &FreeSpace, from: Cell) -> Vec<(Cell, u64)> {
    let mut moves = Vec::new();
    for dx in -1..=1 {
        for dy in -1..=1 {
            let to = Cell::new(from.column + dx, from.row + dy);
            let beside = [
                Cell::new(from.column, to.row),
                Cell::new(to.column, from.row),
            ];
            if to != from && space.is_free(to) && beside.iter().all(|&cell| space.is_free(cell)) {
                let cost = if dx * dy == 0 { STRAIGHT } else { DIAGONAL };
                moves.push((to, cost));
            }
        }
    }
    moves
}

/// What the moves between consecutive cells cost; none when one of them is not allowed.
fn cost_of(space: &FreeSpace, cells: &[Cell]) -> Option<u64> {
    cells
        .windows(2)
        .map(|pair| {
            let allowed = moves(space, pair[0]);
            allowed
                .into_iter()
                .find(|&(to, _)| to == pair[1])
                .map(|(_, cost)| cost)
        })
        .sum()
}

#[test]
fn every_heuristic_agrees_with_dijkstra_on_random_grids() {
    let mut random = Pcg64Mcg::seed_from_u64(13);
    let (mut found_any, mut found_none, mut detours) = (0, 0, 0);
    let mut used = Searcher::default();
    for case in 0..600 {
        let obstacles = random_ground::obstacles(&mut random, 36);
        let frame = obstacles.frame();
        let radius_m = [0.0, 0.0, 0.6][case % 3] * frame.resolution_m;
        let space = FreeSpace::new(&obstacles, radius_m);
        let start = random_ground::cell(&mut random, frame);
        let goal = random_ground::cell(&mut random, frame);
        if !(space.is_free(start) && space.is_free(goal)) {
            continue;
        }
        let expected = dijkstra(&start, |&cell| moves(&space, cell), |&cell| cell == goal);
        for heuristic in HEURISTICS {
            let found = used.astar(&space, start, goal, heuristic, None);
            let mut unused = Searcher::default();
            let again = unused.astar(&space, start, goal, heuristic, None);
            assert_eq!(found, again, "whatever was searched before");
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
                    let reached = bfs_reach(start, |&cell| {
                        moves(&space, cell).into_iter().map(|(to, _)| to)
                    });
                    let reached = reached.count();
                    let expanded = not_found.expanded as usize;
                    // A cell may be expanded again when a cheaper way to it is found later.
                    assert!(
                        (reached..=reached + reached / 8).contains(&expanded),
                        "{expanded} of {reached}"
                    );
                }
                (expected, found) => panic!("case {case}, {heuristic:?}: {expected:?}, {found:?}"),
            }
        }
    }
    // The random grids must show all three outcomes for the comparison to mean anything.
    let counts = [found_any, found_none, detours];
    assert!(counts.iter().all(|&count| count > 100), "{counts:?}");
}

/// Jump points and A* must agree on what is shortest, whatever the grid; sides pass the 64 cells of a word.
#[test]
fn jump_points_are_as_short_as_any() {
    let mut random = Pcg64Mcg::seed_from_u64(14);
    let mut searcher = Searcher::default();
    let (mut found_any, mut found_none, mut jumped) = (0, 0, 0);
    for case in 0..6000 {
        let obstacles = random_ground::obstacles(&mut random, [20, 70, 200][case % 3]);
        let frame = obstacles.frame();
        let space = FreeSpace::new(&obstacles, [0.0, 0.3][case % 2] * frame.resolution_m);
        let start = random_ground::cell(&mut random, frame);
        let goal = random_ground::cell(&mut random, frame);
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

/// The costs as their documentation has them, with a distance taken cell by cell.
fn dearness(obstacles: &ObstacleGrid, cell: Cell, preferred_m: f64, weight: f64) -> u64 {
    let frame = obstacles.frame();
    let distance_m = (0..frame.len())
        .map(|index| frame.cell_at(index))
        .filter(|&other| obstacles.is_blocked(other))
        .map(|other| (frame.center_of(other) - frame.center_of(cell)).norm())
        .fold(f64::INFINITY, f64::min);
    let clearance_m = (distance_m - frame.resolution_m / 2.0).max(0.0);
    // A rounding error above a sixteenth below must not decide.
    (16.0 * weight * (1.0 - clearance_m / preferred_m) + 1e-9).max(0.0) as u64
}

#[test]
fn with_costs_the_cheapest_path_is_found() {
    let mut random = Pcg64Mcg::seed_from_u64(15);
    let mut searcher = Searcher::default();
    let (mut compared, mut dearer) = (0, 0);
    for case in 0..200 {
        let obstacles = random_ground::obstacles(&mut random, 24);
        let frame = obstacles.frame();
        let space = FreeSpace::new(&obstacles, 0.0);
        let start = random_ground::cell(&mut random, frame);
        let goal = random_ground::cell(&mut random, frame);
        // Odd, so that no clearance makes a whole number of sixteenths but for none.
        let (preferred_m, weight) = (3.2179 * frame.resolution_m, [0.731, 3.07, 15.0][case % 3]);
        let costs = ClearanceCosts::new(&obstacles, preferred_m, weight);
        let priced = |from: Cell| {
            let price = |(to, cost)| {
                (
                    to,
                    cost + cost * dearness(&obstacles, to, preferred_m, weight) / 16,
                )
            };
            moves(&space, from)
                .into_iter()
                .map(price)
                .collect::<Vec<_>>()
        };
        let expected = dijkstra(&start, |&cell| priced(cell), |&cell| cell == goal);
        for heuristic in [Heuristic::Octile, Heuristic::Euclid, Heuristic::default()] {
            let found = searcher
                .astar(&space, start, goal, heuristic, Some(&costs))
                .ok();
            let Some(((_, least), found)) = expected.as_ref().zip(found) else {
                continue;
            };
            let own = found.cells.windows(2).map(|pair| {
                let priced = priced(pair[0]);
                priced
                    .iter()
                    .find(|(to, _)| *to == pair[1])
                    .expect("a move")
                    .1
            });
            assert_eq!(own.sum::<u64>(), found.cost, "case {case}, {heuristic:?}");
            if heuristic.is_admissible() {
                assert_eq!(found.cost, *least, "case {case}, {heuristic:?}");
            }
            let length: u64 = cost_of(&space, found.cells).expect("moves");
            dearer += u32::from(found.cost > length);
            compared += 1;
        }
    }
    assert!(compared > 150 && dearer > 100, "{compared}, {dearer}");
}

#[test]
fn a_path_keeps_its_distance_where_that_is_asked_for_and_there_is_room() {
    let map = OccupancyGrid::from_rows(&WORKINGS, 0.5, Pose::new(-10.0, 20.0, 0.0));
    let obstacles = map.expect("rows of text").obstacles(UnknownPolicy::Blocked);
    let space = FreeSpace::new(&obstacles, 0.0);
    let (start, goal) = (Point::new(-8.7, 21.3), Point::new(8.7, 25.7));
    let planned = |clearance_weight| {
        let settings = Settings {
            clearance_weight,
            ..Settings::default()
        };
        let costs = settings.costs(&obstacles);
        assert_eq!(costs.is_some(), clearance_weight > 0.0);
        let ground = Ground {
            search: &space,
            proof: &space,
            costs: costs.as_ref(),
        };
        plan(
            &mut Searcher::default(),
            &ground,
            start,
            goal,
            &settings,
            &mut || 0.0,
        )
        .expect("the drifts are joined")
        .smoothed
    };
    // The mean distance to the nearest obstacle, by which a path that hugs walls and one that does not differ most.
    let mean_m = |path: &Path| {
        let clearances = path
            .samples(0.1)
            .map(|at| min_clearance_m(&Path::new(vec![at]), &obstacles));
        clearances.sum::<f64>() / path.samples(0.1).count() as f64
    };
    let [shortest, careful] = [0.0, 4.0].map(planned);
    assert!(careful.length_m() > shortest.length_m());
    assert!(careful.length_m() < shortest.length_m() * 1.2);
    let means_m = [&shortest, &careful].map(mean_m);
    assert!(means_m[1] > means_m[0] + 0.05, "{means_m:?}");
}

/// Two drifts joined by cross-cuts, with some spoil lying about.
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

/// A change of order, ties or heuristics shows here; lengths are in the units of the costs.
#[test]
fn the_work_of_each_heuristic_is_known() {
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
fn theta_runs_from_octile_to_manhattan() {
    let space = free_space(&WORKINGS, 0.0);
    let (start, goal) = (Cell::new(2, 11), Cell::new(37, 2));
    // The same up to the rounding of an irrational slope, which may order ties otherwise.
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
fn a_start_that_is_the_goal_is_found_at_once() {
    let space = free_space(&WORKINGS, 0.0);
    let here = Cell::new(2, 11);
    for heuristic in HEURISTICS {
        let mut searcher = Searcher::default();
        let found = searcher.astar(&space, here, here, heuristic, None);
        let found = found.expect("it is free");
        assert_eq!(
            (found.cells, found.cost, found.expanded),
            (&[here][..], 0, 0)
        );
    }
    let point = Point::new(-8.7, 21.3);
    let plan = query(&space, point, point).expect("it is free");
    for path in [&plan.raw, &plan.pruned, &plan.smoothed] {
        assert_eq!(path.points().first(), Some(&point));
        assert_eq!(path.points().last(), Some(&point));
    }
    assert_eq!(plan.smoothed.points(), [point]);
}

#[test]
fn cells_that_are_not_free_are_not_searched_from_or_for() {
    let space = free_space(&WORKINGS, 0.0);
    let free = Cell::new(2, 11);
    for bad in [
        Cell::new(0, 0),
        Cell::new(-1, 3),
        Cell::new(40, 3),
        Cell::new(3, i32::MAX),
    ] {
        for (start, goal) in [(bad, free), (free, bad), (bad, bad)] {
            let mut searcher = Searcher::default();
            let outcome = searcher.astar(&space, start, goal, Heuristic::Octile, None);
            assert_eq!(
                outcome.map_err(|not_found| not_found.expanded),
                Err(0),
                "{bad:?}"
            );
        }
    }
}

fn query(space: &FreeSpace, start: Point, goal: Point) -> Result<Plan, PlanError> {
    let ground = Ground {
        search: space,
        proof: space,
        costs: None,
    };
    let settings = Settings::default();
    plan(
        &mut Searcher::default(),
        &ground,
        start,
        goal,
        &settings,
        &mut || 0.0,
    )
}

/// The last point that a message names.
fn last_point_of(message: &str) -> Point {
    let (_, tail) = message.rsplit_once('(').expect("a point in the message");
    let (x, y) = tail.trim_end_matches(')').split_once(", ").expect(message);
    Point::new(x.parse().expect(message), y.parse().expect(message))
}

#[test]
fn a_bad_end_is_named_with_what_is_wrong_and_a_point_that_mends_it() {
    let good = Point::new(-8.7, 21.3);
    let space = free_space(&WORKINGS, 0.3);
    let cases = [
        (Point::new(-9.9, 20.1), "OCCUPIED", "is in an obstacle"),
        (
            Point::new(-9.4, 21.3),
            "OCCUPIED",
            "is less than 0.300 m from an obstacle",
        ),
        (
            Point::new(-10.01, 21.3),
            "OUTSIDE_MAP",
            "is off the map, which spans (-10.00, 20.00) to (10.00, 27.00)",
        ),
        (Point::new(10.0, 21.3), "OUTSIDE_MAP", "is off the map"),
        (Point::new(1e300, -1e300), "OUTSIDE_MAP", "is off the map"),
    ];
    for (bad, code, wrong) in cases {
        for (end, outcome) in [
            ("start", query(&space, bad, good)),
            ("goal", query(&space, good, bad)),
        ] {
            let error = outcome.expect_err("a bad end");
            let message = error.to_string();
            let end_code = format!("{}_{code}", end.to_uppercase());
            let place = format!("{end_code}: {end} ({:.2}, {:.2}) {wrong}", bad.x, bad.y);
            assert_eq!(error.code(), end_code);
            assert!(message.starts_with(&place), "{message}");
            assert!(
                message.contains(": the nearest free point is ("),
                "{message}"
            );
            assert!(!message.contains('\n'), "{message}");
            let mended = last_point_of(&message);
            let plan = query(&space, mended, mended).expect(&message);
            assert_eq!(plan.smoothed.points().first(), Some(&mended));
        }
    }
}

#[test]
fn no_free_cell_is_nearer_than_the_point_that_is_named() {
    let space = free_space(&WORKINGS, 0.3);
    let frame = space.frame();
    let bad = Point::new(-9.6, 23.4);
    let error = query(&space, bad, bad).expect_err("a bad end");
    let named = (last_point_of(&error.to_string()) - bad).norm();
    let nearest = (0..frame.len())
        .map(|index| frame.cell_at(index))
        .filter(|&cell| space.is_free(cell))
        .map(|cell| (frame.center_of(cell) - bad).norm())
        .fold(f64::INFINITY, f64::min);
    assert!((named - nearest).abs() < 1e-3);
}

#[test]
fn ends_that_are_no_numbers_and_maps_without_room_are_refused() {
    let good = Point::new(-8.7, 21.3);
    let space = free_space(&WORKINGS, 0.0);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for place in [Point::new(bad, 21.3), Point::new(-8.7, bad)] {
            let start = query(&space, place, good).expect_err("no place");
            let goal = query(&space, good, place).expect_err("no place");
            assert_eq!(start.code(), "START_OUTSIDE_MAP");
            assert_eq!(goal.code(), "GOAL_OUTSIDE_MAP");
            assert!(start.to_string().contains("must be finite"), "{start}");
        }
    }
    for radius_m in [50.0, f64::INFINITY, f64::NAN] {
        let space = free_space(&WORKINGS, radius_m);
        let error = query(&space, good, good).expect_err("no room");
        assert_eq!(error.code(), "START_OCCUPIED");
        let message = error.to_string();
        assert!(
            message.contains("the map has no free point at all"),
            "{message}"
        );
    }
}

#[test]
fn a_goal_in_a_closed_chamber_has_no_path() {
    let space = free_space(&WORKINGS, 0.0);
    let (start, chamber) = (Point::new(-8.7, 21.3), Point::new(0.8, 23.4));
    let error = query(&space, start, chamber).expect_err("a closed chamber");
    let PlanError::NoValidPath {
        expanded,
        nearest: Some(nearest),
        ..
    } = error
    else {
        panic!("{error}");
    };
    assert!(expanded > 200);
    assert_eq!(
        error.to_string(),
        format!(
            "NO_VALID_PATH: no way from (-8.70, 21.30) to (0.80, 23.40) that keeps 0.000 m from every obstacle \
             ({} cells searched); the reachable point nearest to the goal is ({:.3}, {:.3}): choose a goal on the \
             same side, a smaller radius (that of the footprint and its margins) or a finer map",
            space.count() - 6,
            nearest.x,
            nearest.y
        )
    );
    // One gets there, and from the other side of the wall it is nearer than where one came from.
    let plan = query(&space, start, nearest).expect("a reachable point");
    assert_eq!(plan.smoothed.points().last(), Some(&nearest));
    assert!((nearest - chamber).norm() < (start - chamber).norm());
}

#[test]
fn settings_out_of_range_are_named() {
    let space = free_space(&WORKINGS, 0.0);
    let ground = Ground {
        search: &space,
        proof: &space,
        costs: None,
    };
    let here = Point::new(-8.7, 21.3);
    let with = |heuristic, spline_degree| {
        let settings = Settings {
            heuristic,
            spline_degree,
            ..Settings::default()
        };
        plan(
            &mut Searcher::default(),
            &ground,
            here,
            here,
            &settings,
            &mut || 0.0,
        )
        .map_err(|error| error.to_string())
    };
    for degree in [0, 10, usize::MAX] {
        let message = with(Heuristic::Octile, degree).expect_err("a bad degree");
        assert!(message.starts_with("spline_degree is "), "{message}");
    }
    for k in [-1e-9, 1.1e6, f64::NAN, f64::INFINITY] {
        for (name, heuristic) in [
            ("normalized", Heuristic::Normalized { k }),
            ("additive", Heuristic::Additive { k }),
            ("literal", Heuristic::Literal { k }),
        ] {
            let message = with(heuristic, 3).expect_err("a bad weight");
            assert_eq!(
                message,
                format!("heuristic.{name}.k is {k}: it must be 0 to 1e6")
            );
        }
    }
    for degrees in [0.0, -30.0, 90.1, f64::NAN] {
        let message = with(Heuristic::Theta { degrees }, 3).expect_err("a bad angle");
        assert!(
            message.starts_with("heuristic.theta.degrees is "),
            "{message}"
        );
    }
}
