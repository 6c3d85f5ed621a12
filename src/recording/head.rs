//! What a recording says of its drive besides the ticks: everything that a navigator is made of, and how it ended.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::RecordingError;
use super::error::FORMAT;
use crate::geometry::{Point, Pose};
use crate::map::{GridFrame, OccupancyGrid};
use crate::navigator::{Goal, Waypoints};
use crate::runtime::{Config, Mission};

/// The attachment with the configuration, as `--config` reads it.
pub const CONFIG: &str = "config.toml";
/// The attachment with the journey and the map's place.
pub const DRIVE: &str = "drive.toml";

/// How a drive began.
#[derive(Clone, Debug, PartialEq)]
pub struct Head {
    /// Every setting.
    pub config: Config,
    /// Start and stops.
    pub journey: Waypoints,
    /// The map that the robot has.
    pub map: Arc<OccupancyGrid>,
    /// What decided, by name.
    pub engine: String,
}

/// How it ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tail {
    /// Ticks recorded.
    pub ticks: u64,
    /// The digest of [`Trace::digest`](crate::runtime::Trace::digest).
    pub trace_digest: String,
}

impl Head {
    /// That of a mission with these settings.
    #[must_use]
    pub fn new(mission: &Mission, config: &Config, engine: String) -> Self {
        Self {
            config: config.clone(),
            journey: Waypoints {
                start: mission.start.position(),
                stops: mission.stops(),
            },
            map: Arc::clone(&mission.map),
            engine,
        }
    }

    /// The attachments: [`CONFIG`] and [`DRIVE`].
    pub(super) fn texts(&self) -> Result<[(&'static str, String); 2], RecordingError> {
        let frame = self.map.frame();
        let drive = Drive {
            format: FORMAT,
            inbye: env!("CARGO_PKG_VERSION").to_owned(),
            engine: self.engine.clone(),
            start: [self.journey.start.x, self.journey.start.y],
            map: Frame {
                width: frame.width,
                height: frame.height,
                resolution_m: frame.resolution_m,
                origin: frame.origin,
            },
            stops: self.journey.stops.iter().map(Stop::of).collect(),
        };
        Ok([
            (CONFIG, toml(CONFIG, &self.config)?),
            (DRIVE, toml(DRIVE, &drive)?),
        ])
    }

    /// Reads the attachments and the cells of the map.
    pub(super) fn read(config: &str, drive: &str, cells: Vec<i8>) -> Result<Self, RecordingError> {
        let drive: Drive = parse(DRIVE, drive)?;
        if drive.format != FORMAT {
            return Err(RecordingError::OtherFormat {
                found: drive.format.to_string(),
                writer: drive.inbye,
            });
        }
        let config: Config = parse(CONFIG, config)?;
        config.validate()?;
        let Frame {
            width,
            height,
            resolution_m,
            origin,
        } = drive.map;
        let frame = GridFrame::new(width, height, resolution_m, origin)?;
        if cells.len() != frame.len() {
            let reason = format!("{} cells of {width} x {height}", cells.len());
            return Err(RecordingError::BadHead {
                name: DRIVE,
                reason,
            });
        }
        let [x, y] = drive.start;
        Ok(Self {
            config,
            journey: Waypoints {
                start: Point::new(x, y),
                stops: drive.stops.iter().map(Stop::goal).collect(),
            },
            map: Arc::new(OccupancyGrid::new(frame, cells)),
            engine: drive.engine,
        })
    }
}

/// [`DRIVE`] as text. Real numbers are written so that they are read to the same bits.
#[derive(Serialize, Deserialize)]
struct Drive {
    format: u32,
    inbye: String,
    engine: String,
    start: [f64; 2],
    map: Frame,
    stops: Vec<Stop>,
}

#[derive(Serialize, Deserialize)]
struct Frame {
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
        Goal {
            position: Point::new(self.x, self.y),
            yaw: self.yaw,
        }
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
    RecordingError::BadHead { name, reason }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers that a decimal of few digits does not hold.
    fn head() -> Head {
        let third = 1.0 / 3.0;
        let frame = GridFrame::new(3, 2, 0.1 + 0.2, Pose::new(-0.0, 1e-300, third)).expect("sound");
        let mut config = Config::default();
        config.robot.track_width_m = third;
        config.local.sim_time_s = 2.9_f64.next_up();
        config.navigator.deadline_s = Some(0.1_f64.next_down());
        let goal = |yaw| Goal {
            position: Point::new(0.1_f64.next_up(), -1e22),
            yaw,
        };
        Head {
            config,
            journey: Waypoints {
                start: Point::new(third, 5e-324),
                stops: vec![goal(None), goal(Some(third.next_up()))],
            },
            map: Arc::new(OccupancyGrid::new(frame, vec![-1, 0, 1, 65, 99, 100])),
            engine: "CPU \"of\" some\tkind".to_owned(),
        }
    }

    #[test]
    fn a_head_is_read_to_the_bit() {
        let head = head();
        let [(_, config), (_, drive)] = head.texts().expect("it can be written");
        let read = Head::read(&config, &drive, head.map.cells().to_vec()).expect("and read");
        assert_eq!(read, head);
        // `==` takes -0 for 0.
        let bits = |head: &Head| head.map.frame().origin.x.to_bits();
        assert_eq!(bits(&read), bits(&head));
        let mut other = head.clone();
        other.journey.start.x = other.journey.start.x.next_up();
        assert_ne!(read, other);
    }

    #[test]
    fn another_format_is_refused_by_its_name() {
        let head = head();
        let [(_, config), (_, drive)] = head.texts().expect("it can be written");
        let newer = drive.replace("format = 2", "format = 3");
        let error = Head::read(&config, &newer, Vec::new()).expect_err("it is newer");
        assert!(error.to_string().contains("format 3"), "{error}");
        assert!(Head::read(&config, &drive, vec![0]).is_err());
    }
}
