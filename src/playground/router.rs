//! Maps paths to responses and checks host and origin.

use core::mem::offset_of;

use hyper::body::Bytes;
use hyper::header::{CONTENT_TYPE, HOST, HeaderName, ORIGIN};
use hyper::{Method, Request, StatusCode};
use serde_json::{Value, json};

use super::connection::MAX_BODY_BYTES;
use super::decision::{self, DecisionService, ProblemParser};
use super::response::{self, HttpError, Response};
use super::scene::Scene;
use crate::local::SampleStatus;
use crate::local::internals::gpu::{self, ENTRY_POINTS};
use crate::local::internals::gpu::{ACCESS, ANSWERS, Access, FIELD, RECORDS};
use crate::local::internals::gpu::{Answer, BATCH_BYTES, Record};
use crate::report;

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
const PAGE_FILES: [(&str, &str, &[u8]); 10] = [
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
];

/// All that the server serves.
pub struct Router {
    port: u16,
    decisions: DecisionService,
    setup: Value,
}

impl Router {
    /// Serves these scenes at a port of the loopback. The page starts with the first.
    pub fn new(port: u16, scenes: Vec<Scene>, engines: usize, parse: ProblemParser) -> Self {
        Self {
            port,
            setup: setup(&scenes),
            decisions: DecisionService::new(scenes, engines, parse),
        }
    }

    /// The response to a request.
    pub fn answer(&self, request: &Request<Bytes>) -> Result<Response, HttpError> {
        self.check_host(request)?;
        let path = request.uri().path();
        match path {
            "/decision" => {
                self.check_post(request)?;
                Ok(response::json(&self.decisions.decide(request.body())?))
            }
            "/records" => {
                self.check_post(request)?;
                Ok(response::ok(BYTES, self.decisions.records(request.body())?))
            }
            _ => {
                let response = self.get(path)?;
                match *request.method() {
                    Method::GET | Method::HEAD => Ok(response),
                    ref other => Err(HttpError::method_not_allowed(other, "GET, HEAD")),
                }
            }
        }
    }

    fn get(&self, path: &str) -> Result<Response, HttpError> {
        let file = PAGE_FILES.iter().find(|(name, ..)| *name == path);
        if let Some((_, content_type, bytes)) = file {
            return Ok(response::ok(content_type, *bytes));
        }
        match path {
            "/report.css" => Ok(response::ok(STYLE, report::STYLE)),
            "/shader.wgsl" => Ok(response::ok("text/plain; charset=utf-8", gpu::source())),
            "/setup" => Ok(response::json(&self.setup)),
            _ => {
                let bytes = self.scene_bytes(path).ok_or_else(|| {
                    let message = format!("there is nothing at {}: start at /", quoted(path));
                    HttpError::new(StatusCode::NOT_FOUND, message)
                })?;
                Ok(response::ok(BYTES, bytes.clone()))
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

    /// Rejects other host names: a foreign page could otherwise read this server by DNS rebinding.
    fn check_host(&self, request: &Request<Bytes>) -> Result<(), HttpError> {
        let host = header(request, HOST).unwrap_or_default();
        if self.hosts().contains(&host) {
            return Ok(());
        }
        let [address, _] = self.hosts();
        let message = format!("this server is not {}: open http://{address}/", quoted(&host));
        Err(HttpError::new(StatusCode::FORBIDDEN, message))
    }

    fn hosts(&self) -> [String; 2] {
        ["127.0.0.1", "localhost"].map(|host| format!("{host}:{}", self.port))
    }

    /// Rejects pages of another origin. They cannot send JSON without a preflight request, so other content types are
    /// rejected too.
    fn check_post(&self, request: &Request<Bytes>) -> Result<(), HttpError> {
        if request.method() != Method::POST {
            return Err(HttpError::method_not_allowed(request.method(), "POST"));
        }
        let is_own = |origin: &String| {
            let host = origin.strip_prefix("http://").unwrap_or_default();
            self.hosts().iter().any(|own| own == host)
        };
        if let Some(origin) = header(request, ORIGIN).filter(|origin| !is_own(origin)) {
            let message = format!("requests from pages of {} are rejected", quoted(&origin));
            return Err(HttpError::new(StatusCode::FORBIDDEN, message));
        }
        let content_type = header(request, CONTENT_TYPE).unwrap_or_default();
        let content_type = content_type.split(';').next().unwrap_or_default();
        if content_type.trim().eq_ignore_ascii_case("application/json") {
            Ok(())
        } else {
            let cure = "send the problem with Content-Type: application/json";
            Err(HttpError::new(StatusCode::UNSUPPORTED_MEDIA_TYPE, cure))
        }
    }
}

/// The value of a header.
fn header(request: &Request<Bytes>, name: HeaderName) -> Option<String> {
    let value = request.headers().get(name)?;
    Some(String::from_utf8_lossy(value.as_bytes()).into_owned())
}

/// A client's text in quotes, at most 60 characters, on one line.
fn quoted(text: &str) -> Value {
    let short: String = text.chars().take(60).collect();
    json!(short)
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

/// What the page needs before its first request: the shaders' buffers and structs, the limits, the scenes.
fn setup(scenes: &[Scene]) -> Value {
    json!({
        "shader": {
            "entry_points": ENTRY_POINTS,
            "bindings": bindings(),
            "uniform_bytes": BATCH_BYTES,
            "answer": word_offsets!(Answer: counts, sums_low, sums_high, min, max, winner, score_low, score_high, stamp, terms),
            "record": word_offsets!(Record: heading, clearance, path, status),
            "record_words": size_of::<Record>() / 4,
        },
        "statuses": (0..4).map(|number| SampleStatus::from_u32(number).as_str()).collect::<Vec<_>>(),
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
    let frame = scene.field.frame();
    let origin = frame.origin;
    json!({
        "name": scene.name,
        "title": scene.title,
        "width": frame.width,
        "height": frame.height,
        "resolution_m": frame.resolution_m,
        "origin": [origin.x, origin.y, origin.yaw],
        "problem": scene.problem,
    })
}
