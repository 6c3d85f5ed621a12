//! Arguments of random missions.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, bail};
use clap::Args;
use inbye::experiment::missions::Rules;
use inbye::experiment::{Grid, RunRow, World, built_in_maps};
use inbye::runtime::Config;

use super::arguments::{number, whole};
use super::grid_run::RunArguments;
use super::output_file::Output;
use super::{config, map_file, output, output_file};

/// Maps, seeds and rules of missions.
#[derive(Debug, Args)]
pub struct MissionsArguments {
    /// Maps, or folders whose .yaml files are all used [default: built-in scenes and a generated mine].
    #[arg(long, value_name = "DIR or FILE", num_args = 1..)]
    pub maps: Vec<PathBuf>,
    /// Seed of the first mission; each further mission has the next.
    #[arg(long, default_value_t = 1, allow_negative_numbers = true, value_parser = whole::<u64>(0, 1 << 60))]
    pub seed: u64,
    /// Longest path, metres.
    #[arg(long, default_value_t = 60.0, allow_negative_numbers = true, value_parser = metres)]
    pub longest: f64,
    /// Largest number of moving obstacles in a mission.
    #[arg(long, default_value_t = 4, allow_negative_numbers = true, value_parser = whole::<usize>(0, 100))]
    pub people: usize,
    /// Settings, TOML.
    #[arg(long, value_name = "FILE.toml")]
    pub config: Option<PathBuf>,
    #[command(flatten)]
    pub run: RunArguments,
}

fn metres(text: &str) -> Result<f64, String> {
    let fits = |metres: f64| (4.0..=10_000.0).contains(&metres);
    number(text, fits, "metres, 4 to 10000")
}

/// A share as typed.
pub fn share(text: &str) -> Result<f64, String> {
    number(text, |share| (0.0..=1.0).contains(&share), "0 to 1")
}

impl MissionsArguments {
    /// The settings, and the maps with the rules of their missions; `unmapped_share` is the share of missions with obstacles
    /// that the map does not show. Maps without room for a mission are left out with a message, unless there is no other.
    pub fn read(&self, unmapped_share: f64) -> anyhow::Result<(Config, Vec<World>)> {
        let rules = Rules {
            longest_m: self.longest,
            most_people: self.people,
            unmapped_share,
            ..Rules::default()
        };
        let config = config::load("--config", self.config.as_deref())?;
        let (mut roomy, mut narrow) = (Vec::new(), Vec::new());
        for world in self.worlds(rules)? {
            match world.simulation(self.seed, &config) {
                Ok(_) => roomy.push(world),
                Err(error) => narrow.push(error),
            }
        }
        match narrow.pop() {
            Some(error) if roomy.is_empty() => return Err(error.into()),
            last => narrow.extend(last),
        }
        for error in narrow {
            output::note(format!("left out: {error}"));
        }
        Ok((config, roomy))
    }

    fn worlds(&self, rules: Rules) -> anyhow::Result<Vec<World>> {
        if self.maps.is_empty() {
            return Ok(built_in_maps(rules));
        }
        let mut names = BTreeSet::new();
        let mut worlds = Vec::new();
        for file in files(&self.maps)? {
            let name = file.file_stem().unwrap_or_default().to_string_lossy();
            if !names.insert(name.to_string()) {
                bail!("--maps: two maps are called {name}: rename one, or leave it out");
            }
            let map = map_file::load(&file, 1.0)?;
            worlds.push(World::missions(&name, Arc::new(map), rules));
        }
        Ok(worlds)
    }

    /// Drives the missions, and writes the record; the rows by settings, map and seed.
    pub fn drive(&self, grid: &Grid) -> anyhow::Result<Vec<RunRow>> {
        let record = Output::create("--record", self.run.record.as_deref(), &["csv", "json"])?;
        let mut rows = self.run.run(grid)?;
        sort(&mut rows);
        if let Some(record) = record {
            output_file::write_rows(record, &rows)?;
        }
        Ok(rows)
    }
}

/// Sorts rows by settings, map and seed.
pub fn sort(rows: &mut [RunRow]) {
    rows.sort_by(|one, other| {
        let key = |row: &RunRow| (row.config.clone(), row.world.clone(), row.seed);
        key(one).cmp(&key(other))
    });
}

/// The given files, and the .yaml files of the given folders by name.
fn files(maps: &[PathBuf]) -> anyhow::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for path in maps {
        if !path.is_dir() {
            files.push(path.clone());
            continue;
        }
        let before = files.len();
        files.extend(yaml_files(path)?);
        if files.len() == before {
            let folder = path.display();
            bail!("--maps {folder}: no .yaml file in it: name a folder of maps, or a map");
        }
    }
    Ok(files)
}

fn yaml_files(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let place = || format!("--maps {}: cannot be read", folder.display());
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).with_context(place)? {
        let path = entry.with_context(place)?.path();
        if path.extension().is_some_and(|ending| ending == "yaml") {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}
