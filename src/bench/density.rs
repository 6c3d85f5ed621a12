//! Latency over sampling density: the same decision with more and more samples, on every engine.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::ControlFlow;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::columns::columns;
use super::quality::{arcs, grid_counts, usual_shape};
use super::roadway::{Roadway, roadway_field};
use super::timing::{Latencies, Misses};
use super::verify::FirstAnswers;
use super::{BenchError, EvaluationDigest};
use crate::local::{ClearanceField, Engine, EngineError, GpuFailureKind, Sampler};

columns! {
    /// One cell of `bench density`: one engine at one sampling density. Fields from `name` on are missing in older records.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    pub struct DensityRow {
        /// `cpu` or `gpu`.
        pub engine: String,
        /// The adapter's name, for a GPU engine.
        pub adapter: Option<String>,
        /// Threads of a CPU engine; zero for a GPU engine.
        pub threads: usize,
        /// Motion of the samples: [`Sampler::name`].
        #[serde(default = "arcs")]
        pub sampler: String,
        /// Samples of the dynamic window.
        pub samples: usize,
        /// Steps of the horizon.
        pub steps: usize,
        /// Median time of one decision, end to end, milliseconds.
        pub p50_ms: f64 => 3,
        /// 95th percentile, milliseconds.
        pub p95_ms: f64 => 3,
        /// 99th percentile, milliseconds.
        pub p99_ms: f64 => 3,
        /// Slowest, milliseconds.
        pub max_ms: f64 => 3,
        /// Decisions timed.
        pub decisions: usize,
        /// Trajectory-steps per second at the median.
        pub steps_per_s: f64 => 0,
        /// The engine's name for people, with its threads and instructions, or its adapter.
        #[serde(default)]
        pub name: String,
        /// Decisions that took longer than 50 ms, the period of a loop at 20 Hz.
        #[serde(default)]
        pub missed_20_hz: usize,
        /// Decisions that took longer than 20 ms, the period of a loop at 50 Hz.
        #[serde(default)]
        pub missed_50_hz: usize,
        /// Decisions that took longer than 10 ms, the period of a loop at 100 Hz.
        #[serde(default)]
        pub missed_100_hz: usize,
    }
}

impl DensityRow {
    /// The columns of a short table, separated by spaces.
    pub const SUMMARY: &str = "name sampler samples steps p50_ms p95_ms p99_ms max_ms missed_20_hz missed_50_hz missed_100_hz \
        decisions";

    fn new(
        engine: &dyn Engine,
        roadway: &Roadway,
        (latencies, misses): &(Latencies, Misses),
    ) -> Self {
        let summary = latencies.summary().unwrap_or_default();
        let (samples, steps) = (roadway.samples(), roadway.steps as usize);
        let [missed_20_hz, missed_50_hz, missed_100_hz] = misses.counts();
        Self {
            engine: engine.kind().to_owned(),
            adapter: (engine.kind() == "gpu").then(|| engine.name()),
            threads: engine.threads(),
            sampler: roadway.sampler.name().to_owned(),
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
        }
    }
}

/// A cell that was not measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SkippedCell {
    /// The engine's name.
    pub name: String,
    /// Motion of the samples.
    #[serde(default = "arcs")]
    pub sampler: String,
    /// Samples of the dynamic window.
    pub samples: usize,
    /// Why.
    pub reason: String,
}

impl SkippedCell {
    fn new(engine: &dyn Engine, roadway: &Roadway, reason: String) -> Self {
        let (sampler, samples) = (roadway.sampler.name().to_owned(), roadway.samples());
        Self { name: engine.name(), sampler, samples, reason }
    }
}

/// Densities to measure, and the time for each.
#[derive(Clone, Debug, PartialEq)]
pub struct DensityPlan {
    /// Steps of the horizon.
    pub steps: u32,
    /// Samplers to measure.
    pub samplers: Vec<Sampler>,
    /// Numbers of samples in ascending order, in the sampler's usual shape.
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
            samplers: vec![Sampler::Arcs],
            samples: samples.take_while(|&samples| samples <= most).collect(),
            seconds,
            max_seconds: (MAX_TIME_FACTOR * seconds).max(MIN_MAX_TIME_S),
        }
    }

    /// Lets a GPU work for the measuring time without timing it: one that was idle needs up to half a second until its clock is high.
    pub(super) fn raise_clock<T>(
        &self,
        engine: &mut dyn Engine,
        clock: &mut dyn FnMut() -> f64,
        mut work: impl FnMut(&mut dyn Engine) -> Result<T, BenchError>,
    ) -> Result<(), BenchError> {
        if engine.kind() != "gpu" {
            return Ok(());
        }
        let began = clock();
        for _ in 0..MAX_REPETITIONS {
            if clock() - began >= self.seconds {
                break;
            }
            work(engine)?;
        }
        Ok(())
    }

    /// Times repetitions of some work, which gets their number.
    pub(super) fn time<T>(
        &self,
        clock: &mut dyn FnMut() -> f64,
        mut work: impl FnMut(usize) -> Result<T, BenchError>,
    ) -> Result<(Latencies, Misses), BenchError> {
        let (mut latencies, mut misses) = (Latencies::default(), Misses::default());
        let began = clock();
        for repetition in 0..MAX_REPETITIONS {
            let before = clock();
            work(repetition)?;
            let after = clock();
            latencies.record(after - before)?;
            misses.record(after - before);
            let (timed, passed_s) = (repetition + 1, after - began);
            let is_enough = timed >= MIN_REPETITIONS && passed_s > self.seconds;
            let is_too_slow = timed >= MIN_SLOW_REPETITIONS && passed_s > self.max_seconds;
            if is_enough || is_too_slow {
                break;
            }
        }
        Ok((latencies, misses))
    }
}

/// Decisions taken before timing starts.
const WARM_UP: usize = 3;
/// Most and least repetitions that are timed, and the least of an engine that is too slow for these.
const MAX_REPETITIONS: usize = 5000;
pub(super) const MIN_REPETITIONS: usize = 20;
const MIN_SLOW_REPETITIONS: usize = 3;

/// The measured and the skipped cells.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Density {
    /// A row for each cell measured: by density, then in the order of the engines.
    pub rows: Vec<DensityRow>,
    /// The cells left out, in the same order.
    pub skipped: Vec<SkippedCell>,
    /// The GPUs that failed.
    pub lost: Vec<LostEngine>,
}

/// A GPU that failed while it was measured. It is not measured any more; the other engines are.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LostEngine {
    /// The engine's name.
    pub name: String,
    /// Why.
    pub reason: String,
}

impl LostEngine {
    /// Why an engine cannot be measured, if this error is the failure of a GPU. Any other error is one of the measurement.
    pub(super) fn reason(
        engine: &dyn Engine,
        error: BenchError,
    ) -> Result<EngineError, BenchError> {
        match error {
            BenchError::Engine { error, .. } if engine.kind() == "gpu" => Ok(error),
            error => Err(error),
        }
    }

    /// Adds an engine that failed, unless the problem was too large for it: then it works on.
    pub(super) fn add(lost: &mut Vec<Self>, engine: &dyn Engine, error: &EngineError) {
        if error.failure_kind() != GpuFailureKind::TooLarge {
            lost.push(Self { name: engine.name(), reason: error.to_string() });
        }
    }
}

/// Measures every engine at every density, end to end: quantization of window and problem, upload, evaluation, answer. The
/// answers are compared first. `done` is called after each cell, with its row or the reason why there is none; it can end the
/// measurement, which then returns the cells so far. A GPU that fails is listed, and its further cells are skipped.
///
/// # Errors
/// Fails when a CPU engine fails or an answer differs.
pub fn measure_density(
    engines: &mut [Box<dyn Engine>],
    plan: &DensityPlan,
    clock: &mut dyn FnMut() -> f64,
    mut done: impl FnMut(Result<&DensityRow, &SkippedCell>) -> ControlFlow<()>,
) -> Result<Density, BenchError> {
    let field = roadway_field();
    let mut density = Density::default();
    let cells =
        plan.samplers.iter().flat_map(|&one| plan.samples.iter().map(move |&all| (one, all)));
    // The last row of each engine, to predict the time of the next one.
    let mut last: Vec<Option<DensityRow>> = vec![None; engines.len()];
    for (sampler, samples) in cells {
        let (vx_samples, vtheta_samples) = grid_counts(samples, usual_shape(sampler));
        let steps = plan.steps;
        let roadway = Roadway { vx_samples, vtheta_samples, steps, sampler, ..Roadway::default() };
        last.iter_mut().for_each(|last| {
            last.take_if(|last| last.sampler != sampler.name());
        });
        let mut first = FirstAnswers::default();
        for (engine, last) in engines.iter_mut().zip(&mut last) {
            let engine = engine.as_mut();
            let skip = |reason| SkippedCell::new(engine, &roadway, reason);
            let is_lost = |lost: &&LostEngine| lost.name == engine.name();
            let skipped = match (density.lost.iter().find(is_lost), &last) {
                (Some(lost), _) => Some(skip(format!("it failed before: {}", lost.reason))),
                (None, Some(last)) => predicted_skip(last, &roadway, plan).map(skip),
                (None, None) => None,
            };
            let measured = match skipped {
                Some(skipped) => Err(skipped),
                None => match measure_cell(engine, (&roadway, &field), plan, &mut first, clock) {
                    Ok(row) => Ok(row),
                    Err(error) => {
                        let error = LostEngine::reason(engine, error)?;
                        LostEngine::add(&mut density.lost, engine, &error);
                        Err(SkippedCell::new(engine, &roadway, error.to_string()))
                    }
                },
            };
            let flow = done(measured.as_ref());
            match measured {
                Ok(row) => {
                    *last = Some(row.clone());
                    density.rows.push(row);
                }
                Err(skipped) => density.skipped.push(skipped),
            }
            if flow.is_break() {
                return Ok(density);
            }
        }
    }
    Ok(density)
}

/// Measures one engine at one density.
fn measure_cell(
    engine: &mut dyn Engine,
    (roadway, field): (&Roadway, &Arc<ClearanceField>),
    plan: &DensityPlan,
    first: &mut FirstAnswers,
    clock: &mut dyn FnMut() -> f64,
) -> Result<DensityRow, BenchError> {
    let answers = warm_up(engine, roadway, field)?;
    plan.raise_clock(engine, clock, |engine| roadway.decide(engine, field, 0))?;
    first.check(engine, answers, || roadway.name())?;
    let timed = plan.time(clock, |tick| roadway.decide(engine, field, tick))?;
    Ok(DensityRow::new(engine, roadway, &timed))
}

/// The reason why an engine is not measured at a density, predicted from a lower one; none if it is measured.
fn predicted_skip(last: &DensityRow, roadway: &Roadway, plan: &DensityPlan) -> Option<String> {
    let samples = roadway.samples();
    let decision_s = last.p50_ms / 1e3 * samples as f64 / last.samples as f64;
    let fewest = WARM_UP + MIN_SLOW_REPETITIONS;
    (decision_s * fewest as f64 > plan.max_seconds).then(|| {
        format!(
            "a decision would take about {decision_s:.1} s, as it took {:.3} s with {} samples; {fewest} of them are \
             more than the {} s that a cell may take",
            last.p50_ms / 1e3,
            last.samples,
            plan.max_seconds
        )
    })
}

/// Warms an engine up and returns the digest of its answers.
fn warm_up(
    engine: &mut dyn Engine,
    roadway: &Roadway,
    field: &Arc<ClearanceField>,
) -> Result<EvaluationDigest, BenchError> {
    let mut answers = EvaluationDigest::default();
    for tick in 0..WARM_UP {
        answers.add(&roadway.decide(engine, field, tick)?.evaluation);
    }
    Ok(answers)
}

/// The density at which a GPU's median falls below the best CPU engine's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Crossover {
    /// The GPU engine's name.
    pub name: String,
    /// Motion of the samples.
    pub sampler: String,
    /// Smallest measured number of samples from which the GPU's median is below that of every CPU engine at all common
    /// densities. None: the CPU is faster at the densest of them, or there is no common density.
    pub samples: Option<usize>,
    /// The fastest CPU engine at that number, or without one at the densest common density.
    pub fastest_cpu: Option<String>,
    /// Largest common number of samples; zero without one.
    pub up_to: usize,
}

impl fmt::Display for Crossover {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, sampler, samples, fastest_cpu, up_to } = self;
        let name = named_sampler(name, sampler);
        match (samples, fastest_cpu) {
            (Some(samples), Some(cpu)) => write!(
                f,
                "{name}: faster than every CPU engine from {samples} samples on (there {cpu})"
            ),
            (None, Some(cpu)) => {
                write!(f, "{name}: not faster than the CPU at {up_to} samples (there {cpu})")
            }
            (_, None) => {
                write!(f, "{name}: measured with no number of samples that a CPU engine was")
            }
        }
    }
}

/// The name of an engine with the sampler, unless that is the plain one.
#[must_use]
pub fn named_sampler(engine: &str, sampler: &str) -> String {
    if sampler == Sampler::Arcs.name() { engine.to_owned() } else { format!("{engine}, {sampler}") }
}

/// The crossover of each GPU engine and sampler, in the order in which they occur. Rows of one number of steps are expected.
#[must_use]
pub fn crossovers(rows: &[DensityRow]) -> Vec<Crossover> {
    let mut fastest_cpu: BTreeMap<(&str, usize), &DensityRow> = BTreeMap::new();
    for row in rows.iter().filter(|row| row.engine == "cpu") {
        let fastest = fastest_cpu.entry((&row.sampler, row.samples)).or_insert(row);
        if row.p50_ms < fastest.p50_ms {
            *fastest = row;
        }
    }
    let mut gpus: Vec<([&str; 2], Vec<&DensityRow>)> = Vec::new();
    for row in rows.iter().filter(|row| row.engine == "gpu") {
        let key = [&*row.name, &*row.sampler];
        match gpus.iter_mut().find(|(known, _)| *known == key) {
            Some((_, own)) => own.push(row),
            None => gpus.push((key, vec![row])),
        }
    }
    let crossover = |([name, sampler], own): ([&str; 2], Vec<&DensityRow>)| {
        let mut pairs: Vec<(&DensityRow, &DensityRow)> = own
            .into_iter()
            .filter_map(|row| Some((row, *fastest_cpu.get(&(sampler, row.samples))?)))
            .collect();
        pairs.sort_by_key(|(gpu, _)| gpu.samples);
        let wins = |(gpu, cpu): &&(&DensityRow, &DensityRow)| gpu.p50_ms < cpu.p50_ms;
        let first = pairs.iter().rev().take_while(wins).last();
        Crossover {
            name: name.to_owned(),
            sampler: sampler.to_owned(),
            samples: first.map(|(gpu, _)| gpu.samples),
            fastest_cpu: first.or(pairs.last()).map(|(_, cpu)| cpu.name.clone()),
            up_to: pairs.last().map_or(0, |(gpu, _)| gpu.samples),
        }
    };
    gpus.into_iter().map(crossover).collect()
}
