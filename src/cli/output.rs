//! Printing: results on standard output, everything else on standard error, coloured where that is a terminal. A reader
//! that has closed its end, as `head` does, is no error: the rest is dropped.

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

/// What went wrong, on a terminal that shows colours.
const WRONG: Style = AnsiColor::Red.on_default().bold();

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
        wrong(&format!("standard output: {error}"));
        exit(2);
    }
}

/// Tells the user something that is no part of the result; `--quiet` leaves it out.
pub fn note(text: impl AsRef<str>) {
    log::info!("{}", text.as_ref());
}

/// Tells the user of something that may not be what they want, `--quiet` or not.
pub fn warn(text: impl AsRef<str>) {
    log::warn!("{}", text.as_ref());
}

/// Whether `--verbose` asks for more than is told anyway: what that takes need not be found out otherwise.
pub fn tells_details() -> bool {
    log::log_enabled!(log::Level::Debug)
}

/// Tells what only `--verbose` asks for.
pub fn detail(text: impl AsRef<str>) {
    log::debug!("{}", text.as_ref());
}

/// Tells why the program ends.
fn wrong(text: &str) {
    // Where standard error is closed there is nobody left to tell.
    let _ = writeln!(anstream::stderr(), "{WRONG}error:{WRONG:#} {text}");
}

/// Prints an error and its causes on one line.
pub fn complain(error: &anyhow::Error) {
    let causes: Vec<String> = error.chain().map(ToString::to_string).collect();
    wrong(&in_one_line(&causes.join(": ")));
}

/// Prints what is wrong with the command line on one line.
pub fn complain_of_arguments(misuse: &clap::Error) {
    let text = misuse.render().to_string();
    let paragraphs: Vec<String> = text.split("\n\n").map(in_one_line).collect();
    let starts = |with: &str| {
        paragraphs
            .iter()
            .find(|paragraph| paragraph.starts_with(with))
    };
    // A command without its subcommand gets its whole help from clap, and no error.
    let said = match (starts("error:"), starts("Usage:")) {
        (None, Some(usage)) => format!("a command is missing: {usage}"),
        _ => paragraphs
            .iter()
            .filter(|paragraph| !paragraph.starts_with("Usage:"))
            .filter(|paragraph| !paragraph.starts_with("For more information"))
            .cloned()
            .collect::<Vec<_>>()
            .join("; "),
    };
    let said = said.strip_prefix("error: ").unwrap_or(&said);
    wrong(&format!("{said}; see --help"));
}

fn in_one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The file of `--record`, emptied.
pub fn create_record(file: &Path) -> anyhow::Result<File> {
    File::create(file).with_context(|| {
        let name = file.display();
        format!("--record {name}: cannot be written: name a file in a folder that exists")
    })
}

/// A progress bar on standard error; invisible where that is no terminal, with `--quiet`, and with `--verbose`, whose lines
/// it would run into.
pub fn progress(steps: u64, what: &str) -> ProgressBar {
    let template = "{msg:24} [{bar:40}] {pos}/{len} {elapsed}";
    let style = ProgressStyle::with_template(template)
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .progress_chars("=> ");
    if log::max_level() != LevelFilter::Info {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(steps)
        .with_style(style)
        .with_message(what.to_owned());
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}
