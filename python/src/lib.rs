//! The Python module `inbye._native`: the types and functions of the package `inbye` that are written in Rust. The package's
//! type stubs, `_native.pyi`, document them.

#![expect(
    clippy::needless_pass_by_value,
    clippy::doc_markdown,
    reason = "Python's functions own their arguments, and their documentation is Python's"
)]

mod controller;
mod conversion;
mod decision;
mod drive;
mod environment;
mod experiment;
mod interrupt;
mod localizer;
mod map;
mod mission_slot;
mod navigator;
mod picture;
mod problem;
mod program;
mod records;
mod settings;
mod shared;

use pyo3::prelude::*;

pyo3::create_exception!(
    inbye,
    InbyeError,
    pyo3::exceptions::PyValueError,
    "An input that cannot be used; the message says what is wrong with it."
);

#[pymodule]
mod _native {
    #[pymodule_export]
    use super::InbyeError;
    #[pymodule_export]
    use super::controller::ControllerInput;
    #[pymodule_export]
    use super::decision::{Decision, Engine};
    #[pymodule_export]
    use super::drive::{Drive, World, replay};
    #[pymodule_export]
    use super::environment::Environments;
    #[pymodule_export]
    use super::experiment::{compare, planner_names, read_worlds, run};
    #[pymodule_export]
    use super::localizer::{Localizer, PoseEstimate};
    #[pymodule_export]
    use super::map::{Map, map_of_parts, plan};
    #[pymodule_export]
    use super::navigator::{Navigator, NavigatorDecision};
    #[pymodule_export]
    use super::problem::Problem;
    #[pymodule_export]
    use super::program::run_program;
    #[pymodule_export]
    use super::settings::Config;
    #[pymodule_export]
    #[expect(non_upper_case_globals, reason = "the name is Python's")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
