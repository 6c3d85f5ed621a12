//! The command line: the only module of the program that prints and opens files to write.

mod ablation;
mod arguments;
mod barn;
mod base_arguments;
mod base_emulate;
mod base_monitor;
mod base_send;
mod base_text;
mod bench;
mod closed_loop;
mod command;
mod config;
mod config_command;
mod curvature_check;
mod demo;
mod density_text;
mod devices;
mod draw;
mod drive;
mod drive_log;
mod dynabarn;
mod engines;
mod evaluate;
mod grid_run;
mod hardware_drive;
mod import_nav2;
mod incident_text;
mod localization;
mod map_file;
mod missions;
mod movingai;
mod multi_leg_plan;
mod node;
mod one_run;
pub mod output;
mod output_file;
mod paper;
mod paper_drive_text;
mod paper_text;
mod plan;
mod plan_drawing;
mod plan_text;
mod playground;
mod problem_file;
mod process;
mod recording;
mod replay;
mod report_file;
mod result_store;
mod run_text;
mod serde_messages;
mod shell_integration;
mod soak;
mod sweep;
mod sweep_merge;
mod sweep_workers;
mod toml_merge;
mod value_parsers;
mod verbosity;
mod verify;
mod worlds;

use base_arguments::BaseCommand;
pub use command::Arguments;
use command::{BenchCommand, Command};

/// The error of commands whose output is no result.
const NO_JSON: &str = "--json: this command has no JSON output: leave the flag out";

/// Runs a command. Returns true if it is done, false if it ran and the answer is no.
///
/// # Errors
/// The input is unusable.
pub fn run(arguments: &Arguments) -> anyhow::Result<bool> {
    let json = arguments.json;
    anyhow::ensure!(
        arguments.command.is_none() || arguments.report.is_none(),
        "--report before a command belongs to the demo: write it after the command, if that command has a report"
    );
    match &arguments.command {
        None => demo::run(arguments),
        Some(Command::Plan(command)) => plan::run(command, json),
        Some(Command::Drive(command)) => drive::run(command, json),
        Some(Command::Replay(command)) => replay::run(command, json),
        Some(Command::Evaluate(command)) => evaluate::run(command, json),
        Some(Command::Verify(command)) => verify::run(command, json),
        Some(Command::Devices) => devices::run(json),
        Some(Command::Config(command)) => config_command::run(command, json),
        Some(Command::Node(command)) => node::run(command, json),
        Some(Command::Playground(command)) => playground::run(command, json),
        Some(Command::Completions(command)) => {
            anyhow::ensure!(!json, NO_JSON);
            shell_integration::completions(command)
        }
        Some(Command::Man(command)) => {
            anyhow::ensure!(!json, NO_JSON);
            shell_integration::man(command)
        }
        Some(Command::Sweep(command)) => sweep::run(command, json),
        Some(Command::Base(base)) => match &base.command {
            BaseCommand::Emulate(command) => base_emulate::run(command, json),
            BaseCommand::Send(command) => base_send::run(command, json),
            BaseCommand::Monitor(command) => base_monitor::run(command, json),
        },
        Some(Command::Bench(bench)) => match &bench.command {
            BenchCommand::Ablation(command) => ablation::run(command, json),
            BenchCommand::Barn(command) => barn::run(command, json),
            BenchCommand::Density(command) => bench::density(command, json),
            BenchCommand::Draw(command) => draw::run(command, json),
            BenchCommand::Dynabarn(command) => dynabarn::run(command, json),
            BenchCommand::Localization(command) => localization::run(command, json),
            BenchCommand::Movingai(command) => movingai::run(command, json),
            BenchCommand::Paper(command) => paper::run(command, json),
            BenchCommand::Soak(command) => soak::run(command, json),
        },
    }
}
