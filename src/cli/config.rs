//! Loads configuration files.

use std::fs;
use std::path::Path;

use anyhow::Context;
use inbye::base::BaseConfig;
use inbye::runtime::Config;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::output;
use super::toml_merge::{is_other_variant, parse};

/// Loads settings from the TOML file of a flag, or returns the defaults. Unknown keys and numbers out of range are errors. With
/// `--verbose` the settings that differ from their defaults are printed.
pub fn load(flag: &str, file: Option<&Path>) -> anyhow::Result<Config> {
    read(flag, file, |config: &Config| Ok(config.validate()?))
}

/// Loads settings of a base, like [`load`].
pub fn load_base(flag: &str, file: Option<&Path>) -> anyhow::Result<BaseConfig> {
    read(flag, file, |config: &BaseConfig| Ok(config.validate()?))
}

/// Returns a benchmark's settings with the changes of a TOML file. Unknown keys and numbers out of range are errors.
pub fn changed(settings: Config, file: Option<&Path>) -> anyhow::Result<Config> {
    let Some(file) = file else {
        settings.validate()?;
        return Ok(settings);
    };
    let text = fs::read_to_string(file).context("cannot be read as text: check the path");
    text.and_then(|text| parse(&text, &settings, |config| Ok(config.validate()?)))
        .with_context(|| format!("{}", file.display()))
}

fn read<T: Default + Serialize + DeserializeOwned>(
    flag: &str,
    file: Option<&Path>,
    validate: impl Fn(&T) -> anyhow::Result<()>,
) -> anyhow::Result<T> {
    let Some(file) = file else {
        return Ok(T::default());
    };
    let text = fs::read_to_string(file)
        .with_context(|| format!("{flag} {}: cannot be read as text", file.display()))?;
    let settings =
        parse(&text, &T::default(), validate).with_context(|| format!("{}", file.display()))?;
    if output::is_verbose() {
        for change in differences(&T::default(), &settings)? {
            output::detail(format!("settings: {}: {change}", file.display()));
        }
    }
    Ok(settings)
}

/// Lists each changed setting, such as `local.vx_samples = 8, not 20`, in the order of the keys.
fn differences<T: Serialize>(old: &T, new: &T) -> anyhow::Result<Vec<String>> {
    let mut changes = Vec::new();
    let (old, new) = (toml::Table::try_from(old)?, toml::Table::try_from(new)?);
    compare(&old, &new, "", &mut changes);
    Ok(changes)
}

fn compare(old: &toml::Table, new: &toml::Table, path: &str, changes: &mut Vec<String>) {
    for (name, value) in new {
        let key = format!("{path}{name}");
        match (old.get(name), value) {
            (Some(same), value) if same == value => {}
            (Some(toml::Value::Table(old)), toml::Value::Table(new))
                if !is_other_variant(old, new) =>
            {
                compare(old, new, &format!("{key}."), changes);
            }
            (Some(old), new) => changes.push(format!("{key} = {new}, not {old}")),
            (None, new) => changes.push(format!("{key} = {new}")),
        }
    }
    let removed = old.keys().filter(|name| !new.contains_key(*name));
    changes.extend(removed.map(|name| format!("{path}{name} is not set")));
}
