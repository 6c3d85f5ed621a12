//! Arguments of `inbye base`.

use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::{Args, Subcommand};
use inbye::base::{Protocol, ScheduledFault};
use inbye::runtime::hardware::SerialLine;

use super::arguments::{Place, duration, length, number, whole};
use super::{config, value_parsers};

/// Largest speed accepted, m/s and rad/s; the base's own limits apply in any case.
const MAX_SPEED: f64 = 100.0;

/// `inbye base`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  inbye base emulate --protocol native --for 1 --json\n\n\
    Run `inbye base emulate` in one terminal: it prints the path of a port. Then run `inbye base monitor --port PATH`, \
    `inbye base send --port PATH` or `inbye drive --port PATH` in another.")]
pub struct BaseArguments {
    /// The subcommand.
    #[command(subcommand)]
    pub command: BaseCommand,
}

/// Subcommands of `inbye base`.
#[derive(Debug, Subcommand)]
pub enum BaseCommand {
    /// Emulate a base: a lower controller with its machine on a pseudo-terminal.
    Emulate(EmulateArguments),
    /// Command a motion for a time, then stop the base.
    Send(SendArguments),
    /// Hold a base still and print its reports.
    Monitor(MonitorArguments),
}

/// Protocol and settings of a base.
#[derive(Debug, Args)]
pub struct KindArguments {
    /// Protocol.
    #[arg(long, value_name = "P", default_value = "native", value_parser = value_parsers::protocol())]
    pub protocol: Protocol,
    /// The base's settings, TOML with the tables [base], [supervisor] and [lidar].
    #[arg(long, value_name = "FILE.toml")]
    pub base_config: Option<PathBuf>,
}

/// `inbye base emulate`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye base emulate --protocol roboclaw --fault stuck-left@0.5 --for 1 --json\n\n\
    The first line is the path of the port for the host, or with --json an object with `port` and `protocol`. At the end \
    (Ctrl-C, SIGTERM or --for) follows a summary: `commands` (accepted), `final_zero_commands` (consecutive zero commands at \
    the end), `watchdog_stops`, `travelled_m`, `pose`, `linear`, `angular`.\n\
    With --lidar-map and --start the second line is the port of the lidar, `lidar` in the object, and `map_pose` in the summary \
    is the pose on the map.\n\
    Faults: stuck-left, stuck-right, runaway, reversed, button, silence, slow-reads, garbage, bit-flips; NAME@2 from 2 s on, \
    NAME@2..3.5 for 1.5 s. Unix only."
)]
pub struct EmulateArguments {
    #[command(flatten)]
    pub kind: KindArguments,
    /// A fault with its times in seconds; repeat --fault for each.
    #[arg(long, value_name = "NAME[@S[..S]]")]
    pub fault: Vec<ScheduledFault>,
    /// Also emulate an LD19 lidar, on its own port, in the world of this map.
    #[arg(long, value_name = "MAP")]
    pub lidar_map: Option<PathBuf>,
    /// Side of a cell of that map, if it is a .map or text map, metres.
    #[arg(long, default_value_t = 1.0, allow_negative_numbers = true, requires = "lidar_map", value_parser = length)]
    pub resolution: f64,
    /// Start pose on that map.
    #[arg(long, value_name = "X,Y[,YAW]", allow_hyphen_values = true, requires = "lidar_map")]
    pub start: Option<Place>,
    /// Unplug the lidar after this time, seconds.
    #[arg(long, value_name = "S", allow_negative_numbers = true, requires = "lidar_map", value_parser = duration)]
    pub lidar_until: Option<f64>,
    /// Seed of noise and faults.
    #[arg(long, default_value_t = 0, allow_negative_numbers = true, value_parser = whole::<u64>(0, u64::MAX))]
    pub seed: u64,
    /// End after this time, seconds [default: at Ctrl-C].
    #[arg(long = "for", value_name = "S", allow_negative_numbers = true, value_parser = duration)]
    pub for_s: Option<f64>,
}

/// Port, protocol and settings of a base.
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
    The motion is ramped up, sent 50 times per second, and ramped down at the end. The base is stopped, with the reason, when it \
    does not follow its commands: a track that is stuck, runs away or runs in reverse, slip, delayed commands, an emergency \
    stop, a fault. Ctrl-C, SIGTERM and an error end with three or more zero commands. After a SIGKILL only the base's own \
    watchdog acts, which WHEELTEC's published firmware does not have.\n\
    Exit status 1: the base was stopped, the connection was lost, or a signal came."
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
    /// Duration, seconds.
    #[arg(long = "for", value_name = "S", default_value_t = 1.0, allow_negative_numbers = true, value_parser = duration)]
    pub for_s: f64,
    /// Release a stop that is latched in the base first.
    #[arg(long)]
    pub release: bool,
}

/// `inbye base monitor`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye base monitor --port /dev/ttyUSB0 --protocol roboclaw --json\n\n\
    Prints ten lines per second; with --json each is an object. The base gets zero commands throughout: queries alone keep the \
    watchdog of some controllers from acting, so that they would follow their last command."
)]
pub struct MonitorArguments {
    #[command(flatten)]
    pub line: LineArguments,
    /// End after this time, seconds [default: at Ctrl-C].
    #[arg(long = "for", value_name = "S", allow_negative_numbers = true, value_parser = duration)]
    pub for_s: Option<f64>,
}

fn speed(text: &str) -> Result<f64, String> {
    let is_valid = |speed: f64| speed.abs() <= MAX_SPEED;
    number(text, is_valid, "m/s or rad/s, -100 to 100")
}

/// Time between polls of a supervisor.
pub const POLL_PERIOD: Duration = Duration::from_millis(20);

/// Returns the base that the arguments name.
pub fn line_of(arguments: &LineArguments) -> anyhow::Result<SerialLine> {
    let kind = &arguments.kind;
    load_line(&arguments.port, kind.protocol, kind.base_config.as_deref())
}

/// Returns a base with the settings of a file, or with the default ones.
pub fn load_line(
    port: &str,
    protocol: Protocol,
    file: Option<&Path>,
) -> anyhow::Result<SerialLine> {
    Ok(SerialLine {
        port: port.to_owned(),
        protocol,
        config: config::load_base("--base-config", file)?,
    })
}
