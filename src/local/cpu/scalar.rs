//! The scalar reference: one sample after the other, with the twins of the shaders.

use super::row::STATUS_SHIFT;
use super::sample_stats::SampleStats;
use super::soa_inputs::SoaInputs;
use crate::local::kernel_inputs::{TurnProfile, VxSample};
use crate::local::{QuantizedProblem, SampleRecord, SampleStatus, Terms, rollout, score, select};

/// Evaluates one sample. `table` is that of its row, see [`rollout::tabulate`].
pub fn evaluate_sample(
    problem: &QuantizedProblem,
    vx: &VxSample,
    profile: &TurnProfile,
    table: &[i32],
) -> SampleRecord {
    let header = &problem.header;
    let (status, clearance) = rollout::evaluate_sample(problem, vx, profile, table);
    if status != SampleStatus::Ok {
        return SampleRecord { status, terms: Terms::default() };
    }
    let end = rollout::end_position(header, vx, table);
    let end_heading = rollout::end_heading(header, profile);
    SampleRecord { status, terms: score::terms(header, vx, end_heading, end, clearance) }
}

/// Evaluates every sample of a row. `table` is working memory; `samples` is as in [`super::row::evaluate_row`].
pub fn evaluate_row(
    problem: &QuantizedProblem,
    inputs: &SoaInputs,
    row: usize,
    table: &mut Vec<i32>,
    samples: &mut [i32],
) -> SampleStats {
    table.resize(rollout::table_words(&problem.header), 0);
    rollout::tabulate(problem, row, table);
    let profile = &problem.profiles[row];
    let mut stats = SampleStats::default();
    for (index, vx) in problem.vx_samples.iter().enumerate() {
        let SampleRecord { status, terms } = evaluate_sample(problem, vx, profile, table);
        select::count(&mut stats.counts, status);
        let mut words = [(status as i32) << STATUS_SHIFT, 0, 0];
        if status == SampleStatus::Ok {
            select::accumulate(&mut stats.totals, terms.to_array());
            words = [terms.heading as i32, terms.clearance as i32, terms.path as i32];
        }
        for (column, word) in words.into_iter().enumerate() {
            samples[column * inputs.stride + index] = word;
        }
    }
    stats
}
