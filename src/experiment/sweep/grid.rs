//! A plan as cells.

use std::collections::BTreeSet;
use std::path::Path;

use toml::Table;

use super::worlds::{SweepWorld, worlds};
use super::{Cell, Label, SweepError, SweepPlan};
use crate::runtime::Config;

/// All cells of a plan, in its order: worlds, settings, weights, samplings, engines, seeds.
#[derive(Clone, Debug)]
pub struct Grid {
    /// The plan's title.
    pub title: String,
    /// The cells. Where two names of the plan mean the same, two cells have one key.
    pub cells: Vec<Cell>,
}

impl Grid {
    /// Reads the worlds of a plan, whose paths count from this folder on, and combines everything. `change` makes changes to
    /// settings, and says what is wrong with them.
    ///
    /// # Errors
    /// When a world cannot be read, or settings cannot be changed so, or make a run depend on the wall clock.
    pub fn new(
        plan: &SweepPlan,
        folder: &Path,
        change: impl Fn(&Config, &Table) -> Result<Config, String>,
    ) -> Result<Self, SweepError> {
        plan.validate()?;
        let mut cells = Vec::new();
        for world in worlds(plan, folder)? {
            for (config_name, config) in configs(plan, &world.settings, &change)? {
                for (weights_name, config) in weighted(plan, &config)? {
                    for config in sampled(plan, &config)? {
                        let names = (config_name.clone(), weights_name.clone());
                        add(plan, &world, names, &config, &mut cells);
                    }
                }
            }
        }
        let mut labels = BTreeSet::new();
        for cell in &cells {
            if !labels.insert(format!("{:?}", cell.label)) {
                let name = cell.label.world.clone();
                return Err(SweepError::SameName { name });
            }
        }
        Ok(Self {
            title: plan.title.clone(),
            cells,
        })
    }

    /// Cells with keys of their own: the first of those that share one.
    #[must_use]
    pub fn distinct(&self) -> Vec<&Cell> {
        let mut seen = BTreeSet::new();
        let cells = self.cells.iter();
        cells
            .filter(|cell| seen.insert(cell.key.as_str()))
            .collect()
    }
}

type Named = (Option<String>, Config);

fn configs(
    plan: &SweepPlan,
    ours: &Config,
    change: impl Fn(&Config, &Table) -> Result<Config, String>,
) -> Result<Vec<Named>, SweepError> {
    if plan.configs.is_empty() {
        return Ok(vec![(None, ours.clone())]);
    }
    let changed = |(name, changes): (&String, &Table)| {
        let config = change(ours, changes).map_err(|reason| SweepError::BadChange {
            place: format!("configs.{name}"),
            reason,
        })?;
        let impure = |key| {
            let config = name.clone();
            Err(SweepError::NotPure { config, key })
        };
        if config.navigator.deadline_s.is_some() {
            return impure("deadline_s");
        }
        if !config.navigator.wait_for_plans {
            return impure("wait_for_plans = false");
        }
        Ok((Some(name.clone()), config))
    };
    plan.configs.iter().map(changed).collect()
}

fn weighted(plan: &SweepPlan, ours: &Config) -> Result<Vec<Named>, SweepError> {
    if plan.weights.is_empty() {
        return Ok(vec![(None, ours.clone())]);
    }
    let mut all = Vec::new();
    for (name, weights) in &plan.weights {
        let mut config = ours.clone();
        config.local.weights = *weights;
        check(&config, || format!("weights.{name}"))?;
        all.push((Some(name.clone()), config));
    }
    Ok(all)
}

fn sampled(plan: &SweepPlan, ours: &Config) -> Result<Vec<Config>, SweepError> {
    if plan.sampling.is_empty() {
        return Ok(vec![ours.clone()]);
    }
    let mut all = Vec::new();
    for sampling in &plan.sampling {
        let mut config = ours.clone();
        config.local.vx_samples = sampling.vx_samples;
        config.local.vtheta_samples = sampling.vtheta_samples;
        check(&config, || format!("sampling {sampling}"))?;
        all.push(config);
    }
    Ok(all)
}

fn check(config: &Config, place: impl Fn() -> String) -> Result<(), SweepError> {
    config.validate().map_err(|error| SweepError::BadChange {
        place: place(),
        reason: error.to_string(),
    })
}

fn add(
    plan: &SweepPlan,
    world: &SweepWorld,
    (config_name, weights): (Option<String>, Option<String>),
    config: &Config,
    cells: &mut Vec<Cell>,
) {
    for engine in &plan.engines {
        for &seed in &plan.seeds {
            let label = Label {
                kind: world.kind,
                world: world.name.clone(),
                config: config_name.clone(),
                weights: weights.clone(),
                vx_samples: config.local.vx_samples,
                vtheta_samples: config.local.vtheta_samples,
                engine: engine.clone(),
                seed,
                latency: world.latency,
            };
            let threads = if world.latency {
                plan.latency_threads
            } else {
                1
            };
            let (ground, digest) = (&world.ground, &world.digest);
            cells.push(Cell::new(label, ground, digest, config.clone(), threads));
        }
    }
}
