//! The metadata of a recorded drive: everything that its navigator needs, and a summary of its end.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::error::{FORMAT, RecordingError};
use crate::geometry::{Point, Pose};
use crate::map::{GridFrame, OccupancyGrid, Zones};
use crate::navigator::{Goal, Waypoints};
use crate::runtime::{Config, Mission};
use crate::suggest::in_one_line;

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
    /// Zones of the map, if there are any.
    pub zones: Option<Arc<Zones>>,
    /// Name of the engine.
    pub engine: String,
    /// Name of the controller that decided in place of inbye's behaviours, if there was one.
    pub controller: Option<String>,
}

/// The end of a drive.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct DriveSummary {
    /// Number of recorded ticks.
    pub ticks: u64,
    /// The digest of the trace: [`Trace::digest`](crate::runtime::Trace::digest).
    pub trace_digest: String,
}

impl DriveMetadata {
    /// The metadata of a mission with these settings and the controller that they name. For a drive with a controller object, set
    /// [`Self::controller`] to its name.
    #[must_use]
    pub fn new(mission: &Mission, config: &Config, engine: String) -> Self {
        Self {
            config: config.clone(),
            waypoints: Waypoints { start: mission.start.position(), goals: mission.stops() },
            map: Arc::clone(&mission.map),
            zones: mission.zones.clone(),
            engine,
            controller: config.controller.name(),
        }
    }

    /// The attachments [`CONFIG`] and [`DRIVE`].
    pub(super) fn attachments(&self) -> Result<[(&'static str, String); 2], RecordingError> {
        let drive = DriveFile {
            format: FORMAT,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            engine: self.engine.clone(),
            controller: self.controller.clone(),
            start: self.waypoints.start,
            map: *self.map.frame(),
            has_zones: self.zones.is_some(),
            stops: self.waypoints.goals.iter().map(Stop::of).collect(),
        };
        Ok([(CONFIG, toml(CONFIG, &self.config)?), (DRIVE, toml(DRIVE, &drive)?)])
    }

    /// Joins the attachments. The cells of the map and of its zones come from their messages.
    pub(super) fn join(
        config: &str,
        drive: DriveFile,
        cells: Vec<i8>,
        zones: Option<Vec<i8>>,
    ) -> Result<Self, RecordingError> {
        if drive.format != FORMAT {
            return Err(RecordingError::OtherFormat {
                found: drive.format.to_string(),
                writer: drive.version,
            });
        }
        let config: Config = parse(CONFIG, config)?;
        config.validate()?;
        let GridFrame { width, height, resolution_m, origin } = drive.map;
        let frame = GridFrame::new(width, height, resolution_m, origin)?;
        let grid = |cells| OccupancyGrid::from_cells(frame, cells);
        Ok(Self {
            config,
            waypoints: Waypoints {
                start: drive.start,
                goals: drive.stops.iter().map(Stop::goal).collect(),
            },
            map: Arc::new(grid(cells)?),
            zones: zones.map(grid).transpose()?.map(|zones| Arc::new(Zones::from_grid(&zones))),
            engine: drive.engine,
            controller: drive.controller,
        })
    }
}

/// The contents of [`DRIVE`]. TOML keeps every bit of the numbers.
#[derive(Serialize, Deserialize)]
pub(super) struct DriveFile {
    format: u32,
    version: String,
    engine: String,
    controller: Option<String>,
    start: Point,
    /// Whether the map has zones.
    #[serde(default)]
    pub has_zones: bool,
    #[serde(with = "MapFrame")]
    map: GridFrame,
    stops: Vec<Stop>,
}

impl DriveFile {
    pub fn parse(text: &str) -> Result<Self, RecordingError> {
        parse(DRIVE, text)
    }
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "GridFrame")]
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
    RecordingError::BadMetadata { name, reason: in_one_line(&error.to_string()) }
}
