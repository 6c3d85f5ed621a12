//! A plan as cells.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::json;

use super::cell::key;
use super::plan::require;
use super::{Cell, ExperimentError, Plan, RunRow, World};
use crate::local::{LocalSettings, Sampler};
use crate::runtime::{Config, TomlError};

/// All cells of a plan, in its order: worlds, settings, weights, samplings, engines, seeds.
#[derive(Clone, Debug)]
pub struct Grid {
    /// The plan's title.
    pub title: String,
    /// The cells. Where two names of the plan mean the same, two cells have one key.
    pub cells: Vec<Cell>,
}

/// Settings with their names in rows.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Setup {
    /// Name of the changes; none if there is only one set of settings.
    pub name: Option<String>,
    /// Name of the weights; none if there is only one set of weights.
    pub weights: Option<String>,
    /// The settings.
    pub config: Config,
}

impl Setup {
    /// Settings under a name.
    #[must_use]
    pub fn named(name: &str, config: Config) -> Self {
        Self { name: Some(name.to_owned()), config, ..Self::default() }
    }

    /// Settings without a name.
    #[must_use]
    pub fn unnamed(config: Config) -> Self {
        Self { config, ..Self::default() }
    }

    /// The settings with this sampling of the dynamic window.
    fn with_sampling(&self, vx_samples: u32, vtheta_samples: u32) -> Self {
        let mut setup = self.clone();
        setup.config.local.vx_samples = vx_samples;
        setup.config.local.vtheta_samples = vtheta_samples;
        setup
    }

    /// Checks that runs do not depend on the wall clock.
    fn check_pure(&self) -> Result<(), ExperimentError> {
        let Some(key) = wall_clock_setting(&self.config) else { return Ok(()) };
        let name = self.name.as_deref();
        Err(ExperimentError::Unusable {
            place: name.map_or("settings".to_owned(), |name| format!("configs.{name}")),
            reason: format!(
                "{key} makes a run depend on the wall clock, and a cell must not: leave it out"
            ),
        })
    }
}

/// The setting by which a simulated run depends on the wall clock; none if no setting does.
#[must_use]
pub const fn wall_clock_setting(config: &Config) -> Option<&'static str> {
    if config.navigator.deadline_s.is_some() {
        Some("navigator.deadline_s")
    } else if !config.navigator.wait_for_plans {
        Some("navigator.wait_for_plans = false")
    } else {
        None
    }
}

impl Grid {
    /// Reads the worlds of a plan and makes all combinations. Paths are relative to this folder.
    ///
    /// # Errors
    /// Fails when a world cannot be read, changes do not fit the settings, or settings make a run depend on the wall clock.
    pub fn new(plan: &Plan, folder: &Path) -> Result<Self, ExperimentError> {
        plan.check()?;
        let mut grid = Self::empty(&plan.title);
        for world in plan.read_worlds(folder)? {
            for setup in setups(plan, &world.settings)? {
                setup.check_pure()?;
                world.check_route(&setup.config)?;
                let threads = if world.latency { plan.latency_threads } else { 1 };
                for engine in &plan.engines {
                    for &seed in &plan.seeds {
                        grid.add(&world, &setup, engine, seed, threads);
                    }
                }
            }
        }
        grid.check_names()?;
        Ok(grid)
    }

    /// Every setup in every world with every seed. Each runs on one CPU thread; its ticks are timed while other cells run.
    ///
    /// # Errors
    /// Fails when settings make a run depend on the wall clock, or two worlds have one name.
    pub fn of_worlds(
        title: &str,
        worlds: &[World],
        setups: &[Setup],
        seeds: &[u64],
    ) -> Result<Self, ExperimentError> {
        let cells = worlds.iter().flat_map(|world| {
            let seeds = seeds.iter();
            seeds.map(move |&seed| (world, seed))
        });
        Self::timed(title, cells, setups)
    }

    /// This many missions with each setup, with consecutive seeds and the worlds in rotation. Each runs on one CPU thread; its
    /// ticks are timed while other cells run.
    ///
    /// # Errors
    /// As [`Grid::of_worlds`].
    pub fn of_missions(
        title: &str,
        worlds: &[World],
        setups: &[Setup],
        missions: usize,
        first_seed: u64,
    ) -> Result<Self, ExperimentError> {
        let turns = worlds.iter().cycle().take(missions);
        Self::timed(title, turns.zip(first_seed..), setups)
    }

    fn timed<'w>(
        title: &str,
        worlds: impl Iterator<Item = (&'w World, u64)>,
        setups: &[Setup],
    ) -> Result<Self, ExperimentError> {
        setups.iter().try_for_each(Setup::check_pure)?;
        let mut grid = Self::empty(title);
        for (world, seed) in worlds {
            for setup in setups {
                world.check_route(&setup.config)?;
                grid.add(world, setup, "cpu", seed, 1);
            }
        }
        grid.check_names()?;
        Ok(grid.with_times())
    }

    /// The same cells, with their ticks timed while other cells run.
    #[must_use]
    pub fn with_times(mut self) -> Self {
        self.cells.iter_mut().for_each(|cell| cell.timed = true);
        self
    }

    /// The same cells on another engine, as plans name it.
    #[must_use]
    pub fn on_engine(&self, engine: &str) -> Self {
        let moved = |cell: &Cell| {
            let names = RunRow { engine: engine.to_owned(), ..cell.row.clone() };
            let timed = cell.timed;
            let cell = Cell::new(names, &cell.world, cell.config.clone(), cell.threads);
            Cell { timed, ..cell }
        };
        Self { title: self.title.clone(), cells: self.cells.iter().map(moved).collect() }
    }

    /// The same cells for an object of the caller that decides, such as a controller in Python, under its name. Their keys depend on
    /// that name too: those of the cells are of the runs in which inbye decides. The code of the object is not part of them, so
    /// equal keys do not mean equal results.
    #[must_use]
    pub fn with_controller(&self, name: &str) -> Self {
        let with = |cell: &Cell| {
            let key = key(&json!({ "cell": cell.row.key, "controller": name }));
            let row = RunRow { config: Some(name.to_owned()), key, ..cell.row.clone() };
            Cell { row, ..cell.clone() }
        };
        Self { title: self.title.clone(), cells: self.cells.iter().map(with).collect() }
    }

    /// The first cell of each key.
    #[must_use]
    pub fn distinct(&self) -> Vec<&Cell> {
        let mut seen = BTreeSet::new();
        let cells = self.cells.iter();
        cells.filter(|cell| seen.insert(cell.row.key.as_str())).collect()
    }

    fn empty(title: &str) -> Self {
        Self { title: title.to_owned(), cells: Vec::new() }
    }

    fn add(&mut self, world: &World, setup: &Setup, engine: &str, seed: u64, threads: usize) {
        let names = RunRow {
            config: setup.name.clone(),
            weights: setup.weights.clone(),
            ..world.row(&setup.config, engine, seed)
        };
        self.cells.push(Cell::new(names, world, setup.config.clone(), threads));
    }

    fn check_names(&self) -> Result<(), ExperimentError> {
        let mut ids = BTreeSet::new();
        for cell in &self.cells {
            let unkeyed = RunRow { key: String::new(), ..cell.row.clone() };
            if !ids.insert(unkeyed.names().to_string()) {
                return Err(ExperimentError::SameName { name: unkeyed.world });
            }
        }
        Ok(())
    }
}

/// All settings of a plan: changes, then weights, then samplings.
fn setups(plan: &Plan, base: &Config) -> Result<Vec<Setup>, ExperimentError> {
    let mut setups = vec![Setup::unnamed(base.clone())];
    setups = vary(setups, &plan.configs, |setup, (name, changes)| {
        let table = format!("configs.{name}");
        let changed = changes.applied(&table, &setup.config)?;
        check_overridden(plan, &setup.config.local, &changed.local)
            .map_err(|error| error.in_table(&table))?;
        Ok(Setup::named(name, changed))
    })?;
    setups = vary(setups, &plan.weights, |mut setup, (name, weights)| {
        setup.weights = Some(name.clone());
        setup.config.local.weights = *weights;
        checked(setup, format!("weights.{name}"))
    })?;
    vary(setups, &plan.sampling, |setup, sampling| {
        let setup = setup.with_sampling(sampling.vx_samples, sampling.vtheta_samples);
        checked(setup, format!("sampling {sampling}"))
    })
}

/// Rejects changes of settings that the plan's samplings or weights would set again.
fn check_overridden(
    plan: &Plan,
    own: &LocalSettings,
    changed: &LocalSettings,
) -> Result<(), ExperimentError> {
    let has_sampling = !plan.sampling.is_empty();
    let expected = "left out: `sampling` of the plan sets the samples";
    for (key, own, changed) in [
        ("local.vx_samples", own.vx_samples, changed.vx_samples),
        ("local.vtheta_samples", own.vtheta_samples, changed.vtheta_samples),
    ] {
        require(own == changed || !has_sampling, key, changed, expected)?;
    }
    let are_used = own.weights == changed.weights || plan.weights.is_empty();
    let expected = "left out: `weights` of the plan sets the weights";
    require(are_used, "local.weights", "given", expected)
}

/// Each setup with each variant; without variants the setups as they are.
fn vary<V>(
    setups: Vec<Setup>,
    variants: impl IntoIterator<Item = V> + Copy,
    apply: impl Fn(Setup, V) -> Result<Setup, ExperimentError>,
) -> Result<Vec<Setup>, ExperimentError> {
    if variants.into_iter().next().is_none() {
        return Ok(setups);
    }
    let each = setups.iter().flat_map(|setup| {
        let apply = &apply;
        variants.into_iter().map(move |variant| apply(setup.clone(), variant))
    });
    each.collect()
}

fn checked(setup: Setup, place: String) -> Result<Setup, ExperimentError> {
    match setup.config.validate() {
        Ok(()) => Ok(setup),
        Err(error) => Err(ExperimentError::BadSettings { place, error: TomlError::of_key(&error) }),
    }
}

/// A configuration with each sampling, as [`grid_counts`](crate::bench::grid_counts) shapes it: each number of samples
/// with each sampler and its ratio of forward speeds to turn rates. A sampler other than arcs names its setups. Equal
/// samplings occur once.
#[must_use]
pub fn sampling_setups(
    config: &Config,
    samples: &[usize],
    samplers: &[(Sampler, f64)],
) -> Vec<Setup> {
    let mut setups: Vec<Setup> = Vec::new();
    for &samples in samples {
        for &(sampler, shape) in samplers {
            let (vx_samples, vtheta_samples) = crate::bench::grid_counts(samples, shape);
            let mut setup =
                Setup::unnamed(config.clone()).with_sampling(vx_samples, vtheta_samples);
            setup.config.local.sampler = sampler;
            setup.name = (sampler != Sampler::Arcs).then(|| sampler.name().to_owned());
            if !setups.contains(&setup) {
                setups.push(setup);
            }
        }
    }
    setups
}
