//! Loads the map of the command line with its settings.

use std::path::Path;

use inbye::map::{
    GridFrame, LoadOptions, OccupancyGrid, UNKNOWN, UnknownPolicy, load_with_warnings,
};
use inbye::runtime::Config;
use serde_json::{Value, json};

use super::arguments::MapArguments;
use super::{config, output};

/// Loads map and configuration.
pub fn read(arguments: &MapArguments) -> anyhow::Result<(OccupancyGrid, Config)> {
    let mut config = config::load("--config", arguments.config.as_deref())?;
    if let Some(unknown) = arguments.unknown {
        config.unknown = unknown;
    }
    let map = load(&arguments.map, arguments.resolution)?;
    if output::is_verbose() {
        print_details(&arguments.map, &map, config.unknown);
    }
    Ok((map, config))
}

fn print_details(file: &Path, map: &OccupancyGrid, policy: UnknownPolicy) {
    let unknown = unknown_cells_text(map, policy);
    let GridFrame { width, height, resolution_m, .. } = map.frame();
    output::detail(format!(
        "map: {}: {width} x {height} cells of {resolution_m} m; {}",
        file.display(),
        unknown.map_or_else(|| "all known".to_owned(), |text| format!("unknown: {text}")),
    ));
}

/// Loads a map of any format; `resolution_m` applies to a format without its own. Warnings go to standard error.
pub fn load(file: &Path, resolution_m: f64) -> anyhow::Result<OccupancyGrid> {
    let options = LoadOptions { resolution_m };
    let mut warn = |warning| output::note(format!("note: {}: {warning}", file.display()));
    Ok(load_with_warnings(file, &options, &mut warn)?)
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
    let unknown = map.cells().iter().filter(|cell| **cell == UNKNOWN);
    unknown.count()
}
