//! The user's own programs: controllers, global planners and simulators.
//!
//! A program reads one JSON object per line from its standard input and answers each with one line on its standard output. The
//! book's chapter "Your own planner" describes the messages. If a program ends, does not answer, or gives an unusable answer, the
//! mission ends with a reason. This is a result of the mission, not an error of inbye.

mod controller;
mod global_planner;
mod line_process;
pub(crate) mod protocol;
#[cfg(test)]
mod schema_test;
mod settings;

pub use controller::ProcessController;
pub use global_planner::ProcessPlanner;
#[doc(hidden)]
pub use line_process::{LineError, LineProcess, interruptible, run_in_group};
pub use protocol::PROTOCOL;
pub use settings::ProgramSettings;

use std::path::Path;
use std::process::ExitStatus;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use serde::de::DeserializeOwned;

#[cfg(doc)]
use crate::navigator::ControllerError;
use crate::suggest::without_rust_types;
use protocol::{AnsweredNumber, Ready, Request};

/// Ends all waits for answers once it is set.
static INTERRUPT: OnceLock<Arc<AtomicBool>> = OnceLock::new();

/// Sets the flag that ends all waits for answers of programs, in every thread, as a handler of Ctrl-C sets it. Only the first flag
/// counts.
#[doc(hidden)]
pub fn interrupt_by(flag: Arc<AtomicBool>) {
    let _ = INTERRUPT.set(flag);
}

/// A program that has answered the first message.
pub(crate) struct Program {
    process: LineProcess,
    name: String,
    wants: Vec<protocol::Want>,
    pub timeout: Duration,
    /// The last message: its number, its time, and whether its answer is due.
    asked: Option<u64>,
    asked_at: Instant,
    is_due: bool,
    /// The longest time of an answer, without the first one.
    longest: Duration,
}

/// Beginning of the reason where a program gave no answer in time, also in [`ControllerError::TimedOut`].
pub(crate) const NO_ANSWER: &str = "no answer";

/// Why a program gave no answer.
pub(crate) enum NoAnswer {
    /// Nothing within the time limit.
    Silent,
    /// The wait was interrupted.
    Interrupted,
    /// It ended, or its answer is unusable.
    Failed(String),
}

impl Program {
    /// Starts a program and sends the first message.
    pub fn start(settings: &ProgramSettings, first: &Request<'_>) -> Result<Self, String> {
        check_program(settings)?;
        let mut command = settings.to_command();
        let process = LineProcess::start(&mut command)
            .map_err(|error| format!("cannot be started: {error}{}", searched(settings)))?;
        let timeout = Duration::from_secs_f64(settings.timeout_s);
        let (name, wants) = (settings.to_string(), Vec::new());
        let mut program = Self {
            process,
            name,
            wants,
            timeout,
            asked: None,
            asked_at: Instant::now(),
            is_due: false,
            longest: Duration::ZERO,
        };
        program.send(first);
        let ready: Ready = match program.answer(START_FACTOR * timeout) {
            Ok(ready) => ready,
            Err(NoAnswer::Silent) => {
                let limit_s = (START_FACTOR * timeout).as_secs_f64();
                return Err(format!("{NO_ANSWER} to the first message for {limit_s} s"));
            }
            Err(NoAnswer::Failed(reason)) if program.process.status().is_some() => {
                return Err(format!("{reason} (in the working folder {})", working_folder()));
            }
            Err(error) => return Err(program.reason(error)),
        };
        if ready.protocol != u64::from(PROTOCOL) {
            return Err(format!(
                "speaks protocol {}, this inbye speaks {PROTOCOL}: change the program",
                ready.protocol
            ));
        }
        program.name = ready.name.map_or(program.name, |name| shown(&name, SHOWN_CHARACTERS));
        program.wants = ready.wants;
        Ok(program)
    }

    /// Sends a message and waits for its answer. Each earlier message must have been answered.
    pub fn ask<T: DeserializeOwned>(
        &mut self,
        request: &Request<'_>,
        limit: Duration,
    ) -> Result<T, NoAnswer> {
        if let Some(line) = self.process.waiting_line() {
            return Err(NoAnswer::Failed(second_line(&line)));
        }
        self.send(request);
        self.answer(limit)
    }

    /// Ends the program after its last answer, and checks that it wrote one line for each message: a line that came just after the
    /// next message was taken as the answer to that message, and each answer since then was for the message before. This shows only
    /// in the line that is left at the end. A line that is no answer, such as a farewell, does no harm.
    ///
    /// # Errors
    /// Has the line that is left.
    pub fn finish<T: DeserializeOwned>(&mut self) -> Result<(), String> {
        // The answer to the last message may still be in preparation.
        let lines = self.process.last_lines(self.longest.min(LONGEST_WAIT));
        let mut answers = lines.iter().filter(|line| serde_json::from_str::<T>(line).is_ok());
        let surplus = answers.nth(usize::from(self.is_due));
        surplus.map_or(Ok(()), |line| {
            Err(format!(
                "{}: it was left at the end, so answers were for earlier messages",
                second_line(line)
            ))
        })
    }

    fn send(&mut self, request: &Request<'_>) {
        (self.asked, self.asked_at, self.is_due) = (request.number(), Instant::now(), true);
        // Numbers, lists and texts always have a JSON form.
        let line = serde_json::to_string(request).unwrap_or_default();
        self.process.send(line);
    }

    /// Waits for an answer that is due.
    pub fn answer<T: DeserializeOwned>(&mut self, limit: Duration) -> Result<T, NoAnswer> {
        let line = self.answer_line(limit)?;
        self.is_due = false;
        if self.asked.is_some() {
            self.longest = self.longest.max(self.asked_at.elapsed());
        }
        let no_answer = |why: String| {
            let shown = match &*shown(&line, SHOWN_CHARACTERS) {
                "" => "an empty line".to_owned(),
                text => format!("`{text}`"),
            };
            NoAnswer::Failed(format!("{shown} is no answer: {why}"))
        };
        let answer = parsed(&line).map_err(no_answer)?;
        let number = serde_json::from_str(&line).ok().and_then(|it: AnsweredNumber| it.tick);
        match (number, self.asked) {
            (Some(number), Some(asked)) if number != asked => Err(no_answer(format!(
                "it is for message {number}, and message {asked} was asked: write one line for each message"
            ))),
            _ => Ok(answer),
        }
    }

    /// Waits for the line of an answer.
    fn answer_line(&mut self, limit: Duration) -> Result<String, NoAnswer> {
        let line = match INTERRUPT.get() {
            Some(flag) => {
                interruptible(|| flag.load(Ordering::Relaxed), || self.process.line(limit))
            }
            None => self.process.line(limit),
        };
        line.map_err(|error| match error {
            LineError::Timeout => NoAnswer::Silent,
            LineError::Interrupted => NoAnswer::Interrupted,
            LineError::TooLong => {
                let limit_mib = line_process::MAX_LINE >> 20;
                NoAnswer::Failed(format!("wrote a line that is longer than {limit_mib} MiB"))
            }
            LineError::Ended => {
                let errors = self.process.end();
                let last = errors.trim_end().lines().next_back().unwrap_or_default();
                let last = shown(last, REASON_CHARACTERS);
                let why = if last.is_empty() { String::new() } else { format!(": {last}") };
                NoAnswer::Failed(format!("{}{why}", end_text(self.process.status())))
            }
        })
    }

    pub fn reason(&self, error: NoAnswer) -> String {
        match error {
            NoAnswer::Silent => format!("{NO_ANSWER} for {} s", self.timeout.as_secs_f64()),
            NoAnswer::Interrupted => "was interrupted".to_owned(),
            NoAnswer::Failed(reason) => reason,
        }
    }
}

/// Why a line without a message is an error.
fn second_line(line: &str) -> String {
    format!("wrote a second line for one message: `{}`", shown(line, SHOWN_CHARACTERS))
}

/// How a program ended; without a status it still runs.
fn end_text(status: Option<ExitStatus>) -> String {
    let Some(status) = status else { return "the program closed its standard output".to_owned() };
    #[cfg(unix)]
    if let Some(signal) = std::os::unix::process::ExitStatusExt::signal(&status) {
        let name = nix::sys::signal::Signal::try_from(signal);
        let name = name.map_or_else(|_| format!("signal {signal}"), |name| name.to_string());
        return format!("the program ended (killed by {name})");
    }
    match status.code() {
        Some(code) => format!("the program ended (exit status {code})"),
        None => "the program ended".to_owned(),
    }
}

/// The answer in a line, or why it is none, for the author of a program.
fn parsed<T: DeserializeOwned>(line: &str) -> Result<T, String> {
    // The parser would take a list for the fields of an object, in their order.
    if line.trim_start().starts_with('{') {
        serde_json::from_str(line).map_err(|error| why_no_answer(&error, line))
    } else {
        Err("an answer is a JSON object; print everything else to the standard error output"
            .to_owned())
    }
}

fn why_no_answer(error: &serde_json::Error, line: &str) -> String {
    let column = error.column();
    // The parser stops at the first letter, or after the first one of `nan`, which may be a `null`; a sign is before it.
    let word_from = |from: usize| {
        let rest = line.get(from.checked_sub(1)?..)?;
        let word = NOT_FINITE.into_iter().find(|word| rest.starts_with(word))?;
        Some((word, from))
    };
    let before = || word_from(column.checked_sub(1)?);
    if let Some((word, from)) = word_from(column).or_else(before) {
        let in_scan = if line.contains("\"ranges\"") {
            "; in `ranges`, null is a beam without a measurement, and range_max one without a return"
        } else {
            ""
        };
        return format!("{word} in column {from} is not JSON: each number must be finite{in_scan}");
    }
    let text = error.to_string();
    let message = text.rsplit_once(" at line ").map_or(&*text, |(message, _)| message);
    // What is missing in the whole line has no column.
    let place = if column == 0 { String::new() } else { format!(" (column {column})") };
    format!("{}{place}", without_rust_types(message))
}

/// Numbers that are not finite, as programs in Python and JavaScript write them.
const NOT_FINITE: [&str; 3] = ["NaN", "nan", "Infinity"];

/// Rejects a shared library in place of a program: it would crash when it is started.
fn check_program(settings: &ProgramSettings) -> Result<(), String> {
    let program = settings.command.first().map_or("", String::as_str);
    let extension = Path::new(program).extension().unwrap_or_default();
    if ["so", "dylib", "dll"].iter().any(|&library| extension == library) {
        return Err(format!(
            "is a shared library, not a program: `inbye-controller-host {program}` runs a controller in one"
        ));
    }
    Ok(())
}

/// Where the system looked for a program that it did not find.
fn searched(settings: &ProgramSettings) -> String {
    let program = Path::new(settings.command.first().map_or("", String::as_str));
    if program.is_absolute() {
        String::new()
    } else if program.components().count() > 1 || program.starts_with(".") {
        format!(", in the working folder {}", working_folder())
    } else {
        ", in the folders of PATH".to_owned()
    }
}

fn working_folder() -> String {
    std::env::current_dir().map_or_else(|error| error.to_string(), |it| it.display().to_string())
}

/// The beginning of a text of a program in one line. Control characters are escaped.
fn shown(text: &str, characters: usize) -> String {
    let text = text.trim();
    let mut shown = String::new();
    for character in text.chars().take(characters) {
        if character.is_control() {
            shown.extend(character.escape_default());
        } else {
            shown.push(character);
        }
    }
    if text.chars().nth(characters).is_some() {
        shown.push('\u{2026}');
    }
    shown
}

/// The first answer may take this many times as long as others: a program loads its libraries first.
const START_FACTOR: u32 = 6;
/// Longest extra time at the end of a mission for an answer that is in preparation.
const LONGEST_WAIT: Duration = Duration::from_secs(2);
/// Characters of a wrong answer or of a name that a message shows.
const SHOWN_CHARACTERS: usize = 80;
/// Characters of a program's reason that a message shows.
const REASON_CHARACTERS: usize = 200;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrong_answers_are_explained_without_rust_types() {
        let why = |line: &str| parsed::<protocol::Velocity>(line).err().unwrap_or_default();
        let no_object =
            "an answer is a JSON object; print everything else to the standard error output";
        for (line, expected) in [
            (
                r#"{"linear": NaN, "angular": 0}"#,
                "NaN in column 12 is not JSON: each number must be finite",
            ),
            (
                r#"{"linear": 0, "angular": -Infinity}"#,
                "Infinity in column 27 is not JSON: each number must be finite",
            ),
            (
                r#"{"linear": "fast", "angular": 0}"#,
                r#"invalid type: string "fast", expected a number (column 17)"#,
            ),
            (
                r#"{"linear":nan,"angular":0}"#,
                "nan in column 11 is not JSON: each number must be finite",
            ),
            (r#"{"linear": 0.5}"#, "write either `linear` and `angular`, or `error`"),
            ("Loading model...", no_object),
            ("", no_object),
            ("3", no_object),
            ("[null, 0.3, 0.0, null]", no_object),
            (r#"{"linear": 1e999, "angular": 0}"#, "number out of range (column 16)"),
        ] {
            assert_eq!(why(line), expected);
        }
        let scan = parsed::<protocol::SimulatedState>(r#"{"scan": {"ranges": [Infinity]}}"#);
        let expected = "Infinity in column 22 is not JSON: each number must be finite; in `ranges`, null is a beam without a measurement, \
            and range_max one without a return";
        assert_eq!(scan.err().as_deref(), Some(expected));
    }

    #[test]
    fn numbers_of_messages_may_have_a_fraction_of_zero() {
        let is_answer = |number: &str| {
            let line = format!(r#"{{"tick": {number}, "linear": 0.5, "angular": 0}}"#);
            parsed::<protocol::Velocity>(&line).is_ok()
        };
        for (number, expected) in [
            ("3", true),
            ("3.0", true),
            ("null", true),
            ("3.5", false),
            ("-1", false),
            ("1e300", false),
        ] {
            assert_eq!(is_answer(number), expected, "{number}");
        }
        let ready = |version: &str| {
            parsed::<Ready>(&format!(r#"{{"protocol": {version}}}"#)).map(|ready| ready.protocol)
        };
        assert_eq!((ready("1"), ready("1.0")), (Ok(1), Ok(1)));
        assert!(ready("null").is_err());
    }

    #[test]
    fn shown_text_is_cut_and_has_no_control_characters() {
        assert_eq!(shown(" caf\u{e9} \"a\"\n", 80), "caf\u{e9} \"a\"");
        assert_eq!(shown("\u{1b}[31mred\na", 80), "\\u{1b}[31mred\\na");
        assert_eq!(shown("abcd", 4), "abcd");
        assert_eq!(shown("abcde", 4), "abcd\u{2026}");
    }
}
