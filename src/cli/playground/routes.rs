//! Which path answers what, and to whom.

use inbye::local::gpu::shaders;
use inbye::report;
use serde_json::{Value, json};

use super::decision::Desk;
use super::head::Request;
use super::refusal::Refusal;
use super::response::{Body, Response};
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
    pub fn answer(&self, request: &Request) -> Result<Response, Refusal> {
        self.check_host(request)?;
        let path = request.path.as_str();
        match path {
            "/decision" | "/records" => {
                self.check_post(request)?;
                if path == "/decision" {
                    return Ok(Response::json(&self.desk.decide(&request.body)?));
                }
                let records = self.desk.records(&request.body)?;
                Ok(Response::new(BYTES, Body::Own(records)))
            }
            _ => {
                let response = self.read(path)?;
                if matches!(request.method.as_str(), "GET" | "HEAD") {
                    Ok(response)
                } else {
                    Err(Refusal::of_method(&request.method, "GET, HEAD"))
                }
            }
        }
    }

    fn read(&self, path: &str) -> Result<Response, Refusal> {
        if let Some((_, content_type, bytes)) = PARTS.iter().find(|(name, ..)| *name == path) {
            return Ok(Response::new(content_type, Body::Fixed(bytes)));
        }
        match path {
            "/report.css" => {
                let style = Body::Fixed(report::STYLE.as_bytes());
                return Ok(Response::new(STYLE, style));
            }
            "/shader.wgsl" => {
                let source = Body::Own(shaders::source().into_bytes());
                return Ok(Response::new("text/plain; charset=utf-8", source));
            }
            "/setup" => return Ok(Response::json(&self.setup)),
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
            Refusal::new(
                404,
                format!("there is nothing at {}: begin at /", shown(path)),
            )
        })?;
        Ok(Response::new(BYTES, Body::Shared(bytes.clone())))
    }

    /// Another host's name that leads here is a page's attempt to read what is not its own.
    fn check_host(&self, request: &Request) -> Result<(), Refusal> {
        if self.hosts().contains(&request.host) {
            return Ok(());
        }
        let [address, _] = self.hosts();
        let what = format!(
            "this server is not {}: open http://{address}/",
            shown(&request.host)
        );
        Err(Refusal::new(403, what))
    }

    fn hosts(&self) -> [String; 2] {
        ["127.0.0.1", "localhost"].map(|host| format!("{host}:{}", self.port))
    }

    /// A page of another origin may ask for nothing, and a body must be what only our page sends without being asked.
    fn check_post(&self, request: &Request) -> Result<(), Refusal> {
        if request.method != "POST" {
            return Err(Refusal::of_method(&request.method, "POST"));
        }
        let is_own = |origin: &String| {
            let host = origin.strip_prefix("http://").unwrap_or_default();
            self.hosts().iter().any(|own| own == host)
        };
        if let Some(origin) = request.origin.as_ref().filter(|origin| !is_own(origin)) {
            let what = format!("pages of {} may not ask here", shown(origin));
            return Err(Refusal::new(403, what));
        }
        let content_type = request.content_type.split(';').next().unwrap_or_default();
        if content_type.trim().eq_ignore_ascii_case("application/json") {
            Ok(())
        } else {
            let what = "send the problem with Content-Type: application/json";
            Err(Refusal::new(415, what))
        }
    }
}

/// A stranger's text, short and in one line.
fn shown(text: &str) -> Value {
    let short: String = text.chars().take(60).collect();
    json!(short)
}
