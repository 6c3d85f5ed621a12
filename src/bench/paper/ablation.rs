//! The effect of each step: heuristics alone, then with pruning, then with the spline.

use serde::Serialize;

use super::measure::TaskRuns;
use super::reduction::Measure;
use super::search::{Search, Stage};
use crate::global::Heuristic;

/// The searches of the table, from the traditional ones on. Each has a row for each of its stages.
const STEPS: [Search; 7] = [
    Search::MANHATTAN,
    Search::EUCLID,
    Search::THETA_45,
    Search::LITERAL_SMALL,
    Search::LITERAL,
    Search::IMPROVED,
    Search::JUMP_POINTS,
];

/// Searches with all steps, and the traditional searches for comparison.
const CHAINS: [Search; 2] = [Search::IMPROVED, Search::JUMP_POINTS];
const BASELINES: [Search; 2] = [Search::MANHATTAN, Search::EUCLID];

/// A step, summed over all tasks.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StepRow {
    /// The search.
    pub search: &'static str,
    /// Label for people.
    pub label: String,
    /// `raw`, `pruned` or `smoothed`.
    pub stage: Stage,
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

/// The rows of the steps whose search was run.
#[must_use]
pub fn step_rows(measured: &[TaskRuns]) -> Vec<StepRow> {
    let steps = STEPS.into_iter().flat_map(|search| {
        let stages = Stage::ALL.into_iter().filter(move |stage| *stage <= search.last_stage);
        stages.map(move |stage| (search, stage))
    });
    steps.filter_map(|(search, stage)| step_row(measured, search, stage)).collect()
}

fn step_row(measured: &[TaskRuns], search: Search, stage: Stage) -> Option<StepRow> {
    let mut sum = StepRow {
        search: search.name,
        label: label(search, stage),
        stage,
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
    let name = match search.heuristic {
        Some(Heuristic::Manhattan | Heuristic::Euclid) => search.variant.1,
        Some(Heuristic::Theta { .. }) => "octile distance (eqs. 16, 17)",
        _ => search.label,
    };
    match stage {
        Stage::Raw => name.to_owned(),
        Stage::Pruned => format!("{name} + pruning"),
        Stage::Smoothed => format!("{name} + pruning + spline"),
    }
}

/// Contribution of each step to a reduction, as shares of the value before; positive for a decrease.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Breakdown {
    /// The improved algorithm's search: `improved` or `jump_points`.
    pub chain: &'static str,
    /// The traditional search that it is compared with.
    pub against: &'static str,
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
        chain: &'static str,
        against: &'static str,
        measure: Measure,
        [before, searched, pruned, smoothed]: [f64; 4],
    ) -> Option<Self> {
        let less = |from: f64, to: f64| (from - to) / before;
        (before > 0.0).then(|| Self {
            chain,
            against,
            measure,
            before,
            after: smoothed,
            total: less(before, smoothed),
            search: less(before, searched),
            pruning: less(searched, pruned),
            spline: less(pruned, smoothed),
        })
    }

    /// The stage whose step reduces most: [`Stage::Raw`] for the search.
    #[must_use]
    pub fn main_step(&self) -> Stage {
        let (search, pruning, spline) = (self.search, self.pruning, self.spline);
        if search >= pruning && search >= spline {
            Stage::Raw
        } else if pruning >= spline {
            Stage::Pruned
        } else {
            Stage::Smoothed
        }
    }
}

/// The breakdown of each reduction.
#[must_use]
pub fn breakdowns(rows: &[StepRow]) -> Vec<Breakdown> {
    let figure = |search: Search, stage: Stage, measure: Measure| -> Option<f64> {
        let row = rows.iter().find(|row| row.search == search.name && row.stage == stage)?;
        Some(match measure {
            Measure::Time => row.time_ms,
            Measure::Length => row.length_m,
            Measure::Turns | Measure::TurnsSmoothed => row.turns as f64,
        })
    };
    let breakdown = |chain: Search, against: Search, measure: Measure| -> Option<Breakdown> {
        let [raw, pruned, smoothed] = Stage::ALL.map(|stage| figure(chain, stage, measure));
        let sums = [figure(against, Stage::Raw, measure)?, raw?, pruned?, smoothed?];
        Breakdown::new(chain.name, against.name, measure, sums)
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
