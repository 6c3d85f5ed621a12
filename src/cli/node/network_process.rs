//! The network process: DDS within a memory limit.

use std::env::{self, VarError};
use std::io::{stdin, stdout};
use std::time::{SystemTime, UNIX_EPOCH};

use anyhow::{Context, anyhow, bail};
use inbye::ros::msg::Time;
use inbye::ros::node::dds::{DdsSettings, Rmw};
use inbye::ros::node::network::run_bridge;
use inbye::ros::node::{NameError, NodeNames};
#[cfg(unix)]
use rlimit::Resource;

use super::{NameArguments, NodeArguments};
use crate::cli::machine::{interrupt_flag, wall_clock};

/// The highest domain with ports of its own.
const MAX_DOMAIN: u16 = 232;

/// Passes messages between DDS and the pipes of the control process.
pub fn run(arguments: &NodeArguments, memory_mib: u64) -> anyhow::Result<bool> {
    limit_memory(memory_mib)?;
    let settings = dds_settings(arguments)?;
    let stop = interrupt_flag()?;
    run_bridge(&settings, stdin(), stdout(), &stop, &mut wall_clock(), &now)?;
    Ok(true)
}

/// An allocation beyond the limit ends this process at once. Linux counts all private memory for it.
#[cfg(unix)]
fn limit_memory(memory_mib: u64) -> anyhow::Result<()> {
    let bytes = memory_mib.saturating_mul(1 << 20);
    let limit = |resource: Resource, bytes: u64| {
        let (_, hard) = resource.get()?;
        resource.set(bytes.min(hard), bytes.min(hard))
    };
    limit(Resource::DATA, bytes).context("cannot limit the memory of the network process")?;
    // A core file of that size would take seconds before the restart.
    limit(Resource::CORE, 0).context("cannot switch core files off")
}

#[cfg(not(unix))]
fn limit_memory(_memory_mib: u64) -> anyhow::Result<()> {
    Ok(())
}

/// The settings of DDS by the arguments and the environment.
pub fn dds_settings(arguments: &NodeArguments) -> anyhow::Result<DdsSettings> {
    let variable = |name| env::var(name).unwrap_or_default();
    Ok(DdsSettings {
        names: node_names(&arguments.names)?,
        domain: domain()?,
        localhost_only: is_localhost_only(
            &variable("ROS_AUTOMATIC_DISCOVERY_RANGE"),
            &variable("ROS_LOCALHOST_ONLY"),
        )?,
        stamped: arguments.stamped,
        rmw: rmw(&variable("RMW_IMPLEMENTATION"))?,
        is_managed: arguments.lifecycle.managed,
    })
}

/// The names by the arguments.
fn node_names(arguments: &NameArguments) -> anyhow::Result<NodeNames> {
    let NameArguments { namespace, remap, .. } = arguments;
    NodeNames::new(namespace, remap).map_err(|error| {
        let is_option =
            matches!(&error, NameError::BadNamespace { namespace: found } if found == namespace);
        let option =
            if is_option { format!("--namespace {namespace}") } else { "--remap".to_owned() };
        anyhow!(error).context(option)
    })
}

/// The implementation of DDS whose limits the node keeps. An empty name is the default.
fn rmw(name: &str) -> anyhow::Result<Rmw> {
    match name {
        "rmw_cyclonedds_cpp" => Ok(Rmw::CycloneDds),
        "" | "rmw_fastrtps_cpp" | "rmw_fastrtps_dynamic_cpp" => Ok(DdsSettings::default().rmw),
        other => Err(anyhow!(
            "RMW_IMPLEMENTATION is `{}`: it must be rmw_fastrtps_cpp or rmw_cyclonedds_cpp",
            other.escape_debug()
        )),
    }
}

/// The time by the wall clock.
pub fn now() -> Time {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    let since = since.unwrap_or_default();
    let sec = i32::try_from(since.as_secs()).unwrap_or(i32::MAX);
    Time { sec, nanosec: since.subsec_nanos() }
}

fn domain() -> anyhow::Result<u16> {
    let name = "ROS_DOMAIN_ID";
    match env::var(name) {
        Err(VarError::NotPresent) => Ok(0),
        Err(error) => Err(error).context(name),
        Ok(text) if text.is_empty() => Ok(0),
        Ok(text) => {
            let number = text.parse().ok().filter(|domain| *domain <= MAX_DOMAIN);
            number.ok_or_else(|| {
                anyhow!("{name} is `{text}`: it must be a whole number, 0 to {MAX_DOMAIN}")
            })
        }
    }
}

/// Whether discovery is restricted to this machine, by the values of `ROS_AUTOMATIC_DISCOVERY_RANGE` and `ROS_LOCALHOST_ONLY`. An
/// empty value is the default.
fn is_localhost_only(range: &str, localhost_only: &str) -> anyhow::Result<bool> {
    let is_local_range = match range {
        "LOCALHOST" => true,
        "" | "SUBNET" | "SYSTEM_DEFAULT" => false,
        "OFF" => bail!(
            "ROS_AUTOMATIC_DISCOVERY_RANGE is OFF: the node cannot switch discovery off; it must be LOCALHOST, SUBNET or \
             SYSTEM_DEFAULT"
        ),
        other => bail!(
            "ROS_AUTOMATIC_DISCOVERY_RANGE is `{}`: it must be LOCALHOST, SUBNET or SYSTEM_DEFAULT",
            other.escape_debug()
        ),
    };
    match localhost_only {
        "1" => Ok(true),
        "" | "0" => Ok(is_local_range),
        other => bail!("ROS_LOCALHOST_ONLY is `{}`: it must be 0 or 1", other.escape_debug()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_rmw_is_an_error() {
        let default = DdsSettings::default().rmw;
        assert_eq!(rmw("").ok(), Some(default));
        assert_eq!(rmw("rmw_fastrtps_cpp").ok(), Some(default));
        assert_eq!(rmw("rmw_cyclonedds_cpp").ok(), Some(Rmw::CycloneDds));
        let error = rmw("foo").expect_err("no implementation").to_string();
        assert!(error.starts_with("RMW_IMPLEMENTATION is `foo`: it must be "), "{error}");
    }

    #[test]
    fn range_of_discovery_is_local_or_the_default_or_an_error() {
        for (range, only, expected) in [
            ("", "", false),
            ("SUBNET", "0", false),
            ("SYSTEM_DEFAULT", "", false),
            ("LOCALHOST", "", true),
            ("", "1", true),
            ("SUBNET", "1", true),
        ] {
            assert_eq!(is_localhost_only(range, only).ok(), Some(expected), "{range} {only}");
        }
        for (range, only, words) in [
            ("OFF", "", "is OFF: the node cannot switch discovery off; it must be LOCALHOST"),
            ("localhost", "", "is `localhost`: it must be LOCALHOST, SUBNET or SYSTEM_DEFAULT"),
            ("", "yes", "ROS_LOCALHOST_ONLY is `yes`: it must be 0 or 1"),
        ] {
            let error = is_localhost_only(range, only).expect_err(words).to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}
