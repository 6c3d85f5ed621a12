//! The map named on the command line, with the settings that go with it.

use std::path::Path;

use inbye::map::{GridFrame, LoadOptions, OccupancyGrid, UnknownPolicy, load_with_warnings};
use inbye::runtime::Config;

use super::arguments::MapArguments;
use super::{output, settings_file, unknown_words};

/// Reads map and configuration.
pub fn read(arguments: &MapArguments) -> anyhow::Result<(OccupancyGrid, Config)> {
    let mut config = settings_file::read(arguments.config.as_deref())?;
    if let Some(unknown) = arguments.unknown {
        config.unknown = unknown;
    }
    let map = load(&arguments.map, arguments.resolution)?;
    if output::tells_details() {
        tell(&arguments.map, &map, config.unknown);
    }
    Ok((map, config))
}

fn tell(file: &Path, map: &OccupancyGrid, policy: UnknownPolicy) {
    let unknown = unknown_words::fact(map, policy);
    let GridFrame {
        width,
        height,
        resolution_m,
        ..
    } = map.frame();
    output::detail(format!(
        "map: {}: {width} x {height} cells of {resolution_m} m; {}",
        file.display(),
        unknown.map_or_else(|| "all known".to_owned(), |fact| format!("unknown: {fact}")),
    ));
}

/// Reads a map of any kind; `resolution_m` is that of one that does not state its own. What may not be meant in it is told on
/// standard error.
pub fn load(file: &Path, resolution_m: f64) -> anyhow::Result<OccupancyGrid> {
    let options = LoadOptions { resolution_m };
    let mut note = |note| output::note(format!("note: {}: {note}", file.display()));
    Ok(load_with_warnings(file, &options, &mut note)?)
}
