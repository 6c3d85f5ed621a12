//! Imports Nav2 parameter files: DWB, MPPI, rotation shim, velocity smoother, the footprint of the local costmap, and the goal
//! and progress checkers.
//!
//! Names and meanings are those of Nav2's configuration guide (docs.nav2.org, 2026) and of the parameter files in
//! `nav2_bringup`. Every parameter of an imported node is either mapped to settings or listed with the reason.

mod config_builder;
mod controllers;
mod error;
mod footprint;
mod import_report;
mod parameter_file;
mod parameters;
mod rules;
mod tables;

pub use error::Nav2Error;
pub use import_report::{Import, Mapped, MappedSetting, Unmapped, UnmappedReason};

use config_builder::ConfigBuilder;
use parameter_file::ParameterFile;
use parameters::Parameters;

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
