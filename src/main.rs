//! The `inbye` program: parses the arguments, runs the command, prints an error with its causes, exits.

use std::process::ExitCode;

use clap::Parser;

mod cli;

/// Exit status for unusable input.
const UNUSABLE: u8 = 2;

fn main() -> ExitCode {
    let arguments = match cli::Arguments::try_parse() {
        Ok(arguments) => arguments,
        // Help and version: clap prints them to standard output.
        Err(help) if !help.use_stderr() => help.exit(),
        Err(error) => {
            let is_json = std::env::args_os().any(|argument| argument == "--json");
            cli::output::print_usage_error(&error, is_json);
            return ExitCode::from(UNUSABLE);
        }
    };
    if arguments.verbosity.verbose < 2 {
        cli::vulkan_environment::silence_device_selection();
    }
    arguments.verbosity.init_logging();
    match cli::run(&arguments) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(error) => {
            cli::output::print_error(&error, arguments.json);
            ExitCode::from(UNUSABLE)
        }
    }
}
