//! The command line: the only room that prints, reads clocks and opens files to write.

mod ablation;
mod arguments;
mod barn;
mod barn_words;
mod base_arguments;
mod base_emulate;
mod base_line;
mod base_monitor;
mod base_send;
mod base_text;
mod bench;
mod campaign;
mod changes;
mod clock;
mod closed_loop;
mod completions;
mod config;
mod config_arguments;
mod config_command;
mod density_words;
mod devices;
mod draw;
mod drive;
mod dynabarn;
mod dynabarn_words;
mod engines;
mod evaluate;
mod followed;
mod hardship_words;
mod import_nav2;
mod interrupt;
mod known_words;
mod lidar_line;
mod localization;
mod main_job;
mod man;
mod map_file;
mod missions;
mod movingai;
mod movingai_words;
mod node;
mod one_run;
pub mod output;
mod output_file;
mod paper;
mod paper_drive_words;
mod paper_words;
mod plain_words;
mod plan;
mod plan_drawing;
mod plan_words;
mod playground;
mod problem_file;
mod record_file;
mod recording;
mod replay;
mod report_file;
mod settings_file;
mod soak;
mod soak_words;
mod story;
mod sweep;
mod sweep_crew;
mod sweep_folder;
mod sweep_merge;
mod tour;
mod unknown_words;
mod verbosity;
mod verify;
mod wired_drive;
mod worlds;

pub use arguments::Arguments;
use arguments::{BenchCommand, Command};
use base_arguments::BaseCommand;

/// Runs a command. True: done; false: it ran and the answer is no.
///
/// # Errors
/// When the input cannot be used.
pub fn run(arguments: &Arguments) -> anyhow::Result<bool> {
    let json = arguments.json;
    anyhow::ensure!(
        arguments.command.is_none() || arguments.report.is_none(),
        "--report before a command: it is the main job's: give it after the command, where that command writes a report"
    );
    match &arguments.command {
        None => main_job::run(arguments),
        Some(Command::Plan(command)) => plan::run(command, json),
        Some(Command::Drive(command)) => drive::run(command, json),
        Some(Command::Replay(command)) => replay::run(command, json),
        Some(Command::Evaluate(command)) => evaluate::run(command, json),
        Some(Command::Verify(command)) => verify::run(command, json),
        Some(Command::Devices) => devices::run(json),
        Some(Command::Config(command)) => config_command::run(command, json),
        Some(Command::Node(command)) => node::run(command, json),
        Some(Command::Playground(command)) => playground::run(command, json),
        Some(Command::Completions(command)) => completions::run(command, json),
        Some(Command::Man(command)) => man::run(command, json),
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
