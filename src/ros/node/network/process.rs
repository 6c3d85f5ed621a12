//! A running network process and its pipes. No call waits.

use std::io::{self, BufReader, BufWriter};
use std::process::{Child, ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::thread;
use std::time::Duration;

use super::frame::{FromNetwork, ToNetwork, read_frame, write_frame};

/// Frames that wait for the network process. More mean that it hangs.
const OUTBOX: usize = 64;
/// Frames that wait for the control process, and their bytes. With more, the network process waits.
const INBOX: usize = 256;
const MAX_QUEUED_BYTES: usize = 64 << 20;
const FULL_PAUSE: Duration = Duration::from_millis(2);

/// A network process.
pub struct NetworkProcess {
    child: Child,
    outbox: Option<SyncSender<ToNetwork>>,
    inbox: Receiver<(FromNetwork, usize)>,
    queued_bytes: Arc<AtomicUsize>,
}

/// Why a process no longer delivers frames.
#[derive(Debug)]
pub struct PipeClosed;

impl NetworkProcess {
    /// Starts the process with pipes as its standard input and output.
    ///
    /// # Errors
    /// When process or threads do not start.
    pub fn start(command: &mut Command) -> io::Result<Self> {
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        let no_pipe = || io::Error::other("the process has no pipe");
        let stdin = child.stdin.take().ok_or_else(no_pipe)?;
        let stdout = child.stdout.take().ok_or_else(no_pipe)?;
        let queued_bytes = Arc::new(AtomicUsize::new(0));
        let (outbox, to_write) = sync_channel(OUTBOX);
        let (read, inbox) = sync_channel(INBOX);
        let queued = Arc::clone(&queued_bytes);
        let threads = thread::Builder::new()
            .name("inbye-to-network".to_owned())
            .spawn(move || write_all(stdin, &to_write))
            .and_then(|_| {
                let name = "inbye-from-network".to_owned();
                thread::Builder::new().name(name).spawn(move || read_all(stdout, &read, &queued))
            });
        if let Err(error) = threads {
            end(&mut child);
            return Err(error);
        }
        Ok(Self { child, outbox: Some(outbox), inbox, queued_bytes })
    }

    /// Takes the next frame that arrived, if there is one.
    ///
    /// # Errors
    /// When the pipe is closed and all frames are taken.
    pub fn receive(&self) -> Result<Option<FromNetwork>, PipeClosed> {
        match self.inbox.try_recv() {
            Ok((frame, bytes)) => {
                self.queued_bytes.fetch_sub(bytes, Ordering::Relaxed);
                Ok(Some(frame))
            }
            Err(TryRecvError::Empty) => Ok(None),
            Err(TryRecvError::Disconnected) => Err(PipeClosed),
        }
    }

    /// Sends a frame. Returns false if the process does not take it.
    pub fn send(&self, frame: ToNetwork) -> bool {
        self.outbox.as_ref().is_some_and(|outbox| outbox.try_send(frame).is_ok())
    }

    /// Closes the pipe to the process, which makes it publish zeros and end.
    pub fn close(&mut self) {
        self.outbox = None;
    }

    /// The exit status, if the process has ended.
    pub fn exit_status(&mut self) -> Option<ExitStatus> {
        self.child.try_wait().ok().flatten()
    }
}

/// A dropped process is ended.
impl Drop for NetworkProcess {
    fn drop(&mut self) {
        end(&mut self.child);
    }
}

fn end(child: &mut Child) {
    // An error means that it has ended.
    let _ = child.kill();
    let _ = child.wait();
}

fn write_all(stdin: ChildStdin, frames: &Receiver<ToNetwork>) {
    let mut writer = BufWriter::new(stdin);
    for frame in frames {
        if write_frame(&mut writer, &frame).is_err() {
            return;
        }
    }
}

fn read_all(
    stdout: ChildStdout,
    frames: &SyncSender<(FromNetwork, usize)>,
    queued: &Arc<AtomicUsize>,
) {
    let mut reader = BufReader::new(stdout);
    while let Ok((frame, bytes)) = read_frame(&mut reader) {
        while queued.load(Ordering::Relaxed) > MAX_QUEUED_BYTES {
            // Without the other owner no frame is ever taken.
            if Arc::strong_count(queued) == 1 {
                return;
            }
            thread::sleep(FULL_PAUSE);
        }
        queued.fetch_add(bytes, Ordering::Relaxed);
        if frames.send((frame, bytes)).is_err() {
            return;
        }
    }
}
