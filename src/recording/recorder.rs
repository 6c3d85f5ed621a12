//! Records a drive in its own thread. An error of the file never affects the drive.

use std::io::{self, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;

use super::error::RecordingError;
use super::messages::{self, BASE_FRAME, MAP_FRAME, Topic, header};
use super::metadata::{DriveMetadata, DriveSummary};
use super::tick::RecordedTick;
use super::writer::{Entry, RecordingWriter};
use crate::ros::convert::{self, SAMPLING, markers, nanoseconds};
use crate::ros::msg::{Duration, Message, Time, TwistStamped};
use crate::runtime::TickEvent;

/// Maximum number of ticks that wait for the disk: 6.4 s at 10 Hz. It limits the memory.
const QUEUE_TICKS: usize = 64;
const TOO_SLOW: &str = "the disk is too slow for the drive";
const WRONG_DEADLINE: &str = "DriveMetadata::new must get the settings of Config::in_real_time for a robot with a clock of its own";
const WRONG_CONTROLLER: &str = "DriveMetadata::controller must name the controller that decides, and none where inbye's behaviours do";
/// Markers of a recording remain until the next tick replaces them.
const MARKER_LIFETIME: Duration = Duration { sec: 0, nanosec: 0 };

/// What a recorder does when its queue is full.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BackpressurePolicy {
    /// The drive waits for the disk: for simulated time.
    Block,
    /// The recording ends: for a real robot. A recording without some of its ticks could not be replayed.
    Stop,
}

/// The result of a recording.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct RecordingReport {
    /// Number of readable messages in the file.
    pub messages: u64,
    /// Number of bytes written.
    pub bytes: u64,
    /// Why the recording ended before the drive, if it did.
    pub stopped: Option<String>,
}

/// Records the [`TickEvent`]s of a drive.
pub struct Recorder {
    /// None after the end of the recording.
    queue: Option<SyncSender<Job>>,
    /// None after the thread was joined.
    thread: Option<JoinHandle<RecordingReport>>,
    report: RecordingReport,
    policy: BackpressurePolicy,
    engine: String,
    has_controller: bool,
    has_deadline: bool,
    range_min_m: f64,
    /// Time of the odometry of the last tick, seconds.
    odometry_s: f64,
    ticks: u64,
    plans: usize,
}

crate::settings::opaque_debug!(Recorder);

enum Job {
    Start(f64),
    Tick(Vec<Entry>),
    End(DriveSummary),
}

impl Recorder {
    /// Writes the metadata and starts the thread.
    ///
    /// # Errors
    /// When the metadata cannot be written, or the system provides no thread.
    pub fn new<W: Write + Send + 'static>(
        file: W,
        metadata: &DriveMetadata,
        policy: BackpressurePolicy,
    ) -> Result<Self, RecordingError> {
        let bytes = Arc::new(AtomicU64::new(0));
        let file = CountingWriter { file, bytes: Arc::clone(&bytes) };
        let writer = RecordingWriter::new(file, metadata)?;
        let (queue, jobs) = sync_channel(QUEUE_TICKS);
        let thread = std::thread::Builder::new()
            .name("inbye-recorder".to_owned())
            .spawn(move || write(writer, &jobs, &bytes))
            .map_err(RecordingError::NoThread)?;
        Ok(Self {
            queue: Some(queue),
            thread: Some(thread),
            report: RecordingReport::default(),
            policy,
            engine: metadata.engine.clone(),
            has_controller: metadata.controller.is_some(),
            has_deadline: metadata.config.navigator.deadline_s.is_some(),
            range_min_m: metadata.config.simulation.lidar.range_min_m,
            odometry_s: f64::NAN,
            ticks: 0,
            plans: 0,
        })
    }

    /// Sets the date of the recording's time zero, seconds since 1970-01-01 00:00 UTC, before the first tick of a real drive. A simulated one has
    /// none: its recording has the same bytes each time.
    pub fn set_start(&mut self, unix_s: f64) {
        if let Some(queue) = &self.queue {
            // A thread that has ended reports why at the first tick.
            let _ = queue.send(Job::Start(unix_s));
        }
    }

    /// Sets the shortest range of the lidar, metres, where it is not that of the simulated lidar in the settings.
    pub const fn set_range_min_m(&mut self, range_min_m: f64) {
        self.range_min_m = range_min_m;
    }

    /// Records a tick. Returns false if the recording ends with it: [`Self::stopped`] has the cause. It ends at once where a controller
    /// decides and [`DriveMetadata::controller`] has no name, or the other way round, and likewise for the deadline of the decisions: it
    /// could not be replayed.
    pub fn record(&mut self, event: &TickEvent<'_>) -> bool {
        let Some(queue) = &self.queue else {
            return true;
        };
        let navigator = event.navigator;
        let wrong_controller = navigator.controller_name().is_some() != self.has_controller;
        let wrong_deadline = navigator.deadline_stats().is_some() != self.has_deadline;
        if wrong_controller || wrong_deadline {
            self.queue = None;
            let cause = if wrong_controller { WRONG_CONTROLLER } else { WRONG_DEADLINE };
            self.report.stopped = Some(cause.to_owned());
            return false;
        }
        let job = Job::Tick(self.entries(event));
        self.odometry_s = event.observation.odometry_s;
        self.ticks += 1;
        self.plans = event.navigator.plans().len();
        let error = match self.policy {
            BackpressurePolicy::Block => queue.send(job).err().map(|_| None),
            BackpressurePolicy::Stop => queue.try_send(job).err().map(|error| match error {
                TrySendError::Full(_) => Some(TOO_SLOW),
                TrySendError::Disconnected(_) => None,
            }),
        };
        let Some(cause) = error else { return true };
        self.queue = None;
        match cause {
            // The thread writes its queue; the drive does not wait for it.
            Some(cause) => self.report.stopped = Some(cause.to_owned()),
            // The thread ended by itself.
            None => self.join(),
        }
        false
    }

    /// Why the recording ended before the drive, if it did.
    #[must_use]
    pub fn stopped(&self) -> Option<&str> {
        self.report.stopped.as_deref()
    }

    /// Ends the recording with the digest of the drive's trace. Waits for the disk.
    #[must_use]
    pub fn finish(mut self, trace_digest: String) -> RecordingReport {
        if let Some(queue) = self.queue.take() {
            // If the thread has ended, its report has the cause.
            let _ = queue.send(Job::End(DriveSummary { ticks: self.ticks, trace_digest }));
        }
        self.join();
        self.report
    }

    fn join(&mut self) {
        let Some(thread) = self.thread.take() else {
            return;
        };
        let panicked = |_| RecordingReport {
            stopped: Some("the recorder's thread panicked".to_owned()),
            ..RecordingReport::default()
        };
        let report = thread.join().unwrap_or_else(panicked);
        self.report =
            RecordingReport { stopped: self.report.stopped.take().or(report.stopped), ..report };
    }

    /// The messages of a tick.
    fn entries(&self, event: &TickEvent<'_>) -> Vec<Entry> {
        let TickEvent { observation, odometry, decision, took_s, navigator, .. } = *event;
        let (time_s, odometry_s) = (observation.time_s, observation.odometry_s);
        let time_ns = nanoseconds(time_s);
        let entry = |topic, bytes| Entry { topic, time_ns, bytes };
        let map_header = header(time_s, MAP_FRAME);
        let plans = navigator.plans();
        let new_plan = plans.get(self.plans..).and_then(<[_]>::last);
        let plan = new_plan.map(|plan| convert::path(plan.smoothed.points(), &map_header).to_cdr());
        let updated_map = event.updated_map.map(|map| messages::map(time_s, map).to_cdr());
        let updated_map = updated_map.map(|map| entry(Topic::UpdatedMap, map));
        let plan = plan.map(|plan| entry(Topic::Plan, plan));
        let mut entries: Vec<Entry> = updated_map.into_iter().chain(plan).collect();
        if odometry_s != self.odometry_s {
            // The pose is that of the newest odometry, and the scan is as seen from there.
            let scan = messages::laser_scan(odometry_s, &observation.scan, self.range_min_m);
            // As the node: a lost robot has no pose in the map.
            let estimate = observation.lost.is_none().then_some(&observation.pose);
            let lidar = &observation.scan.origin;
            let transforms = messages::transforms(odometry_s, estimate, &odometry.pose, lidar);
            entries.extend([
                entry(Topic::Scan, scan.to_cdr()),
                entry(Topic::Odometry, messages::odometry(odometry_s, odometry).to_cdr()),
                entry(Topic::Transforms, transforms.to_cdr()),
            ]);
        }
        let fan = event.fan(SAMPLING);
        let moving = navigator.obstacle_model().moving();
        let markers = markers(fan.as_ref(), moving, &map_header, MARKER_LIFETIME);
        let stamp = Time::from_seconds(time_s);
        let command = TwistStamped::new(&decision.command, stamp, BASE_FRAME);
        let diagnostics = messages::diagnostics(event, &self.engine);
        let tick = RecordedTick {
            tick: self.ticks,
            observation: observation.clone(),
            decision: decision.clone(),
            reply: navigator.controller_reply().cloned(),
            plans: plans.len() as u64,
            plans_received: navigator.plans_received(),
            took_s,
            awaits_operator: event.protective_action.awaits_operator(),
        };
        entries.extend([
            entry(Topic::Markers, markers.to_cdr()),
            entry(Topic::Command, command.to_cdr()),
            entry(Topic::Diagnostics, diagnostics.to_cdr()),
            entry(Topic::Tick, tick.to_cdr()),
        ]);
        entries
    }
}

/// Writes the jobs until the end or the first error.
fn write<W: Write>(
    mut writer: RecordingWriter<W>,
    jobs: &Receiver<Job>,
    bytes: &AtomicU64,
) -> RecordingReport {
    let mut work = || {
        for job in jobs {
            match job {
                Job::Start(unix_s) => writer.write_start(unix_s)?,
                Job::Tick(entries) => writer.write(&entries)?,
                Job::End(summary) => return writer.finish(&summary),
            }
        }
        writer.end_chunk()
    };
    let stopped = work().err().map(|error: RecordingError| error.to_string());
    let messages = writer.written();
    drop(writer);
    RecordingReport { messages, bytes: bytes.load(Ordering::Relaxed), stopped }
}

/// Counts the bytes that a file accepts.
struct CountingWriter<W> {
    file: W,
    bytes: Arc<AtomicU64>,
}

impl<W: Write> Write for CountingWriter<W> {
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        let written = self.file.write(buffer)?;
        self.bytes.fetch_add(written as u64, Ordering::Relaxed);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}
