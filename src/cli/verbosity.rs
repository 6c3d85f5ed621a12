//! How much is told beside the result: `--quiet` and `--verbose`.

use std::io::{self, Write};

use clap::{ArgAction, Args};
use env_logger::Builder;
use env_logger::fmt::Formatter;
use log::{Level, LevelFilter, Record};

use super::arguments::EVERYWHERE;

/// What is said by ourselves, and not by a library.
const OURS: &str = env!("CARGO_CRATE_NAME");

/// How much is told on standard error.
#[derive(Clone, Copy, Debug, Args)]
pub struct Verbosity {
    /// Tell warnings and errors only: no notes, no progress.
    #[arg(long, short, global = true, help_heading = EVERYWHERE, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Tell more: map, settings that are not at their default, modes and plans of a drive. Twice: what the libraries say,
    /// that of the graphics drivers too.
    #[arg(long, short, global = true, help_heading = EVERYWHERE, action = ArgAction::Count)]
    pub verbose: u8,
}

impl Verbosity {
    /// Has everything told from here on. Nothing is told before.
    pub fn begin(self) {
        let (ours, libraries) = match (self.quiet, self.verbose) {
            (true, _) => (LevelFilter::Warn, LevelFilter::Off),
            (false, 0) => (LevelFilter::Info, LevelFilter::Off),
            (false, 1) => (LevelFilter::Debug, LevelFilter::Off),
            (false, _) => (LevelFilter::Debug, LevelFilter::Debug),
        };
        Builder::new()
            .filter_level(libraries)
            .filter_module(OURS, ours)
            .format(write)
            .init();
    }
}

/// A line as it stands: what we say as a sentence, a warning named so, a library's word with the library's name.
fn write(out: &mut Formatter, record: &Record) -> io::Result<()> {
    let (level, said) = (record.level(), record.args());
    let style = out.default_level_style(level);
    let target = record.target();
    let is_ours = target
        .strip_prefix(OURS)
        .is_some_and(|rest| rest.is_empty() || rest.starts_with("::"));
    match (is_ours, level) {
        (true, Level::Warn) => writeln!(out, "{style}warning:{style:#} {said}"),
        (true, _) => writeln!(out, "{said}"),
        (false, _) => {
            let level = level.as_str().to_lowercase();
            writeln!(out, "{style}{level}:{style:#} {target}: {said}")
        }
    }
}
