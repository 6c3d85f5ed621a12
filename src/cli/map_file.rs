//! The map named on the command line, with the settings that go with it.

use inbye::map::{LoadOptions, OccupancyGrid, load};
use inbye::sim::Config;

use super::arguments::MapArguments;
use super::config;

/// Reads map and configuration.
pub fn read(arguments: &MapArguments) -> anyhow::Result<(OccupancyGrid, Config)> {
    let mut config = config::load(arguments.config.as_deref())?;
    if let Some(unknown) = arguments.unknown {
        config.unknown = unknown;
    }
    let options = LoadOptions {
        resolution_m: arguments.resolution,
    };
    Ok((load(&arguments.map, &options)?, config))
}
