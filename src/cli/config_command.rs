//! `inbye config`.

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use inbye::base::BaseConfig;
use inbye::runtime::Config;
use inbye::settings::KeyDescription;
use serde_json::json;

use super::{config, import_nav2, output};

/// `inbye config`.
#[derive(Debug, Args)]
#[command(
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = "Example:\n  inbye config --print\n  inbye config --print --base --json\n  \
    inbye config --schema\n  inbye config --check mine.toml\n  inbye config import-nav2 nav2_params.yaml --output mine.toml\n\n\
    --print writes a complete configuration: every key with its default, unit, range and meaning. Leave out every key that \
    keeps its default. --schema writes a JSON Schema (draft 2020-12), from which an editor completes and checks a file. JSON fields: \
    `config` (the TOML) and `keys` [{`key`,`default`,`description`,`unit`,`range`}]; with --check `file` and `ok`."
)]
pub struct ConfigArguments {
    #[command(flatten)]
    pub action: ActionArguments,
    /// Use the settings of a base (--base-config) instead of those of --config.
    #[arg(long)]
    pub base: bool,
    /// What else to do.
    #[command(subcommand)]
    pub command: Option<ConfigCommand>,
}

/// Print or check.
#[derive(Debug, Args)]
#[group(required = true, multiple = false)]
pub struct ActionArguments {
    /// Print every setting with its default, as commented TOML.
    #[arg(long)]
    pub print: bool,
    /// Print the JSON Schema of the configuration, for editors.
    #[arg(long)]
    pub schema: bool,
    /// Check whether a file is valid, and print the reason if not.
    #[arg(long, value_name = "FILE.toml")]
    pub check: Option<PathBuf>,
}

/// Imports of other configurations.
#[derive(Debug, Subcommand)]
pub enum ConfigCommand {
    /// Import the parameters of a Nav2 file, and list those that have no equivalent.
    ImportNav2(ImportArguments),
}

/// `inbye config import-nav2`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye config import-nav2 nav2_params.yaml --output mine.toml\n  \
    inbye config import-nav2 nav2_params.yaml --json\n\n\
    Read are controller_server (DWB or MPPI, alone or in a rotation shim; goal and progress checkers), velocity_smoother and \
    local_costmap (the robot's shape), in any namespace and with wildcards. The TOML goes to standard output or into \
    the file, each key with the parameter that it comes from. Standard error lists every parameter of these nodes that is not \
    imported, with the reason. If controller and smoother limit the same quantity, the tighter limit counts.\n\
    JSON fields: `config` and `base_config` (TOML), `mapped` [{`parameter`,`settings` [{`setting`,`value`,`note`}]}], `unmapped` \
    [{`parameter`,`reason`,`explanation`}], `ignored_nodes`; `reason` is no_equivalent, different_meaning, not_supported, \
    not_in_effect or unknown."
)]
pub struct ImportArguments {
    /// A Nav2 parameter file, YAML.
    pub file: PathBuf,
    /// Write the settings for --config into this file.
    #[arg(long, value_name = "FILE.toml")]
    pub output: Option<PathBuf>,
    /// Write the settings for --base-config, which come from the velocity smoother, into this file.
    #[arg(long, value_name = "FILE.toml")]
    pub base_output: Option<PathBuf>,
    /// Namespace of the robot to read, if the file has several robots.
    #[arg(long, value_name = "NS")]
    pub namespace: Option<String>,
}

/// Prints, checks or imports a configuration.
pub fn run(arguments: &ConfigArguments, json: bool) -> anyhow::Result<bool> {
    let action = &arguments.action;
    match (&arguments.command, &action.check) {
        (Some(ConfigCommand::ImportNav2(command)), _) => import_nav2::run(command, json),
        (None, Some(file)) => check(file, arguments.base, json),
        (None, None) if action.schema => {
            let schema = if arguments.base { BaseConfig::schema() } else { Config::schema() };
            output::json(&schema)?;
            Ok(true)
        }
        (None, None) => print(arguments.base, json),
    }
}

fn print(base: bool, json: bool) -> anyhow::Result<bool> {
    let (text, keys): (String, Vec<KeyDescription>) = if base {
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
