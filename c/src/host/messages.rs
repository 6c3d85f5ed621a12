//! The messages of the protocol that a controller needs.

use serde::{Deserialize, Serialize};

use crate::interface::InbyeLimits;

#[derive(Deserialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Message {
    Start(Start),
    Tick(Box<Tick>),
}

#[derive(Deserialize)]
pub struct Start {
    pub period_s: f64,
    pub robot: Robot,
}

#[derive(Deserialize)]
pub struct Robot {
    pub radius_m: f64,
    pub limits: InbyeLimits,
}

#[derive(Deserialize)]
pub struct Tick {
    pub time_s: f64,
    pub pose: [f64; 3],
    pub twist: [f64; 2],
    pub predicted_pose: [f64; 3],
    pub predicted_twist: [f64; 2],
    pub last_command: [f64; 2],
    pub limits: InbyeLimits,
    pub goal: (f64, f64, Option<f64>),
    pub local_target: [f64; 2],
    pub path: Option<Vec<[f64; 2]>>,
    pub path_progress_m: f64,
    pub reset: bool,
    pub scan: Scan,
    pub scan_s: f64,
    #[serde(default)]
    pub moving_obstacles: Vec<Disc>,
}

#[derive(Deserialize)]
pub struct Scan {
    /// Place of the lidar in the robot's frame, metres.
    pub origin: [f64; 2],
    pub angle_min: f64,
    pub angle_increment: f64,
    pub range_max: f64,
    /// No measurement is null; nothing within range is the longest range.
    pub ranges: Vec<Option<f64>>,
}

#[derive(Deserialize)]
pub struct Disc {
    pub x: f64,
    pub y: f64,
    pub radius: f64,
    pub vx: f64,
    pub vy: f64,
}

#[derive(Serialize)]
pub struct Ready<'a> {
    pub protocol: u32,
    pub name: &'a str,
    pub wants: [&'static str; 1],
}

#[derive(Serialize)]
#[serde(untagged)]
pub enum Answer {
    Velocity { linear: f64, angular: f64 },
    Error { error: String },
}
