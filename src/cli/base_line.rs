//! A base on a port, as the command line names it.

use std::path::Path;
use std::time::Duration;

use inbye::base::Protocol;
use inbye::runtime::hardware::SerialLine;

use super::base_arguments::LineArguments;
use super::config;

/// Time between polls of a supervisor.
pub const POLL_PERIOD: Duration = Duration::from_millis(20);

/// Returns the base that the arguments name.
pub fn from_arguments(arguments: &LineArguments) -> anyhow::Result<SerialLine> {
    let kind = &arguments.kind;
    load(&arguments.port, kind.protocol, kind.base_config.as_deref())
}

/// Returns a base with the settings of a file, or with the default ones.
pub fn load(port: &str, protocol: Protocol, file: Option<&Path>) -> anyhow::Result<SerialLine> {
    Ok(SerialLine {
        port: port.to_owned(),
        protocol,
        config: config::load_base("--base-config", file)?,
    })
}
