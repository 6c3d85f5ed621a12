//! A process that exchanges lines of text with this one.

use std::collections::VecDeque;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStderr, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Longest line of a process, bytes.
const MAX_LINE: u64 = 1 << 20;
/// Lines of a process that wait to be read; the process waits while there are more.
const MAX_UNREAD: usize = 16;
/// Bytes at the end of the standard error output that are kept.
const KEPT_ERRORS: usize = 16 << 10;
/// Time for a process to end by itself after its input has ended.
const GRACE: Duration = Duration::from_millis(500);
/// Time for the rest of the standard error output of a process that has ended. A process that it started may hold the stream.
const LAST_ERRORS: Duration = Duration::from_millis(200);
const POLL: Duration = Duration::from_millis(2);

/// Why there is no line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineError {
    /// The process wrote none within the time.
    Timeout,
    /// The process has closed its standard output.
    Ended,
}

/// A process that writes lines, and may read lines. It is ended when this is dropped.
///
/// Its streams are read all the time, so that it never waits for a reader, and writing to it never blocks.
pub struct LineProcess {
    process: Child,
    input: Option<Sender<String>>,
    lines: Receiver<String>,
    errors: Arc<Mutex<VecDeque<u8>>>,
    /// Disconnected when the whole standard error output has been read.
    errors_open: Receiver<()>,
}

impl LineProcess {
    /// Starts the process, with or without standard input.
    ///
    /// # Errors
    /// When it cannot be started.
    pub fn start(command: &mut Command, has_input: bool) -> io::Result<Self> {
        let stdin = if has_input { Stdio::piped() } else { Stdio::null() };
        command.stdin(stdin).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut process = command.spawn()?;
        let missing = || io::Error::other("a process without its streams");
        let stdout = process.stdout.take().ok_or_else(missing)?;
        let stderr = process.stderr.take().ok_or_else(missing)?;
        let errors = Arc::new(Mutex::new(VecDeque::new()));
        let (open, errors_open) = channel();
        let kept = Arc::clone(&errors);
        thread::spawn(move || {
            keep_errors(stderr, &kept);
            drop(open);
        });
        Ok(Self {
            input: process.stdin.take().map(write_lines),
            lines: read_lines(stdout),
            process,
            errors,
            errors_open,
        })
    }

    /// Writes a line. One that the process can no longer read is lost; [`Self::line`] then tells that it has ended.
    pub fn send(&self, line: String) {
        if let Some(input) = &self.input {
            let _ = input.send(line);
        }
    }

    /// Waits for the next line, at most for a time.
    ///
    /// # Errors
    /// [`LineError`].
    pub fn line(&mut self, limit: Duration) -> Result<String, LineError> {
        self.lines.recv_timeout(limit).map_err(|error| match error {
            RecvTimeoutError::Timeout => LineError::Timeout,
            RecvTimeoutError::Disconnected => LineError::Ended,
        })
    }

    /// The id of the process.
    #[must_use]
    pub fn id(&self) -> u32 {
        self.process.id()
    }

    /// Ends the input, waits a moment for the process, then kills it. Returns the end of its standard error output.
    pub fn end(&mut self) -> String {
        if self.input.take().is_some() {
            let until = Instant::now() + GRACE;
            while matches!(self.process.try_wait(), Ok(None)) && Instant::now() < until {
                thread::sleep(POLL);
            }
        }
        // A process that has ended already needs no signal.
        let _ = self.process.kill();
        let _ = self.process.wait();
        let _ = self.errors_open.recv_timeout(LAST_ERRORS);
        let errors = self.errors.lock().unwrap_or_else(PoisonError::into_inner);
        let bytes: Vec<u8> = errors.iter().copied().collect();
        String::from_utf8_lossy(&bytes).into_owned()
    }
}

impl Drop for LineProcess {
    fn drop(&mut self) {
        self.end();
    }
}

/// Writes lines on a thread until there are no more.
fn write_lines(mut stdin: ChildStdin) -> Sender<String> {
    let (sender, lines) = channel::<String>();
    thread::spawn(move || {
        for mut line in lines {
            line.push('\n');
            if stdin.write_all(line.as_bytes()).and_then(|()| stdin.flush()).is_err() {
                return;
            }
        }
    });
    sender
}

/// Reads lines on a thread until the stream ends.
fn read_lines(stdout: ChildStdout) -> Receiver<String> {
    let (sender, lines) = sync_channel(MAX_UNREAD);
    thread::spawn(move || {
        let mut stdout = BufReader::new(stdout);
        loop {
            let mut line = Vec::new();
            let read = (&mut stdout).take(MAX_LINE).read_until(b'\n', &mut line);
            let line = String::from_utf8_lossy(&line).into_owned();
            if !matches!(read, Ok(1..)) || sender.send(line).is_err() {
                return;
            }
        }
    });
    lines
}

/// Reads the whole stream and keeps its end.
fn keep_errors(mut stderr: ChildStderr, kept: &Mutex<VecDeque<u8>>) {
    let mut buffer = [0; 4096];
    while let Ok(read @ 1..) = stderr.read(&mut buffer) {
        let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.extend(&buffer[..read]);
        let surplus = kept.len().saturating_sub(KEPT_ERRORS);
        kept.drain(..surplus);
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    const LONG: Duration = Duration::from_secs(60);

    fn shell(script: &str, has_input: bool) -> LineProcess {
        let mut command = Command::new("sh");
        LineProcess::start(command.args(["-c", script]), has_input).expect("a shell")
    }

    /// A pipe holds 64 KiB: a process that writes more to an unread one waits for ever.
    #[test]
    fn process_with_long_error_output_still_answers() {
        let mut process = shell("head -c 1000000 /dev/zero >&2; echo done", false);
        assert_eq!(process.line(LONG), Ok("done\n".to_owned()));
    }

    #[test]
    fn silent_process_is_killed_at_the_end() {
        let mut process = shell("echo why >&2; exec sleep 1000", true);
        assert_eq!(process.line(Duration::from_millis(300)), Err(LineError::Timeout));
        assert_eq!(process.end(), "why\n");
        assert!(process.process.try_wait().expect("a state").is_some());
    }

    #[test]
    fn process_that_ended_gives_its_last_errors() {
        let mut process = shell("echo first >&2; echo broken >&2; exit 3", true);
        assert_eq!(process.line(LONG), Err(LineError::Ended));
        assert_eq!(process.end(), "first\nbroken\n");
    }

    #[test]
    fn lines_are_answered_in_order_and_the_end_of_the_input_ends_the_process() {
        let mut process = shell("while read line; do echo \"<$line>\"; done; echo bye >&2", true);
        for word in ["one", "two"] {
            process.send(word.to_owned());
            assert_eq!(process.line(LONG), Ok(format!("<{word}>\n")));
        }
        assert_eq!(process.end(), "bye\n");
    }

    /// A process that the process started may hold its streams open.
    #[test]
    fn end_does_not_wait_for_a_process_of_the_process() {
        let mut process = shell("sleep 1000 & echo started", false);
        assert_eq!(process.line(LONG), Ok("started\n".to_owned()));
        let began = Instant::now();
        process.end();
        assert!(began.elapsed() < LONG);
    }
}
