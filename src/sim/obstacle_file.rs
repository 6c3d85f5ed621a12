//! Moving obstacles read from a file.

use std::path::Path;

use serde::Deserialize;

use super::obstacles::Walker;
use super::{SimError, Walkers};
use crate::geometry::Point;
use crate::global;
use crate::map::GridFrame;

/// One moving obstacle as a file has it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    x: f64,
    y: f64,
    radius: f64,
    speed: f64,
    #[serde(default)]
    route: Vec<[f64; 2]>,
    #[serde(default = "yes")]
    yields: bool,
}

/// A TOML document, which cannot be a bare list.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    obstacles: Vec<Entry>,
}

const fn yes() -> bool {
    true
}

impl Walkers {
    /// Reads moving obstacles from a `.json` or `.toml` file; see [`Walkers::parse`].
    ///
    /// # Errors
    /// [`SimError::Unreadable`], or as [`Walkers::parse`].
    pub fn read(file: &Path, frame: &GridFrame) -> Result<Self, SimError> {
        let name = file.display().to_string();
        match std::fs::read_to_string(file) {
            Ok(text) => Self::parse(&text, &name, frame),
            Err(error) => Err(SimError::Unreadable {
                file: name,
                reason: error.to_string(),
            }),
        }
    }

    /// Moving obstacles from the text of a file: TOML, with an `[[obstacles]]` table for each, when the file's name
    /// ends in `.toml`, else a JSON list. Each has `x` and `y`, where it starts, metres in the map frame; `radius`,
    /// metres, above zero; `speed`, m/s, at least zero; `route`, a list of further points `[x, y]`, from its start to
    /// the last of which it walks back and forth (left out: it stands); `yields`, whether it minds the robot (left
    /// out: it does). All points must lie in the map; that they are free ground is the caller's affair.
    ///
    /// # Errors
    /// [`SimError::NotObstacles`], [`SimError::BadObstacle`] or [`SimError::ObstacleOutside`]: for the first that is
    /// wrong.
    pub fn parse(text: &str, file: &str, frame: &GridFrame) -> Result<Self, SimError> {
        let is_toml = Path::new(file)
            .extension()
            .is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
        let entries = if is_toml {
            toml::from_str::<Document>(text)
                .map(|document| document.obstacles)
                .map_err(|error| {
                    let before = error.span().map_or("", |span| &text[..span.start]);
                    let line = before.matches('\n').count() + 1;
                    format!("{} at line {line}", error.message())
                })
        } else {
            serde_json::from_str::<Vec<Entry>>(text).map_err(|error| error.to_string())
        };
        let entries = entries.map_err(|reason| SimError::NotObstacles {
            file: file.to_owned(),
            reason: reason.split_whitespace().collect::<Vec<_>>().join(" "),
        })?;
        entries
            .iter()
            .enumerate()
            .map(|(index, entry)| entry.walker(file, index, frame))
            .collect::<Result<Vec<_>, _>>()
            .map(Self::new)
    }
}

impl Entry {
    fn walker(&self, file: &str, index: usize, frame: &GridFrame) -> Result<Walker, SimError> {
        let bad = |key, value, expected| {
            Err(SimError::BadObstacle {
                file: file.to_owned(),
                index,
                key,
                value,
                expected,
            })
        };
        if !(self.radius.is_finite() && self.radius > 0.0) {
            return bad("radius", self.radius, "finite and above zero");
        }
        if !(self.speed.is_finite() && self.speed >= 0.0) {
            return bad("speed", self.speed, "finite and at least zero");
        }
        let mut points = vec![Point::new(self.x, self.y)];
        points.extend(self.route.iter().map(|&[x, y]| Point::new(x, y)));
        if let Some(outside) = points.iter().find(|point| frame.cell_of(point).is_none()) {
            return Err(SimError::ObstacleOutside {
                file: file.to_owned(),
                index,
                x: outside.x,
                y: outside.y,
                width_m: f64::from(frame.width) * frame.resolution_m,
                height_m: f64::from(frame.height) * frame.resolution_m,
            });
        }
        Ok(Walker::new(
            self.radius,
            self.speed,
            global::Path::new(points),
            self.yields,
        ))
    }
}
