//! Every algorithm on the generated benchmark, and faults that the benchmark must detect.

use std::path::Path;

use inbye::bench::movingai::{
    ALGORITHMS, Algorithm, AlgorithmRow, Bench, Files, Queries, Search, find, longest,
};
use inbye::global::{CellPath, Heuristic, NoPath, Searcher};
use inbye::map::{Cell, FreeSpace};

use super::{Test, sample};

pub const TESTS: [Test; 5] = [
    (
        "exact algorithms find the shortest paths, the others legal ones",
        exact_algorithms_find_the_shortest_paths,
    ),
    ("a wrong listed length is detected", wrong_lengths_are_noticed),
    ("a search that crosses occupied cells is detected", a_blind_search_is_noticed),
    ("a search that gives up is detected", a_search_that_gives_up_is_noticed),
    ("the longest scenarios are listed first", the_longest_are_listed_first),
];

/// The maps and scenarios of the sample.
fn sample() -> Vec<Queries> {
    let folder = tempfile::tempdir().expect("a place for temporary files");
    let scenarios = sample::write(folder.path());
    let maps = read(folder.path());
    assert_eq!(maps.iter().map(|map| map.scenarios.len()).sum::<usize>(), scenarios);
    maps
}

fn read(folder: &Path) -> Vec<Queries> {
    let found = find(folder).expect("maps with scenarios");
    assert!(found.skipped.is_empty(), "{:?}", found.skipped);
    assert!(found.files.is_sorted_by_key(|files| files.map.clone()));
    let maps = found.files.iter().map(Files::read);
    maps.map(|map| map.expect("files as the benchmark has them")).collect()
}

/// Returns the rows of the algorithms over all maps.
fn totals(maps: &[Queries], algorithms: &[Algorithm]) -> Vec<AlgorithmRow> {
    let mut bench = Bench::new(algorithms, 1);
    for map in maps {
        let rows = bench.measure(map, &mut || 0.0, || ()).expect("a clock that stands");
        assert_eq!((&rows.map, rows.scenarios), (&map.name, map.scenarios.len()));
    }
    bench.totals()
}

fn exact_algorithms_find_the_shortest_paths() {
    let maps = sample();
    let rows = totals(&maps, &ALGORITHMS);
    assert_eq!(rows.len(), ALGORITHMS.len());
    for row in &rows {
        assert!(row.total >= 400, "{row:?}");
        assert_eq!((row.solved, row.illegal), (row.total, 0), "{row:?}");
        assert!(row.passed() && row.first_fault.is_none(), "{row:?}");
        if row.exact {
            assert_eq!((row.suboptimal, row.worst_length_ratio), (0, Some(1.0)), "{row:?}");
        }
    }
    // The maps must be hard enough to reveal a search that is not exact.
    let greedy = rows.iter().find(|row| row.name == "A* Manhattan");
    let greedy = greedy.expect("it is listed");
    assert!(greedy.suboptimal > 40, "{greedy:?}");
    assert!(greedy.worst_length_ratio > Some(1.02), "{greedy:?}");
    assert!(greedy.mean_length_ratio < greedy.worst_length_ratio);
}

fn wrong_lengths_are_noticed() {
    let exact: Vec<Algorithm> = ALGORITHMS.into_iter().filter(Algorithm::is_exact).collect();
    for sign in [1.0, -1.0] {
        let mut maps = sample();
        for scenario in maps.iter_mut().flat_map(|map| &mut map.scenarios) {
            scenario.optimal += sign * (0.01 + 2.0 * scenario.rounding);
        }
        for row in totals(&maps, &exact) {
            assert!(!row.passed(), "{row:?}");
            let fault = row.first_fault.expect("all are wrong");
            if sign > 0.0 {
                // The path is shorter than the listed length.
                assert_eq!((row.solved, row.illegal), (0, row.total), "{}", row.name);
                assert!(fault.contains("shorter than"), "{fault}");
            } else {
                assert_eq!((row.solved, row.illegal), (row.total, 0), "{}", row.name);
                assert_eq!(row.suboptimal, row.total, "{}", row.name);
                assert!(fault.contains("longer than"), "{fault}");
            }
        }
    }
}

/// A search that goes straight to the goal and ignores obstacles.
#[expect(clippy::unnecessary_wraps, reason = "an algorithm's search may fail")]
fn blind<'a>(
    _: &'a mut Searcher,
    _: &FreeSpace,
    [start, goal]: [Cell; 2],
    _: Option<Heuristic>,
) -> Result<CellPath<'a>, NoPath> {
    let mut cells = vec![start];
    let mut at = start;
    while at != goal {
        let (dx, dy) = (goal.column - at.column, goal.row - at.row);
        at = Cell::new(at.column + dx.signum(), at.row + dy.signum());
        cells.push(at);
    }
    // A leak is acceptable in a short test.
    Ok(CellPath { cells: cells.leak(), cost: 0, expanded: 0 })
}

fn alone(search: Search) -> AlgorithmRow {
    let algorithm = Algorithm {
        name: "made up",
        usual: true,
        // It is not exact; the check of legality applies to every algorithm.
        heuristic: Some(Heuristic::Manhattan),
        search,
    };
    let mut rows = totals(&sample(), &[algorithm]);
    rows.pop().expect("one algorithm")
}

fn a_blind_search_is_noticed() {
    let row = alone(blind);
    assert!(row.illegal > 100 && !row.passed(), "{row:?}");
    assert_eq!(row.solved + row.illegal, row.total);
    // On open ground the straight path is the shortest.
    assert!(row.solved > 10 && row.suboptimal == 0, "{row:?}");
}

fn a_search_that_gives_up_is_noticed() {
    let row = alone(|_, _, _, _| Err(NoPath { expanded: 7 }));
    assert_eq!((row.solved, row.illegal, row.expanded), (0, 0, 7.0), "{row:?}");
    assert!(!row.passed());
    assert_eq!((row.mean_length_ratio, row.worst_length_ratio), (None, None));
    let fault = row.first_fault.expect("all are wrong");
    assert!(fault.contains("no path was found"), "{fault}");
}

fn the_longest_are_listed_first() {
    for map in sample() {
        let all = map.scenarios;
        let some = longest(all.clone(), 20);
        let last = some.last().expect("some").clone();
        // In descending order; of equal lengths the first lines of the file.
        let key = |scenario: &inbye::map::Scenario| (-scenario.optimal, scenario.line);
        assert!(some.is_sorted_by(|one, other| key(one) < key(other)));
        let longer = all.iter().filter(|scenario| key(scenario) <= key(&last));
        assert_eq!((some.len(), longer.count()), (20, 20), "{}", map.name);
        assert_eq!(longest(all.clone(), usize::MAX).len(), all.len());
    }
}
