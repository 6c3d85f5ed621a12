//! Which heuristics are admissible and consistent.

use inbye::global::{DIAGONAL, Heuristic, STRAIGHT};
use inbye::map::Cell;

/// On an empty grid the octile distance is the true cost.
#[test]
fn heuristic_is_admissible_exactly_if_it_never_exceeds_the_cost_on_an_empty_grid() {
    let (start, goal) = (Cell::new(2, 31), Cell::new(28, 17));
    let octile = Heuristic::Octile.estimator(start, goal);
    let weights = [0.0, 0.01, 0.1, 1e6];
    let angles = [1e-6, 30.0, 45.0, 45.1, 60.0, 90.0];
    let heuristics = [Heuristic::Manhattan, Heuristic::Euclid, Heuristic::Octile]
        .into_iter()
        .chain(angles.map(|degrees| Heuristic::Theta { degrees }))
        .chain(weights.map(|k| Heuristic::Normalized { k }))
        .chain(weights.map(|k| Heuristic::Additive { k }))
        .chain(weights.map(|k| Heuristic::Literal { k }));
    for heuristic in heuristics {
        let estimator = heuristic.estimator(start, goal);
        let exceeds = (0..40 * 40).any(|index| {
            let cell = Cell::new(index % 40, index / 40);
            estimator.cost(cell) > octile.cost(cell)
        });
        assert_eq!(exceeds, !heuristic.is_admissible(), "{heuristic:?}");
        assert_eq!(estimator.cost(goal), 0, "{heuristic:?}");
    }
}

/// Consistency makes a single expansion per cell sufficient.
#[test]
fn admissible_heuristics_are_consistent() {
    let (start, goal) = (Cell::new(0, 0), Cell::new(3, 5));
    let angles = [0.5, 30.0, 44.9, 45.0];
    let heuristics = [Heuristic::Euclid, Heuristic::Octile]
        .into_iter()
        .chain(angles.map(|degrees| Heuristic::Theta { degrees }));
    for heuristic in heuristics {
        let estimator = heuristic.estimator(start, goal);
        let far = (32_700..32_767).map(|column| Cell::new(column, 32_000));
        let near = (0..100 * 100).map(|index| Cell::new(index % 100, index / 100));
        for cell in near.chain(far) {
            let at = |dx, dy| estimator.cost(Cell::new(cell.column + dx, cell.row + dy));
            for (dx, dy, cost) in [(1, 0, STRAIGHT), (0, 1, STRAIGHT), (1, 1, DIAGONAL)] {
                let step = at(dx, dy).abs_diff(at(0, 0));
                assert!(step <= cost, "{heuristic:?} at {cell:?}: {step}");
            }
            assert!(at(1, 0).abs_diff(at(0, 1)) <= DIAGONAL, "{heuristic:?}");
        }
    }
}
