//! Printing: results to standard output, everything else to standard error, in colour on a terminal. A closed pipe, as after
//! `head`, is no error: the rest is dropped.

use std::fs::File;
use std::io::{self, ErrorKind, Write};
use std::path::Path;
use std::process::exit;
use std::time::Duration;

use anstyle::{AnsiColor, Style};
use anyhow::Context;
use indicatif::{ProgressBar, ProgressStyle};
use log::LevelFilter;
use serde::Serialize;

/// Style of the word `error`.
const ERROR: Style = AnsiColor::Red.on_default().bold();

/// Prints a result as one JSON object.
pub fn json(result: &impl Serialize) -> anyhow::Result<()> {
    line(serde_json::to_string(result)?);
    Ok(())
}

/// Prints a line of a result.
pub fn line(text: impl AsRef<str>) {
    let mut out = io::stdout().lock();
    let written = writeln!(out, "{}", text.as_ref()).and_then(|()| out.flush());
    if let Err(error) = written
        && error.kind() != ErrorKind::BrokenPipe
    {
        print_error_text(&format!("standard output: {error}"));
        exit(2);
    }
}

/// Prints a note that is no part of the result; `--quiet` hides it.
pub fn note(text: impl AsRef<str>) {
    log::info!("{}", text.as_ref());
}

/// Prints a warning, also with `--quiet`.
pub fn warn(text: impl AsRef<str>) {
    log::warn!("{}", text.as_ref());
}

/// Whether `--verbose` was given, so that details are worth computing.
pub fn is_verbose() -> bool {
    log::log_enabled!(log::Level::Debug)
}

/// Prints a detail with `--verbose`.
pub fn detail(text: impl AsRef<str>) {
    log::debug!("{}", text.as_ref());
}

fn print_error_text(text: &str) {
    // A closed standard error leaves no place to report to.
    let _ = writeln!(anstream::stderr(), "{ERROR}error:{ERROR:#} {text}");
}

/// Prints an error and its causes on one line.
pub fn print_error(error: &anyhow::Error) {
    let causes: Vec<String> = error.chain().map(ToString::to_string).collect();
    print_error_text(&in_one_line(&causes.join(": ")));
}

/// Prints an error of the command line on one line.
pub fn print_usage_error(error: &clap::Error) {
    let text = error.render().to_string();
    let paragraphs: Vec<String> = text.split("\n\n").map(in_one_line).collect();
    let starts = |with: &str| paragraphs.iter().find(|paragraph| paragraph.starts_with(with));
    // For a missing subcommand clap renders the whole help instead of an error.
    let message = match (starts("error:"), starts("Usage:")) {
        (None, Some(usage)) => format!("a command is missing: {usage}"),
        _ => paragraphs
            .iter()
            .filter(|paragraph| !paragraph.starts_with("Usage:"))
            .filter(|paragraph| !paragraph.starts_with("For more information"))
            .cloned()
            .collect::<Vec<_>>()
            .join("; "),
    };
    let message = message.strip_prefix("error: ").unwrap_or(&message);
    print_error_text(&format!("{message}; see --help"));
}

fn in_one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Creates the file of `--record`.
pub fn create_record(file: &Path) -> anyhow::Result<File> {
    File::create(file).with_context(|| {
        let name = file.display();
        format!("--record {name}: cannot be written: name a file in a folder that exists")
    })
}

/// Creates a progress bar on standard error; hidden without a terminal, with `--quiet`, and with `--verbose`, whose lines would
/// mix with it.
pub fn progress(steps: u64, what: &str) -> ProgressBar {
    let template = "{msg:24} [{bar:40}] {pos}/{len} {elapsed}";
    let style = ProgressStyle::with_template(template)
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .progress_chars("=> ");
    if log::max_level() != LevelFilter::Info {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(steps).with_style(style).with_message(what.to_owned());
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}
