//! Imports Nav2 parameter files: DWB, MPPI, rotation shim, velocity smoother, the footprint of the local costmap, and the goal
//! and progress checkers.
//!
//! Names and meanings are those of Nav2's configuration guide (docs.nav2.org, 2026) and of the parameter files in
//! `nav2_bringup`. Every parameter of an imported node is either mapped to settings or listed with the reason.

mod config_builder;
mod controllers;
mod error;
mod footprint;
mod parameter_file;
mod parameters;
mod rules;
mod tables;

pub use error::Nav2Error;

use core::fmt::{Display, Formatter};

use serde::Serialize;

use config_builder::ConfigBuilder;
use parameter_file::ParameterFile;
use parameters::Parameters;

/// The result of an import.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Import {
    /// The imported settings in TOML, each with its source as a comment. All others have their defaults.
    pub config: String,
    /// The imported settings of the base, likewise; empty if there are none.
    pub base_config: String,
    /// Mapped parameters by their paths in the file.
    pub mapped: Vec<Mapped>,
    /// Unmapped parameters by their paths in the file.
    pub unmapped: Vec<Unmapped>,
    /// Nodes that are not imported.
    pub ignored_nodes: Vec<String>,
}

/// A mapped parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Mapped {
    /// Path in the file, such as `controller_server.FollowPath.max_vel_x`.
    pub parameter: String,
    /// The settings that depend on it.
    pub settings: Vec<MappedSetting>,
}

/// A setting that depends on a parameter, alone or together with others.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MappedSetting {
    /// Path of the setting, such as `robot.limits.max_vel_x`.
    pub setting: &'static str,
    /// Value of the setting.
    pub value: serde_json::Value,
    /// How the value follows from the parameter; empty if both are equal.
    pub note: String,
}

/// An unmapped parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Unmapped {
    /// Path in the file.
    pub parameter: String,
    /// Kind of the reason.
    pub reason: UnmappedReason,
    /// Explanation of the reason.
    pub explanation: String,
}

/// Why a parameter is not mapped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum UnmappedReason {
    /// No setting has the same purpose.
    NoEquivalent,
    /// The setting with the same purpose has another meaning.
    DifferentMeaning,
    /// The import does not support it.
    NotSupported,
    /// Another parameter overrides it.
    NotInEffect,
    /// The parameter is unknown.
    Unknown,
}

impl Display for UnmappedReason {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> core::fmt::Result {
        formatter.write_str(match self {
            Self::NoEquivalent => "no equivalent",
            Self::DifferentMeaning => "different meaning",
            Self::NotSupported => "not supported",
            Self::NotInEffect => "not in effect",
            Self::Unknown => "unknown",
        })
    }
}

/// Imports the parameters of a node.
type NodeImport = fn(Parameters, &mut ConfigBuilder) -> Result<(), Nav2Error>;

/// The imported nodes.
const NODES: [(&str, NodeImport); 3] = [
    ("controller_server", controllers::import_server),
    ("velocity_smoother", |parameters, builder| {
        rules::apply(parameters, &[tables::VELOCITY_SMOOTHER], builder)
    }),
    ("local_costmap", |parameters, builder| {
        rules::apply(parameters, &[tables::LOCAL_COSTMAP], builder)
    }),
];

/// Imports the text of a `nav2_params.yaml`: the parameters of the robot in a namespace, or of the only robot.
///
/// The resulting configuration is valid. Settings without a parameter have their defaults.
///
/// # Errors
/// When the text is no parameter file, has several robots and no namespace is given, or has a value out of range.
pub fn import(text: &str, namespace: Option<&str>) -> Result<Import, Nav2Error> {
    let file = ParameterFile::parse(text)?;
    let names = NODES.map(|(name, _)| name);
    let namespace = file.select_namespace(namespace, &names)?;
    let mut builder = ConfigBuilder::default();
    for (name, import) in NODES {
        let Some((parameters, overridden)) = file.node(&namespace, name) else {
            continue;
        };
        for (path, by) in overridden {
            let explanation = format!("{by} overrides it");
            builder.add_unmapped(path, UnmappedReason::NotInEffect, explanation);
        }
        import(parameters, &mut builder)?;
    }
    builder.finish(file.ignored_nodes(&namespace, &names))
}
