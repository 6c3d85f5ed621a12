//! What may be typed after `inbye base`.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use inbye::base::{Protocol, ScheduledFault};

use super::arguments::{Place, duration, length, number, whole};
use super::known_words;

/// Fastest that may be typed, m/s and rad/s; the base's own limits hold in any case.
const FASTEST: f64 = 100.0;

/// `inbye base`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye base emulate --protocol native --for 1 --json\n\n\
    In one terminal `inbye base emulate`, which prints the path of a port; in another `inbye base monitor --port PATH`, \
    `inbye base send --port PATH` or `inbye drive --port PATH`."
)]
pub struct BaseArguments {
    /// What to do.
    #[command(subcommand)]
    pub command: BaseCommand,
}

/// What can be done with a base.
#[derive(Debug, Subcommand)]
pub enum BaseCommand {
    /// Be a base: a virtual lower controller and its machine on a pseudo-terminal.
    Emulate(EmulateArguments),
    /// Tell a base one motion for a time, and stop it.
    Send(SendArguments),
    /// Hold a base still and tell what it reports.
    Monitor(MonitorArguments),
}

/// The language of a base, and what it is.
#[derive(Debug, Args)]
pub struct KindArguments {
    /// Protocol.
    #[arg(long, value_name = "P", default_value = "native", value_parser = known_words::protocol())]
    pub protocol: Protocol,
    /// The base's settings, TOML with the tables [base], [supervisor] and [lidar].
    #[arg(long, value_name = "FILE.toml")]
    pub base_config: Option<PathBuf>,
}

/// `inbye base emulate`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye base emulate --protocol roboclaw --fault stuck-left@0.5 --for 1 --json\n\n\
    The first line is the path of the port that a host opens, or with --json an object with `port` and `protocol`. At the end, \
    by Ctrl-C, SIGTERM or --for, a summary: `frames` (commands accepted), `final_zero_commands` (how many of them, the last in a row, \
    were to stand), `watchdog_stops`, `distance_m`, `pose`, `linear`, `angular`.\n\
    With --lidar-map and --start the second line is the port of its lidar, `lidar` in the object, and `place` in the summary is where \
    it stands on the map.\n\
    Faults: stuck-left, stuck-right, runaway, reversed, button, silence, slow-reads, garbage, bit-flips; NAME@2 from 2 s on, \
    NAME@2..3.5 for 1.5 s. Unix only."
)]
pub struct EmulateArguments {
    #[command(flatten)]
    pub kind: KindArguments,
    /// Something that goes wrong, at its time in seconds; give one --fault for each.
    #[arg(long, value_name = "NAME[@S[..S]]")]
    pub fault: Vec<ScheduledFault>,
    /// Be a whole robot: an LD19 as well, on a port of its own, in the world of this map.
    #[arg(long, value_name = "MAP")]
    pub lidar_map: Option<PathBuf>,
    /// Side of a cell of that map, if it is a .map or text map, metres.
    #[arg(long, default_value_t = 1.0, allow_negative_numbers = true, requires = "lidar_map", value_parser = length)]
    pub resolution: f64,
    /// Where in that world it stands in the beginning.
    #[arg(
        long,
        value_name = "X,Y[,YAW]",
        allow_hyphen_values = true,
        requires = "lidar_map"
    )]
    pub start: Option<Place>,
    /// Unplug the lidar after so long, seconds.
    #[arg(long, value_name = "S", allow_negative_numbers = true, requires = "lidar_map", value_parser = duration)]
    pub lidar_until: Option<f64>,
    /// Seed of noise and faults.
    #[arg(long, default_value_t = 0, allow_negative_numbers = true, value_parser = whole::<u64>(0, u64::MAX))]
    pub seed: u64,
    /// End after so long, seconds [default: at Ctrl-C].
    #[arg(long = "for", value_name = "S", allow_negative_numbers = true, value_parser = duration)]
    pub for_s: Option<f64>,
}

/// Which base, and on which line.
#[derive(Debug, Args)]
pub struct LineArguments {
    /// The port, such as /dev/ttyUSB0 or COM3.
    #[arg(long, value_name = "P")]
    pub port: String,
    #[command(flatten)]
    pub kind: KindArguments,
}

/// `inbye base send`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye base send --port /dev/ttyUSB0 --protocol wheeltec --linear 0.2 --for 2\n\n\
    The motion is ramped up, sent 50 times a second, and ramped down at the end. The base is stopped, and the reason told, when \
    it does not do what it is told: a track that is stuck, runs away or runs the wrong way, slip, commands \
    that are obeyed late, an emergency stop, a fault. \
    Ctrl-C, SIGTERM and an error end with three or more commands of zero; after a SIGKILL only the base's own watchdog helps, which \
    WHEELTEC's published firmware does not have.\n\
    Exit status 1: the base was stopped, the line was lost, or a signal came."
)]
pub struct SendArguments {
    #[command(flatten)]
    pub line: LineArguments,
    /// Forward speed, m/s.
    #[arg(long, default_value_t = 0.0, value_name = "V", allow_negative_numbers = true, value_parser = speed)]
    pub linear: f64,
    /// Turn rate, rad/s, counter-clockwise.
    #[arg(long, default_value_t = 0.0, value_name = "W", allow_negative_numbers = true, value_parser = speed)]
    pub angular: f64,
    /// For how long, seconds.
    #[arg(long = "for", value_name = "S", default_value_t = 1.0, allow_negative_numbers = true, value_parser = duration)]
    pub for_s: f64,
    /// First end a stop that is latched in the base.
    #[arg(long)]
    pub release: bool,
}

/// `inbye base monitor`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye base monitor --port /dev/ttyUSB0 --protocol roboclaw --json\n\n\
    Ten lines a second; with --json each is an object. The base is told to stand all the while: some controllers take questions \
    for a sign of life, and would go on with what they were told before."
)]
pub struct MonitorArguments {
    #[command(flatten)]
    pub line: LineArguments,
    /// End after so long, seconds [default: at Ctrl-C].
    #[arg(long = "for", value_name = "S", allow_negative_numbers = true, value_parser = duration)]
    pub for_s: Option<f64>,
}

fn speed(text: &str) -> Result<f64, String> {
    let fits = |speed: f64| speed.abs() <= FASTEST;
    number(text, fits, "m/s or rad/s, -100 to 100")
}
