//! What may be typed after `inbye config`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

/// `inbye config`.
#[derive(Debug, Args)]
#[command(
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = "Example:\n  inbye config --print\n  inbye config --print --base --json\n  \
    inbye config --check mine.toml\n  inbye config import-nav2 nav2_params.yaml --output mine.toml\n\n\
    What is printed is a whole configuration: every key at its default, with its unit, its range and what it does. Leave out \
    what is to stay as it is. JSON fields: `config` (the TOML) and `keys` [{`key`,`default`,`says`}]; with --check `file` and `ok`."
)]
pub struct ConfigArguments {
    #[command(flatten)]
    pub action: ActionArguments,
    /// The settings of a base, those of --base-config, in place of those of --config.
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
    /// Say whether a file can be used, and if not, why.
    #[arg(long, value_name = "FILE.toml")]
    pub check: Option<PathBuf>,
}

/// What can be taken over.
#[derive(Debug, Subcommand)]
pub enum ConfigCommand {
    /// Take over the parameters of a Nav2 file, and list what cannot be taken over.
    ImportNav2(ImportArguments),
}

/// `inbye config import-nav2`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye config import-nav2 nav2_params.yaml --output mine.toml\n  \
    inbye config import-nav2 nav2_params.yaml --json\n\n\
    Read are controller_server (DWB or MPPI, alone or in a rotation shim; goal and progress checkers), velocity_smoother and \
    local_costmap (the robot's shape), in any namespace and with wildcards. The TOML goes to standard output or into \
    the file, each key with the parameter that it comes from; standard error lists every parameter of these nodes that is not \
    taken over, with the reason. Where controller and smoother limit the same, the tighter limit counts.\n\
    JSON fields: `config` and `base_config` (TOML), `mapped` [{`key`,`to` [{`key`,`value`,`how`}]}], `not_mapped` \
    [{`key`,`why`,`reason`}], `ignored` (nodes not read); `why` is no_such_thing, other_meaning, not_yet, not_in_force or unknown."
)]
pub struct ImportArguments {
    /// A Nav2 parameter file, YAML.
    pub file: PathBuf,
    /// Write the settings for --config into this file.
    #[arg(long, value_name = "FILE.toml")]
    pub output: Option<PathBuf>,
    /// Write those for --base-config, which come from the velocity smoother, into this file.
    #[arg(long, value_name = "FILE.toml")]
    pub base_output: Option<PathBuf>,
    /// The robot to read, where the file has several.
    #[arg(long, value_name = "NS")]
    pub namespace: Option<String>,
}
