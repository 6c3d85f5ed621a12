//! Logging to standard error: `--quiet` and `--verbose`.

use std::io::{self, Write};

use clap::{ArgAction, Args};
use env_logger::Builder;
use env_logger::fmt::Formatter;
use log::{Level, LevelFilter, Record};

/// Heading of the flags that every command has.
pub(super) const GLOBAL_OPTIONS: &str = "Global options";

/// Log target of this program, as opposed to libraries.
const PROGRAM: &str = env!("CARGO_CRATE_NAME");

/// Amount of messages on standard error.
#[derive(Clone, Copy, Debug, Args)]
pub struct Verbosity {
    /// Print warnings and errors only: no notes, no progress.
    #[arg(long, short, global = true, help_heading = GLOBAL_OPTIONS, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Print more: map, settings that differ from their defaults, modes and plans of a drive. Twice: also messages of the
    /// libraries and graphics drivers.
    #[arg(long, short, global = true, help_heading = GLOBAL_OPTIONS, action = ArgAction::Count)]
    pub verbose: u8,
}

impl Verbosity {
    /// Installs the logger. Earlier messages are lost.
    pub fn init_logging(self) {
        let (program, libraries) = match (self.quiet, self.verbose) {
            (true, _) => (LevelFilter::Warn, LevelFilter::Off),
            (false, 0) => (LevelFilter::Info, LevelFilter::Off),
            (false, 1) => (LevelFilter::Debug, LevelFilter::Off),
            (false, _) => (LevelFilter::Debug, LevelFilter::Debug),
        };
        Builder::new().filter_level(libraries).filter_module(PROGRAM, program).format(write).init();
    }
}

/// Formats a message of this program as plain text, a warning with its level, and a library's message with level and target.
fn write(out: &mut Formatter, record: &Record) -> io::Result<()> {
    let (level, message) = (record.level(), record.args());
    let style = out.default_level_style(level);
    let target = record.target();
    let is_own =
        target.strip_prefix(PROGRAM).is_some_and(|rest| rest.is_empty() || rest.starts_with("::"));
    match (is_own, level) {
        (true, Level::Warn) => writeln!(out, "{style}warning:{style:#} {message}"),
        (true, _) => writeln!(out, "{message}"),
        (false, _) => {
            let level = level.as_str().to_lowercase();
            writeln!(out, "{style}{level}:{style:#} {target}: {message}")
        }
    }
}
