//! `inbye config`: prints, checks and imports settings.

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::{Context, anyhow, bail};
use clap::{Args, Subcommand};
use inbye::base::BaseConfig;
use inbye::input_file::read_text;
use inbye::ros::nav2::{Import, Mapped, MappedSetting, Nav2Error, import};
use inbye::runtime::Config;
use serde_json::json;

use super::files::Output;
use super::{config, output, own_file};

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
#[group(multiple = false)]
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
    The command reads controller_server (DWB or MPPI, alone or in a rotation shim; goal and progress checkers), velocity_smoother \
    and local_costmap (the robot's shape), in any namespace and with wildcards. The TOML goes to standard output or into \
    the file; each key has a comment with the parameter that it comes from. Standard error lists every parameter of these nodes that is not \
    imported, with the reason. If controller and smoother limit the same quantity, the tighter limit counts.\n\
    Warnings, such as that of a file without a footprint, are at the start of the TOML and on standard error.\n\
    JSON fields: `config` and `base_config` (TOML), `mapped` [{`parameter`,`settings` [{`setting`,`value`,`note`}]}], \
    `defaults` (likewise, missing parameters whose default in Nav2 is safer), `unmapped` \
    [{`parameter`,`reason`,`explanation`}], `ignored_nodes`, `warnings`; `reason` is no_equivalent, different_meaning, not_supported, \
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
pub fn run(arguments: &ConfigArguments) -> anyhow::Result<bool> {
    let (action, base) = (&arguments.action, arguments.base);
    if let Some(ConfigCommand::ImportNav2(command)) = &arguments.command {
        import_nav2(command)?;
    } else if let Some(file) = &action.check {
        if base {
            config::load_base("--check", Some(file))?;
        } else {
            let config = config::load("--check", Some(file))?;
            config::warn_of_period(&config);
        }
        let name = file.display().to_string();
        output::result(&json!({ "file": name, "ok": true }), [format!("{name}: ok")])?;
    } else if !(action.schema || action.print) {
        bail!(
            "config: nothing to do: write --print, --schema, --check FILE.toml, or the command import-nav2 FILE; see --help"
        );
    } else if action.schema {
        output::print_json(&if base { BaseConfig::schema() } else { Config::schema() })?;
    } else {
        let (text, keys) = if base {
            (BaseConfig::documented(), BaseConfig::keys())
        } else {
            (Config::documented(), Config::keys())
        };
        output::result(&json!({ "config": text, "keys": keys }), [text.trim_end()])?;
    }
    Ok(true)
}

/// Imports a Nav2 file.
fn import_nav2(arguments: &ImportArguments) -> anyhow::Result<()> {
    let file = &arguments.file;
    let place = || file.display().to_string();
    let text = read_text(file).with_context(place)?;
    let imported = import(&text, arguments.namespace.as_deref());
    let imported = imported.map_err(with_flag).with_context(place)?;
    // Files are overwritten only after a successful import, and neither of them if both are one.
    let names = [("--output", &arguments.output), ("--base-output", &arguments.base_output)];
    for (flag, name) in names.iter().filter_map(|(flag, name)| Some((flag, name.as_ref()?))) {
        own_file::reserve(flag, name)?;
    }
    let written = Output::create("--output", arguments.output.as_deref(), &["toml"])?;
    let base_written =
        Output::create("--base-output", arguments.base_output.as_deref(), &["toml"])?;
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let heading = heading(&name);
    imported.warnings.iter().for_each(output::warn);
    if output::is_json() {
        output::print_json(&imported)?;
    } else {
        if !written.is_requested() {
            output::line(heading.clone() + &imported.config);
        }
        note(&imported, !base_written.is_requested());
    }
    written.write(|| heading.clone() + &imported.config)?;
    base_written.write(|| heading.clone() + &imported.base_config)
}

/// Adds the flag that selects a namespace.
fn with_flag(error: Nav2Error) -> anyhow::Error {
    match error {
        Nav2Error::SeveralNamespaces { .. } => anyhow!("{error} with --namespace"),
        other => other.into(),
    }
}

/// The first lines of the file. A control character in the name would end the comment.
fn heading(name: &str) -> String {
    let name: String = name.chars().filter(|letter| !letter.is_control()).collect();
    format!(
        "# Imported from {name} by `inbye config import-nav2`; all other settings have their defaults.\n\n"
    )
}

/// Notes the base's settings, which belong to another file, and the parameters that are not imported.
fn note(imported: &Import, with_base_config: bool) {
    if with_base_config && !imported.base_config.is_empty() {
        output::note("for --base-config, which --base-output FILE.toml writes:");
        for line in imported.base_config.lines().filter(|line| !line.is_empty()) {
            output::note(format!("  {line}"));
        }
    }
    // By reason, and parameters with the same explanation together.
    let mut groups: BTreeMap<String, BTreeMap<&str, Vec<&str>>> = BTreeMap::new();
    for unmapped in &imported.unmapped {
        let group = groups.entry(unmapped.reason.to_string()).or_default();
        group.entry(&unmapped.explanation).or_default().push(&unmapped.parameter);
    }
    for (reason, explanations) in &groups {
        output::note(format!("{reason}:"));
        for (explanation, parameters) in explanations {
            output::note(format!("  {}: {explanation}", parameters.join(", ")));
        }
    }
    for Mapped { parameter, settings } in &imported.defaults {
        for MappedSetting { setting, value, note } in settings {
            output::note(format!("{parameter}: {note}: {setting} = {value}"));
        }
    }
    if !imported.ignored_nodes.is_empty() {
        output::note(format!("ignored nodes: {}", imported.ignored_nodes.join(", ")));
    }
    let (mapped, unmapped) = (imported.mapped.len(), imported.unmapped.len());
    output::note(format!("{mapped} parameters mapped, {unmapped} without an equivalent"));
}
