//! Decisions per second over the size of a batch, on every engine: the decisions of many robots in one call.

use serde::{Deserialize, Serialize};

use super::columns::columns;
use super::density::MIN_REPETITIONS;
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
/// answers are compared first. An engine is measured with no larger batches once one takes too long for the plan.
///
/// # Errors
/// Fails when an engine fails or its answers differ.
pub fn measure_batches(
    engines: &mut [Box<dyn Engine>],
    plan: &DensityPlan,
    clock: &mut dyn FnMut() -> f64,
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
        for (&size, first) in SIZES.iter().zip(&mut first) {
            let problems = &problems[..size];
            let mut answers = EvaluationDigest::default();
            decide(engine, problems)?.iter().for_each(|evaluation| answers.add(evaluation));
            first.check(engine, answers, || format!("a batch of {size} of {}", roadway.name()))?;
            plan.raise_clock(engine, clock, |engine| decide(engine, problems))?;
            let (latencies, _) = plan.time(clock, |_| decide(engine, problems))?;
            let summary = latencies.summary().unwrap_or_default();
            let batches = summary.count as usize;
            rows.push(BatchRow {
                name: engine.name(),
                engine: engine.kind().to_owned(),
                batch: size,
                samples: roadway.samples(),
                steps: roadway.steps as usize,
                p50_ms: summary.p50_ms,
                p99_ms: summary.p99_ms,
                decisions_hz: size as f64 / (summary.p50_ms / 1e3),
                batches,
            });
            if batches < MIN_REPETITIONS {
                break;
            }
        }
    }
    Ok(rows)
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
