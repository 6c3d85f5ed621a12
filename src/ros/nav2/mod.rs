//! Imports Nav2 parameter files: DWB, MPPI, speeds of Regulated Pure Pursuit, rotation shim, velocity smoother, the footprint of the
//! local or the global costmap, and the goal and progress checkers.
//!
//! Names and meanings are those of Nav2's configuration guide (docs.nav2.org, 2026) and of the parameter files in
//! `nav2_bringup`. Every parameter of an imported node is either mapped to settings or listed with the reason.

mod config_builder;
mod controllers;
mod costmap_filters;
mod footprint;
mod parameter_file;
mod rules;
mod tables;

use core::fmt::{self, Display, Formatter};

use serde::Serialize;
use thiserror::Error;

use crate::suggest::MAX_POINTS;
use config_builder::ConfigBuilder;
use parameter_file::{ParameterFile, Parameters};

/// Imports the parameters of a node.
type NodeImport = fn(Parameters, &mut ConfigBuilder) -> Result<(), Nav2Error>;

/// The imported nodes.
const NODES: [(&str, NodeImport); 3] = [
    ("controller_server", controllers::import_server),
    ("velocity_smoother", |parameters, builder| {
        rules::apply(parameters, &[tables::VELOCITY_SMOOTHER], builder)
    }),
    ("local_costmap", |mut parameters, builder| {
        costmap_filters::list(&mut parameters, builder);
        rules::apply(parameters, &[tables::LOCAL_COSTMAP], builder)
    }),
];
/// The node whose costmap filters are listed. Its footprint is imported if the local costmap has none; else its other parameters are
/// ignored.
const GLOBAL_COSTMAP: &str = "global_costmap";
/// A node whose polygons have a similar form here.
const COLLISION_MONITOR: &str = "collision_monitor";

/// Imports the text of a `nav2_params.yaml`: the parameters of the robot in a namespace, or of the only robot.
///
/// The resulting configuration is valid. Settings without a parameter have their defaults, or Nav2's where it is safer.
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
            let explanation = format!("{by} comes later in the file and overrides it");
            builder.add_unmapped(path, UnmappedReason::NotInEffect, explanation);
        }
        import(parameters, &mut builder)?;
    }
    let mut names = [names.as_slice(), &[COLLISION_MONITOR]].concat();
    if let Some((mut parameters, _)) = file.node(&namespace, GLOBAL_COSTMAP) {
        costmap_filters::list(&mut parameters, &mut builder);
        let has_shape =
            ["footprint", "robot_radius"].iter().any(|name| parameters.peek(name).is_some());
        if has_shape && !builder.has(footprint::FOOTPRINT) {
            rules::apply(parameters, &[tables::LOCAL_COSTMAP], &mut builder)?;
            names.push(GLOBAL_COSTMAP);
        }
    }
    if let Some((parameters, _)) = file.node(&namespace, COLLISION_MONITOR) {
        for (name, path) in parameters.unused() {
            let mut explanation = "the import leaves it out: write each of its polygons into collision_monitor.polygons of the settings, with name, action_type and points = [[x, y], ...]".to_owned();
            if name.ends_with(MAX_POINTS.0) {
                explanation += &["; ", MAX_POINTS.1].concat();
            }
            builder.add_unmapped(path, UnmappedReason::NotSupported, explanation);
        }
    }
    builder.finish(file.ignored_nodes(&namespace, &names))
}

/// The result of an import.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Import {
    /// The imported settings in TOML, each with its source as a comment, after the warnings. All others have their defaults.
    pub config: String,
    /// The imported settings of the base, likewise; empty if there are none.
    pub base_config: String,
    /// Mapped parameters by their paths in the file.
    pub mapped: Vec<Mapped>,
    /// Parameters that the file does not have and whose default in Nav2 is safer than that of the setting, by the paths that they
    /// would have.
    pub defaults: Vec<Mapped>,
    /// Unmapped parameters by their paths in the file.
    pub unmapped: Vec<Unmapped>,
    /// Nodes that are not imported.
    pub ignored_nodes: Vec<String>,
    /// What to check before a robot drives with the settings.
    pub warnings: Vec<String>,
}

/// A mapped parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Mapped {
    /// Path in the file, such as `controller_server.FollowPath.max_vel_x`.
    pub parameter: String,
    /// The settings that depend on it.
    pub settings: Vec<MappedSetting>,
}

/// A setting that depends on a parameter, alone or together with others.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
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
#[non_exhaustive]
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
    /// Its value is out of the range of the base's setting.
    OutOfRange,
    /// The parameter is unknown.
    Unknown,
}

impl Display for UnmappedReason {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoEquivalent => "no equivalent",
            Self::DifferentMeaning => "different meaning",
            Self::NotSupported => "not supported",
            Self::NotInEffect => "not in effect",
            Self::OutOfRange => "out of range",
            Self::Unknown => "unknown",
        })
    }
}

/// Why a Nav2 file cannot be imported. Each message is one line: the place in the file, the cause, the cure.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Nav2Error {
    /// The text is not valid YAML.
    #[error("line {line}: {reason}: it must be YAML of ROS 2 parameters, each key once")]
    BadYaml {
        /// Line, from one.
        line: usize,
        /// Message of the parser.
        reason: String,
    },
    /// The file has none of the imported nodes.
    #[error(
        "no parameters of controller_server, velocity_smoother or local_costmap: it must be a nav2_params.yaml, with `ros__parameters` under each node"
    )]
    NoNodes,
    /// No setting follows from any parameter of the imported nodes.
    #[error(
        "no setting follows from the parameters of controller_server, velocity_smoother and local_costmap: {parameter}: {explanation}"
    )]
    NothingMapped {
        /// Path of one of the parameters.
        parameter: String,
        /// Why it is not mapped.
        explanation: String,
    },
    /// The file has several robots, and no namespace is given.
    #[error("the file has several robots, in the namespaces {found}: choose a namespace")]
    SeveralNamespaces {
        /// The namespaces.
        found: String,
    },
    /// The file has no robot in the given namespace.
    #[error("no parameters in the namespace `{namespace}`: the file has {found}")]
    UnknownNamespace {
        /// The given namespace.
        namespace: String,
        /// The namespaces of the file.
        found: String,
    },
    /// A parameter is both nested and written with dots.
    #[error("{parameter} is given twice, once nested and once with dots: remove one")]
    Duplicate {
        /// Path of the parameter.
        parameter: String,
    },
    /// A value has the wrong type.
    #[error("{parameter} is {value}: it must be {expected}")]
    BadValue {
        /// Path of the parameter.
        parameter: String,
        /// The value.
        value: String,
        /// The valid values.
        expected: &'static str,
    },
    /// The footprint is not a polygon of a body.
    #[error("{parameter}: {reason}")]
    BadFootprint {
        /// Path of the parameter.
        parameter: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A value is out of the range of its setting.
    #[error("{parameters}: out of range: {reason}")]
    OutOfRange {
        /// Paths of the parameters.
        parameters: String,
        /// The cause, with the names of the settings.
        reason: String,
    },
}
