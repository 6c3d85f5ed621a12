//! The file of `drive --record`: ROS 2 messages during the drive, or its ticks as lines of JSON afterwards.

use std::fs::File;
use std::io::{self, Write};
use std::mem;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::SystemTime;

use anyhow::bail;
use inbye::navigator::Mode;
use inbye::recording::{BackpressurePolicy, DriveMetadata, Recorder, RecordingReport};
use inbye::runtime::{Config, Mission, MissionResult, TickEvent};
use serde_json::{Value, json};

use super::files::has_extension;
use super::hardware_drive::HardwareDrive;
use super::output;
use super::own_file::OutputFile;

/// A recording in progress.
pub struct Recording<'a> {
    name: &'a Path,
    kind: Kind,
    /// Whether the drive has begun, so that the file may lose what an earlier drive wrote.
    has_begun: Arc<AtomicBool>,
    /// The control period of a real drive whose start is to be recorded, seconds.
    period_s: Option<f64>,
}

enum Kind {
    Lines(OutputFile),
    Mcap(Box<Recorder>),
    /// The recording could not start.
    Stopped(String),
}

/// A finished recording.
pub struct Ending {
    /// Whether the file holds the whole drive.
    pub is_whole: bool,
    pub object: Value,
    pub line: String,
}

impl<'a> Recording<'a> {
    /// Prepares a recording: MCAP for the extension `.mcap`. The file stays as it is until the robot has begun to drive. A drive in
    /// real time does not wait for the disk.
    pub fn begin(
        (file, name): (OutputFile, &'a Path),
        mission: &Mission,
        config: &Config,
        engine: String,
        hardware: Option<&HardwareDrive>,
    ) -> Self {
        let has_begun = Arc::default();
        let period_s = hardware.map(|_| config.local.control_period_s);
        if !has_extension(name, "mcap") {
            return Self { name, kind: Kind::Lines(file), has_begun, period_s };
        }
        let policy =
            if hardware.is_some() { BackpressurePolicy::Stop } else { BackpressurePolicy::Block };
        let real_time = hardware.map(|_| config.clone().in_real_time());
        let metadata = DriveMetadata::new(mission, real_time.as_ref().unwrap_or(config), engine);
        let file = DeferredFile {
            has_begun: Arc::clone(&has_begun),
            output: Some(file),
            file: None,
            waiting: Vec::new(),
        };
        let kind = match Recorder::new(file, &metadata, policy) {
            Ok(mut recorder) => {
                if let Some(range_m) = hardware.and_then(HardwareDrive::lidar_range_min_m) {
                    recorder.set_range_min_m(range_m);
                }
                Kind::Mcap(Box::new(recorder))
            }
            Err(error) => Kind::Stopped(error.to_string()),
        };
        Self { name, kind, has_begun, period_s }
    }

    /// The warning before the drive, if the recording could not start.
    pub fn warning(&self) -> Option<String> {
        match &self.kind {
            Kind::Stopped(why) => Some(warning(self.name, why)),
            Kind::Lines(_) | Kind::Mcap(_) => None,
        }
    }

    /// Records a tick. Returns a warning if the recording stopped.
    pub fn record(&mut self, tick: &TickEvent<'_>) -> Option<String> {
        let Kind::Mcap(recorder) = &mut self.kind else {
            return None;
        };
        // Settings that no engine takes fail at the first decision, like a start in an obstacle before it.
        if tick.row.mode != Mode::Failed {
            self.has_begun.store(true, Ordering::Release);
        }
        if let Some(period_s) = self.period_s.take() {
            // The tick ends a period after its decision.
            let since_s = tick.row.time_s + tick.took_s + period_s;
            let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
            recorder.set_start(now.unwrap_or_default().as_secs_f64() - since_s);
        }
        if recorder.record(tick) {
            return None;
        }
        Some(warning(self.name, recorder.stopped()?))
    }

    /// Finishes the recording after the drive, and warns if it stopped only now.
    pub fn end(self, result: &MissionResult) -> Ending {
        self.has_begun.store(true, Ordering::Release);
        let (has_warned, recorded) = match self.kind {
            Kind::Mcap(recorder) => {
                (recorder.stopped().is_some(), recorder.finish(result.trace.digest()))
            }
            Kind::Lines(file) => (false, write_lines(file, result)),
            Kind::Stopped(why) => {
                (true, RecordingReport { stopped: Some(why), ..RecordingReport::default() })
            }
        };
        let RecordingReport { messages, bytes, stopped, .. } = recorded;
        if let Some(why) = stopped.as_ref().filter(|_| !has_warned) {
            output::warn(warning(self.name, why));
        }
        let (name, mb) = (self.name.display(), bytes as f64 / 1e6);
        let stop = stopped.as_ref().map(|why| format!("; STOPPED before the end: {why}"));
        let stop = stop.unwrap_or_default();
        Ending {
            is_whole: stopped.is_none(),
            line: format!("recording    {name}: {messages} messages, {mb:.1} MB{stop}"),
            object: json!({
                "file": self.name.to_string_lossy(), "messages": messages, "bytes": bytes, "stopped": stopped,
            }),
        }
    }
}

/// The file of a recording. It stays as it is until the drive has begun; until then the content waits in memory. The recorder's
/// thread empties the file, so that a real base does not wait for the disk.
struct DeferredFile {
    has_begun: Arc<AtomicBool>,
    /// None once it has been begun.
    output: Option<OutputFile>,
    /// None until then.
    file: Option<File>,
    waiting: Vec<u8>,
}

impl DeferredFile {
    /// The file with all that waited; none before the drive has begun.
    fn begun(&mut self) -> io::Result<Option<&mut File>> {
        if self.has_begun.load(Ordering::Acquire)
            && let Some(output) = self.output.take()
        {
            let mut file = output.begin()?;
            file.write_all(&mem::take(&mut self.waiting))?;
            self.file = Some(file);
        }
        Ok(self.file.as_mut())
    }
}

impl Write for DeferredFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if let Some(file) = self.begun()? {
            return file.write(bytes);
        }
        self.waiting.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.begun()?.map_or(Ok(()), File::flush)
    }
}

fn warning(name: &Path, why: &str) -> String {
    format!("the recording stopped: --record {}: {why}; the drive is not affected", name.display())
}

/// Writes every tick as a line of JSON.
fn write_lines(file: OutputFile, result: &MissionResult) -> RecordingReport {
    let write = || -> io::Result<usize> {
        let mut lines = Vec::new();
        for row in &result.trace.rows {
            serde_json::to_writer(&mut lines, row)?;
            lines.push(b'\n');
        }
        file.write(&lines)?;
        Ok(lines.len())
    };
    match write() {
        Ok(bytes) => RecordingReport {
            messages: result.trace.rows.len() as u64,
            bytes: bytes as u64,
            ..RecordingReport::default()
        },
        Err(error) => {
            RecordingReport { stopped: Some(error.to_string()), ..RecordingReport::default() }
        }
    }
}

/// Writes every tick of a run as a line of JSON into the file of a flag.
pub fn write_ticks(flag: &str, file: OutputFile, result: &MissionResult) -> anyhow::Result<()> {
    write_lines(file, result).stopped.map_or(Ok(()), |why| bail!("{flag}: {why}"))
}
