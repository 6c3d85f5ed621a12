//! Printing: results on standard output, everything else on standard error.
#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "this is where the program prints"
)]

use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

/// Prints a result as one JSON object.
pub fn json(result: &impl Serialize) -> anyhow::Result<()> {
    println!("{}", serde_json::to_string(result)?);
    Ok(())
}

/// Prints a line of a result.
pub fn line(text: impl AsRef<str>) {
    println!("{}", text.as_ref());
}

/// Tells the user something that is no part of the result.
pub fn note(text: impl AsRef<str>) {
    eprintln!("{}", text.as_ref());
}

/// Prints an error and its causes on one line.
pub fn complain(error: &anyhow::Error) {
    let causes: Vec<String> = error.chain().map(ToString::to_string).collect();
    eprintln!("error: {}", causes.join(": ").replace('\n', " "));
}

/// A progress bar on standard error; invisible where that is no terminal.
pub fn progress(steps: u64, what: &str) -> ProgressBar {
    let template = "{msg:24} [{bar:40}] {pos}/{len} {elapsed}";
    let style = ProgressStyle::with_template(template)
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .progress_chars("=> ");
    let bar = ProgressBar::new(steps)
        .with_style(style)
        .with_message(what.to_owned());
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}
