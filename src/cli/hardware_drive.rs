//! `inbye drive --port`: a base on a serial line, driven in real time; a simulated world around it, or with `--lidar` the real
//! one.

use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use inbye::base::ld19::LidarStatus;
use inbye::base::{Protocol, SupervisorStatus};
use inbye::geometry::Pose;
use inbye::runtime::hardware::{HardwareRobot, SerialLine, connect_lidar, stop_cause};
use serde_json::{Value, json};

use super::{base_arguments, base_text, process, report_file, value_parsers};

/// The base of a drive.
#[derive(Debug, Args)]
pub struct HardwareArguments {
    /// Drive the base on this port, in real time; without --lidar, world and lidar stay simulated.
    #[arg(long, value_name = "P")]
    pub port: Option<String>,
    /// Use the LD19 lidar on this port: the pose comes from its scans, matched to the map, and from the base's odometry.
    #[arg(long, value_name = "P", requires = "port")]
    pub lidar: Option<String>,
    /// Protocol of that base [default: native].
    #[arg(long, value_name = "P", requires = "port", value_parser = value_parsers::protocol())]
    pub protocol: Option<Protocol>,
    /// Settings of that base: TOML with the tables [base], [supervisor] and [lidar].
    #[arg(long, value_name = "FILE.toml", requires = "port")]
    pub base_config: Option<PathBuf>,
}

impl HardwareArguments {
    /// Describes the drive for its report.
    pub const fn description(&self) -> &'static str {
        match (&self.port, &self.lidar) {
            (None, _) => report_file::SIMULATED,
            (Some(_), None) => {
                "One mission, driven by a base on a serial line in real time; world and lidar are simulated."
            }
            (Some(_), Some(_)) => {
                "One mission, driven by a base and a lidar on serial lines in real time; contact and gaps are measured on the map \
                at the pose that the scans give."
            }
        }
    }
}

/// A robot on serial lines.
pub struct HardwareDrive {
    line: SerialLine,
    lidar_port: Option<String>,
    pub robot: HardwareRobot,
}

/// The robot after a mission.
pub struct HardwareReport {
    line: SerialLine,
    status: SupervisorStatus,
    lidar: Option<(String, LidarStatus)>,
    late_ticks: u64,
}

/// Opens the ports of a drive, if any are given, and waits for the devices.
pub fn connect(
    arguments: &HardwareArguments,
    start: Pose,
) -> anyhow::Result<Option<HardwareDrive>> {
    let Some(port) = &arguments.port else {
        return Ok(None);
    };
    let file = arguments.base_config.as_deref();
    let line = base_arguments::load_line(port, arguments.protocol.unwrap_or_default(), file)?;
    let mut robot = line.connect(start, process::interrupt_flag()?).context("--port")?;
    let lidar_port = arguments.lidar.clone();
    if let Some(port) = &lidar_port {
        let reader = connect_lidar(port, line.config.lidar).context("--lidar")?;
        robot = robot.with_lidar(reader);
    }
    Ok(Some(HardwareDrive { line, lidar_port, robot }))
}

impl HardwareDrive {
    /// Stops the base and closes the ports.
    pub fn end(self) -> HardwareReport {
        HardwareReport {
            status: self.robot.base_status(),
            lidar: self.lidar_port.zip(self.robot.lidar_status()),
            late_ticks: self.robot.late_ticks(),
            line: self.line,
        }
    }

    pub const fn has_lidar(&self) -> bool {
        self.lidar_port.is_some()
    }
}

impl HardwareReport {
    /// For scripts.
    pub fn object(&self) -> Value {
        let mut object = base_text::status(&self.status);
        object["port"] = json!(self.line.port);
        object["protocol"] = json!(self.line.protocol.name());
        object["interrupted"] = json!(!self.status.is_running);
        object["late_ticks"] = json!(self.late_ticks);
        object["lidar"] = json!(self.lidar.as_ref().map(lidar_object));
        object
    }

    /// For people.
    pub fn lines(&self) -> Vec<String> {
        let counters = self.status.counters;
        let mut lines = vec![format!(
            "base         {} on {}: {} commands, {} late; {} ticks late; {} connection failures",
            self.line.protocol,
            self.line.port,
            counters.commands,
            counters.late_commands,
            self.late_ticks,
            counters.connection_failures,
        )];
        if let Some((port, status)) = &self.lidar {
            lines.push(format!(
                "lidar        LD19 on {port}: {} revolutions, {} bytes outside packets",
                status.revolutions, status.dropped_bytes
            ));
            lines.extend(status.fault.iter().map(|why| format!("no scans     {why}")));
        }
        if let Some(why) = &self.status.last_failure {
            lines.push(format!("line failed  {why}"));
        }
        if let Some(why) = stop_cause(&self.status) {
            lines.push(format!("stopped      {why}"));
        } else if !self.status.is_running {
            lines.push("stopped      by a signal".to_owned());
        }
        lines
    }
}

fn lidar_object((port, status): &(String, LidarStatus)) -> Value {
    json!({
        "port": port,
        "revolutions": status.revolutions,
        "packets": status.packets,
        "dropped_bytes": status.dropped_bytes,
        "connections": status.connections,
        "fault": status.fault.as_ref().map(ToString::to_string),
    })
}
