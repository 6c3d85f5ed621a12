//! The metadata of a recorded drive: everything that its navigator needs, and a summary of its end.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::error::{FORMAT, RecordingError};
use crate::geometry::{Point, Pose};
use crate::map::{GridFrame, OccupancyGrid};
use crate::navigator::{Goal, Waypoints};
use crate::runtime::{Config, Mission};

/// The attachment with the configuration in TOML.
pub const CONFIG: &str = "config.toml";
/// The attachment with waypoints and map frame in TOML.
pub const DRIVE: &str = "drive.toml";

/// The initial state of a drive.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveMetadata {
    /// All settings.
    pub config: Config,
    /// Start and goals.
    pub waypoints: Waypoints,
    /// The robot's map.
    pub map: Arc<OccupancyGrid>,
    /// Name of the engine.
    pub engine: String,
}

/// The end of a drive.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DriveSummary {
    /// Number of recorded ticks.
    pub ticks: u64,
    /// The digest of the trace: [`Trace::digest`](crate::runtime::Trace::digest).
    pub trace_digest: String,
}

impl DriveMetadata {
    /// The metadata of a mission with these settings.
    #[must_use]
    pub fn new(mission: &Mission, config: &Config, engine: String) -> Self {
        Self {
            config: config.clone(),
            waypoints: Waypoints { start: mission.start.position(), goals: mission.stops() },
            map: Arc::clone(&mission.map),
            engine,
        }
    }

    /// The attachments [`CONFIG`] and [`DRIVE`].
    pub(super) fn attachments(&self) -> Result<[(&'static str, String); 2], RecordingError> {
        let frame = self.map.frame();
        let drive = DriveFile {
            format: FORMAT,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            engine: self.engine.clone(),
            start: [self.waypoints.start.x, self.waypoints.start.y],
            map: MapFrame {
                width: frame.width,
                height: frame.height,
                resolution_m: frame.resolution_m,
                origin: frame.origin,
            },
            stops: self.waypoints.goals.iter().map(Stop::of).collect(),
        };
        Ok([(CONFIG, toml(CONFIG, &self.config)?), (DRIVE, toml(DRIVE, &drive)?)])
    }

    /// Parses the attachments. The cells of the map come from its message.
    pub(super) fn read(config: &str, drive: &str, cells: Vec<i8>) -> Result<Self, RecordingError> {
        let drive: DriveFile = parse(DRIVE, drive)?;
        if drive.format != FORMAT {
            return Err(RecordingError::OtherFormat {
                found: drive.format.to_string(),
                writer: drive.version,
            });
        }
        let config: Config = parse(CONFIG, config)?;
        config.validate()?;
        let MapFrame { width, height, resolution_m, origin } = drive.map;
        let frame = GridFrame::new(width, height, resolution_m, origin)?;
        if cells.len() != frame.len() {
            let reason = format!("{} cells of {width} x {height}", cells.len());
            return Err(RecordingError::BadMetadata { name: DRIVE, reason });
        }
        let [x, y] = drive.start;
        Ok(Self {
            config,
            waypoints: Waypoints {
                start: Point::new(x, y),
                goals: drive.stops.iter().map(Stop::goal).collect(),
            },
            map: Arc::new(OccupancyGrid::new(frame, cells)),
            engine: drive.engine,
        })
    }
}

/// The contents of [`DRIVE`]. TOML keeps every bit of the numbers.
#[derive(Serialize, Deserialize)]
struct DriveFile {
    format: u32,
    version: String,
    engine: String,
    start: [f64; 2],
    map: MapFrame,
    stops: Vec<Stop>,
}

#[derive(Serialize, Deserialize)]
struct MapFrame {
    width: i32,
    height: i32,
    resolution_m: f64,
    origin: Pose,
}

#[derive(Serialize, Deserialize)]
struct Stop {
    x: f64,
    y: f64,
    yaw: Option<f64>,
}

impl Stop {
    fn of(goal: &Goal) -> Self {
        let Goal { position, yaw } = *goal;
        let (x, y) = (position.x, position.y);
        Self { x, y, yaw }
    }

    fn goal(&self) -> Goal {
        Goal { position: Point::new(self.x, self.y), yaw: self.yaw }
    }
}

fn toml(name: &'static str, value: &impl Serialize) -> Result<String, RecordingError> {
    toml::to_string(value).map_err(|error| bad(name, &error))
}

fn parse<T: for<'a> Deserialize<'a>>(name: &'static str, text: &str) -> Result<T, RecordingError> {
    toml::from_str(text).map_err(|error| bad(name, &error))
}

fn bad(name: &'static str, error: &impl ToString) -> RecordingError {
    let lines = error.to_string();
    let reason = lines.split_whitespace().collect::<Vec<_>>().join(" ");
    RecordingError::BadMetadata { name, reason }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Metadata with numbers that need all their digits.
    fn metadata() -> DriveMetadata {
        let third = 1.0 / 3.0;
        let frame =
            GridFrame::new(3, 2, 0.1 + 0.2, Pose::new(-0.0, 1e-300, third)).expect("a valid frame");
        let mut config = Config::default();
        config.robot.track_width_m = third;
        config.local.sim_time_s = 2.9_f64.next_up();
        config.navigator.deadline_s = Some(0.1_f64.next_down());
        let goal = |yaw| Goal { position: Point::new(0.1_f64.next_up(), -1e22), yaw };
        DriveMetadata {
            config,
            waypoints: Waypoints {
                start: Point::new(third, 5e-324),
                goals: vec![goal(None), goal(Some(third.next_up()))],
            },
            map: Arc::new(OccupancyGrid::new(frame, vec![-1, 0, 1, 65, 99, 100])),
            engine: "CPU \"of\" some\tkind".to_owned(),
        }
    }

    #[test]
    fn attachments_keep_every_bit() {
        let metadata = metadata();
        let [(_, config), (_, drive)] = metadata.attachments().expect("valid metadata");
        let read = DriveMetadata::read(&config, &drive, metadata.map.cells().to_vec())
            .expect("valid metadata");
        assert_eq!(read, metadata);
        // `==` does not distinguish -0 and 0.
        let bits = |metadata: &DriveMetadata| metadata.map.frame().origin.x.to_bits();
        assert_eq!(bits(&read), bits(&metadata));
        let mut other = metadata.clone();
        other.waypoints.start.x = other.waypoints.start.x.next_up();
        assert_ne!(read, other);
    }

    #[test]
    fn other_format_is_rejected() {
        let metadata = metadata();
        let [(_, config), (_, drive)] = metadata.attachments().expect("valid metadata");
        let newer = drive.replace("format = 3", "format = 4");
        let error = DriveMetadata::read(&config, &newer, Vec::new()).expect_err("a newer format");
        assert!(error.to_string().contains("format 4"), "{error}");
        assert!(DriveMetadata::read(&config, &drive, vec![0]).is_err());
    }
}
