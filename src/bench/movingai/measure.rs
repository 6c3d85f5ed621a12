//! Runs every algorithm on every scenario: times and checks the answers.

use super::algorithms::{Algorithm, Answer};
use super::files::Queries;
use super::path_check::{AnswerCheck, check_answer};
use super::record::{AlgorithmRow, MapRows};
use super::statistics::Statistics;
use crate::bench::BenchError;
use crate::global::Searcher;
use crate::map::{FreeSpace, Scenario, cell_from_top_left};

/// A measurement over several maps.
#[derive(Debug)]
pub struct Bench {
    algorithms: Vec<Algorithm>,
    passes: usize,
    totals: Vec<Statistics>,
}

/// A checked answer without its path.
struct Checked {
    check: AnswerCheck,
    expanded: u32,
    seconds: f64,
}

impl Bench {
    /// A measurement of these algorithms. The time of a query is its smallest over a number of passes, at least one.
    #[must_use]
    pub fn new(algorithms: &[Algorithm], passes: usize) -> Self {
        Self {
            algorithms: algorithms.to_vec(),
            passes: passes.max(1),
            totals: vec![Statistics::default(); algorithms.len()],
        }
    }

    /// Measures on a map, for a point robot without distance to obstacles. A pass runs all scenarios, so the cache does not
    /// hold the cells of the same query. The answers of the first pass are checked. The clock counts seconds; `done` is called
    /// after each search.
    ///
    /// # Errors
    /// Fails when the clock runs backwards.
    pub fn measure(
        &mut self,
        queries: &Queries,
        clock: &mut dyn FnMut() -> f64,
        mut done: impl FnMut(),
    ) -> Result<MapRows, BenchError> {
        let Queries { name, obstacles, scenarios } = queries;
        let space = FreeSpace::new(obstacles, 0.0);
        let mut searcher = Searcher::default();
        let mut rows = Vec::new();
        for (algorithm, total) in self.algorithms.iter().zip(&mut self.totals) {
            let mut first_pass = |scenario: &Scenario| {
                let (answer, seconds) = search(algorithm, &mut searcher, &space, scenario, clock);
                done();
                Checked {
                    check: check_answer(obstacles, scenario, answer.cells),
                    expanded: answer.expanded,
                    seconds,
                }
            };
            let mut answers: Vec<Checked> = scenarios.iter().map(&mut first_pass).collect();
            for _ in 1..self.passes {
                for (scenario, checked) in scenarios.iter().zip(&mut answers) {
                    let (_, seconds) = search(algorithm, &mut searcher, &space, scenario, clock);
                    checked.seconds = checked.seconds.min(seconds);
                    done();
                }
            }
            let mut statistics = Statistics::default();
            for (scenario, checked) in scenarios.iter().zip(&answers) {
                statistics.add(scenario, &checked.check, checked.seconds, checked.expanded)?;
                statistics.add_fault(|| {
                    let fault = checked.check.fault(algorithm.exact, scenario.optimal)?;
                    Some(format!("{name}, scenario of line {}: {fault}", scenario.line))
                });
            }
            total.merge(&statistics);
            rows.push(statistics.row(name, algorithm));
        }
        Ok(MapRows { map: name.clone(), scenarios: scenarios.len(), algorithms: rows })
    }

    /// Each algorithm over all maps so far.
    #[must_use]
    pub fn totals(&self) -> Vec<AlgorithmRow> {
        let both = self.totals.iter().zip(&self.algorithms);
        both.map(|(statistics, algorithm)| statistics.row("all", algorithm)).collect()
    }
}

/// An answer and its time in seconds.
fn search<'a>(
    algorithm: &Algorithm,
    searcher: &'a mut Searcher,
    space: &FreeSpace,
    scenario: &Scenario,
    clock: &mut dyn FnMut() -> f64,
) -> (Answer<'a>, f64) {
    let [start, goal] =
        [scenario.start, scenario.goal].map(|end| cell_from_top_left(space.frame(), end));
    let before = clock();
    let answer = (algorithm.search)(searcher, space, start, goal);
    (answer, clock() - before)
}

#[cfg(test)]
mod tests {
    use super::super::algorithms::ALGORITHMS;
    use super::*;
    use crate::geometry::Pose;
    use crate::map::{OccupancyGrid, UnknownPolicy};

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
}
