//! What `inbye playground` may be told.

use std::path::PathBuf;

use clap::Args;
use inbye::map::UnknownPolicy;

use super::arguments::{length, whole};
use super::known_words;

/// `inbye playground`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye playground --port 8047\n  inbye playground --port 0 --map mine.yaml --json\n\n\
    The first line is the page's address, on this machine only. Drag the robot, the goal and what moves, or take their handles \
    with Tab and move them with the arrow keys; the browser takes the decision with the shaders of the GPU engine, and the page \
    tells whether its bits are those of the CPU engine. It needs WebGPU for that; without, it shows the CPU engine's answer.\n\
    POST /decision takes what `inbye evaluate` takes as problem.json, with a scene's name as map.file: at most 64 KiB, 524288 \
    samples, 32 moving obstacles. What is not answered gets a status of 4xx or 5xx and one line of JSON, `error`.\n\
    JSON fields: `url`, `port`, `scenes`. Ctrl-C ends it, with exit status 0."
)]
pub struct PlaygroundArguments {
    /// Port of the loopback to serve at; 0 takes any free one.
    #[arg(long, default_value_t = 0, allow_negative_numbers = true, value_parser = whole::<u16>(0, 65_535))]
    pub port: u16,
    #[arg(
        long,
        value_name = "FILE",
        help = "Map to play on instead of the built-in scenes: a ROS map_server .yaml, a MovingAI .map, or rows of text"
    )]
    pub map: Option<PathBuf>,
    /// Side of a cell of a .map or text map, metres.
    #[arg(long, default_value_t = 1.0, allow_negative_numbers = true, value_parser = length)]
    pub resolution: f64,
    /// What unknown ground counts as [default: the configuration's, blocked].
    #[arg(long, value_parser = known_words::unknown())]
    pub unknown: Option<UnknownPolicy>,
    /// Settings, TOML: the robot, and the sampling and weights to begin with.
    #[arg(long)]
    pub config: Option<PathBuf>,
}
