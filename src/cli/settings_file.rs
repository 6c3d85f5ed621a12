//! The settings named on the command line, and what in them is not at its default, told with `--verbose`.

use std::path::Path;

use inbye::base::BaseConfig;
use inbye::runtime::Config;
use serde::Serialize;

use super::changes::is_other_choice;
use super::{config, output};

/// Settings from the TOML file of `--config`, or the defaults.
pub fn read(file: Option<&Path>) -> anyhow::Result<Config> {
    let settings = config::load("--config", file)?;
    tell(file, &settings)?;
    Ok(settings)
}

/// Settings of a base and its supervisor from the TOML file of `--base-config`, or the defaults.
pub fn read_base(file: Option<&Path>) -> anyhow::Result<BaseConfig> {
    let settings = config::load_base("--base-config", file)?;
    tell(file, &settings)?;
    Ok(settings)
}

fn tell<T: Default + Serialize>(file: Option<&Path>, settings: &T) -> anyhow::Result<()> {
    let Some(file) = file.filter(|_| output::tells_details()) else {
        return Ok(());
    };
    for change in between(&T::default(), settings)? {
        output::detail(format!("settings: {}: {change}", file.display()));
    }
    Ok(())
}

/// Each setting that is not as it was, as `local.vx_samples = 8, not 20`; in the order of the keys.
fn between<T: Serialize>(before: &T, after: &T) -> anyhow::Result<Vec<String>> {
    let mut changes = Vec::new();
    let (before, after) = (
        toml::Table::try_from(before)?,
        toml::Table::try_from(after)?,
    );
    compare(&before, &after, "", &mut changes);
    Ok(changes)
}

fn compare(before: &toml::Table, after: &toml::Table, path: &str, changes: &mut Vec<String>) {
    for (name, value) in after {
        let key = format!("{path}{name}");
        match (before.get(name), value) {
            (Some(same), value) if same == value => {}
            (Some(toml::Value::Table(before)), toml::Value::Table(after))
                if !is_other_choice(before, after) =>
            {
                compare(before, after, &format!("{key}."), changes);
            }
            (Some(before), after) => changes.push(format!("{key} = {after}, not {before}")),
            (None, after) => changes.push(format!("{key} = {after}")),
        }
    }
    let gone = before.keys().filter(|name| !after.contains_key(*name));
    changes.extend(gone.map(|name| format!("{path}{name} is not set")));
}
