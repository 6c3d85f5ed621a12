//! Clearance costs in the search and in the whole plan.

use inbye::geometry::{Point, Pose};
use inbye::global::{
    ClearanceCosts, Heuristic, Path, PathClearance, PlanningSpace, Searcher, Settings, plan,
};
use inbye::map::{Cell, FreeSpace, ObstacleGrid, OccupancyGrid, UnknownPolicy};
use pathfinding::prelude::dijkstra;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use super::{WORKINGS, cost_of, moves};
use crate::support::random_grid;

/// The documented cost formula, with a brute-force distance.
fn expected_cost(obstacles: &ObstacleGrid, cell: Cell, preferred_m: f64, weight: f64) -> u64 {
    let frame = obstacles.frame();
    let distance_m = frame
        .cells()
        .filter(|&other| obstacles.is_blocked(other))
        .map(|other| (frame.center_of(other) - frame.center_of(cell)).norm())
        .fold(f64::INFINITY, f64::min);
    let clearance_m = (distance_m - frame.resolution_m / 2.0).max(0.0);
    // Prevents a rounding error from changing the sixteenth.
    (16.0 * weight * (1.0 - clearance_m / preferred_m) + 1e-9).max(0.0) as u64
}

#[test]
fn search_with_costs_finds_the_cheapest_path() {
    let mut random = Pcg64Mcg::seed_from_u64(15);
    let mut searcher = Searcher::default();
    let (mut compared, mut dearer) = (0, 0);
    for case in 0..200 {
        let obstacles = random_grid::obstacles(&mut random, 24);
        let frame = obstacles.frame();
        let space = FreeSpace::new(&obstacles, 0.0);
        let start = random_grid::cell(&mut random, frame);
        let goal = random_grid::cell(&mut random, frame);
        // An odd value, so that only a clearance of zero gives a whole number of sixteenths.
        let (preferred_m, weight) = (3.2179 * frame.resolution_m, [0.731, 3.07, 15.0][case % 3]);
        let costs = ClearanceCosts::new(&obstacles, preferred_m, weight);
        let priced = |from: Cell| {
            let price = |(to, cost)| {
                (to, cost + cost * expected_cost(&obstacles, to, preferred_m, weight) / 16)
            };
            moves(&space, from).into_iter().map(price).collect::<Vec<_>>()
        };
        let expected = dijkstra(&start, |&cell| priced(cell), |&cell| cell == goal);
        for heuristic in [Heuristic::Octile, Heuristic::Euclid, Heuristic::default()] {
            let found = searcher.astar(&space, start, goal, heuristic, Some(&costs)).ok();
            let Some(((_, least), found)) = expected.as_ref().zip(found) else {
                continue;
            };
            let own = found.cells.windows(2).map(|pair| {
                let priced = priced(pair[0]);
                priced.iter().find(|(to, _)| *to == pair[1]).expect("a move").1
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
fn clearance_weight_moves_a_path_away_from_walls() {
    let map = OccupancyGrid::from_rows(&WORKINGS, 0.5, Pose::new(-10.0, 20.0, 0.0));
    let obstacles = map.expect("rows of text").obstacles(UnknownPolicy::Blocked);
    let space = FreeSpace::new(&obstacles, 0.0);
    let (start, goal) = (Point::new(-8.7, 21.3), Point::new(8.7, 25.7));
    let planned = |clearance_weight| {
        let settings = Settings::default().clearance_weight(clearance_weight);
        let costs = settings.costs(&obstacles);
        assert_eq!(costs.is_some(), clearance_weight > 0.0);
        let ground = PlanningSpace { search: &space, smoothing: &space, costs: costs.as_ref() };
        plan(&mut Searcher::default(), &ground, start, goal, &settings, &mut || 0.0)
            .expect("the drifts are joined")
            .smoothed
    };
    // The mean distance to the nearest obstacle.
    let clearance = PathClearance::new(&obstacles);
    let mean_m = |path: &Path| {
        let clearances = path.samples(0.1).map(|at| clearance.min_m(&Path::new(vec![at])));
        clearances.sum::<f64>() / path.samples(0.1).count() as f64
    };
    let [shortest, careful] = [0.0, 4.0].map(planned);
    assert!(careful.length_m() > shortest.length_m());
    assert!(careful.length_m() < shortest.length_m() * 1.2);
    let means_m = [&shortest, &careful].map(mean_m);
    assert!(means_m[1] > means_m[0] + 0.05, "{means_m:?}");
}
