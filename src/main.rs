//! The `inbye` program: parse, dispatch, print the error chain once, exit.

use std::process::ExitCode;

use clap::Parser;

mod cli;

/// Unusable input.
const UNUSABLE: u8 = 2;

fn main() -> ExitCode {
    let arguments = match cli::Arguments::try_parse() {
        Ok(arguments) => arguments,
        // Help and version are answers: clap prints them as they stand.
        Err(asked) if !asked.use_stderr() => asked.exit(),
        Err(misuse) => {
            cli::output::complain_of_arguments(&misuse);
            return ExitCode::from(UNUSABLE);
        }
    };
    arguments.verbosity.begin();
    match cli::run(&arguments) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(error) => {
            cli::output::complain(&error);
            ExitCode::from(UNUSABLE)
        }
    }
}
