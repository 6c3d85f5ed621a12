//! The `inbye` program: parse, dispatch, print the error chain once, exit.

use std::process::ExitCode;

use clap::Parser;

mod cli;

fn main() -> ExitCode {
    match cli::run(&cli::Arguments::parse()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(error) => {
            cli::output::complain(&error);
            ExitCode::from(2)
        }
    }
}
