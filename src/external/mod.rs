//! The user's own programs: controllers, global planners and simulators.
//!
//! A program reads one JSON object per line from its standard input and answers each with one line on its standard output. The
//! book's chapter "Your own planner" describes the messages. If a program ends, does not answer, or gives an unusable answer, the
//! mission ends with a reason. This is a result of the mission, not an error of inbye.

mod controller;
mod global_planner;
mod line_process;
pub(crate) mod protocol;
mod settings;

pub use controller::ProcessController;
pub use global_planner::ProcessPlanner;
#[doc(hidden)]
pub use line_process::{LineError, LineProcess};
pub use protocol::PROTOCOL;
pub use settings::ProgramSettings;

use std::time::Duration;

use protocol::{Ready, Request};

/// A program that has answered the first message.
pub(crate) struct Program {
    process: LineProcess,
    name: String,
    wants: Vec<protocol::Want>,
    pub timeout: Duration,
}

/// Why a program gave no answer.
pub(crate) enum NoAnswer {
    /// Nothing within the time limit.
    Silent,
    /// It ended, or its answer is unusable.
    Failed(String),
}

impl Program {
    /// Starts a program and sends the first message.
    pub fn start(settings: &ProgramSettings, first: &Request<'_>) -> Result<Self, String> {
        let mut command = settings.to_command();
        let process = LineProcess::start(&mut command, true)
            .map_err(|error| format!("cannot be started: {error}"))?;
        let timeout = Duration::from_secs_f64(settings.timeout_s);
        let (name, wants) = (settings.to_string(), Vec::new());
        let mut program = Self { process, name, wants, timeout };
        program.send(first);
        let ready: Ready = match program.answer(START_FACTOR * timeout) {
            Ok(ready) => ready,
            Err(NoAnswer::Silent) => {
                let limit_s = (START_FACTOR * timeout).as_secs_f64();
                return Err(format!("no answer to the first message for {limit_s} s"));
            }
            Err(NoAnswer::Failed(reason)) => return Err(reason),
        };
        if ready.protocol != PROTOCOL {
            return Err(format!(
                "speaks protocol {}, this inbye speaks {PROTOCOL}: change the program",
                ready.protocol
            ));
        }
        program.name = ready.name.unwrap_or(program.name);
        program.wants = ready.wants;
        Ok(program)
    }

    pub fn send(&self, request: &Request<'_>) {
        // Numbers, lists and texts always have a JSON form.
        let line = serde_json::to_string(request).unwrap_or_default();
        self.process.send(line);
    }

    /// Waits for the next answer.
    pub fn answer<T: serde::de::DeserializeOwned>(
        &mut self,
        limit: Duration,
    ) -> Result<T, NoAnswer> {
        let line = match self.process.line(limit) {
            Ok(line) => line,
            Err(LineError::Timeout) => return Err(NoAnswer::Silent),
            Err(LineError::Ended) => {
                let errors = self.process.end();
                let last = errors.trim_end().lines().next_back().unwrap_or_default().trim();
                let why = if last.is_empty() { String::new() } else { format!(": {last}") };
                return Err(NoAnswer::Failed(format!("the program ended{why}")));
            }
        };
        serde_json::from_str(&line).map_err(|error| {
            let start: String = line.trim_end().chars().take(SHOWN_CHARACTERS).collect();
            NoAnswer::Failed(format!("`{}` is no answer: {error}", start.escape_debug()))
        })
    }

    pub fn reason(&self, error: NoAnswer) -> String {
        match error {
            NoAnswer::Silent => format!("no answer for {} s", self.timeout.as_secs_f64()),
            NoAnswer::Failed(reason) => reason,
        }
    }
}

/// The first answer may take this many times as long as others: a program loads its libraries first.
const START_FACTOR: u32 = 6;
/// Characters of a wrong answer that a message shows.
const SHOWN_CHARACTERS: usize = 80;
