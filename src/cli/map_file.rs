//! The map of the command line with its settings.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use inbye::map::{
    GridFrame, LoadOptions, OccupancyGrid, UNKNOWN, UnknownPolicy, load_with_warnings,
};
use inbye::runtime::Config;
use serde_json::{Value, json};

use super::arguments::{length, unknown};
use super::{config, output};

/// A map and its settings.
#[derive(Debug, Args)]
pub struct MapArguments {
    #[arg(
        long,
        help = "Map: a ROS map_server .yaml, a MovingAI .map, or rows of text (# wall, . free, ? unknown)"
    )]
    pub map: PathBuf,
    #[command(flatten)]
    pub settings: MapSettings,
}

/// The settings for a map.
#[derive(Debug, Args)]
pub struct MapSettings {
    /// Side of a cell of a .map or text map, metres.
    #[arg(long, default_value_t = 1.0, allow_negative_numbers = true, value_parser = length)]
    pub resolution: f64,
    /// How unknown cells count [default: the configuration's, blocked].
    #[arg(long, value_parser = unknown())]
    pub unknown: Option<UnknownPolicy>,
    /// Settings, TOML.
    #[arg(long)]
    pub config: Option<PathBuf>,
}

impl MapSettings {
    /// Loads the configuration.
    pub fn load(&self) -> anyhow::Result<Config> {
        let mut config = config::load("--config", self.config.as_deref())?;
        config.unknown = self.unknown.unwrap_or(config.unknown);
        Ok(config)
    }
}

/// Loads map and configuration.
pub fn read(arguments: &MapArguments) -> anyhow::Result<(OccupancyGrid, Config)> {
    let (file, settings) = (&arguments.map, &arguments.settings);
    let config = settings.load()?;
    let map = load(file, settings.resolution)?;
    if output::is_verbose() {
        let unknown = unknown_cells_text(&map, config.unknown);
        let unknown =
            unknown.map_or_else(|| "all known".to_owned(), |text| format!("unknown: {text}"));
        let GridFrame { width, height, resolution_m, .. } = map.frame();
        output::detail(format!(
            "map: {}: {width} x {height} cells of {resolution_m} m; {unknown}",
            file.display()
        ));
    }
    Ok((map, config))
}

/// Loads a map of any format; `resolution_m` applies to a format without its own. Warnings go to standard error.
pub fn load(file: &Path, resolution_m: f64) -> anyhow::Result<OccupancyGrid> {
    let options = LoadOptions { resolution_m };
    let mut warn = |warning| output::note(format!("note: {}: {warning}", file.display()));
    Ok(load_with_warnings(file, &options, &mut warn)?)
}

/// Loads a map like [`load`], with its name: that of the file without folder and extension.
pub fn load_named(file: &Path, resolution_m: f64) -> anyhow::Result<(String, Arc<OccupancyGrid>)> {
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    Ok((name.into_owned(), Arc::new(load(file, resolution_m)?)))
}

/// The number of unknown cells and how they count, as JSON.
pub fn unknown_cells_json(map: &OccupancyGrid, policy: UnknownPolicy) -> Value {
    json!({ "cells": count_unknown(map), "counted_as": policy })
}

/// The number of unknown cells and how they count, as text; none for a map without such cells.
pub fn unknown_cells_text(map: &OccupancyGrid, policy: UnknownPolicy) -> Option<String> {
    let counted = match policy {
        UnknownPolicy::Blocked => "blocked (--unknown free counts them as free)",
        UnknownPolicy::Free => "free",
    };
    match count_unknown(map) {
        0 => None,
        cells => Some(format!("{cells} cells, counted as {counted}")),
    }
}

fn count_unknown(map: &OccupancyGrid) -> usize {
    map.cells().iter().filter(|cell| **cell == UNKNOWN).count()
}
