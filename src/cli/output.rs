//! Printing: results to standard output, everything else to standard error, in colour on a terminal. A closed pipe, as after
//! `head`, is no error: the rest is dropped. Any other result that cannot be written is an error at the end of the command: the
//! command itself goes on, stops its base and writes its files.

use std::borrow::Cow;
use std::fmt;
use std::io::{self, ErrorKind, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use anstyle::{AnsiColor, Style};
use clap::{ArgAction, Args};
use env_logger::fmt::Formatter;
use env_logger::{Builder, Logger};
use indicatif::style::ProgressTracker;
use indicatif::{HumanDuration, ProgressBar, ProgressState, ProgressStyle};
use log::{Level, LevelFilter, Log, Metadata, Record};
use serde::Serialize;
use serde_json::{Value, json};

use super::{error_text, invocation};
use crate::suggest::in_one_line;

/// Style of the word `error`, and of a bad result.
const ERROR: Style = AnsiColor::Red.on_default().bold();
/// Style of a good result.
const GOOD: Style = AnsiColor::Green.on_default().bold();

/// Heading of the flags that every command has.
const GLOBAL_OPTIONS: &str = "Global options";

/// Log target of this program, as opposed to libraries.
const PROGRAM: &str = env!("CARGO_CRATE_NAME");

/// Whether results are printed as JSON: a flag of every command, like the level of messages.
static IS_JSON: AtomicBool = AtomicBool::new(false);

/// Form of results, and amount of messages on standard error.
#[derive(Clone, Copy, Debug, Args)]
pub struct OutputArguments {
    /// Print one JSON object on standard output instead of text.
    #[arg(long, global = true, help_heading = GLOBAL_OPTIONS)]
    pub json: bool,
    /// Print warnings and errors only: no notes, no progress.
    #[arg(long, short, global = true, help_heading = GLOBAL_OPTIONS, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Print more: map, settings that differ from their defaults, modes and plans of a drive. Twice: also messages of the
    /// libraries and graphics drivers.
    #[arg(long, short, global = true, help_heading = GLOBAL_OPTIONS, action = ArgAction::Count)]
    pub verbose: u8,
}

impl OutputArguments {
    /// Sets the form of results and installs the logger. Earlier messages are lost.
    pub fn init(self) {
        set_json(self.json);
        let (program, libraries) = match (self.quiet, self.verbose) {
            (true, _) => (LevelFilter::Warn, LevelFilter::Off),
            (false, 0) => (LevelFilter::Info, LevelFilter::Off),
            (false, 1) => (LevelFilter::Debug, LevelFilter::Off),
            (false, _) => (LevelFilter::Debug, LevelFilter::Debug),
        };
        let mut logger = Builder::new();
        let logger =
            logger.filter_level(libraries).filter_module(PROGRAM, program).format(write_record);
        let logger = MessageLogger { printed: logger.build() };
        let level = logger.printed.filter();
        // Only a second logger is refused.
        if log::set_boxed_logger(Box::new(logger)).is_ok() {
            log::set_max_level(level);
        }
    }
}

/// Prints messages, and collects those of libraries for [`library_messages`].
struct MessageLogger {
    printed: Logger,
}

/// The messages of libraries, while they are collected.
static COLLECTED: Mutex<Option<Vec<String>>> = Mutex::new(None);

impl Log for MessageLogger {
    fn enabled(&self, metadata: &Metadata) -> bool {
        self.printed.enabled(metadata)
    }

    fn log(&self, record: &Record) {
        if !is_own(record)
            && let Some(messages) = &mut *COLLECTED.lock().unwrap_or_else(PoisonError::into_inner)
        {
            messages.push(record.args().to_string());
        }
        self.printed.log(record);
    }

    fn flush(&self) {
        self.printed.flush();
    }
}

/// Does some work and returns the messages of libraries during it, down to those for debugging, in order. They are printed as
/// usual.
pub fn library_messages(work: impl FnOnce()) -> Vec<String> {
    let exchange = |messages| {
        let mut collected = COLLECTED.lock().unwrap_or_else(PoisonError::into_inner);
        std::mem::replace(&mut *collected, messages)
    };
    let level = log::max_level();
    exchange(Some(Vec::new()));
    log::set_max_level(level.max(LevelFilter::Debug));
    work();
    log::set_max_level(level);
    exchange(None).unwrap_or_default()
}

/// Whether this program, not a library, wrote a message.
fn is_own(record: &Record) -> bool {
    let rest = record.target().strip_prefix(PROGRAM);
    rest.is_some_and(|rest| rest.is_empty() || rest.starts_with("::"))
}

/// Formats a message of this program as plain text, a warning with its level, and a library's message with level and target.
fn write_record(out: &mut Formatter, record: &Record) -> io::Result<()> {
    let (level, message) = (record.level(), record.args());
    let style = out.default_level_style(level);
    if !is_own(record) {
        let (level, target) = (level.as_str().to_lowercase(), record.target());
        return writeln!(out, "{style}{level}:{style:#} {target}: {message}");
    }
    let mark = if level == Level::Warn { "warning:" } else { "" };
    let text = format!("{mark}{}{message}", if mark.is_empty() { "" } else { " " });
    let text = if io::stderr().is_terminal() { folded(&text) } else { text.into() };
    writeln!(out, "{style}{mark}{style:#}{}", text.strip_prefix(mark).unwrap_or(&text))
}

/// Sets the form of results.
pub fn set_json(is_json: bool) {
    IS_JSON.store(is_json, Ordering::Relaxed);
}

/// Whether `--json` was given.
pub fn is_json() -> bool {
    IS_JSON.load(Ordering::Relaxed)
}

/// Prints a result, as one JSON object or as lines of text.
pub fn result(
    object: &impl Serialize,
    lines: impl IntoIterator<Item: AsRef<str>>,
) -> anyhow::Result<()> {
    if is_json() {
        return print_json(object);
    }
    lines.into_iter().for_each(line);
    Ok(())
}

/// Prints a result as one JSON object.
pub fn print_json(object: &impl Serialize) -> anyhow::Result<()> {
    line(serde_json::to_string(object)?);
    Ok(())
}

/// Longest line on a terminal, characters, and the indentation of its further lines, which is that of the values.
const TERMINAL_WIDTH: usize = 100;
const FURTHER_LINES: &str = "             ";

/// Prints a line of a result. A terminal gets a long line as several, a file or a pipe as it is.
pub fn line(text: impl AsRef<str>) {
    // Colours reach a terminal only.
    let mut out = anstream::stdout().lock();
    let text = text.as_ref();
    let folded = if io::stdout().is_terminal() { folded(text) } else { Cow::Borrowed(text) };
    note_if_not_written(writeln!(out, "{folded}").and_then(|()| out.flush()));
}

/// Prints help, or the version.
pub fn print_help(help: &clap::Error) {
    note_if_not_written(help.print().and_then(|()| io::stdout().flush()));
}

/// Whether a result could not be written, for another reason than a reader who wants no more.
static IS_INCOMPLETE: AtomicBool = AtomicBool::new(false);

/// Prints the first error of standard output.
fn note_if_not_written(written: io::Result<()>) {
    if let Err(error) = written
        && error.kind() != ErrorKind::BrokenPipe
        && !IS_INCOMPLETE.swap(true, Ordering::Relaxed)
    {
        print_error_text(&format!("standard output: {error}"));
    }
}

/// Whether a result, or a part of it, could not be written.
pub fn is_incomplete() -> bool {
    IS_INCOMPLETE.load(Ordering::Relaxed)
}

/// A text whose lines have at most 100 characters, unless a word is longer.
fn folded(text: &str) -> Cow<'_, str> {
    let options = textwrap::Options::new(TERMINAL_WIDTH)
        .subsequent_indent(FURTHER_LINES)
        .break_words(false)
        .word_splitter(textwrap::WordSplitter::NoHyphenation);
    // Aligned columns keep their spaces.
    if text.lines().all(|line| textwrap::core::display_width(line) <= TERMINAL_WIDTH) {
        return Cow::Borrowed(text);
    }
    Cow::Owned(textwrap::fill(text, options))
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
    log::log_enabled!(Level::Debug)
}

/// Prints a detail with `--verbose`.
pub fn detail(text: impl AsRef<str>) {
    log::debug!("{}", text.as_ref());
}

fn print_error_text(text: &str) {
    // A closed standard error leaves no place to report to.
    let _ = writeln!(anstream::stderr(), "{ERROR}error:{ERROR:#} {text}");
}

/// Prints an error and its causes on one line, and as JSON with its kind also on standard output.
pub fn print_error(kind: &str, error: &anyhow::Error) {
    let message = in_one_line(&format!("{error:#}"));
    print_error_text(&message);
    if is_json() {
        let place = error_text::place(&message, invocation::arguments());
        json_error(kind, &message, place);
    }
}

fn json_error(code: &str, message: &str, place: Option<&str>) {
    line(json!({ "error": error_object(code, message, place) }).to_string());
}

/// An error as JSON: `place` is what the message begins with, `hint` what follows its last colon outside a quotation.
pub fn error_object(code: &str, message: &str, place: Option<&str>) -> Value {
    let mut rests = message.rmatch_indices(": ").map(|(colon, _)| &message[colon + 2..]);
    let hint = rests.find(|rest| rest.matches('`').count() % 2 == 0);
    json!({ "code": code, "message": message, "place": place, "hint": hint })
}

/// Prints an error of the command line on one line.
pub fn print_usage_error(error: &clap::Error) {
    let text = error.render().to_string();
    let mut paragraphs: Vec<String> = text.split("\n\n").map(in_one_line).collect();
    let starts = |with: &str| paragraphs.iter().find(|paragraph| paragraph.starts_with(with));
    // For a missing subcommand clap renders the whole help instead of an error.
    let message = if let (None, Some(usage)) = (starts("error:"), starts("Usage:")) {
        format!("a command is missing: {usage}")
    } else {
        let is_hint =
            |text: &String| text.starts_with("Usage:") || text.starts_with("For more information");
        paragraphs.retain(|paragraph| !is_hint(paragraph));
        paragraphs.join("; ")
    };
    let message = message.strip_prefix("error: ").unwrap_or(&message);
    print_error_text(&format!("{message}; see --help"));
    if is_json() {
        json_error("usage", message, None);
    }
}

/// Marks a good result, in green on a terminal.
pub fn good(text: &str) -> String {
    format!("{GOOD}{text}{GOOD:#}")
}

/// Marks a bad result, in red on a terminal.
pub fn bad(text: &str) -> String {
    format!("{ERROR}{text}{ERROR:#}")
}

/// Unit of a progress bar over a distance.
pub fn whole_cm(metres: f64) -> u64 {
    (metres * 100.0) as u64
}

/// Creates a progress bar over a distance, whose position is in whole centimetres.
pub fn progress_m(metres: f64, what: &str) -> ProgressBar {
    let metres_of = |cm: u64| cm as f64 / 100.0;
    let done = move |state: &ProgressState, out: &mut dyn fmt::Write| {
        let (done, all) = (metres_of(state.pos()), state.len().map_or(0.0, metres_of));
        // A bar that cannot be written is no error.
        let _ = write!(out, "{done:.1} of {all:.1} m");
    };
    bar(whole_cm(metres), what, done)
}

/// Creates a progress bar over this many steps, named in the plural; hidden without a terminal, with `--quiet`, and with `--verbose`, whose lines would
/// mix with it.
pub fn progress(steps: u64, what: &str, unit: &'static str) -> ProgressBar {
    let done = move |state: &ProgressState, out: &mut dyn fmt::Write| {
        // A bar that cannot be written is no error.
        let _ = write!(out, "{} of {} {unit}", state.pos(), state.len().unwrap_or_default());
    };
    bar(steps, what, done)
}

fn bar(steps: u64, what: &str, done: impl ProgressTracker + 'static) -> ProgressBar {
    if log::max_level() != LevelFilter::Info {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{msg:24} [{bar:24}] {done}, {elapsed}{left}")
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .with_key("done", done)
        .with_key("left", write_left)
        .progress_chars("=> ");
    let bar = ProgressBar::new(steps).with_style(style).with_message(what.to_owned());
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// The time left, which is unknown before the first step.
fn write_left(state: &ProgressState, out: &mut dyn fmt::Write) {
    if state.pos() > 0 {
        // A bar that cannot be written is no error.
        let _ = write!(out, ", {:#} left", HumanDuration(state.eta()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_are_folded_at_words() {
        let short = "why          the time was up";
        assert_eq!(folded(short), short);
        let long = format!("why          {}", "obstacles are within the margins; ".repeat(6));
        let text = folded(&long).into_owned();
        assert!(text.lines().count() == 3 && text.lines().all(|line| line.len() <= 100), "{text}");
        assert!(text.lines().skip(1).all(|line| line.starts_with(FURTHER_LINES)), "{text}");
        let digest = "9".repeat(130);
        assert_eq!(folded(&digest), digest);
    }
}
