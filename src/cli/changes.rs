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
    let text = fs::read_to_string(file).context("cannot be read as text: check the path");
    text.and_then(|text| by_text(&ours, &text))
        .with_context(|| format!("{}", file.display()))
}

/// Settings changed by the text of a TOML file.
pub fn by_text(ours: &Config, text: &str) -> anyhow::Result<Config> {
    // The error's first line names the place, the others draw it.
    let plain = |error: toml::de::Error| anyhow!("{}", error.message().to_owned());
    let changes = toml::Table::from_str(text).map_err(plain)?;
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
            (Some(toml::Value::Table(within)), toml::Value::Table(changes))
                if !is_other_choice(within, &changes) =>
            {
                change(within, changes);
            }
            (_, value) => {
                table.insert(name, value);
            }
        }
    }
}

/// Whether two tables are different choices of one setting, such as `{ theta = { degrees = 30 } }` in place of
/// `{ normalized = { k = 1 } }`: such a table has one key, and is exchanged as a whole.
fn is_other_choice(ours: &toml::Table, theirs: &toml::Table) -> bool {
    let only = |table: &toml::Table| {
        let name = table.keys().next().cloned();
        name.filter(|_| table.len() == 1)
    };
    only(ours).is_some_and(|ours| only(theirs).is_some_and(|theirs| theirs != ours))
}
