//! The effect of each step: heuristics alone, then with pruning, then with the spline.

use serde::Serialize;

use super::measure::TaskRuns;
use super::reduction::Measure;
use super::search::{LITERAL_K, SMALL_K, Search, Stage};

/// The steps of the table, from the traditional ones to all steps together.
pub const STEPS: [(Search, Stage); 13] = [
    (Search::Manhattan, Stage::Raw),
    (Search::Euclid, Stage::Raw),
    (Search::Theta(45.0), Stage::Raw),
    (Search::Literal(SMALL_K), Stage::Raw),
    (Search::Literal(LITERAL_K), Stage::Raw),
    (Search::Literal(LITERAL_K), Stage::Pruned),
    (Search::Literal(LITERAL_K), Stage::Smoothed),
    (Search::Improved, Stage::Raw),
    (Search::Improved, Stage::Pruned),
    (Search::Improved, Stage::Smoothed),
    (Search::JumpPoints, Stage::Raw),
    (Search::JumpPoints, Stage::Pruned),
    (Search::JumpPoints, Stage::Smoothed),
];

/// Searches with all steps, and the traditional searches for comparison.
const CHAINS: [Search; 2] = [Search::Improved, Search::JumpPoints];
const BASELINES: [Search; 2] = [Search::Manhattan, Search::Euclid];

/// A step, summed over all tasks.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StepRow {
    /// The search.
    pub search: String,
    /// Label for people.
    pub label: String,
    /// `raw`, `pruned` or `smoothed`.
    pub stage: &'static str,
    /// Sum of the median times up to here, milliseconds.
    pub time_ms: f64,
    /// Sum of the lengths, metres.
    pub length_m: f64,
    /// Sum of the turns.
    pub turns: usize,
    /// Sum of the cells expanded.
    pub expanded: u64,
    /// Smallest distance of any path to an obstacle, metres.
    pub min_clearance_m: f64,
    /// Excess length of the searched paths over shortest ones, as a share of the sums.
    pub over_shortest: f64,
    /// The same of the worst path.
    pub worst_over_shortest: f64,
}

/// The rows of [`STEPS`] whose search was run.
#[must_use]
pub fn step_rows(measured: &[TaskRuns]) -> Vec<StepRow> {
    STEPS.iter().filter_map(|&(search, stage)| step_row(measured, search, stage)).collect()
}

fn step_row(measured: &[TaskRuns], search: Search, stage: Stage) -> Option<StepRow> {
    let mut sum = StepRow {
        search: search.name(),
        label: label(search, stage),
        stage: match stage {
            Stage::Raw => "raw",
            Stage::Pruned => "pruned",
            Stage::Smoothed => "smoothed",
        },
        time_ms: 0.0,
        length_m: 0.0,
        turns: 0,
        expanded: 0,
        min_clearance_m: f64::INFINITY,
        over_shortest: 0.0,
        worst_over_shortest: 0.0,
    };
    let (mut cost, mut shortest) = (0, 0);
    for task in measured {
        let run = task.of(search)?;
        let path = run.at(stage);
        sum.time_ms += path.time.p50_ms;
        sum.length_m += path.path.length_m();
        sum.turns += path.path.turns();
        sum.expanded += u64::from(run.expanded);
        sum.min_clearance_m = sum.min_clearance_m.min(path.min_clearance_m);
        sum.worst_over_shortest = sum.worst_over_shortest.max(task.over_shortest(run));
        cost += run.cost;
        shortest += task.shortest;
    }
    sum.over_shortest = cost as f64 / shortest.max(1) as f64 - 1.0;
    Some(sum)
}

fn label(search: Search, stage: Stage) -> String {
    let name = match search {
        Search::Manhattan | Search::Euclid => format!("traditional, {}", search.label()),
        Search::Theta(_) => "octile distance (eqs. 16, 17)".to_owned(),
        _ => search.label(),
    };
    match stage {
        Stage::Raw => name,
        Stage::Pruned => format!("{name} + pruning"),
        Stage::Smoothed => format!("{name} + pruning + spline"),
    }
}

/// The steps of an improved algorithm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Step {
    /// Another heuristic, or jump points.
    Search,
    /// Redundant nodes removed.
    Pruning,
    /// Smoothing.
    Spline,
}

/// Contribution of each step to a reduction, as shares of the value before; positive for a decrease.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Breakdown {
    /// The improved algorithm's search: `improved` or `jump_points`.
    pub chain: String,
    /// The traditional search that it is compared with.
    pub against: String,
    /// The compared measure.
    pub measure: Measure,
    /// Sum before: milliseconds, metres or turns.
    pub before: f64,
    /// Sum after all steps.
    pub after: f64,
    /// The reduction by all steps together.
    pub total: f64,
    /// The reduction by the search.
    pub search: f64,
    /// The reduction by the pruning.
    pub pruning: f64,
    /// The reduction by the spline.
    pub spline: f64,
}

impl Breakdown {
    /// Computes the contributions from the sums before and after each step; none if the sum before is zero.
    #[must_use]
    pub fn new(
        chain: &str,
        against: &str,
        measure: Measure,
        [before, searched, pruned, smoothed]: [f64; 4],
    ) -> Option<Self> {
        let less = |from: f64, to: f64| (from - to) / before;
        (before > 0.0).then(|| Self {
            chain: chain.to_owned(),
            against: against.to_owned(),
            measure,
            before,
            after: smoothed,
            total: less(before, smoothed),
            search: less(before, searched),
            pruning: less(searched, pruned),
            spline: less(pruned, smoothed),
        })
    }

    /// The step that reduces most.
    #[must_use]
    pub fn main_step(&self) -> Step {
        let (search, pruning, spline) = (self.search, self.pruning, self.spline);
        if search >= pruning && search >= spline {
            Step::Search
        } else if pruning >= spline {
            Step::Pruning
        } else {
            Step::Spline
        }
    }
}

/// The breakdown of each reduction.
#[must_use]
pub fn breakdowns(rows: &[StepRow]) -> Vec<Breakdown> {
    let figure = |search: Search, stage: &str, measure: Measure| -> Option<f64> {
        let name = search.name();
        let row = rows.iter().find(|row| row.search == name && row.stage == stage)?;
        Some(match measure {
            Measure::Time => row.time_ms,
            Measure::Length => row.length_m,
            Measure::Turns | Measure::TurnsSmoothed => row.turns as f64,
        })
    };
    let breakdown = |chain: Search, against: Search, measure: Measure| -> Option<Breakdown> {
        let sums = [
            figure(against, "raw", measure)?,
            figure(chain, "raw", measure)?,
            figure(chain, "pruned", measure)?,
            figure(chain, "smoothed", measure)?,
        ];
        Breakdown::new(&chain.name(), &against.name(), measure, sums)
    };
    let mut all = Vec::new();
    // Smoothing is one of the steps here, so turns are counted once.
    for measure in [Measure::Time, Measure::Length, Measure::Turns] {
        for against in BASELINES {
            all.extend(CHAINS.into_iter().filter_map(|chain| breakdown(chain, against, measure)));
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn breakdown_steps_add_up_to_the_total() {
        let sums = [10.0, 11.0, 8.0, 7.5];
        let found = Breakdown::new("improved", "euclid", Measure::Length, sums);
        let found = found.expect("there was something before");
        assert!((found.search + found.pruning + found.spline - found.total).abs() < 1e-15);
        assert_eq!((found.total, found.main_step()), (0.25, Step::Pruning));
        assert_eq!(Breakdown::new("", "", Measure::Turns, [0.0; 4]), None);
    }
}
