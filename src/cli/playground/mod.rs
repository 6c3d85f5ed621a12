//! `inbye playground`: one page on the loopback whose browser takes decisions with the shaders of the GPU engine.
//!
//! The server turns a problem into the integers that the GPU engine would upload, and the page runs the same WGSL over them
//! in the browser's WebGPU: nothing is prepared twice. Beside them goes the CPU engine's answer, and the page tells whether
//! the two have the same bits.

mod bounds;
mod connection;
mod decision;
mod gate;
mod refusal;
mod request;
mod response;
mod routes;
mod scene;
mod server;
mod setup;

use std::sync::atomic::Ordering;
use std::thread;
use std::time::Duration;

use anyhow::Context;
use inbye::map::OccupancyGrid;
use inbye::runtime::Config;
use serde_json::json;

use super::playground_arguments::PlaygroundArguments;
use super::{interrupt, map_file, output, settings_file};
use routes::Site;

/// How long from one look for Ctrl-C to the next.
const LOOK: Duration = Duration::from_millis(20);
/// How long an answer under way may take at the end, looks.
const LAST_LOOKS: u32 = 100;

/// Serves until Ctrl-C.
pub fn run(arguments: &PlaygroundArguments, json: bool) -> anyhow::Result<bool> {
    let mut config = settings_file::read(arguments.config.as_deref())?;
    if let Some(unknown) = arguments.unknown {
        config.unknown = unknown;
    }
    let scenes = scenes(arguments, &config)?;
    let names: Vec<String> = scenes.iter().map(|scene| scene.name.clone()).collect();
    let end = interrupt::flag()?;
    let (listener, address) = server::bind(arguments.port).with_context(|| {
        let port = arguments.port;
        format!("--port {port}: cannot be served: name another, or 0 for any free one")
    })?;
    let engines = thread::available_parallelism().map_or(1, usize::from);
    let tally = server::start(listener, Site::new(address.port(), scenes, engines))?;
    let url = format!("http://{address}/");
    if json {
        output::json(&json!({ "url": url, "port": address.port(), "scenes": names }))?;
    } else {
        output::line(&url);
        output::note("open it in a browser; Ctrl-C ends it");
    }
    while !end.load(Ordering::Relaxed) {
        thread::sleep(LOOK);
    }
    for _ in 0..LAST_LOOKS {
        if tally.under_way.load(Ordering::Relaxed) == 0 {
            break;
        }
        thread::sleep(LOOK);
    }
    output::note(format!(
        "{} requests answered, {} refused",
        tally.answered.load(Ordering::Relaxed),
        tally.refused.load(Ordering::Relaxed)
    ));
    Ok(true)
}

fn scenes(arguments: &PlaygroundArguments, config: &Config) -> anyhow::Result<Vec<scene::Scene>> {
    let Some(file) = &arguments.map else {
        return scene::built_in(config);
    };
    let map: OccupancyGrid = map_file::load(file, arguments.resolution)?;
    let title = file.file_name().unwrap_or_default().to_string_lossy();
    Ok(vec![scene::of_map(&title, &map, config)?])
}
