//! Which path answers what, and to whom.

use hyper::body::Bytes;
use hyper::header::{CONTENT_TYPE, HOST, HeaderName, ORIGIN};
use hyper::{Method, Request, StatusCode};
use inbye::local::gpu::shaders;
use inbye::report;
use serde_json::{Value, json};

use super::decision::Desk;
use super::refusal::Refusal;
use super::response::{self, Response};
use super::scene::Scene;
use super::setup;

const HTML: &str = "text/html; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";
const BYTES: &str = "application/octet-stream";

macro_rules! part {
    ($name:literal, $content_type:expr) => {
        (
            concat!("/", $name),
            $content_type,
            include_bytes!(concat!("page/", $name)),
        )
    };
}

/// The parts of the page.
const PARTS: [(&str, &str, &[u8]); 10] = [
    ("/", HTML, include_bytes!("page/index.html")),
    part!("playground.css", STYLE),
    part!("main.js", SCRIPT),
    part!("gpu.js", SCRIPT),
    part!("answer.js", SCRIPT),
    part!("view.js", SCRIPT),
    part!("picture.js", SCRIPT),
    part!("handles.js", SCRIPT),
    part!("controls.js", SCRIPT),
    part!("results.js", SCRIPT),
];

/// All that is served.
pub struct Site {
    port: u16,
    desk: Desk,
    setup: Value,
}

impl Site {
    /// Of these scenes, the first of which is shown first, at a port of the loopback.
    pub fn new(port: u16, scenes: Vec<Scene>, engines: usize) -> Self {
        Self {
            port,
            setup: setup::setup(&scenes),
            desk: Desk::new(scenes, engines),
        }
    }

    /// What the request asked for.
    pub fn answer(&self, request: &Request<Bytes>) -> Result<Response, Refusal> {
        self.check_host(request)?;
        let path = request.uri().path();
        match path {
            "/decision" | "/records" => {
                self.check_post(request)?;
                if path == "/decision" {
                    return Ok(response::json(&self.desk.decide(request.body())?));
                }
                let records = self.desk.records(request.body())?;
                Ok(response::of(BYTES, records))
            }
            _ => {
                let response = self.read(path)?;
                if matches!(*request.method(), Method::GET | Method::HEAD) {
                    Ok(response)
                } else {
                    Err(Refusal::of_method(request.method(), "GET, HEAD"))
                }
            }
        }
    }

    fn read(&self, path: &str) -> Result<Response, Refusal> {
        if let Some((_, content_type, bytes)) = PARTS.iter().find(|(name, ..)| *name == path) {
            return Ok(response::of(content_type, *bytes));
        }
        match path {
            "/report.css" => return Ok(response::of(STYLE, report::STYLE)),
            "/shader.wgsl" => {
                return Ok(response::of("text/plain; charset=utf-8", shaders::source()));
            }
            "/setup" => return Ok(response::json(&self.setup)),
            _ => {}
        }
        let found = path
            .strip_prefix("/scenes/")
            .and_then(|rest| rest.split_once('/'))
            .and_then(|(name, part)| {
                let scene = self.desk.scene(name)?;
                match part {
                    "cells" => Some(&scene.cells),
                    "field" => Some(&scene.field_bytes),
                    _ => None,
                }
            });
        let bytes = found.ok_or_else(|| {
            let what = format!("there is nothing at {}: begin at /", shown(path));
            Refusal::new(StatusCode::NOT_FOUND, what)
        })?;
        Ok(response::of(BYTES, bytes.clone()))
    }

    /// Another host's name that leads here is a page's attempt to read what is not its own.
    fn check_host(&self, request: &Request<Bytes>) -> Result<(), Refusal> {
        let host = said(request, HOST).unwrap_or_default();
        if self.hosts().contains(&host) {
            return Ok(());
        }
        let [address, _] = self.hosts();
        let what = format!(
            "this server is not {}: open http://{address}/",
            shown(&host)
        );
        Err(Refusal::new(StatusCode::FORBIDDEN, what))
    }

    fn hosts(&self) -> [String; 2] {
        ["127.0.0.1", "localhost"].map(|host| format!("{host}:{}", self.port))
    }

    /// A page of another origin may ask for nothing, and a body must be what only our page sends without being asked.
    fn check_post(&self, request: &Request<Bytes>) -> Result<(), Refusal> {
        if request.method() != Method::POST {
            return Err(Refusal::of_method(request.method(), "POST"));
        }
        let is_own = |origin: &String| {
            let host = origin.strip_prefix("http://").unwrap_or_default();
            self.hosts().iter().any(|own| own == host)
        };
        if let Some(origin) = said(request, ORIGIN).filter(|origin| !is_own(origin)) {
            let what = format!("pages of {} may not ask here", shown(&origin));
            return Err(Refusal::new(StatusCode::FORBIDDEN, what));
        }
        let content_type = said(request, CONTENT_TYPE).unwrap_or_default();
        let content_type = content_type.split(';').next().unwrap_or_default();
        if content_type.trim().eq_ignore_ascii_case("application/json") {
            Ok(())
        } else {
            let what = "send the problem with Content-Type: application/json";
            Err(Refusal::new(StatusCode::UNSUPPORTED_MEDIA_TYPE, what))
        }
    }
}

/// What a header says.
fn said(request: &Request<Bytes>, name: HeaderName) -> Option<String> {
    let value = request.headers().get(name)?;
    Some(String::from_utf8_lossy(value.as_bytes()).into_owned())
}

/// A stranger's text, short and in one line.
fn shown(text: &str) -> Value {
    let short: String = text.chars().take(60).collect();
    json!(short)
}
