//! Statistics over the answers of one algorithm.

use super::algorithms::Algorithm;
use super::path_check::AnswerCheck;
use super::record::AlgorithmRow;
use crate::bench::{BenchError, Latencies};
use crate::map::Scenario;

const MICROSECONDS_PER_MILLISECOND: f64 = 1e3;

/// Statistics of an algorithm so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Statistics {
    solved: usize,
    total: usize,
    suboptimal: usize,
    illegal: usize,
    times: Latencies,
    expanded: u64,
    ratios: usize,
    ratio_sum: f64,
    worst_ratio: Option<f64>,
    first_fault: Option<String>,
}

impl Statistics {
    /// Adds an answer with its time, seconds, and its number of expanded cells.
    pub fn add(
        &mut self,
        scenario: &Scenario,
        check: &AnswerCheck,
        seconds: f64,
        expanded: u32,
    ) -> Result<(), BenchError> {
        self.times.record(seconds)?;
        self.total += 1;
        self.expanded += u64::from(expanded);
        match check {
            AnswerCheck::Optimal => self.solve(1.0, scenario),
            AnswerCheck::Longer { length } => {
                self.suboptimal += 1;
                self.solve(length / scenario.optimal, scenario);
            }
            AnswerCheck::Shorter { .. } | AnswerCheck::Illegal(_) => self.illegal += 1,
            AnswerCheck::NotFound => {}
        }
        Ok(())
    }

    fn solve(&mut self, ratio: f64, scenario: &Scenario) {
        self.solved += 1;
        if scenario.optimal > 0.0 {
            self.ratios += 1;
            self.ratio_sum += ratio;
            self.worst_ratio = Some(self.worst_ratio.map_or(ratio, |worst| worst.max(ratio)));
        }
    }

    /// Keeps the first fault.
    pub fn add_fault(&mut self, fault: impl FnOnce() -> Option<String>) {
        if self.first_fault.is_none() {
            self.first_fault = fault();
        }
    }

    /// Adds the statistics of another map.
    pub fn merge(&mut self, other: &Self) {
        self.solved += other.solved;
        self.total += other.total;
        self.suboptimal += other.suboptimal;
        self.illegal += other.illegal;
        self.times.merge(&other.times);
        self.expanded += other.expanded;
        self.ratios += other.ratios;
        self.ratio_sum += other.ratio_sum;
        let worse = |worst: f64| other.worst_ratio.map_or(worst, |other| other.max(worst));
        self.worst_ratio = self.worst_ratio.map(worse).or(other.worst_ratio);
        self.add_fault(|| other.first_fault.clone());
    }

    /// The row of this algorithm; its figures are zeros before the first answer.
    pub fn row(&self, map: &str, algorithm: &Algorithm) -> AlgorithmRow {
        let quantile_us = |share| {
            let time_ms = self.times.quantile_ms(share).unwrap_or_default();
            time_ms * MICROSECONDS_PER_MILLISECOND
        };
        AlgorithmRow {
            map: map.to_owned(),
            name: algorithm.name.to_owned(),
            exact: algorithm.exact,
            solved: self.solved,
            total: self.total,
            suboptimal: self.suboptimal,
            illegal: self.illegal,
            median_us: quantile_us(0.5),
            p95_us: quantile_us(0.95),
            max_us: quantile_us(1.0),
            expanded: self.expanded as f64 / self.total.max(1) as f64,
            mean_length_ratio: (self.ratios > 0).then(|| self.ratio_sum / self.ratios as f64),
            worst_length_ratio: self.worst_ratio,
            first_fault: self.first_fault.clone(),
        }
    }
}
