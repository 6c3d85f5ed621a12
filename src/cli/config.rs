//! The configuration file.

use std::fs;
use std::path::Path;

use anyhow::Context;
use inbye::sim::Config;

/// Settings from a TOML file, or the defaults. Unknown keys are errors.
pub fn load(file: Option<&Path>) -> anyhow::Result<Config> {
    let Some(file) = file else {
        return Ok(Config::default());
    };
    let place = || format!("{}", file.display());
    let text = fs::read_to_string(file).with_context(place)?;
    let config: Config = toml::from_str(&text)
        .map_err(|error| anyhow::anyhow!(one_line(&error, &text)))
        .with_context(place)?;
    config.robot.limits.validate().with_context(place)?;
    Ok(config)
}

fn one_line(error: &toml::de::Error, text: &str) -> String {
    let line = error
        .span()
        .map_or(1, |span| text[..span.start].matches('\n').count() + 1);
    format!("line {line}: {}", error.message())
}
