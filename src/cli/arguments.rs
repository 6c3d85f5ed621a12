//! Arguments that several commands share, and those of the planner.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use inbye::geometry::{Point, Pose};
use inbye::local::EngineChoice;
use inbye::map::UnknownPolicy;

use super::value_parsers;

/// The map and its settings.
#[derive(Debug, Args)]
pub struct MapArguments {
    #[arg(
        long,
        help = "Map: a ROS map_server .yaml, a MovingAI .map, or rows of text (# wall, . free, ? unknown)"
    )]
    pub map: PathBuf,
    /// Side of a cell of a .map or text map, metres.
    #[arg(long, default_value_t = 1.0, allow_negative_numbers = true, value_parser = length)]
    pub resolution: f64,
    /// How unknown cells count [default: the configuration's, blocked].
    #[arg(long, value_parser = value_parsers::unknown())]
    pub unknown: Option<UnknownPolicy>,
    /// Settings, TOML.
    #[arg(long)]
    pub config: Option<PathBuf>,
}

/// `inbye plan`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  inbye plan --map mine.yaml --start 10,5 --goal 80,40\n  \
    inbye plan --map mine.yaml --start 10,5 --via 20,30 --via 60,50 --goal 80,40 --png tour.png\n\n\
    With --via all figures are those of the whole path, and `legs` has those of each leg. If the goal cannot be reached, \
    `nearest_reachable` is the reachable point nearest to it; --svg and --png show it.\n\
    `curvature` compares the smoothed path with the robot's limits: the share of the path that the base can follow at max_vel_x, \
    and its highest speed in the tightest bend; 0 if it must turn in place.")]
pub struct PlanArguments {
    #[command(flatten)]
    pub map: MapArguments,
    /// Start, metres (and radians).
    #[arg(long, value_name = "X,Y[,YAW]", allow_hyphen_values = true)]
    pub start: Place,
    /// Goal, metres.
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true)]
    pub goal: Place,
    /// An intermediate stop, metres; repeat --via for each stop in the order of the visit.
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true)]
    pub via: Vec<Place>,
    /// Distance to keep from every obstacle, metres [default: the robot's circle and margins].
    #[arg(long, allow_negative_numbers = true, value_parser = distance)]
    pub radius: Option<f64>,
    /// Draw the map with the plan into this file.
    #[arg(long, value_name = "FILE.svg")]
    pub svg: Option<PathBuf>,
    /// The same picture as pixels, 1440 wide.
    #[arg(long, value_name = "FILE.png")]
    pub png: Option<PathBuf>,
}

/// `inbye drive`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye drive --map mine.yaml --start 10,5 --goal 80,40 --obstacles 5 \
    --seed 7 --report out\n  inbye drive --map mine.yaml --start 10,5 --goal 80,40 --record run.mcap\n\n\
    With --port the base is a real or emulated one on a serial line, in real time. With --lidar nothing is simulated: the pose \
    comes from the scans of an LD19 on the map. The robot stands while it is not localized or its lidar is silent, and gives up \
    with the reason if that lasts (exit status 1). Without --lidar the world and the lidar are simulated, and the pose is the \
    base's odometry. The base is stopped when it gets no command for 0.3 s, when it does not follow its commands, and at the \
    end in any case: `inbye base send --help`."
)]
pub struct DriveArguments {
    #[command(flatten)]
    pub map: MapArguments,
    /// Start, metres and radians; the default yaw is 0.
    #[arg(long, value_name = "X,Y[,YAW]", allow_hyphen_values = true)]
    pub start: Place,
    /// Goal, metres, and optionally the final yaw, radians.
    #[arg(long, value_name = "X,Y[,YAW]", allow_hyphen_values = true)]
    pub goal: Place,
    /// An intermediate stop, metres, and optionally its yaw, radians; repeat --via for each stop in order.
    #[arg(long, value_name = "X,Y[,YAW]", allow_hyphen_values = true)]
    pub via: Vec<Place>,
    /// Number of pedestrians, or a JSON or TOML file of moving obstacles.
    #[arg(long, default_value = "0", value_name = "N or FILE", allow_negative_numbers = true)]
    pub obstacles: Obstacles,
    /// Seed of pedestrians and lidar noise.
    #[arg(long, default_value_t = 0, allow_negative_numbers = true, value_parser = whole::<u64>(0, u64::MAX))]
    pub seed: u64,
    /// Engine, or gpu:NAME for an adapter whose name contains NAME.
    #[arg(long, default_value = "auto", value_parser = value_parsers::engine())]
    pub engine: EngineChoice,
    /// Fail without a GPU; a software adapter counts if --engine names it. If the GPU is lost during the drive, the CPU takes over
    /// and the loss is counted.
    #[arg(long)]
    pub require_gpu: bool,
    /// CPU threads [default: all cores].
    #[arg(long, allow_negative_numbers = true, value_parser = whole::<usize>(1, 1024))]
    pub threads: Option<usize>,
    /// Deadline of a decision by the wall clock, milliseconds. A late decision is replaced by the last command, which decays with
    /// its age, and repeated misses reduce the sampling. Such a run is not repeatable. Waiting for plans counts, unless the
    /// settings have `wait_for_plans = false` [default: the configuration's `deadline_s`, none].
    #[arg(long, value_name = "MS", allow_negative_numbers = true, value_parser = milliseconds)]
    pub deadline: Option<f64>,
    /// Time limit of the drive, seconds of simulated time.
    #[arg(long, default_value_t = 3600.0, allow_negative_numbers = true, value_parser = duration)]
    pub time_limit: f64,
    /// Write a report page into this folder.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// Record the drive in this file: as ROS 2 messages for Foxglove, `ros2 bag` and `inbye replay` if its name ends in .mcap,
    /// else every tick as a line of JSON. A full disk stops the recording, never the drive: then the exit status is 1, and
    /// `recording.stopped` gives the reason.
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    #[command(flatten)]
    pub hardware: super::hardware_drive::HardwareArguments,
}

/// `inbye evaluate`.
#[derive(Debug, Args)]
#[command(after_help = super::problem_file::HELP)]
pub struct EvaluateArguments {
    /// The problem, JSON.
    #[arg(long, value_name = "FILE.json")]
    pub problem: PathBuf,
    /// Engine, or gpu:NAME for an adapter whose name contains NAME.
    #[arg(long, default_value = "auto", value_parser = value_parsers::engine())]
    pub engine: EngineChoice,
    /// Also return every sample, in SI units.
    #[arg(long)]
    pub samples: bool,
}

/// `inbye verify`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  inbye verify --cases 500 --seed 1 --json")]
pub struct VerifyArguments {
    /// Number of random problems.
    #[arg(long, default_value_t = 200, allow_negative_numbers = true, value_parser = whole::<u64>(1, u64::MAX))]
    pub cases: u64,
    /// Seed of the problems.
    #[arg(long, default_value_t = 1, allow_negative_numbers = true, value_parser = whole::<u64>(0, u64::MAX))]
    pub seed: u64,
}

/// `inbye bench density`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye bench density --max-samples 16384 --seconds 0.1 --ticks 10 --missions 0 --chart density.svg\n\n\
    Latency is that of a decision from end to end; the engines' answers are compared bit for bit first. An engine that is too slow \
    for a density is skipped there, and listed.\n\
    Quality: the regret is the loss of score against the densest sampling (1,048,576 samples, or --max-samples if larger), as a \
    share of the best sample's gain over the mean admissible one. It is measured with windows of 0.1 s and 1 s, with as many \
    forward speeds as turn rates and with a quarter as many.\n\
    Closed loop: the same random missions of at most 30 m on built-in maps with 64, 256... samples, up to 16,384 or \
    --max-samples. The tick time is that of the whole navigator (scan, local field and decision) on one core; the 99th \
    percentile includes waiting for new paths."
)]
pub struct DensityArguments {
    /// Steps of the horizon.
    #[arg(long, default_value_t = 40, allow_negative_numbers = true, value_parser = whole::<u32>(1, 1023))]
    pub steps: u32,
    /// Smallest number of samples; the others are 4, 16, 64... times this number.
    #[arg(long, default_value_t = 256, allow_negative_numbers = true, value_parser = whole::<usize>(1, 4_194_304))]
    pub min_samples: usize,
    /// Largest number of samples.
    #[arg(long, default_value_t = 1_048_576, allow_negative_numbers = true, value_parser = whole::<usize>(1, 4_194_304))]
    pub max_samples: usize,
    /// Measuring time per engine and density, seconds; slow engines take up to 20 times as long.
    #[arg(long, default_value_t = 0.5, allow_negative_numbers = true, value_parser = duration)]
    pub seconds: f64,
    /// Decisions whose commands are compared with those of the densest sampling; 0 skips the comparison.
    #[arg(long, default_value_t = 100, allow_negative_numbers = true, value_parser = whole::<usize>(0, 100))]
    pub ticks: usize,
    /// Random missions driven with each sampling, one after the other on one core; 0 skips them.
    #[arg(long, default_value_t = 12, allow_negative_numbers = true, value_parser = whole::<usize>(0, 100_000))]
    pub missions: usize,
    /// Write the latency rows into this file, CSV or JSON by its extension.
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Write the regret rows into this file, CSV or JSON by its extension.
    #[arg(long, value_name = "FILE")]
    pub record_quality: Option<PathBuf>,
    /// Write a row for each mission and sampling into this file, CSV or JSON by its ending.
    #[arg(long, value_name = "FILE")]
    pub record_missions: Option<PathBuf>,
    /// Draw latency, regret, and closed-loop success and time over the number of samples into this file.
    #[arg(long, value_name = "FILE.svg")]
    pub chart: Option<PathBuf>,
    /// Write `index.html` into this folder, with each chart as SVG and its rows as CSV and JSON.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
}

/// `inbye bench movingai`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye bench movingai --map mine.map --scen mine.map.scen --longest 100\n  \
    inbye bench movingai --folder maps --all --passes 3 --json\n\n\
    Every path is checked on the map alone: moves to the eight neighbours, no corner cutting, and its length against the listed one. \
    Exit status 1: a path of an exact algorithm is not the shortest, or a path is missing, illegal or shorter than listed."
)]
pub struct MovingAiArguments {
    /// The map, MovingAI .map.
    #[arg(long, value_name = "M.map", requires = "scen", required_unless_present = "folder")]
    pub map: Option<PathBuf>,
    /// The map's scenarios.
    #[arg(long, value_name = "M.map.scen", requires = "map")]
    pub scen: Option<PathBuf>,
    /// Instead of a map: all maps in this folder and its subfolders that have scenarios, as X.map.scen or X.scen.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["map", "scen"])]
    pub folder: Option<PathBuf>,
    /// Run every algorithm, including the slow and the greedy ones.
    #[arg(long)]
    pub all: bool,
    /// Number of scenarios of each map, those of the greatest listed length [default: all].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole::<usize>(1, 1_000_000_000))]
    pub longest: Option<usize>,
    /// Passes over the scenarios; the time of a query is its shortest.
    #[arg(long, default_value_t = 1, allow_negative_numbers = true, value_parser = whole::<usize>(1, 1000))]
    pub passes: usize,
    /// Write a row for each map and algorithm into this file, CSV or JSON by its extension.
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
}

/// Largest coordinate, metres.
const MAX_COORDINATE: f64 = 1e9;

/// A position with an optional yaw: two or three numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Position, metres.
    pub position: Point,
    /// Yaw, radians.
    pub yaw: Option<f64>,
}

impl Place {
    /// Converts to a pose; the default yaw is 0.
    pub fn pose(&self) -> Pose {
        Pose::new(self.position.x, self.position.y, self.yaw.unwrap_or(0.0))
    }
}

/// Most obstacles of a decision.
const MAX_OBSTACLES: u64 = 1024;

/// Moving obstacles: a number of pedestrians, or a file.
#[derive(Clone, Debug, PartialEq)]
pub enum Obstacles {
    /// Number of pedestrians.
    Count(usize),
    /// A JSON or TOML file.
    File(PathBuf),
}

impl FromStr for Obstacles {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.parse::<f64>().is_err() {
            return Ok(Self::File(text.into()));
        }
        whole(0, MAX_OBSTACLES)(text)
            .map(Self::Count)
            .map_err(|expected| format!("{expected}, or the name of a JSON or TOML file"))
    }
}

impl FromStr for Place {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let error = || {
            format!(
                "`{text}` is not a position: write X,Y or X,Y,YAW in metres and radians, such as 2.5,-1,0"
            )
        };
        let numbers = text
            .split(',')
            .map(|part| {
                part.trim().parse::<f64>().ok().filter(|number| number.abs() <= MAX_COORDINATE)
            })
            .collect::<Option<Vec<f64>>>()
            .ok_or_else(error)?;
        match numbers[..] {
            [x, y] => Ok(Self { position: Point::new(x, y), yaw: None }),
            [x, y, yaw] => Ok(Self { position: Point::new(x, y), yaw: Some(yaw) }),
            _ => Err(error()),
        }
    }
}

pub(super) fn whole<T>(
    min: u64,
    max: u64,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync
where
    T: TryFrom<u64>,
{
    move |text| {
        let number: Option<u64> = text.parse().ok();
        number
            .filter(|number| (min..=max).contains(number))
            .and_then(|number| T::try_from(number).ok())
            .ok_or_else(|| format!("it must be a whole number, {min} to {max}"))
    }
}

pub(super) fn length(text: &str) -> Result<f64, String> {
    let is_valid = |metres: f64| metres > 0.0 && metres <= MAX_COORDINATE;
    number(text, is_valid, "metres, above zero and at most 1e9")
}

fn distance(text: &str) -> Result<f64, String> {
    let is_valid = |metres: f64| (0.0..=MAX_COORDINATE).contains(&metres);
    number(text, is_valid, "metres, 0 to 1e9")
}

pub(super) fn duration(text: &str) -> Result<f64, String> {
    let is_valid = |seconds: f64| seconds > 0.0 && seconds <= 1e9;
    number(text, is_valid, "seconds, above zero and at most 1e9")
}

fn milliseconds(text: &str) -> Result<f64, String> {
    let is_valid = |milliseconds: f64| milliseconds > 0.0 && milliseconds <= 1e6;
    number(text, is_valid, "milliseconds, above zero and at most 1e6")
}

pub(super) fn number(
    text: &str,
    is_valid: impl Fn(f64) -> bool,
    expected: &str,
) -> Result<f64, String> {
    match text.parse() {
        Ok(number) if is_valid(number) => Ok(number),
        _ => Err(format!("it must be a number of {expected}")),
    }
}
