//! A problem becomes the buffers that the GPU engine would upload, and the CPU engine's answer.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use anyhow::{anyhow, ensure};
use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use hyper::StatusCode;
use inbye::bench::EvaluationDigest;
use inbye::local::gpu::batch::Batch;
use inbye::local::{
    CpuEngine, Detail, Engine, EngineError, Evaluation, Explainer, Prepared, Problem, SampleRecord,
    Terms, spread,
};
use serde_json::{Value, json};

use super::bounds;
use super::refusal::Refusal;
use super::scene::Scene;
use crate::cli::problem_file;

/// Arcs of the fan at most: forward speeds, turn rates.
const MOST_ARCS: (u32, u32) = (9, 31);

/// Scenes, and engines to decide in them.
pub struct Desk {
    scenes: Vec<Scene>,
    engines: Vec<Mutex<CpuEngine>>,
    turn: AtomicUsize,
}

impl Desk {
    /// With so many engines: so many problems are evaluated at a time.
    pub fn new(scenes: Vec<Scene>, engines: usize) -> Self {
        let engine = |_| Mutex::new(CpuEngine::single_threaded());
        Self {
            scenes,
            engines: (0..engines.max(1)).map(engine).collect(),
            turn: AtomicUsize::new(0),
        }
    }

    /// The scene of this name.
    pub fn scene(&self, name: &str) -> Option<&Scene> {
        self.scenes.iter().find(|scene| scene.name == name)
    }

    /// What a browser needs to take the decision itself, and what the CPU engine decides.
    pub fn decide(&self, body: &[u8]) -> Result<Value, Refusal> {
        self.with_engine(|engine| {
            let began = Instant::now();
            let (problem, prepared) = self.prepare(body)?;
            let batch = Batch::first_of(core::slice::from_ref(&prepared));
            let mut input = vec![0; batch.sizes().input as usize];
            let written = batch.write(&mut input, 0, |_| 0);
            let prepare_ms = milliseconds_since(began);
            let began = Instant::now();
            engine.evaluate(&prepared, Detail::Answer).map_err(|error| failed(&error))?;
            let decide_ms = milliseconds_since(began);
            let evaluation = engine.evaluate(&prepared, Detail::Samples).map_err(|error| failed(&error))?;
            let sizes = batch.sizes();
            let window = &problem.window;
            Ok(json!({
                "input": BASE64_STANDARD.encode(&input[..written]),
                "bytes": {
                    "input": sizes.input,
                    "field": sizes.field,
                    "table": sizes.table,
                    "records": sizes.records,
                    "partials": sizes.partials,
                    "answers": sizes.answers,
                },
                "workgroups": batch.workgroups(),
                "velocity_terms": prepared.speeds.iter().map(|speed| speed.term).collect::<Vec<_>>(),
                "window": {
                    "v": [window.linear.low, window.linear.high],
                    "omega": [window.angular.low, window.angular.high],
                    "v_count": window.linear.count,
                    "omega_count": window.angular.count,
                },
                "from": problem.pose,
                "horizon_s": f64::from(problem.steps) * problem.step_s,
                "unit": unit(&problem, &prepared, &evaluation),
                "cpu": answer(&evaluation),
                "fan": fan(&prepared, &evaluation),
                "prepare_ms": prepare_ms,
                "decide_ms": decide_ms,
                "engine": engine.name(),
            }))
        })
    }

    /// Every sample as the CPU engine judges it: reason, heading, clearance, velocity and path, a little-endian word each.
    pub fn records(&self, body: &[u8]) -> Result<Vec<u8>, Refusal> {
        self.with_engine(|engine| {
            let (_, prepared) = self.prepare(body)?;
            let evaluation = engine
                .evaluate(&prepared, Detail::Samples)
                .map_err(|error| failed(&error))?;
            let samples = evaluation.samples.iter().flatten().flat_map(words);
            Ok(samples.flat_map(u32::to_le_bytes).collect())
        })
    }

    fn prepare(&self, body: &[u8]) -> Result<(Problem, Prepared), Refusal> {
        let text = core::str::from_utf8(body).map_err(|_| {
            Refusal::new(StatusCode::BAD_REQUEST, "the problem must be text in UTF-8")
        })?;
        let problem = self.read(text).map_err(|error| refused(&error))?;
        bounds::check(&problem)?;
        let prepared = Prepared::new(&problem).map_err(|error| refused(&error.into()))?;
        Ok((problem, prepared))
    }

    fn read(&self, text: &str) -> anyhow::Result<Problem> {
        problem_file::parse_on(text, |map, unknown| {
            let scene = map.name().and_then(|name| self.scene(name));
            let scene = scene.ok_or_else(|| {
                let names: Vec<String> = self
                    .scenes
                    .iter()
                    .map(|scene| json!(scene.name).to_string())
                    .collect();
                anyhow!(
                    "map must be a scene of this playground: {{\"file\": one of {}}}",
                    names.join(", ")
                )
            })?;
            ensure!(
                unknown == scene.unknown,
                "unknown ground counts as {:?} here: start with --unknown for another",
                scene.unknown
            );
            Ok(scene.field.clone())
        })
    }

    /// Works with one of the engines when its turn comes.
    fn with_engine<T>(&self, work: impl FnOnce(&mut CpuEngine) -> T) -> T {
        let turn = self.turn.fetch_add(1, Ordering::Relaxed);
        let engine = &self.engines[turn % self.engines.len()];
        // One that was given up within a decision is as good as new: each begins with its own problem.
        work(&mut engine.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// What one of each term is in SI units.
fn unit(problem: &Problem, prepared: &Prepared, evaluation: &Evaluation) -> Value {
    let one = Terms {
        heading: 1,
        clearance: 1,
        velocity: 1,
        path: 1,
    };
    json!(Explainer::new(problem, prepared, evaluation).terms(&one))
}

/// All that the digest is of, but for the samples; numbers of 64 bits as text.
fn answer(evaluation: &Evaluation) -> Value {
    let mut digest = EvaluationDigest::default();
    digest.add(evaluation);
    let totals = &evaluation.totals;
    json!({
        "counts": evaluation.counts.to_array(),
        "sums": totals.sums.map(|sum| sum.to_string()),
        "least": totals.least,
        "greatest": totals.greatest,
        "winner": evaluation.winner.map(|winner| json!({
            "index": winner.index,
            "score": winner.score.to_string(),
            "terms": winner.terms.to_array(),
        })),
        "digest": digest.hex(),
    })
}

/// Which samples to draw, and how the CPU engine judges them.
fn fan(prepared: &Prepared, evaluation: &Evaluation) -> Value {
    let (columns, rows) = MOST_ARCS;
    let speeds = prepared.speeds.len();
    let mut indices = Vec::new();
    let mut records = Vec::new();
    for row in spread(prepared.turns.len(), rows) {
        for column in spread(speeds, columns) {
            let index = row * speeds + column;
            indices.push(index);
            records.extend(
                evaluation
                    .samples
                    .iter()
                    .flat_map(|samples| words(&samples[index])),
            );
        }
    }
    json!({ "indices": indices, "records": records })
}

/// As the digest has them.
const fn words(sample: &SampleRecord) -> [u32; 5] {
    let [heading, clearance, velocity, path] = sample.terms.to_array();
    [sample.reason as u32, heading, clearance, velocity, path]
}

fn milliseconds_since(began: Instant) -> f64 {
    began.elapsed().as_secs_f64() * 1000.0
}

fn refused(error: &anyhow::Error) -> Refusal {
    let causes: Vec<String> = error.chain().map(ToString::to_string).collect();
    Refusal::new(StatusCode::BAD_REQUEST, causes.join(": "))
}

fn failed(error: &EngineError) -> Refusal {
    Refusal::new(StatusCode::INTERNAL_SERVER_ERROR, error.to_string())
}
