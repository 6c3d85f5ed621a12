//! A process that exchanges lines of text with this one.

use std::cell::Cell;
use std::collections::{BTreeSet, VecDeque};
use std::io::{self, BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStderr, ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Longest line of a process with its line end, bytes.
pub(super) const MAX_LINE: u64 = 1 << 20;
/// Lines of a process that wait to be read; the process waits while there are more.
const MAX_UNREAD: usize = 16;
/// Bytes at the end of the standard error output that are kept.
const KEPT_ERRORS: usize = 16 << 10;
/// Time for a process to end by itself after its input has ended.
const GRACE: Duration = Duration::from_millis(500);
/// Time for the rest of the output of a process that has ended. A process outside its group may hold the streams.
const LAST_OUTPUT: Duration = Duration::from_millis(200);
const POLL: Duration = Duration::from_millis(2);
/// Time between two checks whether a process that writes nothing has ended.
const END_POLL: Duration = Duration::from_millis(20);

/// The processes that run. On Unix each is the leader of its group.
static RUNNING: Mutex<BTreeSet<u32>> = Mutex::new(BTreeSet::new());

/// Why there is no line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineError {
    /// The process wrote none within the time.
    Timeout,
    /// The wait was interrupted, see [`interruptible`].
    Interrupted,
    /// The process has ended or has closed its standard output.
    Ended,
    /// The process wrote a line that is too long. Nothing after it is read.
    TooLong,
}

thread_local! {
    /// Asked while this thread waits for a line.
    static IS_INTERRUPTED: Cell<Option<Box<dyn FnMut() -> bool>>> = const { Cell::new(None) };
}

/// Runs work in this thread. While it waits for a line of a process, it asks at least every 20 ms whether it is interrupted; if so,
/// the wait ends.
pub fn interruptible<R>(
    is_interrupted: impl FnMut() -> bool + 'static,
    work: impl FnOnce() -> R,
) -> R {
    /// Restores the earlier question, also after a panic.
    struct Restore(Option<Box<dyn FnMut() -> bool>>);
    impl Drop for Restore {
        fn drop(&mut self) {
            IS_INTERRUPTED.set(self.0.take());
        }
    }
    let _restore = Restore(IS_INTERRUPTED.replace(Some(Box::new(is_interrupted))));
    work()
}

/// Asks the question of [`interruptible`]. It may use processes itself, and is not asked again meanwhile.
fn is_interrupted() -> bool {
    let mut asked = IS_INTERRUPTED.take();
    let answer = asked.as_mut().is_some_and(|is_interrupted| is_interrupted());
    IS_INTERRUPTED.set(asked);
    answer
}

/// A process that writes lines, and may read lines. It is ended when this is dropped.
///
/// Its streams are read all the time, so that it never waits for a reader, and writing to it never blocks. On Unix it has a
/// process group of its own: Ctrl-C in the terminal does not reach it, and the processes that it started are ended with it.
pub struct LineProcess {
    process: Child,
    /// Whether the process has ended and its group was killed.
    is_over: bool,
    status: Option<ExitStatus>,
    input: Option<Sender<String>>,
    lines: Receiver<Result<String, LineError>>,
    errors: Arc<Mutex<VecDeque<u8>>>,
    /// Disconnected when the whole standard error output has been read.
    errors_open: Receiver<()>,
}

impl LineProcess {
    /// Starts the process, which reads lines from its standard input.
    ///
    /// # Errors
    /// When it cannot be started.
    pub fn start(command: &mut Command) -> io::Result<Self> {
        Self::start_with(command, Stdio::piped())
    }

    /// Starts the process with an empty standard input.
    ///
    /// # Errors
    /// When it cannot be started.
    pub fn start_without_input(command: &mut Command) -> io::Result<Self> {
        Self::start_with(command, Stdio::null())
    }

    fn start_with(command: &mut Command, stdin: Stdio) -> io::Result<Self> {
        command.stdin(stdin).stdout(Stdio::piped()).stderr(Stdio::piped());
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(command, 0);
        let mut process = command.spawn()?;
        running().insert(process.id());
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
            is_over: false,
            status: None,
            errors,
            errors_open,
        })
    }

    /// Kills all processes that run, for a program that is about to exit.
    pub fn kill_all() {
        running().iter().for_each(|&id| kill_group(id));
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
    /// [`LineError`]. Lines that are there already come before an interrupt.
    pub fn line(&mut self, limit: Duration) -> Result<String, LineError> {
        let until = Instant::now() + limit;
        loop {
            let left = until.saturating_duration_since(Instant::now());
            match self.lines.recv_timeout(left.min(END_POLL)) {
                Ok(line) => return line,
                Err(RecvTimeoutError::Disconnected) => return Err(LineError::Ended),
                Err(RecvTimeoutError::Timeout) if self.has_ended() => {
                    let last = self.lines.recv_timeout(LAST_OUTPUT);
                    return last.unwrap_or(Err(LineError::Ended));
                }
                Err(RecvTimeoutError::Timeout) if left.is_zero() => return Err(LineError::Timeout),
                Err(RecvTimeoutError::Timeout) if is_interrupted() => {
                    return Err(LineError::Interrupted);
                }
                Err(RecvTimeoutError::Timeout) => {}
            }
        }
    }

    /// The next line if it is there already.
    pub fn waiting_line(&self) -> Option<String> {
        self.lines.try_recv().ok().map(Result::unwrap_or_default)
    }

    /// The status of a process that has ended by itself, as far as it is known.
    #[must_use]
    pub const fn status(&self) -> Option<ExitStatus> {
        self.status
    }

    fn has_ended(&mut self) -> bool {
        if !self.is_over
            && let Ok(Some(status)) = self.process.try_wait()
        {
            self.status = Some(status);
            self.kill_rest();
        }
        self.is_over
    }

    /// Kills what is left of the group. This follows the end of the process at once, before another group can get its number.
    fn kill_rest(&mut self) {
        self.is_over = true;
        running().remove(&self.process.id());
        kill_group(self.process.id());
    }

    /// The id of the process.
    #[must_use]
    pub fn id(&self) -> u32 {
        self.process.id()
    }

    /// Ends the process, to which the wait gives more time, and returns the lines that were not read, as far as they are kept.
    pub(super) fn last_lines(&mut self, more_time: Duration) -> Vec<String> {
        self.end_within(GRACE + more_time);
        let line = |_| self.lines.recv_timeout(LAST_OUTPUT).ok()?.ok();
        (0..=MAX_UNREAD).map_while(line).collect()
    }

    /// Ends the input, waits a moment for the process, then kills it with its group. Returns the end of its standard error
    /// output.
    pub fn end(&mut self) -> String {
        self.end_within(GRACE)
    }

    fn end_within(&mut self, grace: Duration) -> String {
        if self.input.take().is_some() {
            let until = Instant::now() + grace;
            while !self.has_ended() && Instant::now() < until {
                thread::sleep(POLL);
            }
        }
        if !self.has_ended() {
            self.kill_rest();
            // A process that has ended already needs no signal.
            let _ = self.process.kill();
            let _ = self.process.wait();
        }
        let _ = self.errors_open.recv_timeout(LAST_OUTPUT);
        let errors = self.errors.lock().unwrap_or_else(PoisonError::into_inner);
        let bytes: Vec<u8> = errors.iter().copied().collect();
        String::from_utf8_lossy(&bytes).into_owned()
    }
}

/// Runs a command with a process group of its own and returns its status. Once `is_interrupted` is true, the group gets SIGTERM, and
/// the call waits for its end. What is left of the group then is killed.
///
/// # Errors
/// When it cannot be started.
pub fn run_in_group(
    command: &mut Command,
    is_interrupted: impl Fn() -> bool,
) -> io::Result<ExitStatus> {
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(command, 0);
    let mut process = command.spawn()?;
    let id = process.id();
    running().insert(id);
    let mut was_told = false;
    let status = loop {
        if let Some(status) = process.try_wait().transpose() {
            break status;
        }
        if !was_told && is_interrupted() {
            was_told = true;
            end_group(id);
        }
        thread::sleep(END_POLL);
    };
    running().remove(&id);
    kill_group(id);
    status
}

impl Drop for LineProcess {
    fn drop(&mut self) {
        self.end();
    }
}

fn running() -> MutexGuard<'static, BTreeSet<u32>> {
    RUNNING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Kills the processes of the group with this leader.
#[cfg(unix)]
fn kill_group(leader: u32) {
    signal_group(leader, nix::sys::signal::Signal::SIGKILL);
}

/// Asks the processes of the group with this leader to end.
#[cfg(unix)]
fn end_group(leader: u32) {
    signal_group(leader, nix::sys::signal::Signal::SIGTERM);
}

#[cfg(unix)]
fn signal_group(leader: u32, signal: nix::sys::signal::Signal) {
    // A group without processes needs no signal.
    let _ = nix::sys::signal::killpg(nix::unistd::Pid::from_raw(leader.cast_signed()), signal);
}

/// Elsewhere there are no groups: the process itself is killed by its handle.
#[cfg(not(unix))]
const fn kill_group(_leader: u32) {}

#[cfg(not(unix))]
const fn end_group(_leader: u32) {}

/// Writes lines on a thread until there are no more.
fn write_lines(mut stdin: ChildStdin) -> Sender<String> {
    let (sender, lines) = channel::<String>();
    thread::spawn(move || {
        hold_broken_pipe_signal();
        for mut line in lines {
            line.push('\n');
            if stdin.write_all(line.as_bytes()).and_then(|()| stdin.flush()).is_err() {
                return;
            }
        }
    });
    sender
}

/// Holds back the SIGPIPE of this thread's writes until the thread ends: a write to a process that has ended then is only an error. A
/// C program that contains this library has the default action of that signal, which would end it.
#[cfg(unix)]
fn hold_broken_pipe_signal() {
    use nix::sys::signal::{SigSet, Signal};
    // This cannot fail for a valid signal.
    let _ = SigSet::from(Signal::SIGPIPE).thread_block();
}

#[cfg(not(unix))]
const fn hold_broken_pipe_signal() {}

/// Reads lines on a thread until the stream ends or a line is too long.
fn read_lines(stdout: ChildStdout) -> Receiver<Result<String, LineError>> {
    let (sender, lines) = sync_channel(MAX_UNREAD);
    thread::spawn(move || {
        let mut stdout = BufReader::new(stdout);
        loop {
            let mut line = Vec::new();
            let read = (&mut stdout).take(MAX_LINE).read_until(b'\n', &mut line);
            let is_whole = line.ends_with(b"\n") || (line.len() as u64) < MAX_LINE;
            let line = String::from_utf8_lossy(&line).into_owned();
            let line = if is_whole { Ok(line) } else { Err(LineError::TooLong) };
            if !matches!(read, Ok(1..)) || sender.send(line).is_err() || !is_whole {
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
    use std::os::unix::process::ExitStatusExt;

    use super::*;

    const LONG: Duration = Duration::from_secs(60);

    fn shell(script: &str, has_input: bool) -> LineProcess {
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        let started = if has_input {
            LineProcess::start(&mut command)
        } else {
            LineProcess::start_without_input(&mut command)
        };
        started.expect("a shell")
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
        assert_eq!(process.status(), None);
    }

    #[test]
    fn process_that_ended_gives_its_last_errors() {
        let mut process = shell("echo first >&2; echo broken >&2; exit 3", true);
        assert_eq!(process.line(LONG), Err(LineError::Ended));
        assert_eq!(process.end(), "first\nbroken\n");
        assert_eq!(process.status().and_then(|status| status.code()), Some(3));
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

    /// The processes of a group, without those that wait for their parent.
    #[cfg(target_os = "linux")]
    fn group_size(leader: u32) -> usize {
        let stat = |entry: io::Result<std::fs::DirEntry>| {
            std::fs::read_to_string(entry.ok()?.path().join("stat")).ok()
        };
        let is_member = |stat: &String| {
            let fields = stat.rsplit(')').next().unwrap_or_default();
            let mut fields = fields.split_whitespace();
            fields.next() != Some("Z") && fields.nth(1) == Some(&leader.to_string())
        };
        let processes = std::fs::read_dir("/proc").expect("a list of processes");
        processes.filter_map(stat).filter(is_member).count()
    }

    /// A process that the process started may hold its streams open.
    #[cfg(target_os = "linux")]
    #[test]
    fn end_kills_the_processes_of_the_process() {
        let mut process = shell("sleep 1000 & echo started; wait", true);
        assert_eq!(process.line(LONG), Ok("started\n".to_owned()));
        let leader = process.id();
        assert_eq!(group_size(leader), 2);
        let began = Instant::now();
        process.end();
        assert!(began.elapsed() < LONG);
        let until = Instant::now() + LONG;
        while group_size(leader) > 0 {
            assert!(Instant::now() < until, "the group lives on");
            thread::sleep(POLL);
        }
    }

    /// The streams of a wrapper are open as long as what it started.
    #[test]
    fn end_of_a_process_is_noticed_while_another_one_holds_its_streams() {
        let mut process = shell("sleep 1000 & echo last; kill -SEGV $$", true);
        assert_eq!(process.line(LONG), Ok("last\n".to_owned()));
        let began = Instant::now();
        assert_eq!(process.line(LONG), Err(LineError::Ended));
        assert!(began.elapsed() < LONG / 2);
        let signal = process.status().and_then(|status| status.signal());
        assert_eq!(signal, Some(11));
    }

    #[test]
    fn interrupted_command_gets_sigterm_with_its_group() {
        let mut command = Command::new("sh");
        let began = Instant::now();
        let script = "trap 'exit 5' TERM; sleep 1000 & wait";
        let is_late = || began.elapsed() > Duration::from_millis(300);
        let status = run_in_group(command.args(["-c", script]), is_late).expect("a shell");
        assert!(began.elapsed() < LONG && status.code() == Some(5), "{status}");
        let mut command = Command::new("sh");
        let status = run_in_group(command.args(["-c", "exit 3"]), || false).expect("a shell");
        assert_eq!(status.code(), Some(3));
    }

    #[test]
    fn interrupt_ends_a_wait_in_its_scope() {
        let mut process = shell("sleep 1; echo late; exec sleep 1000", false);
        let began = Instant::now();
        let wait = || process.line(LONG);
        assert_eq!(interruptible(|| true, wait), Err(LineError::Interrupted));
        assert!(began.elapsed() < LONG / 2);
        assert_eq!(process.line(LONG), Ok("late\n".to_owned()));
    }

    #[test]
    fn line_that_is_too_long_is_an_error() {
        let mut process = shell("head -c 1048576 /dev/zero; echo; sleep 1000", false);
        assert_eq!(process.line(LONG), Err(LineError::TooLong));
        assert_eq!(process.line(LONG), Err(LineError::Ended));
    }

    #[test]
    fn line_before_its_message_is_there_at_once() {
        let mut process = shell("echo one; echo two; exec sleep 1000", false);
        assert_eq!(process.line(LONG), Ok("one\n".to_owned()));
        let until = Instant::now() + LONG;
        let second = loop {
            let line = process.waiting_line();
            if line.is_some() || Instant::now() > until {
                break line;
            }
        };
        assert_eq!((second, process.waiting_line()), (Some("two\n".to_owned()), None));
    }
}
