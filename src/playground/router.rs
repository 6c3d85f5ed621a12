//! Maps paths to responses.

use core::mem::offset_of;
use std::collections::BTreeMap;

use hyper::Request;
use hyper::body::Bytes;
use serde_json::{Value, json};

use super::decision::{self, DecisionService, ProblemParser};
use super::drive::DriveService;
use super::scene::Scene;
use crate::local::SampleStatus;
use crate::local::internals::gpu::{self, Pipeline};
use crate::local::internals::gpu::{ACCESS, ANSWERS, Access, FIELD, RECORDS};
use crate::local::internals::gpu::{Answer, BATCH_BYTES, Record};
use crate::report;
use crate::server::{self, HttpError, MAX_BODY_BYTES, Response, Service};

const HTML: &str = "text/html; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";
const BYTES: &str = "application/octet-stream";

macro_rules! page_file {
    ($name:literal, $content_type:expr) => {
        (concat!("/", $name), $content_type, include_bytes!(concat!("page/", $name)))
    };
}

/// The files of the page.
const PAGE_FILES: [(&str, &str, &[u8]); 11] = [
    ("/", HTML, include_bytes!("page/index.html")),
    page_file!("playground.css", STYLE),
    page_file!("main.js", SCRIPT),
    page_file!("gpu.js", SCRIPT),
    page_file!("evaluation.js", SCRIPT),
    page_file!("view.js", SCRIPT),
    page_file!("drawing.js", SCRIPT),
    page_file!("handles.js", SCRIPT),
    page_file!("controls.js", SCRIPT),
    page_file!("results.js", SCRIPT),
    page_file!("drive.js", SCRIPT),
];

/// All that the server serves.
pub struct Router {
    decisions: DecisionService,
    drives: DriveService,
    setup: Value,
}

impl Service for Router {
    fn answer(&self, request: &Request<Bytes>) -> Result<Response, HttpError> {
        let path = request.uri().path();
        match path {
            "/decision" => {
                server::check_post(request)?;
                Ok(server::json(&self.decisions.decide(request.body())?))
            }
            "/records" => {
                server::check_post(request)?;
                Ok(server::ok(BYTES, self.decisions.records(request.body())?))
            }
            "/drive" => {
                server::check_post(request)?;
                Ok(server::json(&self.drives.drive(self.decisions.scenes(), request.body())?))
            }
            _ => {
                let response = self.get(path)?;
                server::check_get(request)?;
                Ok(response)
            }
        }
    }
}

impl Router {
    /// Serves these scenes. The page starts with the first.
    pub fn new(scenes: Vec<Scene>, engines: usize, parse: ProblemParser) -> Self {
        Self {
            setup: setup(&scenes),
            decisions: DecisionService::new(scenes, engines, parse),
            drives: DriveService::default(),
        }
    }

    fn get(&self, path: &str) -> Result<Response, HttpError> {
        let file = PAGE_FILES.iter().find(|(name, ..)| *name == path);
        if let Some((_, content_type, bytes)) = file {
            return Ok(server::ok(content_type, *bytes));
        }
        if let Some(page) = self.drives.page(path) {
            return Ok(server::page(page));
        }
        match path {
            "/report.css" => Ok(server::ok(STYLE, report::STYLE)),
            "/copy.js" => Ok(server::ok(SCRIPT, report::COPY_SCRIPT)),
            "/shader.wgsl" => Ok(server::ok("text/plain; charset=utf-8", gpu::source())),
            "/setup" => Ok(server::json(&self.setup)),
            _ => {
                let bytes = self.scene_bytes(path).ok_or_else(|| server::nothing_at(path))?;
                Ok(server::ok(BYTES, bytes.clone()))
            }
        }
    }

    fn scene_bytes(&self, path: &str) -> Option<&Bytes> {
        let (name, part) = path.strip_prefix("/scenes/")?.split_once('/')?;
        let scene = self.decisions.scene(name)?;
        match part {
            "cells" => Some(&scene.cells),
            "field" => Some(&scene.field_bytes),
            _ => None,
        }
    }
}

/// The binding of the displacement tables, between the fields and the records.
const TABLE: usize = FIELD + 1;
/// The binding of the workgroups' sums, between the records and the answers.
const PARTIALS: usize = RECORDS + 1;

macro_rules! word_offsets {
    ($struct:ty: $($field:ident),+) => {
        json!({ $(stringify!($field): offset_of!($struct, $field) / 4),+ })
    };
}

/// Entry point and constants of each pipeline, by name.
fn pipelines() -> Value {
    let pipeline = |pipeline: &Pipeline| {
        let constants = pipeline.constants().iter().copied();
        json!({
            "name": pipeline,
            "entry_point": pipeline.entry_point(),
            "constants": constants.collect::<BTreeMap<_, _>>(),
        })
    };
    Pipeline::ALL.iter().map(pipeline).collect()
}

/// What the page needs before its first request: the shaders' buffers and structs, the limits, the scenes.
fn setup(scenes: &[Scene]) -> Value {
    json!({
        "shader": {
            "pipelines": pipelines(),
            "bindings": bindings(),
            "uniform_bytes": BATCH_BYTES,
            "answer": word_offsets!(Answer: counts, sums_low, sums_high, min, max, winner, score_low, score_high, stamp, terms),
            "record": word_offsets!(Record: heading, clearance, path, status),
            "record_words": size_of::<Record>() / 4,
        },
        "statuses": (0..4).map(|number| SampleStatus::from_u32(number).name()).collect::<Vec<_>>(),
        "limits": {
            "samples": decision::MAX_SAMPLES,
            "obstacles": decision::MAX_OBSTACLES,
            "disc_checks": decision::MAX_DISC_CHECKS,
            "body_bytes": MAX_BODY_BYTES,
        },
        "scenes": scenes.iter().map(scene_setup).collect::<Vec<_>>(),
    })
}

/// The buffer of each binding and its type in WebGPU.
fn bindings() -> Vec<Value> {
    let buffer = |binding| match binding {
        ..FIELD => "input",
        FIELD => "field",
        TABLE => "table",
        RECORDS => "records",
        PARTIALS => "partials",
        ANSWERS.. => "answers",
    };
    let kind = |access| match access {
        Access::Uniform => "uniform",
        Access::Read => "read-only-storage",
        Access::ReadWrite => "storage",
    };
    let all = ACCESS.into_iter().enumerate();
    all.map(|(binding, access)| json!({ "buffer": buffer(binding), "type": kind(access) }))
        .collect()
}

fn scene_setup(scene: &Scene) -> Value {
    let (frame, footprint) = (scene.field.frame(), &scene.config.robot.footprint);
    let origin = frame.origin;
    json!({
        "name": scene.name,
        "title": scene.title,
        "width": frame.width,
        "height": frame.height,
        "resolution_m": frame.resolution_m,
        "origin": [origin.x, origin.y, origin.yaw],
        "body": footprint.body(),
        "discs": footprint.discs(),
        "problem": scene.problem,
    })
}
