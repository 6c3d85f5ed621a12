//! `inbye playground`.

use std::path::PathBuf;

use clap::Args;

use super::arguments::{scene, whole};
use super::map_file::MapSettings;
use super::zones::ZoneArguments;

/// `inbye playground`.
#[derive(Debug, Args)]
#[command(
    mut_arg("config", |config| config.help("Settings, TOML: the robot, and the initial sampling and weights")),
    after_help = "Example:\n  inbye playground --port 8047\n  inbye playground --scene crossing --json\n\n\
    The first line is the address of the page, on this machine only. Drag the robot, the goal and the obstacles, or select their \
    handles with Tab and move them with the arrow keys; `Drive to the goal` lets the whole navigator drive. The browser takes the decision with the shaders of the GPU engine, and \
    the page shows whether its bits are those of the CPU engine. Without WebGPU, the page shows the CPU engine's decision.\n\
    POST /decision accepts the problem.json of `inbye evaluate`, with a scene's name as map.file: at most 64 KiB, 524288 \
    samples, 32 moving obstacles. An error response has a status 4xx or 5xx and one line of JSON, `error`.\n\
    JSON fields: `url`, `port`, `scenes`. Ctrl-C ends the server, with exit status 0."
)]
pub struct PlaygroundArguments {
    /// Port of localhost; 0 selects any free port.
    #[arg(long, default_value_t = 0, allow_negative_numbers = true, value_parser = whole::<u16>(0, 65_535))]
    pub port: u16,
    #[arg(
        long,
        value_name = "FILE",
        help = "Map to use instead of the built-in scenes: a ROS map_server .yaml, a MovingAI .map, or rows of text"
    )]
    pub map: Option<PathBuf>,
    /// Only this built-in scene.
    #[arg(long, value_name = "NAME", conflicts_with = "map", value_parser = scene())]
    pub scene: Option<&'static str>,
    #[command(flatten)]
    pub zones: ZoneArguments,
    #[command(flatten)]
    pub settings: MapSettings,
}

#[cfg(not(feature = "playground"))]
pub fn run(_arguments: &PlaygroundArguments) -> anyhow::Result<bool> {
    anyhow::bail!(
        "inbye playground: this program was built without the playground: build it with `cargo build --release --features playground`"
    )
}

#[cfg(feature = "playground")]
pub use server::run;

#[cfg(feature = "playground")]
mod server {
    use std::sync::atomic::Ordering;
    use std::thread;
    use std::time::Duration;

    use anyhow::{Context, bail, ensure};
    use inbye::local::Problem;
    use inbye::playground::{self, FieldLookup, Scene};
    use inbye::runtime::Config;
    use inbye::sim::scene as scene_of;
    use serde_json::json;

    use super::PlaygroundArguments;
    use crate::cli::refusal::refused;
    use crate::cli::{files, machine, map_file, output, problem_file};

    /// Interval at which the program looks for Ctrl-C.
    const POLL_INTERVAL: Duration = Duration::from_millis(20);

    /// Serves until Ctrl-C.
    pub fn run(arguments: &PlaygroundArguments) -> anyhow::Result<bool> {
        let scenes = scenes(arguments, &arguments.settings.load()?)?;
        let names: Vec<String> = scenes.iter().map(|scene| scene.name().to_owned()).collect();
        let end = machine::interrupt_flag()?;
        let server = playground::start(arguments.port, scenes, parse).map_err(|error| {
            let what = format!("--port {}: cannot be served", arguments.port);
            refused(what, error, "choose another, or 0 for any free one")
        })?;
        let address = server.address();
        let url = format!("http://{address}/");
        let object = json!({ "url": url, "port": address.port(), "scenes": names });
        output::result(&object, [&url])?;
        if !output::is_json() {
            output::note("open it in a browser; Ctrl-C ends it");
        }
        while !end.load(Ordering::Relaxed) {
            thread::sleep(POLL_INTERVAL);
        }
        let counts = server.finish();
        output::note(format!(
            "{} requests answered, {} rejected",
            counts.answered, counts.rejected
        ));
        Ok(true)
    }

    fn scenes(arguments: &PlaygroundArguments, config: &Config) -> anyhow::Result<Vec<Scene>> {
        let zones = arguments.zones.as_arguments();
        let settings = zones.clone() + &arguments.settings.as_arguments();
        let maps = arguments.map.as_deref().into_iter().chain(arguments.zones.files());
        let resolution_m = arguments.settings.resolution.of(maps)?;
        let scene = match (&arguments.map, arguments.scene.and_then(scene_of)) {
            (Some(file), _) => {
                let map = map_file::load(file, resolution_m)?;
                let zones = arguments.zones.read(&map, resolution_m)?;
                let title = file.file_name().unwrap_or_default().to_string_lossy();
                let name = files::quoted(&file.display().to_string());
                let arguments = format!("--map {name}{settings}");
                let scene = Scene::from_map(&title, map, zones, config, arguments);
                scene.with_context(|| file.display().to_string())?
            }
            (None, Some(scene)) => {
                let zones = arguments.zones.read(&scene.map, resolution_m)?;
                Scene::built_in(scene, zones, config, &settings)?
            }
            (None, None) if !zones.is_empty() => {
                bail!("--keepout and --speed-zones belong to a map: name it with --map or --scene")
            }
            (None, None) => return Ok(Scene::all_built_in(config, &settings)?),
        };
        Ok(vec![scene])
    }

    /// Reads a problem in the format of `problem.json`.
    fn parse(text: &str, field: FieldLookup<'_>) -> Result<Problem, String> {
        let parsed = problem_file::parse_on(text, |map, unknown| {
            ensure!(
                map.name().is_none() || !map.has_resolution(),
                "map.resolution_m: a scene states its own resolution: leave it out"
            );
            field(map.name(), unknown).map_err(anyhow::Error::msg)
        });
        parsed.map_err(|error| format!("{error:#}"))
    }
}
