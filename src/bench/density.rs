//! Latency over sampling density: the same decision with more and more samples, on every engine.

use std::sync::Arc;

use super::deadlines::Misses;
use super::quality::grid_counts;
use super::roadway::{Roadway, roadway_field};
use super::{BenchError, DensityRow, EvaluationDigest, Latencies, SkippedCell};
use crate::local::{ClearanceField, Detail, Engine, Evaluation, QuantizedProblem};

/// Densities to measure, and the time for each.
#[derive(Clone, Debug, PartialEq)]
pub struct DensityPlan {
    /// Steps of the horizon.
    pub steps: u32,
    /// Numbers of samples in ascending order, each about a square.
    pub samples: Vec<usize>,
    /// Time to measure each engine at each density, seconds. A slow engine gets more time, for 20 decisions.
    pub seconds: f64,
    /// Longest time for that, seconds. A very slow engine is timed for fewer decisions, at least 3. An engine that needs
    /// longer for these is not measured at higher densities.
    pub max_seconds: f64,
}

/// Longest time of a cell relative to the usual one, and its minimum, seconds.
const MAX_TIME_FACTOR: f64 = 20.0;
const MIN_MAX_TIME_S: f64 = 1.0;

impl DensityPlan {
    /// Powers of four from least to most samples. The longest time is 20 times the usual one, and at least 1 s.
    #[must_use]
    pub fn powers_of_four(steps: u32, least: usize, most: usize, seconds: f64) -> Self {
        let samples = std::iter::successors(Some(least.max(1)), |samples| samples.checked_mul(4));
        Self {
            steps,
            samples: samples.take_while(|&samples| samples <= most).collect(),
            seconds,
            max_seconds: (MAX_TIME_FACTOR * seconds).max(MIN_MAX_TIME_S),
        }
    }
}

/// Decisions taken before timing starts.
const WARM_UP: usize = 3;
/// Largest number of decisions timed in one cell.
const MAX_DECISIONS: usize = 5000;
/// Smallest number of decisions timed in one cell.
const MIN_DECISIONS: usize = 20;
/// The same for an engine that is too slow for [`MIN_DECISIONS`].
const MIN_SLOW_DECISIONS: usize = 3;

/// The measured and the skipped cells.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Density {
    /// A row for each cell measured: by density, then in the order of the engines.
    pub rows: Vec<DensityRow>,
    /// The cells left out, in the same order.
    pub skipped: Vec<SkippedCell>,
}

/// Measures every engine at every density, end to end: quantization of window and problem, upload, evaluation, answer. The
/// answers are compared first. `done` is called after each cell, with its row or the reason why there is none.
///
/// # Errors
/// Fails when an engine fails or its answer differs.
pub fn measure_density(
    engines: &mut [Box<dyn Engine>],
    plan: &DensityPlan,
    clock: &mut dyn FnMut() -> f64,
    mut done: impl FnMut(Result<&DensityRow, &SkippedCell>),
) -> Result<Density, BenchError> {
    let field = roadway_field();
    let mut density = Density::default();
    // The last row of each engine, to predict the time of the next one.
    let mut last: Vec<Option<DensityRow>> = vec![None; engines.len()];
    for &samples in &plan.samples {
        let scene = Scene::new(&field, plan.steps, samples);
        let mut expected: Option<(String, String)> = None;
        for (engine, last) in engines.iter_mut().zip(&mut last) {
            if let Some(skipped) = last.as_ref().and_then(|last| predict_skip(last, &scene, plan)) {
                done(Err(&skipped));
                density.skipped.push(skipped);
                continue;
            }
            let digest = scene.digest(engine.as_mut())?;
            match &expected {
                None => expected = Some((engine.name(), digest)),
                Some((first, answer)) if *answer != digest => {
                    let (engine, first) = (engine.name(), first.clone());
                    return Err(BenchError::Differs { which: scene.name(), engine, first });
                }
                Some(_) => {}
            }
            let Some(row) = scene.time(engine.as_mut(), plan, clock)? else {
                continue;
            };
            done(Ok(&row));
            *last = Some(row.clone());
            density.rows.push(row);
        }
    }
    Ok(density)
}

/// The reason why an engine is not measured at a density, predicted from a lower one; none if it is measured.
fn predict_skip(last: &DensityRow, scene: &Scene, plan: &DensityPlan) -> Option<SkippedCell> {
    let samples = scene.len();
    let decision_s = last.p50_ms / 1e3 * samples as f64 / last.samples as f64;
    let fewest = WARM_UP + MIN_SLOW_DECISIONS;
    (decision_s * fewest as f64 > plan.max_seconds).then(|| SkippedCell {
        name: last.name.clone(),
        samples,
        reason: format!(
            "a decision would take about {decision_s:.1} s, as it took {:.3} s with {} samples; {fewest} of them are \
             more than the {} s that a cell may take",
            last.p50_ms / 1e3,
            last.samples,
            plan.max_seconds
        ),
    })
}

/// The decisions of one density.
struct Scene<'a> {
    field: &'a Arc<ClearanceField>,
    roadway: Roadway,
}

impl<'a> Scene<'a> {
    fn new(field: &'a Arc<ClearanceField>, steps: u32, samples: usize) -> Self {
        let (vx_samples, vtheta_samples) = grid_counts(samples, 1.0);
        let roadway = Roadway { vx_samples, vtheta_samples, steps, ..Roadway::default() };
        Self { field, roadway }
    }

    fn len(&self) -> usize {
        self.roadway.vx_samples as usize * self.roadway.vtheta_samples as usize
    }

    fn name(&self) -> String {
        format!("{} samples", self.len())
    }

    fn decide(&self, engine: &mut dyn Engine, tick: usize) -> Result<Evaluation, BenchError> {
        let problem = self.roadway.problem(self.field, tick);
        let prepared = QuantizedProblem::new(&problem)
            .map_err(|error| BenchError::Problem { which: self.name(), error })?;
        engine
            .evaluate(&prepared, Detail::Answer)
            .map_err(|error| BenchError::Engine { which: self.name(), error })
    }

    /// Warms an engine up and returns the digest of its answers.
    fn digest(&self, engine: &mut dyn Engine) -> Result<String, BenchError> {
        let mut digest = EvaluationDigest::default();
        for tick in 0..WARM_UP {
            digest.add(&self.decide(engine, tick)?);
        }
        Ok(digest.hex())
    }

    fn time(
        &self,
        engine: &mut dyn Engine,
        plan: &DensityPlan,
        clock: &mut dyn FnMut() -> f64,
    ) -> Result<Option<DensityRow>, BenchError> {
        let mut latencies = Latencies::default();
        let mut misses = Misses::default();
        let began = clock();
        for tick in 0..MAX_DECISIONS {
            let before = clock();
            self.decide(engine, tick)?;
            let after = clock();
            latencies.record(after - before)?;
            misses.record(after - before);
            let (decisions, passed_s) = (tick + 1, after - began);
            let enough = decisions >= MIN_DECISIONS && passed_s > plan.seconds;
            let too_slow = decisions >= MIN_SLOW_DECISIONS && passed_s > plan.max_seconds;
            if enough || too_slow {
                break;
            }
        }
        let Some(summary) = latencies.summary() else {
            return Ok(None);
        };
        let (samples, steps) = (self.len(), self.roadway.steps as usize);
        let is_gpu = engine.kind() == "gpu";
        let [missed_20_hz, missed_50_hz, missed_100_hz] = misses.counts();
        Ok(Some(DensityRow {
            engine: engine.kind().to_owned(),
            adapter: is_gpu.then(|| engine.name()),
            threads: engine.threads(),
            samples,
            steps,
            p50_ms: summary.p50_ms,
            p95_ms: summary.p95_ms,
            p99_ms: summary.p99_ms,
            max_ms: summary.max_ms,
            decisions: summary.count as usize,
            steps_per_s: (samples * steps) as f64 / (summary.p50_ms / 1000.0),
            name: engine.name(),
            missed_20_hz,
            missed_50_hz,
            missed_100_hz,
        }))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU64, Ordering};

    use super::*;
    use crate::local::{CpuEngine, EngineError};

    /// An engine that answers like the CPU and advances a clock by a number of nanoseconds for each sample.
    struct Slow {
        engine: CpuEngine,
        nanoseconds_per_sample: u64,
        clock: Arc<AtomicU64>,
    }

    impl Engine for Slow {
        fn name(&self) -> String {
            format!("{} ns", self.nanoseconds_per_sample)
        }

        fn kind(&self) -> &'static str {
            "gpu"
        }

        fn threads(&self) -> usize {
            0
        }

        fn evaluate(
            &mut self,
            problem: &QuantizedProblem,
            detail: Detail,
        ) -> Result<Evaluation, EngineError> {
            let nanoseconds = self.nanoseconds_per_sample * problem.len() as u64;
            self.clock.fetch_add(nanoseconds, Ordering::Relaxed);
            self.engine.evaluate(problem, detail)
        }
    }

    /// 4, 16 and 64 samples on such engines, half a second to each cell and 10 s at most.
    fn measure(nanoseconds_per_sample: &[u64]) -> (Density, Vec<String>) {
        let clock = Arc::new(AtomicU64::new(0));
        let engine = |&nanoseconds_per_sample| -> Box<dyn Engine> {
            Box::new(Slow {
                engine: CpuEngine::single_threaded(),
                nanoseconds_per_sample,
                clock: Arc::clone(&clock),
            })
        };
        let mut engines: Vec<_> = nanoseconds_per_sample.iter().map(engine).collect();
        let plan = DensityPlan::powers_of_four(2, 4, 64, 0.5);
        let mut now = || clock.load(Ordering::Relaxed) as f64 / 1e9;
        let mut reported = Vec::new();
        let density = measure_density(&mut engines, &plan, &mut now, |cell| {
            reported.push(match cell {
                Ok(row) => format!("{} at {}", row.name, row.samples),
                Err(skipped) => format!("no {} at {}", skipped.name, skipped.samples),
            });
        });
        (density.expect("the engines answer"), reported)
    }

    #[test]
    fn density_plan_counts_by_powers_of_four() {
        let plan = DensityPlan::powers_of_four(40, 256, 1_048_576, 0.5);
        assert_eq!(plan.samples, [256, 1024, 4096, 16_384, 65_536, 262_144, 1_048_576]);
        assert_eq!(plan.max_seconds, 10.0);
        assert_eq!(DensityPlan::powers_of_four(40, 3, 11, 0.01).max_seconds, 1.0);
    }

    #[test]
    fn density_rows_report_the_clock() {
        // 4, 16 and 64 ms for a decision.
        let (density, reported) = measure(&[1_000_000]);
        assert_eq!(reported, ["1000000 ns at 4", "1000000 ns at 16", "1000000 ns at 64"]);
        let found: Vec<_> = density
            .rows
            .iter()
            .map(|row| {
                let misses = [row.missed_20_hz, row.missed_50_hz, row.missed_100_hz];
                (row.decisions, misses)
            })
            .collect();
        // Decisions for half a second and one more; for the slowest engine at least 20.
        assert_eq!(found, [(126, [0, 0, 0]), (32, [0, 0, 32]), (20, [20, 20, 20])]);
        for row in &density.rows {
            let expected_ms = row.samples as f64;
            for ms in [row.p50_ms, row.p95_ms, row.p99_ms, row.max_ms] {
                assert!((ms / expected_ms - 1.0).abs() < 2e-3, "{row:?}");
            }
            assert!((row.steps_per_s / 2000.0 - 1.0).abs() < 2e-3, "{row:?}");
        }
    }

    #[test]
    fn very_slow_engines_are_timed_less_and_then_skipped() {
        // 0.4, 1.6 and 6.4 s for a decision: 20 of them are 8 s and 32 s, 6 of the last 38 s.
        let (density, reported) = measure(&[100, 100_000_000]);
        let slow: Vec<_> = density
            .rows
            .iter()
            .filter(|row| row.name == "100000000 ns")
            .map(|row| (row.samples, row.decisions))
            .collect();
        assert_eq!(slow, [(4, 20), (16, 7)]);
        let [skipped] = &density.skipped[..] else {
            panic!("{:?}", density.skipped);
        };
        assert_eq!((skipped.name.as_str(), skipped.samples), ("100000000 ns", 64));
        assert!(
            skipped.reason.contains("about 6.4 s") && skipped.reason.contains("10 s"),
            "{}",
            skipped.reason
        );
        assert_eq!(reported.len(), 6);
        assert_eq!(reported[5], "no 100000000 ns at 64");
        // The other engine is still measured at every density.
        assert_eq!(density.rows.len(), 5);
    }
}
