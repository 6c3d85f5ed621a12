//! Settings of a file in place of a benchmark's own.

use std::fs;
use std::path::Path;
use std::str::FromStr;

use anyhow::{Context, anyhow};
use inbye::sim::Config;

/// A benchmark's settings, changed by a TOML file if there is one. Unknown keys and numbers out of range are errors.
pub fn changed(ours: Config, file: Option<&Path>) -> anyhow::Result<Config> {
    let Some(file) = file else {
        ours.validate()?;
        return Ok(ours);
    };
    by_file(&ours, file).with_context(|| format!("{}", file.display()))
}

fn by_file(ours: &Config, file: &Path) -> anyhow::Result<Config> {
    let text = fs::read_to_string(file).context("cannot be read as text: check the path")?;
    // The error's first line names the place, the others draw it.
    let plain = |error: toml::de::Error| anyhow!("{}", error.message().to_owned());
    let changes = toml::Table::from_str(&text).map_err(plain)?;
    let mut table = toml::Table::try_from(ours)?;
    change(&mut table, changes);
    let config: Config = table.try_into().map_err(plain)?;
    config.validate()?;
    Ok(config)
}

/// Puts values in place of others, table by table.
fn change(table: &mut toml::Table, changes: toml::Table) {
    for (name, value) in changes {
        match (table.get_mut(&name), value) {
            (Some(toml::Value::Table(within)), toml::Value::Table(changes)) => {
                change(within, changes);
            }
            (_, value) => {
                table.insert(name, value);
            }
        }
    }
}
