//! Decisions per second over the size of a batch, on every engine: the decisions of many robots in one call.

use std::ops::ControlFlow;

use serde::{Deserialize, Serialize};

use super::columns::columns;
use super::density::{LostEngine, MIN_REPETITIONS};
use super::quality::{grid_counts, usual_shape};
use super::roadway::{Roadway, roadway_field};
use super::verify::FirstAnswers;
use super::{BenchError, DensityPlan, EvaluationDigest};
use crate::local::{Detail, Engine, Evaluation, QuantizedProblem, Sampler};

/// Numbers of decisions in a batch: 256 is the largest of one submission to a GPU.
const SIZES: [usize; 5] = [1, 8, 64, 256, 1024];
/// Samples of each decision: the usual number of one robot.
const SAMPLES: usize = 1024;

columns! {
    /// One engine with batches of one size.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    pub struct BatchRow {
        /// The engine's name for people, with its threads and instructions, or its adapter.
        pub name: String,
        /// `cpu` or `gpu`.
        pub engine: String,
        /// Decisions in a batch.
        pub batch: usize,
        /// Samples of each decision.
        pub samples: usize,
        /// Steps of the horizon.
        pub steps: usize,
        /// Median time of a batch, end to end, milliseconds.
        pub p50_ms: f64 => 3,
        /// 99th percentile, milliseconds.
        pub p99_ms: f64 => 3,
        /// Decisions per second at the median.
        pub decisions_hz: f64 => 0,
        /// Batches timed.
        pub batches: usize,
    }
}

impl BatchRow {
    /// The columns of a short table, separated by spaces.
    pub const SUMMARY: &str = "name batch samples steps p50_ms p99_ms decisions_hz batches";
}

/// Measures every engine with batches of 1 to 1,024 decisions of 1,024 arcs, from quantized problems to answers. The
/// answers are compared first. An engine is measured with no larger batches once one takes too long for the plan. A GPU of
/// `lost` is not measured; one that fails is added to it. `done` is called after each size; it can end the measurement, which
/// then returns the rows so far.
///
/// # Errors
/// Fails when a CPU engine fails or answers differ.
pub fn measure_batches(
    engines: &mut [Box<dyn Engine>],
    plan: &DensityPlan,
    lost: &mut Vec<LostEngine>,
    clock: &mut dyn FnMut() -> f64,
    mut done: impl FnMut() -> ControlFlow<()>,
) -> Result<Vec<BatchRow>, BenchError> {
    let (vx_samples, vtheta_samples) = grid_counts(SAMPLES, usual_shape(Sampler::Arcs));
    let roadway = Roadway { vx_samples, vtheta_samples, steps: plan.steps, ..Roadway::default() };
    let field = roadway_field();
    let problems: Vec<QuantizedProblem> = (0..SIZES[SIZES.len() - 1])
        .map(|tick| {
            QuantizedProblem::new(&roadway.problem(&field, tick))
                .map_err(|error| BenchError::Problem { which: roadway.name(), error })
        })
        .collect::<Result<_, _>>()?;
    let mut rows = Vec::new();
    let mut first: [FirstAnswers; SIZES.len()] = Default::default();
    for engine in engines {
        let engine = engine.as_mut();
        if lost.iter().any(|lost| lost.name == engine.name()) {
            continue;
        }
        for (&size, first) in SIZES.iter().zip(&mut first) {
            let row = match measure_size(engine, &roadway, &problems[..size], plan, first, clock) {
                Ok(row) => row,
                Err(error) => {
                    let error = LostEngine::reason(engine, error)?;
                    LostEngine::add(lost, engine, &error);
                    break;
                }
            };
            let is_slow = row.batches < MIN_REPETITIONS;
            rows.push(row);
            if done().is_break() {
                return Ok(rows);
            }
            if is_slow {
                break;
            }
        }
    }
    Ok(rows)
}

/// Measures one engine with batches of these problems.
fn measure_size(
    engine: &mut dyn Engine,
    roadway: &Roadway,
    problems: &[QuantizedProblem],
    plan: &DensityPlan,
    first: &mut FirstAnswers,
    clock: &mut dyn FnMut() -> f64,
) -> Result<BatchRow, BenchError> {
    let size = problems.len();
    let mut answers = EvaluationDigest::default();
    decide(engine, problems)?.iter().for_each(|evaluation| answers.add(evaluation));
    first.check(engine, answers, || format!("a batch of {size} of {}", roadway.name()))?;
    plan.raise_clock(engine, clock, |engine| decide(engine, problems))?;
    let (latencies, _) = plan.time(clock, |_| decide(engine, problems))?;
    let summary = latencies.summary().unwrap_or_default();
    Ok(BatchRow {
        name: engine.name(),
        engine: engine.kind().to_owned(),
        batch: size,
        samples: roadway.samples(),
        steps: roadway.steps as usize,
        p50_ms: summary.p50_ms,
        p99_ms: summary.p99_ms,
        decisions_hz: size as f64 / (summary.p50_ms / 1e3),
        batches: summary.count as usize,
    })
}

/// Takes all decisions in one call.
fn decide(
    engine: &mut dyn Engine,
    problems: &[QuantizedProblem],
) -> Result<Vec<Evaluation>, BenchError> {
    engine.evaluate_batch(problems, Detail::Answer).map_err(|error| {
        let which = format!("a batch of {}", problems.len());
        BenchError::Engine { which, error }
    })
}
