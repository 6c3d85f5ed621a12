//! Random missions on maps: which, with which settings, and their campaign.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;
use inbye::experiment::campaign::{Ledger, Row, settings_digest};
use inbye::experiment::missions::{
    MissionKey, MissionRow, MissionSite, Rules, Setup, built_in_sites, drive,
};
use inbye::local::{CpuEngine, Engine};
use inbye::runtime::{Config, Observer};

use super::arguments::{number, whole};
use super::campaign::Campaign;
use super::process::wall_clock;
use super::{config, map_file, output};

/// Which missions.
#[derive(Debug, Args)]
pub struct MissionsArguments {
    /// Maps, or folders of which all .yaml files are taken [default: built-in scenes and a made mine].
    #[arg(long, value_name = "DIR or FILE", num_args = 1..)]
    pub maps: Vec<PathBuf>,
    /// Seed of the first mission; each further one has the next.
    #[arg(long, default_value_t = 1, allow_negative_numbers = true, value_parser = whole::<u64>(0, 1 << 60))]
    pub seed: u64,
    /// Longest path, metres.
    #[arg(long, default_value_t = 60.0, allow_negative_numbers = true, value_parser = metres)]
    pub longest: f64,
    /// Most moving obstacles in a mission.
    #[arg(long, default_value_t = 4, allow_negative_numbers = true, value_parser = whole::<usize>(0, 100))]
    pub people: usize,
    /// Missions at a time [default: all cores].
    #[arg(long, allow_negative_numbers = true, value_parser = whole::<usize>(1, 1024))]
    pub threads: Option<usize>,
    /// Settings, TOML.
    #[arg(long, value_name = "FILE.toml")]
    pub config: Option<PathBuf>,
    /// Keep a row for each mission in this file, and go on where it ends.
    #[arg(long, value_name = "FILE.csv")]
    pub record: Option<PathBuf>,
}

fn metres(text: &str) -> Result<f64, String> {
    let fits = |metres: f64| (4.0..=10_000.0).contains(&metres);
    number(text, fits, "metres, 4 to 10000")
}

impl MissionsArguments {
    /// The settings, the maps, and the rules with such a share of missions on which the map is wrong. Maps without room for a
    /// mission are told and left out, unless there is no other.
    pub fn read(&self, unmapped_share: f64) -> anyhow::Result<(Config, Vec<MissionSite>, Rules)> {
        let rules = Rules {
            longest_m: self.longest,
            most_people: self.people,
            unmapped_share,
            ..Rules::default()
        };
        let config = config::load("--config", self.config.as_deref())?;
        let (mut roomy, mut narrow) = (Vec::new(), Vec::new());
        for site in sites(&self.maps, &config)? {
            match site.draw(self.seed, &rules, &config) {
                Ok(_) => roomy.push(site),
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
        Ok((config, roomy, rules))
    }
}

fn sites(maps: &[PathBuf], config: &Config) -> anyhow::Result<Vec<MissionSite>> {
    if maps.is_empty() {
        return Ok(built_in_sites(config));
    }
    let mut names = BTreeSet::new();
    let mut sites = Vec::new();
    for file in files(maps)? {
        let name = file.file_stem().unwrap_or_default().to_string_lossy();
        if !names.insert(name.to_string()) {
            bail!("--maps: two maps are called {name}: rename one, or leave it out");
        }
        let map = map_file::load(&file, 1.0)?;
        sites.push(MissionSite::new(&name, map, config));
    }
    Ok(sites)
}

/// The files named, folders as the .yaml files in them, by name.
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

/// A mission of a campaign, driven with a setup.
#[derive(Clone, Copy, Debug)]
pub struct Cell<'a> {
    /// The settings.
    pub setup: &'a Setup,
    /// The map.
    pub site: &'a MissionSite,
    /// The seed.
    pub seed: u64,
}

impl Cell<'_> {
    /// Which row is this one's.
    pub fn key(&self) -> MissionKey {
        MissionKey {
            setup: self.setup.name.clone(),
            map: self.site.name.clone(),
            seed: self.seed,
        }
    }
}

/// So many missions with each setup: the maps take turns.
pub fn cells<'a>(
    setups: &'a [Setup],
    sites: &'a [MissionSite],
    missions: usize,
    seed: u64,
) -> Vec<Cell<'a>> {
    let of_mission = |number: usize| {
        let site = &sites[number % sites.len()];
        let seed = seed + number as u64;
        setups.iter().map(move |setup| Cell { setup, site, seed })
    };
    (0..missions).flat_map(of_mission).collect()
}

/// How missions are driven.
pub struct Driving<'a> {
    /// What stands beside the progress bar.
    pub what: &'a str,
    /// What the missions are drawn by.
    pub rules: &'a Rules,
    /// Missions at a time.
    pub threads: usize,
    /// The file of rows.
    pub record: Option<&'a Path>,
}

impl Driving<'_> {
    /// Drives all missions that the record does not have, each on an engine of its own; the rows of those asked for, in the
    /// order of their keys.
    pub fn run(
        &self,
        cells: &[Cell],
        engine: impl Fn() -> anyhow::Result<Box<dyn Engine>> + Sync,
    ) -> anyhow::Result<Vec<MissionRow>> {
        self.rules.validate()?;
        let identities: BTreeSet<_> = cells.iter().map(|cell| cell.site.identity()).collect();
        let configs: Vec<_> = distinct(cells.iter().map(|cell| cell.setup));
        let campaign = Campaign {
            what: self.what,
            record: self.record,
            settings: &settings_digest(&(self.rules, identities, configs)),
            threads: self.threads,
        };
        let work = |cell: &Cell| {
            let (site, setup) = (cell.site, cell.setup);
            let (row, ..) = drive(
                site,
                cell.seed,
                self.rules,
                setup,
                engine()?,
                &mut Observer {
                    clock: &mut wall_clock(),
                    on_tick: &mut |_| {},
                },
            )?;
            Ok(row)
        };
        let ledger: Ledger<MissionRow> = campaign.run(cells, Cell::key, work)?;
        let asked: BTreeSet<MissionKey> = cells.iter().map(Cell::key).collect();
        Ok(ledger
            .rows()
            .filter(|row| asked.contains(&row.key()))
            .cloned()
            .collect())
    }
}

/// Names and configurations of setups, each once.
fn distinct<'a>(setups: impl Iterator<Item = &'a Setup>) -> Vec<(&'a str, &'a Config)> {
    let mut distinct: Vec<(&str, &Config)> = Vec::new();
    for setup in setups {
        if distinct.iter().all(|(name, _)| *name != setup.name) {
            distinct.push((&setup.name, &setup.config));
        }
    }
    distinct
}

/// The CPU on one thread: missions, not decisions, are what is done at the same time.
pub fn one_core() -> Box<dyn Engine> {
    Box::new(CpuEngine::single_threaded())
}
