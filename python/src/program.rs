//! The program `inbye`.

use std::ffi::OsString;

use inbye::Invocation;
use pyo3::prelude::*;

/// Runs the program and ends the process with its exit status. `program` is the command that starts it again.
#[pyfunction]
pub fn run_program(py: Python<'_>, program: Vec<OsString>, arguments: Vec<OsString>) {
    py.detach(|| {
        let status = inbye::run_program(Invocation { program, arguments });
        // Ends without Python's own clean-up, which no command needs.
        std::process::exit(status.into())
    });
}
