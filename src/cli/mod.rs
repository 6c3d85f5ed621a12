//! The command line: the only module of the program that prints and opens files to write.

mod arguments;
mod base;
mod base_calibrate;
mod base_emulate;
mod child_process;
mod comparison;
mod config;
mod config_command;
mod demo;
mod density;
mod doctor;
mod draw;
mod drive;
mod drive_pictures;
mod drive_text;
#[cfg_attr(
    not(all(unix, feature = "serial")),
    expect(dead_code, reason = "only an emulated base has people")
)]
mod emulated_person;
#[cfg(all(unix, feature = "serial"))]
mod emulated_surroundings;
mod engine_selection;
mod error_text;
mod evaluate;
mod fault_matrix;
mod files;
mod hardware_drive;
mod invocation;
mod latency_lock;
mod localization;
mod log_file;
mod log_localization;
mod machine;
mod map_file;
mod map_log;
mod map_output;
mod missions;
mod movingai;
mod node;
mod operator;
mod operator_port;
mod output;
mod own_file;
mod own_programs;
mod paper;
mod perception;
mod plan;
mod plan_drawing;
mod plan_result;
mod playground;
mod problem_file;
mod protection;
#[cfg(all(unix, feature = "serial"))]
mod pseudo_terminal;
mod recording;
mod refusal;
mod replay;
mod result_store;
mod run_page;
mod runs;
mod serial_cases;
mod serial_faults;
mod serial_verdict;
mod shell_integration;
mod soak;
#[cfg(unix)]
mod stop_signals;
mod sweep;
mod sweep_merge;
mod tune;
mod verify;
mod vulkan_environment;
mod whole_file;
mod worlds;
mod zones;

use std::ffi::OsString;
use std::path::PathBuf;

pub use files::ReportFolder;
pub use invocation::Invocation;

use anyhow::ensure;
use base::BaseCommand;
use clap::{Args, Parser, Subcommand};
use inbye::runtime::hardware::HardwareError;
use output::OutputArguments;
#[cfg(unix)]
use stop_signals::OnStopSignal;

/// The error of commands whose output is no result.
const NO_JSON: &str = "--json: this command has no JSON output: leave the flag out";

/// Exact GPU-parallel local planning and hybrid navigation for inspection robots.
///
/// Without a command the program runs a demo on built-in scenes. It plans, drives among pedestrians, compares and measures all
/// engines of this machine, and writes a report.
#[derive(Debug, Parser)]
#[command(version, about, long_about, max_term_width = 100)]
#[command(
    after_help = "Example:\n  inbye                       run the demo, write inbye-report/index.html\n  \
    inbye drive --scene mine --report out\n\n\
    Exit status: 0 done; 1 the command ran and the answer is no; 2 unusable input.\n\
    Output to a terminal is coloured unless NO_COLOR=1 is set. `inbye man` prints manual pages, `inbye completions` shell completions."
)]
pub struct Arguments {
    #[command(flatten)]
    pub output: OutputArguments,
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
    Plan(plan::PlanArguments),
    /// Make a map from the log of a real robot: odometry and lidar scans.
    Map(map_log::MapLogArguments),
    /// Drive to a goal in a closed loop: simulated, or with --port on a real base.
    Drive(Box<drive::DriveArguments>),
    /// Repeat the decisions of a recording and compare all bits.
    Replay(replay::ReplayArguments),
    /// Take one decision of the dynamic window approach and explain it.
    Evaluate(evaluate::EvaluateArguments),
    /// Run random problems on every engine of this machine and compare all bits.
    Verify(verify::VerifyArguments),
    /// List GPU adapters and CPU features.
    #[command(after_help = "Example:\n  inbye devices --json")]
    Devices,
    /// Check this machine: GPU, serial ports, cores, and the engine and thread count to use.
    Doctor(doctor::DoctorArguments),
    /// Print all settings with their defaults, check a configuration file, or import a Nav2 parameter file.
    Config(config_command::ConfigArguments),
    /// Run benchmarks.
    Bench(BenchArguments),
    /// Run an experiment plan (worlds x settings x samplings x engines x seeds), resume it, or merge results.
    Sweep(sweep::SweepArguments),
    /// Search settings on some worlds, and judge the best ones on others.
    Tune(tune::TuneArguments),
    /// Emulate, command, monitor or calibrate a base on a serial line.
    Base(base::BaseArguments),
    /// Run as a ROS 2 node: map, scan, odometry and goal in, velocity out.
    Node(node::NodeArguments),
    /// Serve a page on which a browser evaluates decisions with the shaders of the GPU engine.
    Playground(playground::PlaygroundArguments),
    /// Print the completion script of a shell.
    Completions(shell_integration::CompletionsArguments),
    /// Print the manual page, or write the pages of all commands.
    Man(shell_integration::ManArguments),
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
    /// Measure the effect of each feature of the navigator: the same random missions with one more feature each time.
    Ablation(missions::AblationArguments),
    /// Drive the worlds of the BARN benchmark in a closed loop, by its rules.
    Barn(worlds::BarnArguments),
    /// Rank planners that drive the same worlds with the same seeds, and show which differences may be chance.
    Compare(comparison::CompareArguments),
    /// Measure latency and quality of decisions for each sampling density, on every engine of this machine.
    Density(density::DensityArguments),
    /// Draw records as a chart or a page, without measuring again.
    Draw(draw::DrawArguments),
    /// Drive the worlds of the DynaBARN benchmark in a closed loop: cylinders that move and ignore the robot.
    Dynabarn(worlds::DynaBarnArguments),
    /// Inject faults in simulation and on emulated serial lines: the robot must stop in time and cause no contact.
    Faults(fault_matrix::FaultsArguments),
    /// Measure the localizer: pose errors and lost robots in simulated drives, or on the log of a real robot.
    Localization(localization::LocalizationArguments),
    /// Compare grid search with the published optimal lengths of the MovingAI benchmark.
    Movingai(movingai::MovingAiArguments),
    /// Repeat the paper's tables and figures of paths and drives, and compare them with its values.
    Paper(paper::PaperArguments),
    /// Measure the perception of obstacles on the log of a real robot: what moves, and how soon marks are cleared.
    Perception(perception::PerceptionArguments),
    /// Count the contacts of wrong planners on random missions, with and without the protective layer.
    Protection(protection::ProtectionArguments),
    /// Drive random missions on many maps among moving obstacles: contacts, their causes, and equal traces on every engine.
    Soak(soak::SoakArguments),
}

/// Exit status for unusable input.
const UNUSABLE: u8 = 2;

/// Runs the program: parses the arguments, runs the command, and prints an error with its causes. Returns the exit status.
#[must_use]
pub fn run_program(invocation: Invocation) -> u8 {
    let name = [OsString::from("inbye")];
    let words = name.iter().chain(&invocation.arguments).cloned();
    let arguments = match Arguments::try_parse_from(words) {
        Ok(arguments) => arguments,
        Err(help) if !help.use_stderr() => {
            output::print_help(&help);
            return if output::is_incomplete() { UNUSABLE } else { 0 };
        }
        Err(error) => {
            output::set_json(invocation.arguments.iter().any(|argument| argument == "--json"));
            output::print_usage_error(&error);
            return UNUSABLE;
        }
    };
    invocation.set();
    if arguments.output.verbose < 2 {
        vulkan_environment::silence_device_selection();
    }
    arguments.output.init();
    match run(&arguments) {
        // A terminal that goes away interrupts the command, and cannot take its result.
        Ok(_) if output::is_incomplete() && !machine::is_interrupted() => UNUSABLE,
        Ok(is_done) => u8::from(!is_done),
        Err(error) => {
            let interrupted =
                matches!(error.downcast_ref(), Some(HardwareError::Interrupted { .. }));
            let (status, kind) =
                if interrupted { (1, "interrupted") } else { (UNUSABLE, "unusable_input") };
            output::print_error(kind, &error);
            status
        }
    }
}

/// Runs a command. Returns true if it is done, false if it ran and the answer is no.
fn run(arguments: &Arguments) -> anyhow::Result<bool> {
    let Some(command) = &arguments.command else {
        return demo::run(arguments);
    };
    ensure!(
        arguments.report.is_none(),
        "--report before a command belongs to the demo: write it after the command, if that command has a report"
    );
    #[cfg(unix)]
    match command {
        Command::Drive(drive) if drive.hardware.port.is_some() => {
            stop_signals::catch(OnStopSignal::StopRobot)?;
        }
        Command::Node(_) => stop_signals::catch(OnStopSignal::StopRobot)?,
        Command::Base(base) if base.opens_line() => stop_signals::catch(OnStopSignal::EndProgram)?,
        _ => {}
    }
    match command {
        Command::Plan(command) => plan::run(command),
        Command::Map(command) => map_log::run(command),
        Command::Drive(command) => drive::run(command),
        Command::Replay(command) => replay::run(command),
        Command::Evaluate(command) => evaluate::run(command),
        Command::Verify(command) => verify::run(command),
        Command::Devices => machine::devices(),
        Command::Doctor(command) => doctor::run(command),
        Command::Config(command) => config_command::run(command),
        Command::Node(command) => node::run(command),
        Command::Playground(command) => playground::run(command),
        Command::Completions(_) | Command::Man(_) if output::is_json() => anyhow::bail!(NO_JSON),
        Command::Completions(command) => shell_integration::completions(command),
        Command::Man(command) => shell_integration::man(command),
        Command::Sweep(command) => sweep::run(command),
        Command::Tune(command) => tune::run(command).map(|done| done && !machine::is_interrupted()),
        Command::Base(base) => match &base.command {
            BaseCommand::Emulate(command) => base_emulate::run(command),
            BaseCommand::Send(command) => base::send(command),
            BaseCommand::Monitor(command) => base::monitor(command),
            BaseCommand::Calibrate(command) => base_calibrate::run(command),
        },
        Command::Bench(bench) => run_bench(bench).map(|done| done && !machine::is_interrupted()),
    }
}

fn run_bench(bench: &BenchArguments) -> anyhow::Result<bool> {
    match &bench.command {
        BenchCommand::Ablation(command) => missions::ablation(command),
        BenchCommand::Barn(command) => worlds::barn(command),
        BenchCommand::Compare(command) => comparison::run(command),
        BenchCommand::Density(command) => density::run(command),
        BenchCommand::Draw(command) => draw::run(command),
        BenchCommand::Dynabarn(command) => worlds::dynabarn(command),
        BenchCommand::Faults(command) => fault_matrix::run(command),
        BenchCommand::Localization(command) => localization::run(command),
        BenchCommand::Movingai(command) => movingai::run(command),
        BenchCommand::Paper(command) => paper::run(command),
        BenchCommand::Perception(command) => perception::run(command),
        BenchCommand::Protection(command) => protection::run(command),
        BenchCommand::Soak(command) => soak::run(command),
    }
}

#[cfg(test)]
mod tests {
    use clap::{Arg, CommandFactory};

    use super::*;

    /// The names of the flags and groups that a flag requires. clap shows them in its debug output only.
    fn required(argument: &Arg) -> Vec<String> {
        let text = format!("{argument:?}");
        let list = text.split_once(", requires: [").and_then(|(_, rest)| rest.split_once(']'));
        let names = list.map_or("", |(list, _)| list).split('"').skip(1).step_by(2);
        names.map(str::to_owned).collect()
    }

    /// Checks the flags of a command and of its subcommands. Returns the number of requirements.
    fn check(command: &clap::Command) -> usize {
        let conflicts = |one: &Arg, other: &Arg| {
            let declares = |of: &Arg, with: &Arg| {
                command.get_arg_conflicts_with(of).iter().any(|it| it.get_id() == with.get_id())
            };
            declares(one, other) || declares(other, one)
        };
        let mut count = 0;
        for argument in command.get_arguments() {
            for name in required(argument) {
                count += 1;
                // A group has no conflicts.
                let target = command.get_arguments().find(|it| it.get_id() == name.as_str());
                let Some(target) = target else { continue };
                for other in command.get_arguments().filter(|other| conflicts(target, other)) {
                    assert!(
                        conflicts(argument, other),
                        "{}: {argument} is ignored without {target} if {other} is given: let it require a group",
                        command.get_name()
                    );
                }
            }
        }
        count + command.get_subcommands().map(check).sum::<usize>()
    }

    #[test]
    fn requirements_hold_next_to_flags_that_conflict_with_the_required_flag() {
        let mut command = Arguments::command();
        command.build();
        assert!(check(&command) > 15, "the debug output of clap has changed");
    }
}
