//! What may be typed.

use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, Parser, Subcommand};
use inbye::geometry::{Point, Pose};
use inbye::local::EngineChoice;
use inbye::map::UnknownPolicy;

use super::known_words;
use super::verbosity::Verbosity;

/// Flags that every command has.
pub(super) const EVERYWHERE: &str = "Everywhere";

/// Exact GPU-parallel local planning and hybrid navigation for inspection robots.
///
/// With no command it runs its main job on built-in scenes: plan, drive among moving people, compare all engines of
/// this machine, measure them, and write a report.
#[derive(Debug, Parser)]
#[command(version, about, long_about, max_term_width = 100)]
#[command(
    after_help = "Example:\n  inbye                       run the main job, write inbye-report/index.html\n  \
    inbye plan --map mine.yaml --start 10,5 --goal 80,40 --json\n\n\
    Exit status: 0 done; 1 it ran and the answer is no; 2 unusable input.\n\
    Colours are for terminals; NO_COLOR=1 leaves them out there as well. `inbye man` and `inbye completions` are for your system."
)]
pub struct Arguments {
    /// Print one JSON object on standard output instead of text.
    #[arg(long, global = true, help_heading = EVERYWHERE)]
    pub json: bool,
    #[command(flatten)]
    pub verbosity: Verbosity,
    /// Folder for the main job's report [default: inbye-report].
    #[arg(long)]
    pub report: Option<PathBuf>,
    /// The command.
    #[command(subcommand)]
    pub command: Option<Command>,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Find a global path on a map.
    Plan(PlanArguments),
    /// Drive to a goal in a closed loop, simulated; with --port on a real base.
    Drive(DriveArguments),
    /// Decide again on what was recorded, and compare all bits.
    Replay(super::replay::ReplayArguments),
    /// Take one decision of the dynamic window approach and explain it.
    Evaluate(EvaluateArguments),
    /// Put random problems to every engine here and compare all bits.
    Verify(VerifyArguments),
    /// List adapters and CPU features.
    #[command(after_help = "Example:\n  inbye devices --json")]
    Devices,
    /// Print every setting with its default, check a file of them, or take over Nav2's.
    Config(super::config_arguments::ConfigArguments),
    /// Measure.
    Bench(BenchArguments),
    /// Run a plan of many cells: worlds, settings, samplings, engines, seeds; go on after any interruption; merge.
    Sweep(super::sweep::SweepArguments),
    /// A base on a serial line: emulate one, tell one, watch one.
    Base(super::base_arguments::BaseArguments),
    /// Drive a robot among ROS 2 nodes: map, scan, odometry and goal in, velocity out.
    Node(super::node::NodeArguments),
    /// Drag robot, goal and obstacles in a browser, which decides with the same shaders.
    Playground(super::playground::PlaygroundArguments),
    /// Print the completions of a shell.
    Completions(super::completions::CompletionsArguments),
    /// Print the manual page, or write those of all commands.
    Man(super::man::ManArguments),
}

/// Which map, and how to read it.
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
    /// What unknown ground counts as [default: the configuration's, blocked].
    #[arg(long, value_parser = known_words::unknown())]
    pub unknown: Option<UnknownPolicy>,
    /// Settings, TOML.
    #[arg(long)]
    pub config: Option<PathBuf>,
}

/// `inbye plan`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye plan --map mine.yaml --start 10,5 --goal 80,40\n  \
    inbye plan --map mine.yaml --start 10,5 --via 20,30 --via 60,50 --goal 80,40 --png tour.png\n\n\
    With stops, all figures are those of the whole tour, and `legs` tells them for each leg. Where a goal is walled off, \
    `nearest_reachable` is the point nearest to it that can be reached; --svg and --png show it.\n\
    `curvature` holds the smoothed path against the robot's limits: what share of it the base can follow at max_vel_x, \
    and how slowly it must take the tightest bend; 0 where it must turn in place."
)]
pub struct PlanArguments {
    #[command(flatten)]
    pub map: MapArguments,
    /// Start, metres (and radians).
    #[arg(long, value_name = "X,Y[,YAW]", allow_hyphen_values = true)]
    pub start: Place,
    /// Goal, metres.
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true)]
    pub goal: Place,
    /// A stop on the way, metres; give one --via for each, in the order in which they are visited.
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true)]
    pub via: Vec<Place>,
    /// Distance to keep from every obstacle, metres [default: the robot's circle and margins].
    #[arg(long, allow_negative_numbers = true, value_parser = distance)]
    pub radius: Option<f64>,
    /// Draw the map and the plan on it into this file, to open in a browser.
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
    With --port the base is a real or an emulated one on a serial line, and time is real. With --lidar as well nothing is \
    simulated: the robot is where the scans of its LD19 put it on the map, it stands while it does not know where that is or \
    its lidar is silent, and gives up with the reason when that lasts (exit status 1). Without, world and lidar are simulated, \
    and the robot is where the base reports to have come. It is stopped when no plan comes for 0.3 s, when it does not do what it \
    is told, and at the end however that comes: `inbye base send --help`."
)]
pub struct DriveArguments {
    #[command(flatten)]
    pub map: MapArguments,
    /// Start, metres and radians; the yaw is 0 when left out.
    #[arg(long, value_name = "X,Y[,YAW]", allow_hyphen_values = true)]
    pub start: Place,
    /// Goal, metres, and the yaw to park with where one is given.
    #[arg(long, value_name = "X,Y[,YAW]", allow_hyphen_values = true)]
    pub goal: Place,
    /// A stop on the way, metres, and the yaw to stand there with where one is given; give one --via for each, in order.
    #[arg(long, value_name = "X,Y[,YAW]", allow_hyphen_values = true)]
    pub via: Vec<Place>,
    /// How many people walk the drifts, or a JSON or TOML file of moving obstacles: walkers, wanderers, scripts.
    #[arg(
        long,
        default_value = "0",
        value_name = "N or FILE",
        allow_negative_numbers = true
    )]
    pub obstacles: Obstacles,
    /// Seed of people and lidar noise.
    #[arg(long, default_value_t = 0, allow_negative_numbers = true, value_parser = whole::<u64>(0, u64::MAX))]
    pub seed: u64,
    /// Engine, or gpu:NAME for an adapter whose name contains NAME.
    #[arg(long, default_value = "auto", value_parser = known_words::engine())]
    pub engine: EngineChoice,
    /// Refuse to start without a GPU; a software adapter counts when --engine names it. One that is lost on the way is
    /// survived all the same, and counted.
    #[arg(long)]
    pub require_gpu: bool,
    /// CPU threads [default: all cores].
    #[arg(long, allow_negative_numbers = true, value_parser = whole::<usize>(1, 1024))]
    pub threads: Option<usize>,
    /// What a decision may take by the wall clock, milliseconds; in place of a later one the last command is sent, fading
    /// with its age, and sampling is lowered where that repeats. Such a run is not the same at each repetition. Waiting for
    /// plans counts, unless the settings have `wait_for_plans = false` [default: the configuration's `deadline_s`, none].
    #[arg(long, value_name = "MS", allow_negative_numbers = true, value_parser = milliseconds)]
    pub deadline: Option<f64>,
    /// Simulated time after which the run ends, seconds.
    #[arg(long, default_value_t = 3600.0, allow_negative_numbers = true, value_parser = duration)]
    pub time_limit: f64,
    /// Write a report page into this folder.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// Record the drive in this file: a name that ends in .mcap gets ROS 2 messages, for Foxglove, `ros2 bag` and `inbye
    /// replay`; any other gets every tick as a line of JSON. A full disk stops the recording, never the drive: then the
    /// exit status is 1, and `recording.stopped` says why.
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    #[command(flatten)]
    pub wired: super::wired_drive::WiredArguments,
}

/// `inbye evaluate`.
#[derive(Debug, Args)]
#[command(after_help = super::problem_file::HELP)]
pub struct EvaluateArguments {
    /// The problem, JSON.
    #[arg(long, value_name = "FILE.json")]
    pub problem: PathBuf,
    /// Engine, or gpu:NAME for an adapter whose name contains NAME.
    #[arg(long, default_value = "auto", value_parser = known_words::engine())]
    pub engine: EngineChoice,
    /// Return every sample as well, in SI units.
    #[arg(long)]
    pub samples: bool,
}

/// `inbye verify`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  inbye verify --cases 500 --seed 1 --json")]
pub struct VerifyArguments {
    /// Random problems.
    #[arg(long, default_value_t = 200, allow_negative_numbers = true, value_parser = whole::<u64>(1, u64::MAX))]
    pub cases: u64,
    /// Seed of the problems.
    #[arg(long, default_value_t = 1, allow_negative_numbers = true, value_parser = whole::<u64>(0, u64::MAX))]
    pub seed: u64,
}

/// `inbye bench`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye bench density --max-samples 4096 --seconds 0.1 --ticks 5 --missions 0 --json"
)]
pub struct BenchArguments {
    /// What to measure.
    #[command(subcommand)]
    pub command: BenchCommand,
}

/// The benchmarks.
#[derive(Debug, Subcommand)]
pub enum BenchCommand {
    /// What each part of the navigator buys: the same random missions with one part more each time.
    Ablation(super::ablation::AblationArguments),
    /// Closed loop over the worlds of the BARN benchmark, by its rules.
    Barn(super::barn::BarnArguments),
    /// Sampling density against latency and quality, on every engine here.
    Density(DensityArguments),
    /// Draw records again without measuring: a picture, a page.
    Draw(super::draw::DrawArguments),
    /// Closed loop over the worlds of the DynaBARN benchmark: cylinders that move and take no notice of the robot.
    Dynabarn(super::dynabarn::DynaBarnArguments),
    /// The pose from slipping odometry and scans matched to the map, against the truth: tours, and robots that are lost.
    Localization(super::localization::LocalizationArguments),
    /// Grid search against the published optimal lengths of the MovingAI benchmark.
    Movingai(MovingAiArguments),
    /// The paper's tables and figures, paths and drives, repeated beside its printed values.
    Paper(super::paper::PaperArguments),
    /// Random missions on many maps among moving obstacles: contacts, reasons, and the same traces on every engine.
    Soak(super::soak::SoakArguments),
}

/// `inbye bench density`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye bench density --max-samples 16384 --seconds 0.1 --ticks 10 --missions 0 --chart density.svg\n\n\
    Latency is that of a decision from end to end; the engines' answers are compared bit for bit first. An engine too slow for a density is left out there, and that is said.\n\
    Then the commands: regret is what is lost against the densest sampling (1,048,576 samples, or --max-samples where \
    that is more), as a share of what the best sample gains there over the mean admissible one. It is taken in \
    windows of 0.1 s and 1 s, with as many forward speeds as turn rates and with a quarter as many.\n\
    Last, closed_loop: the same random missions of at most 30 m on built-in maps with 64, 256... samples, at most 16,384 and \
    --max-samples. The time of a tick there is that of the whole navigator, scan, local field and decision, on one core; \
    the 99th percentile includes waiting for new paths."
)]
pub struct DensityArguments {
    /// Steps of the horizon.
    #[arg(long, default_value_t = 40, allow_negative_numbers = true, value_parser = whole::<u32>(1, 1023))]
    pub steps: u32,
    /// Smallest number of samples; the others are 4, 16, 64... times as many.
    #[arg(long, default_value_t = 256, allow_negative_numbers = true, value_parser = whole::<usize>(1, 4_194_304))]
    pub min_samples: usize,
    /// Largest number of samples.
    #[arg(long, default_value_t = 1_048_576, allow_negative_numbers = true, value_parser = whole::<usize>(1, 4_194_304))]
    pub max_samples: usize,
    /// Seconds to measure each engine at each density; slow ones take up to 20 times as long.
    #[arg(long, default_value_t = 0.5, allow_negative_numbers = true, value_parser = duration)]
    pub seconds: f64,
    /// Decisions in which commands are compared with those of the densest sampling; 0 leaves that out.
    #[arg(long, default_value_t = 100, allow_negative_numbers = true, value_parser = whole::<usize>(0, 100))]
    pub ticks: usize,
    /// Random missions driven with each of several samplings, one after the other on one core; 0 leaves that out.
    #[arg(long, default_value_t = 12, allow_negative_numbers = true, value_parser = whole::<usize>(0, 100_000))]
    pub missions: usize,
    /// Write the rows of latencies into this file, CSV or JSON by its ending.
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Write the rows of regrets into this file, CSV or JSON by its ending.
    #[arg(long, value_name = "FILE")]
    pub record_quality: Option<PathBuf>,
    /// Keep a row for each mission and sampling in this file, and go on where it ends.
    #[arg(long, value_name = "FILE.csv")]
    pub record_missions: Option<PathBuf>,
    /// Draw latency, regret, and success and time in closed loop over the number of samples into this file.
    #[arg(long, value_name = "FILE.svg")]
    pub chart: Option<PathBuf>,
    /// Write `index.html` into this folder, and beside it each chart as SVG and its rows as CSV and JSON.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
}

/// `inbye bench movingai`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye bench movingai --map mine.map --scen mine.map.scen --longest 100\n  \
    inbye bench movingai --folder maps --all --passes 3 --json\n\n\
    Every path is judged from the map alone: moves to the eight neighbours, no corner cut, its length beside the one listed. \
    Exit status 1: an exact algorithm has a path that is not the shortest, or any has none, or one that may not be \
    walked or is shorter than listed."
)]
pub struct MovingAiArguments {
    /// The map, MovingAI .map.
    #[arg(
        long,
        value_name = "M.map",
        requires = "scen",
        required_unless_present = "folder"
    )]
    pub map: Option<PathBuf>,
    /// Its scenarios.
    #[arg(long, value_name = "M.map.scen", requires = "map")]
    pub scen: Option<PathBuf>,
    /// In place of a map: all maps in this folder and below that have scenarios beside them, as X.map.scen or X.scen.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["map", "scen"])]
    pub folder: Option<PathBuf>,
    /// Run every algorithm, also the slow and the greedy ones.
    #[arg(long)]
    pub all: bool,
    /// Only so many scenarios of each map, those of the greatest listed length [default: all].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole::<usize>(1, 1_000_000_000))]
    pub longest: Option<usize>,
    /// Passes over the scenarios: the time of a query is its least.
    #[arg(long, default_value_t = 1, allow_negative_numbers = true, value_parser = whole::<usize>(1, 1000))]
    pub passes: usize,
    /// Write a row for each map and algorithm into this file, CSV or JSON by its ending.
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
}

/// No map reaches further, metres.
const FARTHEST: f64 = 1e9;

/// A place as typed: two or three numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Position, metres.
    pub position: Point,
    /// Yaw, radians.
    pub yaw: Option<f64>,
}

impl Place {
    /// As a pose; without a yaw, facing along x.
    pub fn pose(&self) -> Pose {
        Pose::new(self.position.x, self.position.y, self.yaw.unwrap_or(0.0))
    }
}

/// No decision minds more.
const MOST_OBSTACLES: u64 = 1024;

/// People to meet: so many, or those of a file.
#[derive(Clone, Debug, PartialEq)]
pub enum Obstacles {
    /// So many.
    Count(usize),
    /// Those of a file.
    File(PathBuf),
}

impl FromStr for Obstacles {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.parse::<f64>().is_err() {
            return Ok(Self::File(text.into()));
        }
        whole(0, MOST_OBSTACLES)(text)
            .map(Self::Count)
            .map_err(|expected| format!("{expected}, or the name of a JSON or TOML file"))
    }
}

impl FromStr for Place {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mend = || {
            format!(
                "`{text}` is no place: write X,Y or X,Y,YAW in metres and radians, such as 2.5,-1,0"
            )
        };
        let numbers = text
            .split(',')
            .map(|part| {
                part.trim()
                    .parse::<f64>()
                    .ok()
                    .filter(|number| number.abs() <= FARTHEST)
            })
            .collect::<Option<Vec<f64>>>()
            .ok_or_else(mend)?;
        match numbers[..] {
            [x, y] => Ok(Self {
                position: Point::new(x, y),
                yaw: None,
            }),
            [x, y, yaw] => Ok(Self {
                position: Point::new(x, y),
                yaw: Some(yaw),
            }),
            _ => Err(mend()),
        }
    }
}

pub(super) fn whole<T>(
    least: u64,
    most: u64,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync
where
    T: TryFrom<u64>,
{
    move |text| {
        let number: Option<u64> = text.parse().ok();
        number
            .filter(|number| (least..=most).contains(number))
            .and_then(|number| T::try_from(number).ok())
            .ok_or_else(|| format!("it must be a whole number, {least} to {most}"))
    }
}

pub(super) fn length(text: &str) -> Result<f64, String> {
    let fits = |metres: f64| metres > 0.0 && metres <= FARTHEST;
    number(text, fits, "metres, above zero and at most 1e9")
}

fn distance(text: &str) -> Result<f64, String> {
    let fits = |metres: f64| (0.0..=FARTHEST).contains(&metres);
    number(text, fits, "metres, 0 to 1e9")
}

pub(super) fn duration(text: &str) -> Result<f64, String> {
    let fits = |seconds: f64| seconds > 0.0 && seconds <= 1e9;
    number(text, fits, "seconds, above zero and at most 1e9")
}

fn milliseconds(text: &str) -> Result<f64, String> {
    let fits = |milliseconds: f64| milliseconds > 0.0 && milliseconds <= 1e6;
    number(text, fits, "milliseconds, above zero and at most 1e6")
}

pub(super) fn number(
    text: &str,
    fits: impl Fn(f64) -> bool,
    expected: &str,
) -> Result<f64, String> {
    match text.parse() {
        Ok(number) if fits(number) => Ok(number),
        _ => Err(format!("it must be a number of {expected}")),
    }
}
