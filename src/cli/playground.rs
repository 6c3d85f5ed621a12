//! `inbye playground`.

use std::path::PathBuf;

use clap::Args;
use inbye::map::UnknownPolicy;

use super::arguments::{length, whole};
use super::value_parsers;

/// `inbye playground`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye playground --port 8047\n  inbye playground --port 0 --map mine.yaml --json\n\n\
    The first line is the address of the page, on this machine only. Drag the robot, the goal and the obstacles, or select their \
    handles with Tab and move them with the arrow keys. The browser takes the decision with the shaders of the GPU engine, and \
    the page shows whether its bits are those of the CPU engine. Without WebGPU, the page shows the CPU engine's decision.\n\
    POST /decision accepts the problem.json of `inbye evaluate`, with a scene's name as map.file: at most 64 KiB, 524288 \
    samples, 32 moving obstacles. An error response has a status 4xx or 5xx and one line of JSON, `error`.\n\
    JSON fields: `url`, `port`, `scenes`. Ctrl-C ends the server, with exit status 0."
)]
pub struct PlaygroundArguments {
    /// Port of the loopback; 0 selects any free one.
    #[arg(long, default_value_t = 0, allow_negative_numbers = true, value_parser = whole::<u16>(0, 65_535))]
    pub port: u16,
    #[arg(
        long,
        value_name = "FILE",
        help = "Map to use instead of the built-in scenes: a ROS map_server .yaml, a MovingAI .map, or rows of text"
    )]
    pub map: Option<PathBuf>,
    /// Side of a cell of a .map or text map, metres.
    #[arg(long, default_value_t = 1.0, allow_negative_numbers = true, value_parser = length)]
    pub resolution: f64,
    /// How unknown cells count [default: the configuration's, blocked].
    #[arg(long, value_parser = value_parsers::unknown())]
    pub unknown: Option<UnknownPolicy>,
    /// Settings, TOML: the robot, and the initial sampling and weights.
    #[arg(long)]
    pub config: Option<PathBuf>,
}

#[cfg(not(feature = "playground"))]
pub fn run(_arguments: &PlaygroundArguments, _json: bool) -> anyhow::Result<bool> {
    anyhow::bail!(
        "inbye playground: this program was built without it: build it with `cargo build --release --features playground`"
    )
}

#[cfg(feature = "playground")]
pub use server::run;

#[cfg(feature = "playground")]
mod server {
    use std::sync::atomic::Ordering;
    use std::thread;
    use std::time::Duration;

    use anyhow::Context;
    use inbye::local::Problem;
    use inbye::playground::{FieldLookup, Playground, Scene};
    use inbye::runtime::Config;
    use serde_json::json;

    use super::super::{config, map_file, output, problem_file, process};
    use super::PlaygroundArguments;

    /// Interval at which the program looks for Ctrl-C.
    const POLL_INTERVAL: Duration = Duration::from_millis(20);

    /// Serves until Ctrl-C.
    pub fn run(arguments: &PlaygroundArguments, json: bool) -> anyhow::Result<bool> {
        let mut config = config::load("--config", arguments.config.as_deref())?;
        if let Some(unknown) = arguments.unknown {
            config.unknown = unknown;
        }
        let scenes = scenes(arguments, &config)?;
        let names: Vec<String> = scenes.iter().map(|scene| scene.name().to_owned()).collect();
        let end = process::interrupt_flag()?;
        let playground = Playground::start(arguments.port, scenes, parse).with_context(|| {
            let port = arguments.port;
            format!("--port {port}: cannot be served: choose another, or 0 for any free one")
        })?;
        let address = playground.address();
        let url = format!("http://{address}/");
        if json {
            output::json(&json!({ "url": url, "port": address.port(), "scenes": names }))?;
        } else {
            output::line(&url);
            output::note("open it in a browser; Ctrl-C ends it");
        }
        while !end.load(Ordering::Relaxed) {
            thread::sleep(POLL_INTERVAL);
        }
        let counts = playground.finish();
        output::note(format!(
            "{} requests answered, {} rejected",
            counts.answered, counts.rejected
        ));
        Ok(true)
    }

    fn scenes(arguments: &PlaygroundArguments, config: &Config) -> anyhow::Result<Vec<Scene>> {
        let Some(file) = &arguments.map else {
            return Ok(Scene::built_in(config)?);
        };
        let map = map_file::load(file, arguments.resolution)?;
        let title = file.file_name().unwrap_or_default().to_string_lossy();
        let scene = Scene::from_map(&title, &map, config);
        Ok(vec![scene.with_context(|| format!("{}", file.display()))?])
    }

    /// Reads a problem in the format of `problem.json`.
    fn parse(text: &str, field: FieldLookup<'_>) -> Result<Problem, String> {
        let parsed = problem_file::parse_on(text, |map, unknown| {
            field(map.name(), unknown).map_err(anyhow::Error::msg)
        });
        parsed.map_err(|error| {
            let causes: Vec<String> = error.chain().map(ToString::to_string).collect();
            causes.join(": ")
        })
    }
}
