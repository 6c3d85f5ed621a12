//! Another process of this program with JSON on its standard output.

use std::process::{Command, Stdio};
use std::time::Duration;

use anyhow::{Context, bail};
use inbye::external::{LineError, LineProcess};
use serde_json::Value;

use super::invocation;

/// A command of this program, with all its streams.
pub fn program(command: &str) -> Command {
    let mut program = invocation::program();
    program.args(command.split(' '));
    program
}

/// A process that writes lines of JSON; killed when dropped.
pub struct ChildProcess(LineProcess);

impl ChildProcess {
    /// Starts the process without standard input.
    pub fn start(command: &mut Command) -> anyhow::Result<Self> {
        let process = LineProcess::start_without_input(command);
        Ok(Self(process.context("this program cannot be started again")?))
    }

    /// Waits for the next object, at most for a time.
    pub fn line(&mut self, limit: Duration) -> anyhow::Result<Value> {
        match self.0.line(limit) {
            Ok(line) => {
                serde_json::from_str(&line).context("a process wrote a line that is no JSON")
            }
            Err(LineError::Timeout) => {
                bail!("a process wrote nothing for {:.0} s{}", limit.as_secs_f64(), self.errors())
            }
            Err(LineError::TooLong) => bail!("a process wrote a line that is too long"),
            Err(LineError::Ended | LineError::Interrupted) => {
                bail!("a process ended{}", self.errors())
            }
        }
    }

    /// Sends a signal by its name, such as INT. A process that has ended gets none.
    pub fn signal(&self, name: &str) -> anyhow::Result<()> {
        let id = self.0.id().to_string();
        // Without its message about a process that has ended.
        let kill = Command::new("kill").args(["-s", name, &id]).stderr(Stdio::null()).status();
        kill.context("kill: cannot be run")?;
        Ok(())
    }

    /// Ends the process and returns its errors.
    fn errors(&mut self) -> String {
        let errors = self.0.end();
        let errors = errors.trim();
        if errors.is_empty() { String::new() } else { format!(": {errors}") }
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn process_that_ends_without_an_answer_gives_its_errors() {
        let mut command = Command::new("sh");
        let mut process =
            ChildProcess::start(command.args(["-c", "echo broken >&2; exit 3"])).expect("a shell");
        let error = process.line(Duration::from_secs(60)).expect_err("no answer");
        assert_eq!(error.to_string(), "a process ended: broken");
    }
}
