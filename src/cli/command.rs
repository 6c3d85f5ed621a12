//! The commands of the program.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

use super::ablation::AblationArguments;
use super::arguments::{
    DensityArguments, DriveArguments, EvaluateArguments, MovingAiArguments, PlanArguments,
    VerifyArguments,
};
use super::barn::BarnArguments;
use super::base_arguments::BaseArguments;
use super::config_command::ConfigArguments;
use super::draw::DrawArguments;
use super::dynabarn::DynaBarnArguments;
use super::localization::LocalizationArguments;
use super::node::NodeArguments;
use super::paper::PaperArguments;
use super::playground::PlaygroundArguments;
use super::replay::ReplayArguments;
use super::shell_integration::{CompletionsArguments, ManArguments};
use super::soak::SoakArguments;
use super::sweep::SweepArguments;
use super::verbosity::{GLOBAL_OPTIONS, Verbosity};

/// Exact GPU-parallel local planning and hybrid navigation for inspection robots.
///
/// Without a command it runs a demo on built-in scenes: it plans, drives among pedestrians, compares and measures all engines of
/// this machine, and writes a report.
#[derive(Debug, Parser)]
#[command(version, about, long_about, max_term_width = 100)]
#[command(
    after_help = "Example:\n  inbye                       run the demo, write inbye-report/index.html\n  \
    inbye plan --map mine.yaml --start 10,5 --goal 80,40 --json\n\n\
    Exit status: 0 done; 1 it ran and the answer is no; 2 unusable input.\n\
    Output to a terminal is coloured unless NO_COLOR=1 is set. `inbye man` prints manual pages, `inbye completions` shell completions."
)]
pub struct Arguments {
    /// Print one JSON object on standard output instead of text.
    #[arg(long, global = true, help_heading = GLOBAL_OPTIONS)]
    pub json: bool,
    #[command(flatten)]
    pub verbosity: Verbosity,
    /// Folder for the demo's report [default: inbye-report].
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
    /// Drive to a goal in a closed loop: simulated, or with --port on a real base.
    Drive(DriveArguments),
    /// Repeat the decisions of a recording and compare all bits.
    Replay(ReplayArguments),
    /// Take one decision of the dynamic window approach and explain it.
    Evaluate(EvaluateArguments),
    /// Run random problems on every engine of this machine and compare all bits.
    Verify(VerifyArguments),
    /// List GPU adapters and CPU features.
    #[command(after_help = "Example:\n  inbye devices --json")]
    Devices,
    /// Print every setting with its default, check a configuration file, or import Nav2's.
    Config(ConfigArguments),
    /// Run benchmarks.
    Bench(BenchArguments),
    /// Run an experiment plan: worlds x settings x samplings x engines x seeds; resumes after an interruption; merges.
    Sweep(SweepArguments),
    /// A base on a serial line: emulate, command or monitor one.
    Base(BaseArguments),
    /// Run as a ROS 2 node: map, scan, odometry and goal in, velocity out.
    Node(NodeArguments),
    /// Move robot, goal and obstacles in a browser, which decides with the same shaders.
    Playground(PlaygroundArguments),
    /// Print the completion script of a shell.
    Completions(CompletionsArguments),
    /// Print the manual page, or write the pages of all commands.
    Man(ManArguments),
}

/// `inbye bench`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye bench density --max-samples 4096 --seconds 0.1 --ticks 5 --missions 0 --json"
)]
pub struct BenchArguments {
    /// The benchmark.
    #[command(subcommand)]
    pub command: BenchCommand,
}

/// The benchmarks.
#[derive(Debug, Subcommand)]
pub enum BenchCommand {
    /// The effect of each feature of the navigator: the same random missions with one feature more each time.
    Ablation(AblationArguments),
    /// Closed loop over the worlds of the BARN benchmark, by its rules.
    Barn(BarnArguments),
    /// Sampling density against latency and quality, on every engine of this machine.
    Density(DensityArguments),
    /// Draw records as a chart or a page, without measuring again.
    Draw(DrawArguments),
    /// Closed loop over the worlds of the DynaBARN benchmark: cylinders that move and ignore the robot.
    Dynabarn(DynaBarnArguments),
    /// Localization by slipping odometry and scan matching, against the true pose: tours, and relocalization.
    Localization(LocalizationArguments),
    /// Grid search against the published optimal lengths of the MovingAI benchmark.
    Movingai(MovingAiArguments),
    /// The paper's tables and figures, paths and drives, repeated and compared with its values.
    Paper(PaperArguments),
    /// Random missions on many maps among moving obstacles: contacts, causes, and equal traces on every engine.
    Soak(SoakArguments),
}
