//! The `inbye` program.

use std::process::ExitCode;

use inbye::{Invocation, run_program};

fn main() -> ExitCode {
    run_program(Invocation::of_process()).into()
}
