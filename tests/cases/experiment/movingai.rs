//! The algorithms of the `MovingAI` benchmark, and the statistics of their answers.

use inbye::bench::BenchError;
use inbye::bench::movingai::{ALGORITHMS, Bench, Queries};
use inbye::geometry::Pose;
use inbye::global::Heuristic;
use inbye::map::{OccupancyGrid, Scenario, UnknownPolicy};

#[test]
fn algorithm_names_are_unique_and_fit_a_table() {
    for (index, algorithm) in ALGORITHMS.iter().enumerate() {
        assert!(!algorithm.name.contains([',', '"']), "{}", algorithm.name);
        let others = &ALGORITHMS[index + 1..];
        assert!(others.iter().all(|other| other.name != algorithm.name));
    }
    let usual =
        |exact| ALGORITHMS.iter().any(|algorithm| algorithm.usual && algorithm.is_exact() == exact);
    assert!(usual(true) && usual(false));
}

#[test]
fn default_heuristic_is_measured_by_default() {
    let default = Some(Heuristic::default());
    assert!(ALGORITHMS.iter().any(|algorithm| algorithm.usual && algorithm.heuristic == default));
}

/// Three queries along an open row, 2, 3 and 4 cells long.
fn queries() -> Queries {
    let map = OccupancyGrid::from_rows(&["......"], 1.0, Pose::default()).expect("a row");
    let scenario = |line: usize| Scenario {
        line,
        bucket: 0,
        map: "row.map".to_owned(),
        width: 6,
        height: 1,
        start: (0, 0),
        goal: (line as i32 + 1, 0),
        optimal: (line + 1) as f64,
        rounding: 0.0,
    };
    Queries {
        name: "row.map".to_owned(),
        obstacles: map.obstacles(UnknownPolicy::Blocked),
        scenarios: (1..=3).map(scenario).collect(),
    }
}

#[test]
fn query_time_is_the_smallest_over_the_passes() {
    let octile = ALGORITHMS.into_iter().find(|it| it.name == "A* octile");
    let mut bench = Bench::new(&[octile.expect("it is listed")], 2);
    // Microseconds of each search, of the first pass and then of the second.
    let mut times = [30.0, 10.0, 20.0, 5.0, 40.0, 25.0].into_iter();
    let (mut now, mut running, mut searches) = (0.0, false, 0);
    let mut clock = || {
        if running {
            now += times.next().unwrap_or(0.0) * 1e-6;
        }
        running = !running;
        now
    };
    let rows = bench.measure(&queries(), &mut clock, || searches += 1);
    let rows = rows.expect("the clock runs forwards");
    assert_eq!((rows.scenarios, searches), (3, 6));
    let row = &rows.algorithms[0];
    // 5, 10 and 20.
    for (found, expected) in [(row.median_us, 10.0), (row.max_us, 20.0)] {
        assert!((found / expected - 1.0).abs() < 1e-3, "{row:?}");
    }
    assert_eq!((row.solved, row.total, row.expanded), (3, 3, 3.0));
    assert_eq!((row.mean_length_ratio, row.worst_length_ratio), (Some(1.0), Some(1.0)));
    assert!(row.passed() && row.first_fault.is_none());
}

#[test]
fn totals_cover_all_maps() {
    let mut bench = Bench::new(&ALGORITHMS, 1);
    let mut now = 0.0;
    let mut clock = || {
        now += 1e-6;
        now
    };
    let mut wrong = queries();
    wrong.name = "other.map".to_owned();
    wrong.scenarios[1].optimal += 0.01;
    for queries in [&queries(), &wrong, &queries()] {
        bench.measure(queries, &mut clock, || ()).expect("forwards");
    }
    for row in bench.totals() {
        assert_eq!((row.solved, row.total, row.illegal), (8, 9, 1), "{row:?}");
        assert!(!row.passed());
        let fault = row.first_fault.expect("one is wrong");
        assert!(fault.starts_with("other.map, scenario of line 2: "), "{fault}");
        assert!(fault.contains("shorter than the 3.01 listed"), "{fault}");
    }
}

#[test]
fn measure_rejects_a_clock_that_runs_backwards() {
    let mut now = 0.0;
    let mut clock = || {
        now -= 1.0;
        now
    };
    let outcome = Bench::new(&ALGORITHMS, 1).measure(&queries(), &mut clock, || ());
    assert!(matches!(outcome, Err(BenchError::NotATime { .. })));
}
