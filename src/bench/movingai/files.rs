//! Maps with their scenarios in folders.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use crate::bench::BenchError;
use crate::map::{LoadOptions, ObstacleGrid, Scenario, UnknownPolicy, load, read_scen};

/// A map and its scenarios.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Files {
    /// Name of the map in results.
    pub name: String,
    /// The map.
    pub map: PathBuf,
    /// Its scenarios.
    pub scen: PathBuf,
}

/// The maps of a folder, sorted by path.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Folder {
    /// The maps with scenarios, named by their path in the folder.
    pub files: Vec<Files>,
    /// Names of the maps without scenarios.
    pub skipped: Vec<String>,
}

/// The content of a map's files.
#[derive(Clone, Debug, PartialEq)]
pub struct Queries {
    /// Name of the map in results.
    pub name: String,
    /// Its obstacles; unknown cells are obstacles.
    pub obstacles: ObstacleGrid,
    /// Its scenarios, at least one, each for a map of this size.
    pub scenarios: Vec<Scenario>,
}

impl Files {
    /// Reads both files.
    ///
    /// # Errors
    /// Fails when a file cannot be read or does not follow its format, when there is no scenario, or when a scenario is for a
    /// map of another size. The message names the file and the line.
    pub fn read(&self) -> Result<Queries, BenchError> {
        let map = load(&self.map, &LoadOptions::default())?;
        let scenarios = read_scen(&self.scen)?;
        if scenarios.is_empty() {
            return Err(BenchError::NoScenario { scen: self.scen.clone() });
        }
        let size = (map.frame().width, map.frame().height);
        let is_other = |scenario: &&Scenario| (scenario.width, scenario.height) != size;
        if let Some(scenario) = scenarios.iter().find(is_other) {
            return Err(BenchError::OtherMap {
                scen: self.scen.clone(),
                line: scenario.line,
                listed: (scenario.width, scenario.height),
                map: self.map.clone(),
                size,
            });
        }
        Ok(Queries {
            name: self.name.clone(),
            obstacles: map.obstacles(UnknownPolicy::Blocked),
            scenarios,
        })
    }
}

/// Finds the `.map` files in a folder and below it with scenarios next to them: `X.map.scen` or `X.scen`. Symbolic links to
/// folders are not followed, since they may lead back.
///
/// # Errors
/// Fails when a folder cannot be listed, or no map has scenarios.
pub fn find(folder: &Path) -> Result<Folder, BenchError> {
    let mut maps = Vec::new();
    collect(folder, &mut maps)?;
    maps.sort();
    let mut found = Folder::default();
    for map in maps {
        let below = map.strip_prefix(folder).unwrap_or(&map);
        let parts: Vec<_> = below.iter().map(|part| part.to_string_lossy()).collect();
        let name = parts.join("/");
        let mut longer = OsString::from(&map);
        longer.push(".scen");
        let candidates = [PathBuf::from(longer), map.with_extension("scen")];
        match candidates.into_iter().find(|scen| scen.is_file()) {
            Some(scen) => found.files.push(Files { name, map, scen }),
            None => found.skipped.push(name),
        }
    }
    if found.files.is_empty() {
        return Err(BenchError::NoMaps { folder: folder.to_owned() });
    }
    Ok(found)
}

fn collect(folder: &Path, maps: &mut Vec<PathBuf>) -> Result<(), BenchError> {
    let unreadable = |error: std::io::Error| BenchError::Folder {
        folder: folder.to_owned(),
        reason: error.to_string(),
    };
    for entry in fs::read_dir(folder).map_err(unreadable)? {
        let entry = entry.map_err(unreadable)?;
        let path = entry.path();
        if entry.file_type().map_err(unreadable)?.is_dir() {
            collect(&path, maps)?;
        } else if path.extension().is_some_and(|extension| extension == "map") {
            maps.push(path);
        }
    }
    Ok(())
}

/// Returns this number of scenarios of the greatest listed length, longest first; of equal ones the first in the file.
#[must_use]
pub fn longest(mut scenarios: Vec<Scenario>, count: usize) -> Vec<Scenario> {
    // The sort is stable: scenarios of equal length stay in order.
    scenarios.sort_by(|one, other| other.optimal.total_cmp(&one.optimal));
    scenarios.truncate(count);
    scenarios
}
