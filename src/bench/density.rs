//! Sampling density against latency: the same decision with more and more samples, on every engine.

use super::roadway::{Roadway, roadway_field};
use super::{BenchError, DensityRow, EvaluationDigest, Latencies, LatencySummary};
use crate::local::{Detail, Engine, Prepared};

/// What to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct DensityPlan {
    /// Steps of the horizon.
    pub steps: u32,
    /// Numbers of samples, each about a square.
    pub samples: Vec<usize>,
    /// Time to measure each engine at each density, seconds.
    pub seconds: f64,
}

impl DensityPlan {
    /// Powers of four from least to most samples.
    #[must_use]
    pub fn powers_of_four(steps: u32, least: usize, most: usize, seconds: f64) -> Self {
        let samples = std::iter::successors(Some(least.max(1)), |samples| samples.checked_mul(4));
        Self {
            steps,
            samples: samples.take_while(|&samples| samples <= most).collect(),
            seconds,
        }
    }
}

/// Decisions taken before timing starts.
const WARM_UP: usize = 3;
/// Most decisions timed in one cell.
const MOST_DECISIONS: usize = 5000;
/// Fewest decisions timed in one cell.
const FEWEST_DECISIONS: usize = 20;

/// Measures every engine at every density, end to end: window and problem to integers, upload, evaluation, answer. The
/// answers are compared first; a row is handed to `done` as soon as it is measured.
///
/// # Errors
/// When an engine fails or its answer differs.
pub fn measure_density(
    engines: &mut [Box<dyn Engine>],
    plan: &DensityPlan,
    clock: &mut dyn FnMut() -> f64,
    mut done: impl FnMut(&DensityRow),
) -> Result<Vec<DensityRow>, BenchError> {
    let field = roadway_field();
    let mut rows = Vec::new();
    for &samples in &plan.samples {
        let side = (samples as f64).sqrt().round().max(1.0) as u32;
        let counts = (side, (samples as u32).div_ceil(side));
        let roadway = Roadway {
            vx_samples: counts.0,
            vtheta_samples: counts.1,
            steps: plan.steps,
            ..Roadway::default()
        };
        let which = || format!("{samples} samples");
        let mut expected: Option<(String, String)> = None;
        for engine in engines.iter_mut() {
            let decide = |engine: &mut dyn Engine, tick: usize| {
                let problem = roadway.problem(&field, tick);
                let prepared = Prepared::new(&problem).map_err(|error| BenchError::Problem {
                    which: which(),
                    error,
                })?;
                engine
                    .evaluate(&prepared, Detail::Answer)
                    .map_err(|error| BenchError::Engine {
                        which: which(),
                        error,
                    })
            };
            let digest = digest_of(|tick| decide(engine.as_mut(), tick))?;
            match &expected {
                None => expected = Some((engine.name(), digest)),
                Some((first, answer)) if *answer != digest => {
                    let (engine, first) = (engine.name(), first.clone());
                    return Err(BenchError::Differs {
                        which: which(),
                        engine,
                        first,
                    });
                }
                Some(_) => {}
            }
            let mut latencies = Latencies::default();
            let began = clock();
            for tick in 0..MOST_DECISIONS {
                let before = clock();
                decide(engine.as_mut(), tick)?;
                let after = clock();
                latencies.record(after - before)?;
                if tick + 1 >= FEWEST_DECISIONS && after - began > plan.seconds {
                    break;
                }
            }
            let actual = counts.0 as usize * counts.1 as usize;
            if let Some(summary) = latencies.summary() {
                let row = row(engine.as_ref(), actual, plan.steps, &summary);
                done(&row);
                rows.push(row);
            }
        }
    }
    Ok(rows)
}

fn digest_of<E>(
    mut decide: impl FnMut(usize) -> Result<crate::local::Evaluation, E>,
) -> Result<String, E> {
    let mut digest = EvaluationDigest::default();
    for tick in 0..WARM_UP {
        digest.add(&decide(tick)?);
    }
    Ok(digest.hex())
}

fn row(engine: &dyn Engine, samples: usize, steps: u32, summary: &LatencySummary) -> DensityRow {
    let is_gpu = engine.kind() == "gpu";
    DensityRow {
        engine: engine.kind().to_owned(),
        adapter: is_gpu.then(|| engine.name()),
        threads: engine.threads(),
        samples,
        steps: steps as usize,
        p50_ms: summary.p50_ms,
        p95_ms: summary.p95_ms,
        p99_ms: summary.p99_ms,
        max_ms: summary.max_ms,
        decisions: summary.count as usize,
        steps_per_s: samples as f64 * f64::from(steps) / (summary.p50_ms / 1000.0),
    }
}
