//! Loads the settings of flags.

use std::path::Path;

use anyhow::{Context, anyhow};
use inbye::base::BaseConfig;
use inbye::input_file::read_text;
#[cfg(feature = "ros2")]
use inbye::runtime::TomlError;
use inbye::runtime::{Config, NodeConfig, is_other_variant, parse_toml};
use inbye::settings::{KeyError, SettingError};
use serde::Serialize;
use serde::de::DeserializeOwned;
use toml::{Table, Value};

use super::output;

/// Loads settings from the TOML file of a flag, or returns the defaults. Unknown keys and numbers out of range are errors. With
/// `--verbose` the settings that differ from their defaults are printed.
pub fn load(flag: &str, file: Option<&Path>) -> anyhow::Result<Config> {
    read(flag, file, Config::validate).map_err(|error| {
        with_other_kind::<BaseConfig>(
            error,
            file,
            "a base",
            "--base-config, or `config --check` with --base",
        )
    })
}

/// Adds to the error of a file that it has settings of another kind, for other flags.
fn with_other_kind<T: Default + Serialize + DeserializeOwned>(
    error: anyhow::Error,
    file: Option<&Path>,
    kind: &str,
    flags: &str,
) -> anyhow::Error {
    let Some(text) = file.and_then(|file| read_text(file).ok()) else { return error };
    let unchecked = |_: &T| Ok::<(), SettingError>(());
    if parse_toml(&text, &T::default(), unchecked).is_ok() {
        anyhow!("{error:#}; the file has the settings of {kind}: give it with {flags}")
    } else {
        error
    }
}

/// Loads settings of a base, like [`load`].
pub fn load_base(flag: &str, file: Option<&Path>) -> anyhow::Result<BaseConfig> {
    let config = read(flag, file, BaseConfig::validate).map_err(|error| {
        with_other_kind::<Config>(
            error,
            file,
            "a robot",
            "--config, or `config --check` without --base",
        )
    })?;
    let track_width_m = config.base.track_width_m;
    if track_width_m > WIDE_TRACK_M {
        let name = file.map_or_else(String::new, |file| file.display().to_string());
        output::warn(format!(
            "{flag} {name}: track_width_m is {track_width_m} m: lengths are in metres, {track_width_m} cm are {} m",
            track_width_m / 100.0
        ));
    }
    Ok(config)
}

/// An error of settings that were valid on their own, with the file and the line that it is about.
#[cfg(feature = "ros2")]
pub fn in_file(error: &SettingError, file: Option<&Path>) -> anyhow::Error {
    let read = file.and_then(|file| Some((file, read_text(file).ok()?)));
    match read {
        Some((file, text)) => {
            anyhow!(TomlError::in_text(error, &text)).context(file.display().to_string())
        }
        None => anyhow!(error.clone()),
    }
}

/// Warns of a control period that the ROS node does not keep.
pub fn warn_of_period(config: &Config) {
    let (period_s, kept) = (config.local.control_period_s, NodeConfig::PERIODS_S);
    if !kept.contains(&period_s) {
        output::warn(format!(
            "[local] control_period_s is {period_s} s: `inbye node` keeps {} to {} s",
            kept.start(),
            kept.end()
        ));
    }
}

/// No inspection robot has a wider track, metres.
const WIDE_TRACK_M: f64 = 5.0;

/// Returns a benchmark's settings with the changes of a TOML file. Unknown keys and numbers out of range are errors.
pub fn changed(settings: Config, file: Option<&Path>) -> anyhow::Result<Config> {
    let Some(file) = file else {
        settings.validate()?;
        return Ok(settings);
    };
    let place = || file.display().to_string();
    let text = read_text(file).with_context(place)?;
    settings.with_changes(&text).with_context(place)
}

/// Returns settings with the changes of `--set`, each `key=value`, where the value is TOML or a bare word. Of two changes of one
/// key the later counts. The numbers are checked together, so that the order of the keys does not matter.
pub fn with_set(settings: Config, changes: &[String]) -> anyhow::Result<Config> {
    if changes.is_empty() {
        return Ok(settings);
    }
    let unchecked = |_: &Config| Ok::<(), SettingError>(());
    let change = |settings: Config, change: &String| {
        set_line(change)
            .and_then(|line| Ok(parse_toml(&line, &settings, unchecked)?))
            .with_context(|| format!("--set {change}"))
    };
    let changed = changes.iter().try_fold(settings, change)?;
    changed.validate().map_err(|error| {
        let flag = format!("--set {}", change_of(&error, changes));
        anyhow!(error).context(flag)
    })?;
    Ok(changed)
}

/// A change of `--set` as a line of TOML.
fn set_line(change: &str) -> anyhow::Result<String> {
    let (key, value) =
        change.split_once('=').context("write KEY=VALUE, such as local.vx_samples=32")?;
    // A word without quotes is a text.
    let is_toml = format!("value = {value}").parse::<Table>().is_ok();
    let value = if is_toml { value.to_owned() } else { format!("{value:?}") };
    Ok(format!("{key} = {value}"))
}

/// The change that an error is about: the last one of its key, else of its table, else the last one.
fn change_of<'c>(error: &SettingError, changes: &'c [String]) -> &'c str {
    let is_in = |path: &str, table: &str| {
        path.strip_prefix(table).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    };
    let last = |is_cause: &dyn Fn(&str) -> bool| {
        let key = |change: &String| change.split('=').next().unwrap_or_default().trim().to_owned();
        changes.iter().rfind(|change| is_cause(&key(change)))
    };
    let path = error.key_path().unwrap_or_default();
    let change = last(&|key| is_in(&path, key)).or_else(|| last(&|key| is_in(key, &error.table)));
    change.or(changes.last()).map_or("", String::as_str)
}

fn read<T: Default + Serialize + DeserializeOwned>(
    flag: &str,
    file: Option<&Path>,
    validate: impl Fn(&T) -> Result<(), SettingError>,
) -> anyhow::Result<T> {
    let Some(file) = file else {
        return Ok(T::default());
    };
    let name = file.display();
    let text = read_text(file).with_context(|| format!("{flag} {name}"))?;
    let settings = parse_toml(&text, &T::default(), validate).with_context(|| name.to_string())?;
    if output::is_verbose() {
        let mut changes = Vec::new();
        let (old, new) = (Table::try_from(T::default())?, Table::try_from(&settings)?);
        list_changes(&old, &new, "", &mut changes);
        for change in changes {
            output::detail(format!("settings: {name}: {change}"));
        }
    }
    Ok(settings)
}

/// Lists each changed setting, such as `local.vx_samples = 8, not 20`, in the order of the keys.
fn list_changes(old: &Table, new: &Table, path: &str, changes: &mut Vec<String>) {
    for (name, value) in new {
        let key = format!("{path}{name}");
        match (old.get(name), value) {
            (Some(same), value) if same == value => {}
            (Some(Value::Table(old)), Value::Table(new)) if !is_other_variant(old, new) => {
                list_changes(old, new, &format!("{key}."), changes);
            }
            (Some(old), new) => changes.push(format!("{key} = {new}, not {old}")),
            (None, new) => changes.push(format!("{key} = {new}")),
        }
    }
    let removed = old.keys().filter(|name| !new.contains_key(*name));
    changes.extend(removed.map(|name| format!("{path}{name} is not set")));
}
