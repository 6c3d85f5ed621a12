//! The moving obstacles of a simulation, and the files that describe them.

use std::path::Path;

use rand::RngExt;
use serde::Deserialize;

use super::{MovingObstacle, RngStream, SimError, SpawnTrigger, TimedPath, generator};
use crate::geometry::{Point, Pose};
use crate::input_file::read_text;
use crate::map::{GridFrame, MovingDisc, ObstacleGrid};
use crate::robot::Footprint;
use crate::settings::{line_in_json, line_in_toml};
use crate::suggest::{in_one_line, without_rust_types};

/// Gap that a yielding obstacle leaves to the robot, metres. It takes no step that ends both nearer than this and nearer
/// than before.
pub const YIELD_GAP_M: f64 = 0.3;

/// Time, seconds, after which a yielding obstacle changes its route.
pub(crate) const YIELD_TIMEOUT_S: f64 = 3.0;

/// Longest step, seconds: 2 cm at 1 m/s.
const SUB_STEP_S: f64 = 0.02;

/// The moving obstacles, identified by their indices. They ignore each other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MovingObstacles {
    moving: Vec<MovingObstacle>,
}

impl MovingObstacles {
    /// Creates the collection.
    #[must_use]
    pub const fn new(moving: Vec<MovingObstacle>) -> Self {
        Self { moving }
    }

    /// Adds an obstacle; the others keep their states and indices.
    pub fn push(&mut self, one: MovingObstacle) {
        self.moving.push(one);
    }

    /// Number of obstacles, including those that have not yet appeared.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.moving.len()
    }

    /// Whether there are no obstacles.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.moving.is_empty()
    }

    /// The obstacles, in order.
    pub fn iter(&self) -> impl Iterator<Item = &MovingObstacle> {
        self.moving.iter()
    }

    /// Advances by a time, seconds, with the robot at a pose. Does nothing for a time that is not above zero.
    pub fn step(&mut self, time_s: f64, robot: &Pose, footprint: &Footprint) {
        if !(time_s > 0.0 && time_s.is_finite()) {
            return;
        }
        let steps = (time_s / SUB_STEP_S).ceil().max(1.0);
        for moving in &mut self.moving {
            for _ in 0..steps as u64 {
                moving.step(time_s / steps, robot, footprint);
            }
        }
    }

    /// Radius of each obstacle, metres.
    #[must_use]
    pub fn radii(&self) -> Vec<f64> {
        self.moving.iter().map(MovingObstacle::radius_m).collect()
    }

    /// Position and velocity of each obstacle; none for one that has not yet appeared.
    #[must_use]
    pub fn states(&self) -> Vec<Option<MovingDisc>> {
        self.moving.iter().map(MovingObstacle::disc).collect()
    }

    /// What a lidar hits of each obstacle: its legs, or its disc; none before it has appeared.
    pub(super) fn parts(&self) -> Vec<Vec<Option<MovingDisc>>> {
        let parts = |moving: &MovingObstacle| match moving.legs() {
            Some(legs) => legs.map(Some).to_vec(),
            None => vec![moving.disc()],
        };
        self.moving.iter().map(parts).collect()
    }

    /// What a lidar hits of the obstacles that have appeared, each part with its index in [`Self::discs`]; none where the
    /// discs are all that there is.
    pub(super) fn legs(&self) -> Option<Vec<(usize, MovingDisc)>> {
        if !self.moving.iter().any(MovingObstacle::has_legs) {
            return None;
        }
        let present = self.moving.iter().filter(|moving| moving.disc().is_some()).enumerate();
        let parts = present.flat_map(|(index, moving)| {
            let parts = moving
                .legs()
                .map_or_else(|| moving.disc().into_iter().collect(), |legs| legs.to_vec());
            parts.into_iter().map(move |part| (index, part))
        });
        Some(parts.collect())
    }

    /// Positions and velocities of the obstacles that have appeared, in order.
    #[must_use]
    pub fn discs(&self) -> Vec<MovingDisc> {
        self.moving.iter().filter_map(MovingObstacle::disc).collect()
    }
}

/// One moving obstacle of a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    x: Option<f64>,
    y: Option<f64>,
    radius: f64,
    speed: Option<f64>,
    route: Option<Vec<[f64; 2]>>,
    wander_m: Option<f64>,
    keyframes: Option<Vec<[f64; 3]>>,
    loop_s: Option<f64>,
    yields: Option<bool>,
    leg_diameter: Option<f64>,
    appears_at_s: Option<f64>,
    appears_within_m: Option<f64>,
}

/// A TOML document, because TOML has no list at its root.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    obstacles: Vec<Entry>,
}

impl MovingObstacles {
    /// Reads moving obstacles from a `.json` or `.toml` file; see [`MovingObstacles::parse`].
    ///
    /// # Errors
    /// [`SimError::UnreadableFile`], or as [`MovingObstacles::parse`].
    pub fn read(file: &Path, ground: &ObstacleGrid, seed: u64) -> Result<Self, SimError> {
        let name = file.display().to_string();
        match read_text(file) {
            Ok(text) => Self::parse(&text, &name, ground, seed),
            Err(problem) => Err(SimError::UnreadableFile { file: name, problem }),
        }
    }

    /// Parses the text of a file: TOML, with an `[[obstacles]]` table for each obstacle, if the file's name ends in
    /// `.toml`, else a JSON list. Lengths are in metres, times in seconds, speeds in m/s, points in the map frame. Each
    /// obstacle has a `radius`, above zero, and one of three motions:
    ///
    /// - patrol: from `x`, `y` at `speed`, at least zero, along the points `[x, y]` of `route` and back (without `route` it
    ///   stands), see [`MovingObstacle::patrol`];
    /// - random waypoints: from `x`, `y` at `speed` over free space within `wander_m` of its start, see [`MovingObstacle::random_waypoint`]; the
    ///   seed and its index in the list determine the waypoints;
    /// - timed path: at the times and points `[t, x, y]` of `keyframes`, repeated with the period `loop_s` if there is one,
    ///   see [`TimedPath`].
    ///
    /// `yields` is true for an obstacle that yields to the robot (default: true except for a timed path).
    /// With a `leg_diameter` the lidar sees two legs that walk within its disc, see [`MovingObstacle::with_legs`].
    /// `appears_at_s` is the time at which it appears, `appears_within_m` its distance from the robot then (default: it is
    /// present from the start). All points must be inside the map; they are not checked for obstacles.
    ///
    /// # Errors
    /// [`SimError::InvalidObstacleFile`], or [`SimError::InvalidObstacle`] for the first invalid obstacle, with the line of its key.
    pub fn parse(
        text: &str,
        file: &str,
        ground: &ObstacleGrid,
        seed: u64,
    ) -> Result<Self, SimError> {
        let entries = if is_toml(file) {
            toml::from_str::<Document>(text).map(|document| document.obstacles).map_err(|error| {
                let before = error.span().map_or("", |span| &text[..span.start]);
                let line = before.matches('\n').count() + 1;
                format!("{} at line {line}", error.message())
            })
        } else {
            serde_json::from_str::<Vec<Entry>>(text).map_err(|error| error.to_string())
        };
        let entries = entries.map_err(|reason| SimError::InvalidObstacleFile {
            file: file.to_owned(),
            reason: without_rust_types(&in_one_line(&reason)),
        })?;
        let mut seeds = generator(seed, RngStream::Obstacles);
        entries
            .iter()
            .enumerate()
            .map(|(index, entry)| {
                // Drawn for each entry, so that a change of one obstacle leaves the others unchanged.
                let moving = entry.moving(ground, seeds.random());
                moving.map_err(|reason| invalid(index, reason, text, file))
            })
            .collect::<Result<Vec<_>, _>>()
            .map(Self::new)
    }

    /// Rejects obstacles of a file that touch a robot at its start: the mission would end with contact before the robot moves.
    ///
    /// # Errors
    /// [`SimError::InvalidObstacle`] for the first such obstacle, with its line.
    pub fn check_start(
        &self,
        file: &Path,
        robot: &Pose,
        footprint: &Footprint,
    ) -> Result<(), SimError> {
        let text = read_text(file).unwrap_or_default();
        self.check_start_in((&text, &file.display().to_string()), robot, footprint)
    }

    /// As [`Self::check_start`], for the text of a file and its name.
    pub(crate) fn check_start_in(
        &self,
        (text, file): (&str, &str),
        robot: &Pose,
        footprint: &Footprint,
    ) -> Result<(), SimError> {
        let touches =
            |disc: MovingDisc| footprint.gap_to_disc_m(robot, &disc.center(), disc.radius) <= 0.0;
        let states = self.states();
        let Some(index) = states.into_iter().position(|disc| disc.is_some_and(touches)) else {
            return Ok(());
        };
        let reason = SimError::TouchesRobot { x: robot.x, y: robot.y };
        Err(invalid(index, reason, text, file))
    }
}

fn is_toml(file: &str) -> bool {
    let extension = Path::new(file).extension();
    extension.is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
}

/// The error of an obstacle, with its place in the text of the file.
fn invalid(index: usize, reason: SimError, text: &str, file: &str) -> SimError {
    let key = reason.key().unwrap_or_default();
    let line = if is_toml(file) {
        line_in_toml(&format!("obstacles.{index}.{key}"), text)
    } else {
        line_in_json(&format!("{index}.{key}"), text)
    };
    let (file, line) = (file.to_owned(), line.unwrap_or(1));
    SimError::InvalidObstacle { file, line, index, reason: Box::new(reason) }
}

impl Entry {
    fn moving(&self, ground: &ObstacleGrid, seed: u64) -> Result<MovingObstacle, SimError> {
        self.check_keys()?;
        let (moving, points): (_, Vec<_>) = if let Some(keyframes) = &self.keyframes {
            let keys: Vec<(f64, Point)> =
                keyframes.iter().map(|&[time_s, x, y]| (time_s, Point::new(x, y))).collect();
            let moving =
                MovingObstacle::timed_path(self.radius, TimedPath::new(&keys, self.loop_s)?)?;
            (moving, keys.iter().map(|key| ("keyframes", key.1)).collect())
        } else {
            let start = Point::new(needed("x", self.x)?, needed("y", self.y)?);
            let speed = needed("speed", self.speed)?;
            if let Some(wander_m) = self.wander_m {
                check_inside("x", &start, ground.frame())?;
                let moving = MovingObstacle::random_waypoint(
                    self.radius,
                    speed,
                    start,
                    wander_m,
                    ground,
                    seed,
                )?;
                (moving, Vec::new())
            } else {
                let route = self.route.iter().flatten();
                let further = route.map(|&[x, y]| ("route", Point::new(x, y)));
                let points: Vec<_> = core::iter::once(("x", start)).chain(further).collect();
                let places = points.iter().map(|point| point.1).collect();
                (MovingObstacle::patrol(self.radius, speed, places)?, points)
            }
        };
        for (key, point) in &points {
            check_inside(key, point, ground.frame())?;
        }
        let moving = match self.yields {
            Some(yields) => moving.yielding(yields),
            None => moving,
        };
        let moving = match self.leg_diameter {
            Some(diameter_m) => moving.with_legs(diameter_m, 0.0)?,
            None => moving,
        };
        match (self.appears_at_s, self.appears_within_m) {
            (Some(time_s), _) => moving.spawned_by(SpawnTrigger::AtTime(time_s)),
            (_, Some(distance_m)) => moving.spawned_by(SpawnTrigger::WithinDistance(distance_m)),
            (None, None) => Ok(moving),
        }
    }

    /// Rejects keys that contradict each other or have no meaning together.
    fn check_keys(&self) -> Result<(), SimError> {
        let given = [
            ("x", self.x.is_some()),
            ("y", self.y.is_some()),
            ("speed", self.speed.is_some()),
            ("route", self.route.is_some()),
            ("wander_m", self.wander_m.is_some()),
            ("keyframes", self.keyframes.is_some()),
            ("loop_s", self.loop_s.is_some()),
            ("appears_at_s", self.appears_at_s.is_some()),
            ("appears_within_m", self.appears_within_m.is_some()),
        ];
        let has = |key| given.contains(&(key, true));
        for (key, other) in [
            ("keyframes", "x"),
            ("keyframes", "y"),
            ("keyframes", "speed"),
            ("keyframes", "route"),
            ("keyframes", "wander_m"),
            ("wander_m", "route"),
            ("appears_at_s", "appears_within_m"),
        ] {
            if has(key) && has(other) {
                return Err(SimError::ConflictingKeys { key, other });
            }
        }
        if has("loop_s") && !has("keyframes") {
            return Err(SimError::MissingKey { key: "keyframes" });
        }
        Ok(())
    }
}

fn needed(key: &'static str, value: Option<f64>) -> Result<f64, SimError> {
    value.ok_or(SimError::MissingKey { key })
}

fn check_inside(key: &'static str, point: &Point, frame: &GridFrame) -> Result<(), SimError> {
    if frame.cell_of(point).is_some() {
        return Ok(());
    }
    Err(SimError::OutsideMap {
        key,
        x: point.x,
        y: point.y,
        width_m: f64::from(frame.width) * frame.resolution_m,
        height_m: f64::from(frame.height) * frame.resolution_m,
    })
}
