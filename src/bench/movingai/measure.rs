//! Runs every algorithm on every scenario: times and checks the answers.

use serde::{Deserialize, Serialize};

use super::algorithms::Algorithm;
use super::files::Queries;
use super::path_check::{AnswerCheck, check_answer};
use crate::bench::columns::columns;
use crate::bench::{BenchError, Latencies};
use crate::global::Searcher;
use crate::map::{FreeSpace, Scenario, cell_from_top_left};

const MICROSECONDS_PER_MILLISECOND: f64 = 1e3;

columns! {
    /// One algorithm on the scenarios of a map, or of all maps together.
    #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
    pub struct AlgorithmRow {
        /// Name of the map; `all` for all maps together.
        pub map: String,
        /// Its name.
        pub name: String,
        /// Whether each of its paths must be the shortest.
        pub exact: bool,
        /// Scenarios answered by a valid path that is not shorter than listed.
        pub solved: usize,
        /// Scenarios.
        pub total: usize,
        /// Scenarios solved by a path longer than listed.
        pub suboptimal: usize,
        /// Scenarios answered by an invalid path or by one that is shorter than listed.
        pub illegal: usize,
        /// Median time of a query, microseconds.
        pub median_us: f64 => 1,
        /// 95th percentile, microseconds.
        pub p95_us: f64 => 1,
        /// Slowest, microseconds.
        pub max_us: f64 => 1,
        /// Cells expanded in a query, the mean.
        pub expanded: f64 => 0,
        /// Length of a path over the one listed, the mean over the scenarios solved; those of length zero are left out. Null
        /// where none is left.
        pub mean_length_ratio: Option<f64> => 5,
        /// The same, the greatest.
        pub worst_length_ratio: Option<f64> => 5,
        /// The first wrong answer: map, line of the scenario, fault.
        pub first_fault: Option<String>,
    }
}

impl AlgorithmRow {
    /// Whether every answer was correct: solved, and for an exact algorithm also shortest.
    #[must_use]
    pub fn passed(&self) -> bool {
        self.solved == self.total && self.illegal == 0 && !(self.exact && self.suboptimal > 0)
    }
}

/// All algorithms on the scenarios of a map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct MapRows {
    /// Name of the map.
    pub map: String,
    /// Scenarios.
    pub scenarios: usize,
    /// A row for each algorithm.
    pub algorithms: Vec<AlgorithmRow>,
}

/// A measurement over several maps.
#[derive(Debug)]
pub struct Bench {
    passes: usize,
    totals: Vec<(Algorithm, Statistics)>,
}

impl Bench {
    /// A measurement of these algorithms. The time of a query is its smallest over a number of passes, at least one.
    #[must_use]
    pub fn new(algorithms: &[Algorithm], passes: usize) -> Self {
        let total = |algorithm: &Algorithm| (*algorithm, Statistics::new("all", algorithm));
        Self { passes: passes.max(1), totals: algorithms.iter().map(total).collect() }
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
        for (algorithm, total) in &mut self.totals {
            let mut answers: Vec<Checked> = Vec::with_capacity(scenarios.len());
            for _ in 0..self.passes {
                for (index, scenario) in scenarios.iter().enumerate() {
                    let ends = [scenario.start, scenario.goal]
                        .map(|end| cell_from_top_left(space.frame(), end));
                    let before = clock();
                    let answer =
                        (algorithm.search)(&mut searcher, &space, ends, algorithm.heuristic);
                    let seconds = clock() - before;
                    done();
                    if let Some(checked) = answers.get_mut(index) {
                        checked.seconds = checked.seconds.min(seconds);
                        continue;
                    }
                    let (cells, expanded) = match answer {
                        Ok(path) => (Some(path.cells), path.expanded),
                        Err(no_path) => (None, no_path.expanded),
                    };
                    let check = check_answer(obstacles, scenario, cells);
                    answers.push(Checked { check, expanded, seconds });
                }
            }
            let mut statistics = Statistics::new(name, algorithm);
            for (scenario, checked) in scenarios.iter().zip(&answers) {
                statistics.add(scenario, checked)?;
            }
            total.merge(&statistics);
            rows.push(statistics.row());
        }
        Ok(MapRows { map: name.clone(), scenarios: scenarios.len(), algorithms: rows })
    }

    /// Each algorithm over all maps so far.
    #[must_use]
    pub fn totals(&self) -> Vec<AlgorithmRow> {
        self.totals.iter().map(|(_, statistics)| statistics.row()).collect()
    }
}

/// A checked answer without its path.
struct Checked {
    check: AnswerCheck,
    expanded: u32,
    seconds: f64,
}

/// Statistics over the answers of one algorithm.
#[derive(Debug)]
struct Statistics {
    /// The counts so far; times and means are zeros.
    counts: AlgorithmRow,
    times: Latencies,
    expanded: u64,
    ratios: usize,
    ratio_sum: f64,
}

impl Statistics {
    fn new(map: &str, algorithm: &Algorithm) -> Self {
        let counts = AlgorithmRow {
            map: map.to_owned(),
            name: algorithm.name.to_owned(),
            exact: algorithm.is_exact(),
            ..AlgorithmRow::default()
        };
        Self { counts, times: Latencies::default(), expanded: 0, ratios: 0, ratio_sum: 0.0 }
    }

    fn add(&mut self, scenario: &Scenario, checked: &Checked) -> Result<(), BenchError> {
        self.times.record(checked.seconds)?;
        self.expanded += u64::from(checked.expanded);
        let counts = &mut self.counts;
        counts.total += 1;
        let ratio = match checked.check {
            AnswerCheck::Optimal => Some(1.0),
            AnswerCheck::Longer { length } => {
                counts.suboptimal += 1;
                Some(length / scenario.optimal)
            }
            AnswerCheck::Shorter { .. } | AnswerCheck::Illegal(_) => {
                counts.illegal += 1;
                None
            }
            AnswerCheck::NotFound => None,
        };
        counts.solved += usize::from(ratio.is_some());
        if let Some(ratio) = ratio.filter(|_| scenario.optimal > 0.0) {
            self.ratios += 1;
            self.ratio_sum += ratio;
            counts.worst_length_ratio = greater(counts.worst_length_ratio, Some(ratio));
        }
        if counts.first_fault.is_none() {
            let fault = checked.check.fault(counts.exact, scenario.optimal);
            let place =
                |fault| format!("{}, scenario of line {}: {fault}", counts.map, scenario.line);
            counts.first_fault = fault.map(place);
        }
        Ok(())
    }

    /// Adds the statistics of another map.
    fn merge(&mut self, other: &Self) {
        let (counts, others) = (&mut self.counts, &other.counts);
        counts.solved += others.solved;
        counts.total += others.total;
        counts.suboptimal += others.suboptimal;
        counts.illegal += others.illegal;
        counts.worst_length_ratio = greater(counts.worst_length_ratio, others.worst_length_ratio);
        if counts.first_fault.is_none() {
            counts.first_fault.clone_from(&others.first_fault);
        }
        self.times.merge(&other.times);
        self.expanded += other.expanded;
        self.ratios += other.ratios;
        self.ratio_sum += other.ratio_sum;
    }

    /// The row of this algorithm; its figures are zeros before the first answer.
    fn row(&self) -> AlgorithmRow {
        let quantile_us = |share| {
            let time_ms = self.times.quantile_ms(share).unwrap_or_default();
            time_ms * MICROSECONDS_PER_MILLISECOND
        };
        AlgorithmRow {
            median_us: quantile_us(0.5),
            p95_us: quantile_us(0.95),
            max_us: quantile_us(1.0),
            expanded: self.expanded as f64 / self.counts.total.max(1) as f64,
            mean_length_ratio: (self.ratios > 0).then(|| self.ratio_sum / self.ratios as f64),
            ..self.counts.clone()
        }
    }
}

fn greater(one: Option<f64>, other: Option<f64>) -> Option<f64> {
    one.into_iter().chain(other).reduce(f64::max)
}
