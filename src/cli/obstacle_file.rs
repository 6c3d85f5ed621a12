//! Reads files of moving obstacles.

use std::path::Path;

use anyhow::{Context, anyhow};
use inbye::input_file::read_text;
use inbye::map::ObstacleGrid;
use inbye::settings::{KeyError, line_in_json, line_in_toml};
use inbye::sim::{MovingObstacles, SimError};

use super::files::has_extension;

/// Reads the file of `--obstacles`. The error of an obstacle names its line.
pub fn read(file: &Path, ground: &ObstacleGrid, seed: u64) -> anyhow::Result<MovingObstacles> {
    let name = file.display().to_string();
    let text = read_text(file).with_context(|| name.clone())?;
    MovingObstacles::parse(&text, &name, ground, seed).map_err(|error| match &error {
        SimError::InvalidObstacle { index, reason, .. } => {
            let key = match &**reason {
                SimError::Setting(error) => error.key_path().unwrap_or_default(),
                SimError::ConflictingKeys { key, .. } => (*key).to_owned(),
                _ => String::new(),
            };
            let line = if has_extension(file, "toml") {
                line_in_toml(&format!("obstacles.{index}.{key}"), &text)
            } else {
                line_in_json(&format!("{index}.{key}"), &text)
            };
            anyhow!("{name}: line {}: obstacle {index}: {reason}", line.unwrap_or(1))
        }
        _ => error.into(),
    })
}
