//! `inbye config`.

use std::path::Path;

use inbye::base::BaseConfig;
use inbye::documented::Described;
use inbye::runtime::Config;
use serde_json::json;

use super::config_arguments::{ConfigArguments, ConfigCommand};
use super::{config, import_nav2, output};

/// Prints or checks a configuration, or takes one over.
pub fn run(arguments: &ConfigArguments, json: bool) -> anyhow::Result<bool> {
    let action = &arguments.action;
    match (&arguments.command, &action.check) {
        (Some(ConfigCommand::ImportNav2(command)), _) => import_nav2::run(command, json),
        (None, Some(file)) => check(file, arguments.base, json),
        (None, None) => print(arguments.base, json),
    }
}

fn print(base: bool, json: bool) -> anyhow::Result<bool> {
    let (text, keys): (String, Vec<Described>) = if base {
        (BaseConfig::documented(), BaseConfig::keys())
    } else {
        (Config::documented(), Config::keys())
    };
    if json {
        output::json(&json!({ "config": text, "keys": keys }))?;
    } else {
        output::line(text.trim_end());
    }
    Ok(true)
}

fn check(file: &Path, base: bool, json: bool) -> anyhow::Result<bool> {
    if base {
        config::load_base("--check", Some(file))?;
    } else {
        config::load("--check", Some(file))?;
    }
    let name = file.display().to_string();
    if json {
        output::json(&json!({ "file": name, "ok": true }))?;
    } else {
        output::line(format!("{name}: ok"));
    }
    Ok(true)
}
