//! The map named on the command line, with the settings that go with it.

use std::path::Path;

use inbye::map::{LoadOptions, OccupancyGrid, load_noting};
use inbye::sim::Config;

use super::arguments::MapArguments;
use super::{config, output};

/// Reads map and configuration.
pub fn read(arguments: &MapArguments) -> anyhow::Result<(OccupancyGrid, Config)> {
    let mut config = config::load("--config", arguments.config.as_deref())?;
    if let Some(unknown) = arguments.unknown {
        config.unknown = unknown;
    }
    Ok((load(&arguments.map, arguments.resolution)?, config))
}

/// Reads a map of any kind; `resolution_m` is that of one that does not state its own. What may not be meant in it is told on
/// standard error.
pub fn load(file: &Path, resolution_m: f64) -> anyhow::Result<OccupancyGrid> {
    let options = LoadOptions { resolution_m };
    let mut note = |note| output::note(format!("note: {}: {note}", file.display()));
    Ok(load_noting(file, &options, &mut note)?)
}
