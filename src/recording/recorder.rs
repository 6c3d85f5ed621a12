//! Recording as a drive goes on, on a thread of its own. Whatever happens to the file, the drive does not notice.

use std::io::{self, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;

use super::messages::{self, FAN, Status};
use super::writer::{Entry, RecordingWriter};
use super::{Head, RecordingError, Tail, Topic, parts};
use crate::runtime::TickEvent;

/// Ticks that may wait for the disk: 6.4 s at 10 Hz. This is what bounds the memory.
const WAITING_TICKS: usize = 64;
const TOO_SLOW: &str = "the disk is too slow for the drive";

/// What to do with a tick while the disk is busy with those before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DiskBusy {
    /// Wait: for simulated time, which waits as well.
    Wait,
    /// End the recording: for a real robot, which does not. A recording without some of its ticks could not be replayed.
    Stop,
}

/// What became of a recording.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Recorded {
    /// Messages that can be read from the file.
    pub messages: u64,
    /// Bytes written.
    pub bytes: u64,
    /// Why it ended before the drive, if it did.
    pub stopped: Option<String>,
}

/// Records a drive: give it every [`TickEvent`].
pub struct Recorder {
    /// None once the recording has ended.
    queue: Option<SyncSender<Job>>,
    /// None once it was joined.
    thread: Option<JoinHandle<Recorded>>,
    /// What the thread said in the end.
    recorded: Recorded,
    disk_busy: DiskBusy,
    engine: String,
    range_min_m: f64,
    ticks: u64,
    plans: usize,
}

enum Job {
    Tick(Vec<Entry>),
    End(Tail),
}

impl Recorder {
    /// Begins a recording: writes the head and starts the thread.
    ///
    /// # Errors
    /// When the head cannot be written, or there is no thread.
    pub fn new<W: Write + Send + 'static>(
        file: W,
        head: &Head,
        disk_busy: DiskBusy,
    ) -> Result<Self, RecordingError> {
        let bytes = Arc::new(AtomicU64::new(0));
        let file = Counted {
            file,
            bytes: Arc::clone(&bytes),
        };
        let writer = RecordingWriter::new(file, head)?;
        let (queue, jobs) = sync_channel(WAITING_TICKS);
        let thread = std::thread::Builder::new()
            .name("inbye-recorder".to_owned())
            .spawn(move || write(writer, &jobs, &bytes))
            .map_err(RecordingError::NoThread)?;
        Ok(Self {
            queue: Some(queue),
            thread: Some(thread),
            recorded: Recorded::default(),
            disk_busy,
            engine: head.engine.clone(),
            range_min_m: head.config.lidar.range_min_m,
            ticks: 0,
            plans: 0,
        })
    }

    /// Records a tick. False when this ended the recording: [`Self::stopped`] says why.
    pub fn record(&mut self, moment: &TickEvent<'_>) -> bool {
        let Some(queue) = &self.queue else {
            return true;
        };
        let job = Job::Tick(entries(self, moment));
        self.ticks += 1;
        self.plans = moment.navigator.plans().len();
        let why = match self.disk_busy {
            DiskBusy::Wait => queue.send(job).err().map(|_| None),
            DiskBusy::Stop => queue.try_send(job).err().map(|error| match error {
                TrySendError::Full(_) => Some(TOO_SLOW),
                TrySendError::Disconnected(_) => None,
            }),
        };
        let Some(why) = why else { return true };
        self.queue = None;
        match why {
            // The thread writes what waits, and is not waited for.
            Some(why) => self.recorded.stopped = Some(why.to_owned()),
            // It has ended by itself.
            None => self.join(),
        }
        false
    }

    /// Why the recording ended before the drive, if it did.
    #[must_use]
    pub fn stopped(&self) -> Option<&str> {
        self.recorded.stopped.as_deref()
    }

    /// Ends the recording with the digest of the drive's trace; waits for the disk.
    #[must_use]
    pub fn finish(mut self, trace_digest: String) -> Recorded {
        if let Some(queue) = self.queue.take() {
            // Where the thread has ended it says why below.
            let _ = queue.send(Job::End(Tail {
                ticks: self.ticks,
                trace_digest,
            }));
        }
        self.join();
        self.recorded
    }

    fn join(&mut self) {
        let Some(thread) = self.thread.take() else {
            return;
        };
        let lost = |_| Recorded {
            stopped: Some("the recorder's thread is lost".to_owned()),
            ..Recorded::default()
        };
        let recorded = thread.join().unwrap_or_else(lost);
        self.recorded = Recorded {
            stopped: self.recorded.stopped.take().or(recorded.stopped),
            ..recorded
        };
    }
}

/// The messages of a tick.
fn entries(recorder: &Recorder, moment: &TickEvent<'_>) -> Vec<Entry> {
    let TickEvent {
        observation,
        odometry,
        decision,
        took_s,
        navigator,
        ..
    } = *moment;
    let time_s = observation.time_s;
    let mut entries = Vec::with_capacity(Topic::ALL.len());
    let mut add = |topic, at_s: f64, bytes| {
        entries.push(Entry {
            topic,
            time: parts::nanoseconds(at_s),
            bytes,
        });
    };
    let plans = navigator.plans();
    if plans.len() > recorder.plans
        && let Some(newest) = plans.last()
    {
        add(
            Topic::Plan,
            time_s,
            messages::plan(time_s, &newest.smoothed),
        );
    }
    let scan_s = observation.scan_s;
    let scan = messages::scan(scan_s, &observation.scan, recorder.range_min_m);
    add(Topic::Scan, scan_s, scan);
    add(
        Topic::Odometry,
        time_s,
        messages::odometry(time_s, odometry),
    );
    let transforms = messages::transforms(time_s, &observation.pose, &odometry.pose);
    add(Topic::Transforms, time_s, transforms);
    let fan = moment.fan(FAN);
    add(
        Topic::Markers,
        time_s,
        messages::markers(time_s, fan.as_ref()),
    );
    add(
        Topic::Command,
        time_s,
        messages::command(time_s, &decision.command),
    );
    let status = Status {
        time_s,
        decision,
        took_s,
        navigator,
        engine: &recorder.engine,
    };
    add(Topic::Diagnostics, time_s, messages::diagnostics(&status));
    let counters = (plans.len() as u64, navigator.plans_received());
    let tick = messages::tick(recorder.ticks, observation, decision, counters, took_s);
    add(Topic::Tick, time_s, tick);
    entries
}

/// Writes what comes until the end or the first error.
fn write<W: Write>(
    mut writer: RecordingWriter<W>,
    jobs: &Receiver<Job>,
    bytes: &AtomicU64,
) -> Recorded {
    let mut work = || {
        for job in jobs {
            match job {
                Job::Tick(entries) => writer.write(&entries)?,
                Job::End(tail) => return writer.finish(&tail),
            }
        }
        writer.end_chunk()
    };
    let stopped = work().err().map(|error: RecordingError| error.to_string());
    let messages = writer.written();
    drop(writer);
    Recorded {
        messages,
        bytes: bytes.load(Ordering::Relaxed),
        stopped,
    }
}

/// A file that counts what it takes.
struct Counted<W> {
    file: W,
    bytes: Arc<AtomicU64>,
}

impl<W: Write> Write for Counted<W> {
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        let taken = self.file.write(buffer)?;
        self.bytes.fetch_add(taken as u64, Ordering::Relaxed);
        Ok(taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}
