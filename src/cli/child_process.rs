//! Another process of this program with JSON on its standard output.

use std::env;
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, ChildStderr, ChildStdout, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use anyhow::{Context, bail};
use serde_json::Value;

/// Longest line of a process, bytes.
const MAX_LINE: u64 = 1 << 20;

/// Bytes of the standard error output that are kept; the rest is read and dropped.
const KEPT_ERRORS: u64 = 16 << 10;

/// A command of this program, with all its streams.
pub fn program(command: &str) -> Command {
    let mut program = Command::new(env::current_exe().unwrap_or_else(|_| "inbye".into()));
    program.args(command.split(' '));
    program
}

/// A process that writes lines of JSON; killed when dropped.
///
/// Both of its streams are read all the time, so that it never waits for a reader.
pub struct ChildProcess {
    process: Child,
    lines: Receiver<String>,
    errors: Option<JoinHandle<String>>,
}

impl ChildProcess {
    /// Starts the process without standard input.
    pub fn start(command: &mut Command) -> anyhow::Result<Self> {
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut process = command.spawn().context("this program cannot be started again")?;
        let stdout = process.stdout.take().context("a process without standard output")?;
        let stderr = process.stderr.take().context("a process without standard error output")?;
        let lines = read_lines(stdout);
        let errors = Some(thread::spawn(move || read_errors(stderr)));
        Ok(Self { process, lines, errors })
    }

    /// Waits for the next object, at most for a time.
    pub fn line(&mut self, limit: Duration) -> anyhow::Result<Value> {
        match self.lines.recv_timeout(limit) {
            Ok(line) => {
                serde_json::from_str(&line).context("a process wrote a line that is no JSON")
            }
            Err(RecvTimeoutError::Timeout) => {
                bail!("a process wrote nothing for {:.0} s{}", limit.as_secs_f64(), self.end())
            }
            Err(RecvTimeoutError::Disconnected) => bail!("a process ended{}", self.end()),
        }
    }

    /// Sends a signal by its name, such as INT. A process that has ended gets none.
    pub fn signal(&self, name: &str) -> anyhow::Result<()> {
        let id = self.process.id().to_string();
        // Without its message about a process that has ended.
        let kill = Command::new("kill").args(["-s", name, &id]).stderr(Stdio::null()).status();
        kill.context("kill: cannot be run")?;
        Ok(())
    }

    /// Ends the process and returns its errors.
    fn end(&mut self) -> String {
        // A process that has ended already needs no signal.
        let _ = self.process.kill();
        let _ = self.process.wait();
        let errors = self.errors.take().and_then(|reader| reader.join().ok()).unwrap_or_default();
        let errors = errors.trim();
        if errors.is_empty() { String::new() } else { format!(": {errors}") }
    }
}

impl Drop for ChildProcess {
    fn drop(&mut self) {
        self.end();
    }
}

/// Reads lines on a thread until the stream ends. The process waits only while 16 lines are unread.
fn read_lines(stdout: ChildStdout) -> Receiver<String> {
    let (sender, lines) = sync_channel(16);
    thread::spawn(move || {
        let mut stdout = BufReader::new(stdout);
        loop {
            let mut line = String::new();
            let read = (&mut stdout).take(MAX_LINE).read_line(&mut line);
            if !matches!(read, Ok(1..)) || sender.send(line).is_err() {
                return;
            }
        }
    });
    lines
}

/// Reads the whole stream and returns its begin.
fn read_errors(mut stderr: ChildStderr) -> String {
    let mut kept = Vec::new();
    // What cannot be read is missing from a message only.
    let _ = (&mut stderr).take(KEPT_ERRORS).read_to_end(&mut kept);
    let _ = std::io::copy(&mut stderr, &mut std::io::sink());
    String::from_utf8_lossy(&kept).into_owned()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    fn shell(script: &str) -> ChildProcess {
        let mut command = Command::new("sh");
        ChildProcess::start(command.args(["-c", script])).expect("a shell")
    }

    /// A pipe holds 64 KiB: a process that writes more to an unread one waits for ever.
    #[test]
    fn process_with_long_error_output_still_answers() {
        let mut process = shell("head -c 1000000 /dev/zero >&2; echo '{\"done\": true}'");
        let answer = process.line(Duration::from_secs(60)).expect("an answer");
        assert_eq!(answer["done"], true);
    }

    #[test]
    fn silent_process_is_ended_after_its_time() {
        let mut process = shell("echo why >&2; exec sleep 1000");
        let error = process.line(Duration::from_millis(500)).expect_err("no answer");
        let text = error.to_string();
        assert!(text.contains("nothing for") && text.contains("why"), "{text}");
        assert!(process.process.try_wait().expect("a state").is_some());
    }

    #[test]
    fn process_that_ends_without_an_answer_gives_its_errors() {
        let mut process = shell("echo broken >&2; exit 3");
        let error = process.line(Duration::from_secs(60)).expect_err("no answer");
        assert_eq!(error.to_string(), "a process ended: broken");
    }
}
