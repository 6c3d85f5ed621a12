//! Logs of real robots: text files, and recordings of ROS 2.

use std::fs::File;
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;
use inbye::input_file::list;
use inbye::lidar_log::{LidarLog, recording_files};

use super::files::has_extension;
use super::output;
use super::refusal::refused;

/// Extensions of files that must be converted first, and what to do.
const OTHER_FILES: [(&str, &str); 4] = [
    ("db3", "is a recording in SQLite: convert it to MCAP with `ros2 bag convert`"),
    ("zstd", "is compressed: decompress it with `zstd -d`"),
    ("zst", "is compressed: decompress it with `zstd -d`"),
    ("gz", "is compressed: decompress it with `gunzip`"),
];

/// How a log is read.
#[derive(Debug, Args)]
pub struct LogFileArguments {
    /// Topic of the scans in a recording of ROS 2 with several.
    #[arg(long, value_name = "TOPIC")]
    pub scan_topic: Option<String>,
    /// Topic of the odometry in a recording of ROS 2 with several.
    #[arg(long, value_name = "TOPIC")]
    pub odometry_topic: Option<String>,
}

impl LogFileArguments {
    /// Reads a log: a text file, an MCAP file, or a folder of `rosbag2` with MCAP files.
    pub fn read(&self, path: &Path) -> anyhow::Result<LidarLog> {
        let mut files = if path.is_dir() { listed(path)? } else { vec![path.to_path_buf()] };
        let has = |extension: &str| files.iter().any(|file| has_extension(file, extension));
        let other = OTHER_FILES.iter().find(|(extension, _)| !has("mcap") && has(extension));
        if let Some((_, problem)) = other {
            bail!("{}: {problem}", path.display());
        }
        if path.is_dir() {
            let is_recording = |file: &PathBuf| has_extension(file, "mcap");
            files.retain(is_recording);
            if let Some(mut named) = recording_files(path)? {
                named.retain(is_recording);
                for file in files.iter().filter(|file| !named.contains(file)) {
                    output::note(format!(
                        "{}: not read: metadata.yaml does not name it",
                        file.display()
                    ));
                }
                files = named;
            }
            if files.is_empty() {
                bail!("{}: the folder has no .mcap file: name a log", path.display());
            }
        } else if !has_extension(path, "mcap") {
            for (name, topic) in self.topics() {
                if topic.is_some() {
                    bail!("{name}: {} is no recording of ROS 2", path.display());
                }
            }
            let log = LidarLog::read(path)?;
            if let Some(line) = log.cut_line {
                output::warn(format!(
                    "{}: line {line} was cut off and is left out",
                    path.display()
                ));
            }
            return Ok(log);
        }
        self.read_recording(&files)
    }

    /// The options that choose a topic, with their values: of the scans, and of the odometry.
    pub fn topics(&self) -> [(&'static str, Option<&str>); 2] {
        [
            ("--scan-topic", self.scan_topic.as_deref()),
            ("--odometry-topic", self.odometry_topic.as_deref()),
        ]
    }

    #[cfg(feature = "mcap")]
    fn read_recording(&self, files: &[PathBuf]) -> anyhow::Result<LidarLog> {
        use inbye::recording::{RecordingError, RosLogReader};

        let [(scans, scan_topic), (odometry, odometry_topic)] = self.topics();
        let mut reader = RosLogReader::new(scan_topic, odometry_topic);
        for path in files {
            let place = || path.display().to_string();
            let file = File::open(path).map_err(|error| unreadable(path, &error))?;
            reader.read(BufReader::new(file)).with_context(place)?;
        }
        let last = files.last().map_or(Path::new(""), PathBuf::as_path).display();
        let (log, warnings) = reader.finish().map_err(|error| {
            let option = match error {
                RecordingError::SeveralTopics { name: "LaserScan", .. } => scans,
                RecordingError::SeveralTopics { .. } => odometry,
                _ => return anyhow::Error::from(error).context(last.to_string()),
            };
            anyhow::anyhow!("{error} with {option}").context(last.to_string())
        })?;
        for warning in warnings {
            output::warn(format!("{last}: {warning}"));
        }
        Ok(log)
    }

    #[cfg(not(feature = "mcap"))]
    fn read_recording(&self, _: &[PathBuf]) -> anyhow::Result<LidarLog> {
        bail!("this build reads no MCAP files: build it with the feature mcap")
    }
}

fn unreadable(path: &Path, error: &io::Error) -> anyhow::Error {
    refused(format!("{}: cannot be read", path.display()), error, "check the path")
}

/// The files of a folder in the order of their numbers: `run_2.mcap` before `run_10.mcap`.
fn listed(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let mut files = list(folder).with_context(|| folder.display().to_string())?;
    files.sort_by_key(|file| (file.as_os_str().len(), file.clone()));
    Ok(files)
}
