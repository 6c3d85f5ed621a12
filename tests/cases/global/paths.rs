//! Planned paths in their three stages: ends, lengths and clearance.

mod lattice_sight;
mod sight;

use inbye::geometry::{Point, Pose};
use inbye::global::{
    Heuristic, Path, Plan, PlanError, PlanningSpace, Pruning, Searcher, Settings, is_clear, plan,
    prune,
};
use inbye::map::{Cell, FreeSpace, GridFrame, ObstacleGrid};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::support::gap;

/// Radii in cells: zero, below a cell, exact distances between cell squares, and values between those.
const RADII: [f64; 8] = [0.0, 0.3, 1.0, core::f64::consts::SQRT_2, 1.7, 2.0, 2.6, 4.0];

const HEURISTICS: [Heuristic; 4] = [
    Heuristic::Normalized { k: 0.1 },
    Heuristic::Octile,
    Heuristic::Manhattan,
    Heuristic::Literal { k: 0.1 },
];

/// A random map, and a plan on it.
struct Case {
    obstacles: ObstacleGrid,
    search: FreeSpace,
    proof: FreeSpace,
    start: Point,
    goal: Point,
    plan: Plan,
}

/// Plans on random maps until `maps` of them have a path; each map is tried once.
fn cases(seed: u64, maps: usize, most_side: i32) -> impl Iterator<Item = Case> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    (0..maps).filter_map(move |number| case(&mut random, number, most_side))
}

fn case(random: &mut Pcg64Mcg, number: usize, most_side: i32) -> Option<Case> {
    let obstacles = crate::support::random_grid::obstacles(random, most_side);
    let frame = *obstacles.frame();
    let cells = RADII[number % RADII.len()];
    let search_m = cells * frame.resolution_m;
    let proof_m = search_m * [1.0, 0.5, 0.8, 0.0][random.random_range(0..4)];
    let [search, proof] = FreeSpace::for_radii(&obstacles, [search_m, proof_m]);
    let free: Vec<Cell> = frame.cells().filter(|&cell| search.is_free(cell)).collect();
    let any_free = |random: &mut Pcg64Mcg| {
        let cell = free.get(random.random_range(0..free.len().max(1)))?;
        Some(point_in(random, &frame, *cell))
    };
    let (start, goal) = (any_free(random)?, any_free(random)?);
    let settings = Settings::default()
        .heuristic(HEURISTICS[number % HEURISTICS.len()])
        .spline_degree(random.random_range(1..=6));
    let ground = PlanningSpace { search: &search, smoothing: &proof, costs: None };
    match plan(&mut Searcher::default(), &ground, start, goal, &settings, &mut || 0.0) {
        Ok(plan) => Some(Case { obstacles, search, proof, start, goal, plan }),
        // A point on a cell's border may be rounded into the next cell or off the grid.
        Err(error) => {
            assert!(!matches!(error, PlanError::Setting(_)), "map {number}: {error}");
            None
        }
    }
}

/// A random point in a cell: its centre, on its border, or anywhere.
fn point_in(random: &mut Pcg64Mcg, frame: &GridFrame, cell: Cell) -> Point {
    let mut within = || match random.random_range(0..4) {
        0 => 0.0,
        1 => 0.5,
        _ => random.random_range(0.0..1.0),
    };
    let (x, y) = (within(), within());
    frame.from_cell_units(&Point::new(f64::from(cell.column) + x, f64::from(cell.row) + y))
}

/// Why a polyline does not keep its clearance, if it does not.
fn fault(path: &Path, obstacles: &ObstacleGrid, radius_m: f64) -> Option<String> {
    let gap_m = gap::smallest_gap_m(path.points(), obstacles, radius_m, gap::STEP);
    if !gap::is_on_grid(path.points(), obstacles) {
        Some("leaves the map".to_owned())
    } else if edge_gap_m(path, obstacles.frame()) < radius_m - 1e-9 {
        Some("is too near to the edge of the map".to_owned())
    } else if gap_m < radius_m - 1e-9 || (gap_m == 0.0 && touches_inside(path, obstacles)) {
        Some(format!("comes within {gap_m} m, not {radius_m} m"))
    } else {
        None
    }
}

/// The smallest distance from a path to the edge of the map, metres: one of its corners is the nearest to a side.
fn edge_gap_m(path: &Path, frame: &GridFrame) -> f64 {
    let (width, height) = (f64::from(frame.width), f64::from(frame.height));
    let gap = |point: &Point| {
        let at = frame.to_cell_units(point);
        at.x.min(at.y).min(width - at.x).min(height - at.y)
    };
    path.points().iter().map(gap).fold(f64::INFINITY, f64::min) * frame.resolution_m
}

/// Whether a path runs through the interior of an obstacle cell, not only along its border. This is forbidden for a
/// radius of zero.
fn touches_inside(path: &Path, obstacles: &ObstacleGrid) -> bool {
    let frame = obstacles.frame();
    path.points().windows(2).any(|pair| {
        let steps = ((pair[1] - pair[0]).norm() / frame.resolution_m * 20.0).ceil() as i32;
        (0..=steps).any(|step| {
            let at = pair[0] + (pair[1] - pair[0]) * (f64::from(step) / f64::from(steps));
            let units = frame.to_cell_units(&at);
            let within = |at: f64| (at - at.floor() - 0.5).abs() < 0.5 - 1e-9;
            let cell = frame.cell_of(&at);
            within(units.x)
                && within(units.y)
                && cell.is_some_and(|cell| obstacles.is_blocked(cell))
        })
    })
}

#[test]
fn every_stage_keeps_ends_and_clearance_and_never_grows() {
    let mut count = 0;
    for (number, case) in cases(21, 20_000, 40).enumerate() {
        let Plan { raw, pruned, smoothed, .. } = &case.plan;
        for (name, path, space) in [
            ("raw", raw, &case.search),
            ("pruned", pruned, &case.search),
            ("smoothed", smoothed, &case.proof),
        ] {
            assert_eq!(path.points().first(), Some(&case.start), "{name} {number}");
            assert_eq!(path.points().last(), Some(&case.goal), "{name} {number}");
            let fault = fault(path, &case.obstacles, space.radius_m());
            assert_eq!(fault, None, "{name} path {number}");
            let clear = |pair: &[Point]| is_clear(space, &pair[0], &pair[1]);
            let ends = [case.start, case.goal];
            if !ends.iter().any(|end| is_on_border(space.frame(), end)) {
                assert!(path.points().windows(2).all(clear), "{name} path {number}");
            }
        }
        let tolerance_m = 1e-9 * (1.0 + raw.length_m());
        assert!(pruned.length_m() <= raw.length_m() + tolerance_m, "path {number}");
        // The control points lie on the pruned path in its order, and a B-spline is no longer than its control polygon.
        assert!(smoothed.length_m() <= pruned.length_m() + tolerance_m, "path {number}");
        count += 1;
    }
    assert!(count > 10_000, "only {count} maps had a path");
}

/// Whether a point is on a cell's border, where it touches cells that need not be free.
fn is_on_border(frame: &GridFrame, point: &Point) -> bool {
    let units = frame.to_cell_units(point);
    [units.x, units.y].iter().any(|&at| (at - at.round()).abs() < 1e-7)
}

/// Checks that the comparison above detects a collision.
/// A planner of a user may return such points; the navigator refuses them.
#[test]
fn projection_on_points_that_are_not_finite_does_not_panic() {
    for bad in [f64::NAN, f64::INFINITY] {
        let path = Path::new([0.0, bad, 2.0].map(|x| Point::new(x, 0.0)).to_vec());
        let place = Point::new(1.0, 1.0);
        assert_eq!(path.project(&place).arc_m, 0.0, "{bad}");
        assert!(!path.project_within(&place, bad..bad).arc_m.is_nan(), "{bad}");
    }
}

#[test]
fn clearance_check_detects_an_obstacle_on_a_path() {
    let mut random = Pcg64Mcg::seed_from_u64(22);
    let mut count = 0;
    for case in cases(23, 800, 40) {
        let path = &case.plan.smoothed;
        let at = path.point_at(path.length_m() * random.random_range(0.05..0.95));
        let cell = case.obstacles.frame().cell_of(&at).expect("paths stay on the map");
        let radius_m = case.proof.radius_m();
        let mut blocked = case.obstacles.clone();
        blocked.set(cell, true);
        if path.points().len() > 1 && radius_m > 0.0 {
            assert!(fault(path, &blocked, radius_m).is_some(), "at {at:?}");
            count += 1;
        }
        // It also detects a required clearance slightly above the kept one.
        let kept_m = gap::smallest_gap_m(path.points(), &case.obstacles, radius_m + 3.0, gap::STEP);
        if kept_m.is_finite() {
            assert!(fault(path, &case.obstacles, kept_m + 1e-6).is_some());
        }
    }
    assert!(count > 200, "only {count} maps had a path");
}

/// On longer paths, not all nodes take part at first.
const ALL_TAKE_PART: usize = 63;

#[test]
fn sparse_pruning_of_a_long_path_is_nearly_shortest() {
    let (mut count, mut excess) = (0, 0.0);
    for (number, case) in cases(26, 6000, 150).enumerate() {
        let nodes = case.plan.raw.points();
        if !(ALL_TAKE_PART + 1..=200).contains(&nodes.len()) {
            continue;
        }
        let expected = shortest_chain_m(&case.search, nodes);
        let ratio = case.plan.pruned.length_m() / expected;
        // After an indirect search, a shortcut may lie between nodes that took no part.
        let is_near = (1.0 - 1e-9..1.2).contains(&ratio);
        assert!(is_near, "path {number}: {ratio} times the shortest");
        excess += ratio - 1.0;
        count += 1;
    }
    let mean = excess / f64::from(count);
    assert!(count > 100 && mean < 0.001, "{count} paths, {mean} longer on average");
}

#[test]
fn pruning_finds_the_shortest_chain_of_nodes() {
    let mut count = 0;
    for (number, case) in cases(24, 1200, 24).enumerate() {
        let nodes = case.plan.raw.points();
        let expected = shortest_chain_m(&case.search, nodes);
        let pruned = prune(&case.search, None, &case.plan.raw, Pruning::Thorough);
        let found = pruned.length_m();
        if nodes.len() <= ALL_TAKE_PART {
            assert_eq!(pruned, case.plan.pruned);
        }
        assert!((found - expected).abs() < 1e-7, "path {number}: {found} m, not {expected} m");
        // Its nodes are nodes of the path, in order.
        let mut rest = nodes.iter();
        let is_kept = |node| rest.any(|other| other == node);
        assert!(pruned.points().iter().all(is_kept), "path {number}");
        count += usize::from(nodes.len() > 5);
    }
    assert!(count > 300, "only {count} maps had a path worth pruning");
}

/// Shortest distance from the first node to the last along forward lines of sight, by Floyd and Warshall.
fn shortest_chain_m(space: &FreeSpace, nodes: &[Point]) -> f64 {
    let count = nodes.len();
    let mut least = vec![vec![f64::INFINITY; count]; count];
    for from in 0..count {
        least[from][from] = 0.0;
        for to in from + 1..count {
            if to == from + 1 || is_clear(space, &nodes[from], &nodes[to]) {
                least[from][to] = (nodes[to] - nodes[from]).norm();
            }
        }
    }
    for over in 0..count {
        for from in 0..count {
            for to in 0..count {
                least[from][to] = least[from][to].min(least[from][over] + least[over][to]);
            }
        }
    }
    least[0][count - 1]
}

fn path(points: &[(f64, f64)]) -> Path {
    Path::new(points.iter().map(|&(x, y)| Point::new(x, y)).collect())
}

#[test]
fn pruning_merges_collinear_nodes_and_leaves_a_line_where_that_is_shorter() {
    let frame = GridFrame { width: 20, height: 20, resolution_m: 1.0, origin: Pose::default() };
    let mut obstacles = ObstacleGrid::filled(frame, false);
    let space = FreeSpace::new(&obstacles, 0.0);
    let straight = path(&[(0.5, 0.5), (1.5, 0.5), (2.5, 0.5), (7.5, 0.5)]);
    let ends = [(0.5, 0.5), (7.5, 0.5)];
    assert_eq!(prune(&space, None, &straight, Pruning::Thorough), path(&ends));
    let alone = path(&[(3.2, 3.4)]);
    assert_eq!(prune(&space, None, &alone, Pruning::Thorough), alone);
    // Along the wall and then up: the shortest chain leaves the lower stretch in its middle, where the path has no turn.
    for column in 3..=6 {
        for row in 3..=8 {
            obstacles.set(Cell::new(column, row), true);
        }
    }
    let space = FreeSpace::new(&obstacles, 0.0);
    let around = path(&[(0.5, 2.5), (3.5, 2.5), (5.5, 2.5), (7.5, 2.5), (9.5, 2.5), (9.5, 9.5)]);
    let pruned = prune(&space, None, &around, Pruning::Thorough);
    assert_eq!(pruned, path(&[(0.5, 2.5), (7.5, 2.5), (9.5, 9.5)]));
}

#[test]
fn turns_are_changes_above_five_degrees_to_either_side() {
    let heading = |degrees: f64| libm::sincos(degrees.to_radians());
    for (degrees, turns) in
        [(0.0, 0), (4.9, 0), (-4.9, 0), (5.1, 1), (-5.1, 1), (90.0, 1), (180.0, 1), (-179.0, 1)]
    {
        for first in [0.0, 45.0, 178.0, -178.0, 90.0] {
            let (y1, x1) = heading(first);
            let (y2, x2) = heading(first + degrees);
            let bent = path(&[(0.0, 0.0), (x1, y1), (x1 + x2, y1 + y2)]);
            assert_eq!(bent.turns(), turns, "{degrees} degrees from {first}");
        }
    }
    let staircase: Vec<(f64, f64)> =
        (0..9).map(|step| (f64::from((step + 1) / 2), f64::from(step / 2))).collect();
    assert_eq!(path(&staircase).turns(), 7);
    assert_eq!(path(&[(1.0, 1.0)]).turns(), 0);
    assert_eq!(path(&[(1.0, 1.0), (2.0, 1.0)]).turns(), 0);
}

#[test]
fn ends_at_cell_centres_add_no_turn() {
    // Centres given by a user often differ from the map's by a rounding error.
    for case in cases(25, 300, 30) {
        let frame = case.obstacles.frame();
        let ground = PlanningSpace { search: &case.search, smoothing: &case.proof, costs: None };
        let settings = Settings::default();
        let center = |point| frame.center_of(frame.cell_of(point).expect("on the map"));
        let (start, goal) = (center(&case.start), center(&case.goal));
        let exact = plan(&mut Searcher::default(), &ground, start, goal, &settings, &mut || 0.0)
            .expect("as before");
        let nudged = |point: Point| {
            let up = |value: f64| f64::from_bits(value.to_bits() + 1);
            Point::new(up(point.x), up(point.y))
        };
        let near = plan(
            &mut Searcher::default(),
            &ground,
            nudged(start),
            nudged(goal),
            &settings,
            &mut || 0.0,
        );
        let near = near.expect("as before");
        assert_eq!(near.raw.turns(), exact.raw.turns());
        assert_eq!(near.raw.points().len(), exact.raw.points().len());
        assert!((near.pruned.length_m() - exact.pruned.length_m()).abs() < 1e-6);
    }
}
