//! Experiments of random missions: their common arguments, and `inbye bench ablation`.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;
use inbye::experiment::missions::Rules;
use inbye::experiment::{
    ABLATION_VARIANTS, Grid, RunRow, Setup, World, ablation_groups, built_in_maps, faults,
};
use inbye::input_file::list;
use inbye::report::BenchReport;
use inbye::runtime::Config;
use serde_json::json;

use super::arguments::{real, whole};
use super::files::{ReportFolder, all_written, has_extension};
use super::own_programs::ProgramArguments;
use super::runs::{Recorded, RunArguments, group_table};
use super::{config, map_file, output};

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
    #[arg(long, default_value_t = 60.0, allow_negative_numbers = true, value_parser = real(4.0..=10_000.0, "metres, 4 to 10000"))]
    pub longest: f64,
    /// Largest number of moving obstacles in a mission.
    #[arg(long, default_value_t = 4, allow_negative_numbers = true, value_parser = whole::<usize>(0, 100))]
    pub people: usize,
    /// Settings, TOML.
    #[arg(long, value_name = "FILE.toml")]
    pub config: Option<PathBuf>,
    #[command(flatten)]
    pub programs: ProgramArguments,
    #[command(flatten)]
    pub run: RunArguments,
}

impl MissionsArguments {
    /// The settings, and the maps with the rules of their missions; `unmapped_share` is the share of missions with obstacles
    /// that the map does not show. Maps without room for a mission are left out with a message, unless there is no other.
    pub fn read(&self, unmapped_share: f64) -> anyhow::Result<(Config, Vec<World>)> {
        let rules = Rules {
            longest_m: self.longest,
            max_people: self.people,
            unmapped_share,
            ..Rules::default()
        };
        let mut config = config::load("--config", self.config.as_deref())?;
        self.programs.set(&mut config);
        let (mut roomy, mut narrow) = (Vec::new(), Vec::new());
        for world in self.worlds(rules)? {
            match world.simulation(self.seed, &config) {
                Ok(_) => roomy.push(world),
                Err(error) => narrow.push(error),
            }
        }
        if roomy.is_empty()
            && let Some(error) = narrow.pop()
        {
            return Err(error.into());
        }
        narrow.iter().for_each(|error| output::note(format!("left out: {error}")));
        Ok((config, roomy))
    }

    /// Drives the missions of a grid, and writes the record. The rows are in the order of settings, map and seed.
    pub fn drive(&self, grid: &Grid) -> anyhow::Result<Recorded> {
        self.run.run(grid, sort)
    }

    fn worlds(&self, rules: Rules) -> anyhow::Result<Vec<World>> {
        if self.maps.is_empty() {
            return Ok(built_in_maps(rules));
        }
        let mut names = BTreeSet::new();
        let mut worlds = Vec::new();
        for file in files(&self.maps)? {
            let (name, map) = map_file::load_named(&file, 1.0)?;
            if !names.insert(name.clone()) {
                bail!("--maps: two maps are called {name}: rename one, or leave it out");
            }
            worlds.push(World::missions(&name, map, rules));
        }
        Ok(worlds)
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
        let found = if path.is_dir() { yaml_files(path)? } else { vec![path.clone()] };
        if found.is_empty() {
            let folder = path.display();
            bail!("--maps {folder}: no .yaml file in it: name a folder of maps, or a map");
        }
        files.extend(found);
    }
    Ok(files)
}

fn yaml_files(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let mut files = list(folder).with_context(|| format!("--maps {}", folder.display()))?;
    files.retain(|path| has_extension(path, "yaml"));
    Ok(files)
}

/// `inbye bench ablation`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye bench ablation --missions 1 --longest 10 --threads 1 --report ablation\n\n\
    The same missions with seven navigators, each with one feature more than the one before: the dynamic window alone, the \
    global path with nodes touched in order as in the paper, progress along the path, tracking of moving obstacles, \
    replanning, passive safety, recovery. Missions are those of `bench soak`; on half of them the map does not show one or \
    two boxes or pillars on the path, which leave a way around.\n\
    The mean time of a variant is that of its own successes; the shared mean time that of the missions that every variant \
    with any success reached.\n\
    JSON fields: `variants`, `rows`."
)]
pub struct AblationArguments {
    #[command(flatten)]
    pub missions_of: MissionsArguments,
    /// Missions, each driven with every variant.
    #[arg(long, default_value_t = 100, allow_negative_numbers = true, value_parser = whole::<usize>(1, 1_000_000))]
    pub missions: usize,
    /// Share of missions, 0 to 1, with boxes or pillars on the path that the map does not show.
    #[arg(long, default_value_t = 0.5, allow_negative_numbers = true, value_parser = real(0.0..=1.0, "0 to 1"))]
    pub unmapped: f64,
    /// Write `index.html`, its charts as SVG and its rows as CSV and JSON into this folder.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
}

/// Drives the missions with each variant.
pub fn ablation(arguments: &AblationArguments) -> anyhow::Result<bool> {
    let report = ReportFolder::create(arguments.report.as_deref())?;
    let AblationArguments { missions_of: missions, missions: count, .. } = arguments;
    let (config, worlds) = missions.read(arguments.unmapped)?;
    let variants = ABLATION_VARIANTS.iter();
    let setups: Vec<Setup> = variants.map(|variant| variant.setup(&config)).collect();
    let grid = Grid::of_missions("ablation", &worlds, &setups, *count, missions.seed)?;
    let (rows, recorded) = missions.drive(&grid)?;
    let table = ablation_groups(&rows);
    let maps: Vec<&str> = worlds.iter().map(|world| world.name.as_str()).collect();
    let intro = format!(
        "{count} random missions in simulation, each driven by every variant of the navigator. A variant has one part more \
         than the one before it. Moving obstacles cross the path; on some missions, obstacles that the map does not show \
         stand on it. Maps: {}.",
        maps.join(", ")
    );
    let mut lines = group_table(&table);
    let shared = table.first().map_or(0, |row| row.shared);
    lines.push(format!("over the {shared} missions that every variant with any success reached:"));
    lines.extend(table.iter().map(|row| {
        let time_s = row.mean_shared_time_s;
        let time = time_s.map_or_else(|| "-".to_owned(), |time_s| format!("{time_s:.1} s"));
        format!("  {:30} mean time {time}", row.name)
    }));
    lines.extend(faults(&rows).into_iter().map(|(name, count)| format!("fault {name}: {count}")));
    output::result(&json!({ "variants": table, "rows": rows }), lines)?;
    let reported = report.write_bench(BenchReport {
        title: "inbye: effect of each part of the navigator",
        intro: &intro,
        ablation: &table,
        ..BenchReport::default()
    });
    all_written([recorded, reported])?;
    Ok(true)
}
