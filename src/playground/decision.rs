//! Converts a problem to the buffers of the GPU engine and evaluates it with the CPU engine.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use hyper::StatusCode;
use serde::Serialize;
use serde_json::{Value, json};

use super::scene::Scene;
use crate::bench::EvaluationDigest;
use crate::local::internals::evenly_spaced;
use crate::local::internals::gpu::Batch;
use crate::local::{
    ClearanceField, CpuEngine, Detail, Engine, EngineError, Evaluation, Explainer, Problem,
    QuantizedProblem, SampleRecord, Sampler, Terms, Window,
};
use crate::map::UnknownPolicy;
use crate::server::HttpError;

// Limits of one problem, far below those of the engines: a single request must not delay the others for long.
/// Maximum number of samples.
pub const MAX_SAMPLES: usize = 1 << 19;
/// Maximum number of moving obstacles.
pub const MAX_OBSTACLES: usize = 32;
/// Maximum number of checks of a disc against the map or an obstacle, over all samples and steps: less than a second on one
/// core.
pub const MAX_DISC_CHECKS: usize = 1 << 28;

/// Arcs of the trajectory fan at most: forward speeds, turn rates.
const MAX_ARCS: (u32, u32) = (9, 31);

/// Finds the clearance field of a map by its name, if the problem names one, and the policy for unknown cells.
pub type FieldLookup<'a> =
    &'a dyn Fn(Option<&str>, UnknownPolicy) -> Result<Arc<ClearanceField>, String>;

/// Parses the text of a problem. The error is one line.
pub type ProblemParser = fn(&str, FieldLookup<'_>) -> Result<Problem, String>;

/// The scenes, and engines that decide in them.
pub struct DecisionService {
    scenes: Vec<Scene>,
    parse: ProblemParser,
    engines: Vec<Mutex<CpuEngine>>,
    next_engine: AtomicUsize,
}

impl DecisionService {
    /// A service that evaluates as many problems in parallel as it has engines.
    pub fn new(scenes: Vec<Scene>, engines: usize, parse: ProblemParser) -> Self {
        let engine = |_| Mutex::new(CpuEngine::single_threaded());
        Self {
            scenes,
            parse,
            engines: (0..engines.max(1)).map(engine).collect(),
            next_engine: AtomicUsize::new(0),
        }
    }

    /// All scenes.
    pub fn scenes(&self) -> &[Scene] {
        &self.scenes
    }

    /// The scene with this name.
    pub fn scene(&self, name: &str) -> Option<&Scene> {
        self.scenes.iter().find(|scene| scene.name == name)
    }

    /// The inputs with which a browser takes the decision itself, and the decision of the CPU engine.
    pub fn decide(&self, body: &[u8]) -> Result<Value, HttpError> {
        self.with_engine(|engine| {
            let began = Instant::now();
            let (problem, prepared) = self.prepare(body)?;
            let batch = Batch::first_of(core::slice::from_ref(&prepared));
            let mut input = vec![0; batch.input_bytes() as usize];
            let put = |at: usize, bytes: &[u8]| input[at..at + bytes.len()].copy_from_slice(bytes);
            batch.write(put, 0, |_| 0);
            let prepare_ms = milliseconds_since(began);
            let began = Instant::now();
            engine.evaluate(&prepared, Detail::Answer)?;
            let decide_ms = milliseconds_since(began);
            let evaluation = engine.evaluate(&prepared, Detail::Samples)?;
            let drawn = fan(&prepared, &evaluation);
            Ok(json!({
                "input": BASE64_STANDARD.encode(&input),
                "bytes": batch.sizes(),
                "dispatches": batch.dispatches(),
                "velocity_terms": prepared.vx_samples.iter().map(|vx| vx.velocity_term).collect::<Vec<_>>(),
                "window": window(&problem),
                "from": problem.pose,
                "horizon_s": f64::from(problem.steps) * problem.step_s,
                "unit": unit(&problem, &prepared, &evaluation),
                "cpu": summary(&evaluation),
                "paths": paths(&problem, &drawn, &evaluation),
                "fan": drawn,
                "prepare_ms": prepare_ms,
                "decide_ms": decide_ms,
                "engine": engine.name(),
            }))
        })
    }

    /// Every sample as the CPU engine evaluates it: status, heading, clearance, velocity and path, a little-endian word each.
    pub fn records(&self, body: &[u8]) -> Result<Vec<u8>, HttpError> {
        self.with_engine(|engine| {
            let (_, prepared) = self.prepare(body)?;
            let evaluation = engine.evaluate(&prepared, Detail::Samples)?;
            let samples = evaluation.samples.iter().flatten().flat_map(words);
            Ok(samples.flat_map(u32::to_le_bytes).collect())
        })
    }

    fn prepare(&self, body: &[u8]) -> Result<(Problem, QuantizedProblem), HttpError> {
        let text = core::str::from_utf8(body)
            .map_err(|_| HttpError::bad_request("the problem must be text in UTF-8"))?;
        let lookup = |map: Option<&str>, unknown| self.field(map, unknown);
        let problem = (self.parse)(text, &lookup).map_err(HttpError::bad_request)?;
        check_limits(&problem)?;
        let prepared = QuantizedProblem::new(&problem)
            .map_err(|error| HttpError::bad_request(error.to_string()))?;
        Ok((problem, prepared))
    }

    fn field(
        &self,
        map: Option<&str>,
        unknown: UnknownPolicy,
    ) -> Result<Arc<ClearanceField>, String> {
        let scene = map.and_then(|name| self.scene(name)).ok_or_else(|| {
            let names = self.scenes.iter().map(|scene| json!(scene.name).to_string());
            let names = names.collect::<Vec<_>>().join(", ");
            format!("map must be a scene of this playground: {{\"file\": one of {names}}}")
        })?;
        if unknown == scene.unknown {
            Ok(scene.field.clone())
        } else {
            Err(format!(
                "unknown must be {:?} here: start the playground with another setting of unknown",
                scene.unknown
            ))
        }
    }

    /// Works with one of the engines, which take turns.
    fn with_engine<T>(&self, work: impl FnOnce(&mut CpuEngine) -> T) -> T {
        let next = self.next_engine.fetch_add(1, Ordering::Relaxed);
        let engine = &self.engines[next % self.engines.len()];
        // An engine is usable after a panic: each evaluation starts from its own problem.
        work(&mut engine.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// Rejects a problem beyond the limits.
fn check_limits(problem: &Problem) -> Result<(), HttpError> {
    let samples = problem.window.len();
    let obstacles = problem.obstacles.len();
    let steps = problem.steps as usize;
    let disc_checks = samples
        .saturating_mul(steps)
        .saturating_mul(problem.footprint.discs().len())
        .saturating_mul(1 + obstacles);
    for (what, number, max, cure) in [
        ("samples", samples, MAX_SAMPLES, "sample less densely"),
        ("moving obstacles", obstacles, MAX_OBSTACLES, "remove some"),
        (
            "samples x steps x discs x (1 + obstacles)",
            disc_checks,
            MAX_DISC_CHECKS,
            "sample less densely, shorten the horizon, or remove obstacles",
        ),
    ] {
        if number > max {
            let message = format!("{number} {what}: at most {max} here: {cure}");
            return Err(HttpError::bad_request(message));
        }
    }
    Ok(())
}

/// Speeds by column and turn rates by row in the first control period.
fn window(problem: &Problem) -> Value {
    let Window { vx, vtheta } = &problem.window;
    let speeds: Vec<f64> = (0..vx.count).map(|column| problem.command(column).linear).collect();
    let rates = (0..vtheta.count).map(|row| problem.command(row * vx.count).angular);
    json!({ "v": speeds, "omega": rates.collect::<Vec<f64>>() })
}

/// The positions of the drawn samples and of the winner after each step, by index; null where samples keep their velocity
/// over the whole horizon.
fn paths(problem: &Problem, drawn: &Fan, evaluation: &Evaluation) -> Option<Value> {
    let winner = evaluation.winner.map(|winner| winner.index as usize);
    let path = |&index: &usize| (index.to_string(), json!(problem.path(index as u32)));
    (problem.sampler != Sampler::Arcs)
        .then(|| drawn.indices.iter().chain(&winner).map(path).collect())
}

fn unit(problem: &Problem, prepared: &QuantizedProblem, evaluation: &Evaluation) -> Value {
    let one = Terms { heading: 1, clearance: 1, velocity: 1, path: 1 };
    json!(Explainer::new(problem, prepared, evaluation).terms(&one))
}

/// All that the digest covers except for the samples. Numbers of 64 bits are text.
fn summary(evaluation: &Evaluation) -> Value {
    let mut digest = EvaluationDigest::default();
    digest.add(evaluation);
    let totals = &evaluation.totals;
    json!({
        "counts": evaluation.counts.to_array(),
        "sums": totals.sums.map(|sum| sum.to_string()),
        "min": totals.min,
        "max": totals.max,
        "winner": evaluation.winner.map(|winner| json!({
            "index": winner.index,
            "score": winner.score.to_string(),
            "terms": winner.terms.to_array(),
        })),
        "digest": digest.hex(),
    })
}

/// The samples to draw, as the CPU engine evaluates them.
fn fan(prepared: &QuantizedProblem, evaluation: &Evaluation) -> Fan {
    let (columns, rows) = MAX_ARCS;
    let speeds = prepared.vx_samples.len();
    let mut indices = Vec::new();
    let mut records = Vec::new();
    for row in evenly_spaced(prepared.profiles.len(), rows) {
        for column in evenly_spaced(speeds, columns) {
            let index = row * speeds + column;
            indices.push(index);
            records.extend(evaluation.samples.iter().flat_map(|samples| words(&samples[index])));
        }
    }
    Fan { indices, records }
}

/// Some samples: their indices, and their words one after the other.
#[derive(Serialize)]
struct Fan {
    indices: Vec<usize>,
    records: Vec<u32>,
}

/// The words of a sample in the order of the digest.
const fn words(sample: &SampleRecord) -> [u32; 5] {
    let [heading, clearance, velocity, path] = sample.terms.to_array();
    [sample.status as u32, heading, clearance, velocity, path]
}

impl From<EngineError> for HttpError {
    fn from(error: EngineError) -> Self {
        Self::new(StatusCode::INTERNAL_SERVER_ERROR, error.to_string())
    }
}

fn milliseconds_since(began: Instant) -> f64 {
    began.elapsed().as_secs_f64() * 1000.0
}
