//! `inbye drive --port`: a base on a serial line, driven in real time; a simulated world around it, or with `--lidar` the real
//! one.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, ensure};
use clap::Args;
use inbye::base::Protocol;
use inbye::base::ld19::PACKET_LENGTH;
use inbye::geometry::Pose;
use inbye::robot::Limits;
use inbye::runtime::Config;
use inbye::runtime::hardware::{HardwareRobot, SerialLine, connect_lidar, stop_cause};
use serde_json::{Value, json};

use super::arguments::{protocol, whole};
use super::base;
use super::drive_text::SIMULATED;
use super::machine::{interrupt_flag, is_interrupted};
use super::operator::{self, Operator};
use super::output;

/// Share of damaged bytes above which a line is bad: a good line has next to none.
const BAD_LINE: f64 = 0.01;

/// The base of a drive.
#[derive(Debug, Args)]
pub struct HardwareArguments {
    /// Drive the base on this port, in real time, with --lidar or --simulated-senses.
    // The other flags require the group: clap drops the requirement of a flag that conflicts with another given flag.
    #[arg(long, value_name = "P", group = "serial_base")]
    pub port: Option<String>,
    /// Use the LD19 lidar on this port: the pose comes from its scans, matched to the map, and from the base's odometry.
    #[arg(long, value_name = "P", requires = "serial_base")]
    pub lidar: Option<String>,
    /// Simulate world, lidar and pose around the base on --port: for a test stand. The robot sees nothing real.
    #[arg(long, requires = "serial_base", conflicts_with = "lidar")]
    pub simulated_senses: bool,
    /// Arm the robot at once. Without it, the robot moves after the word `arm` in the terminal, or a request to --operator-port. Enter
    /// in the terminal stops it.
    #[arg(long, requires = "serial_base")]
    pub arm: bool,
    /// Serve the operator on this port of localhost: POST /arm, POST /stop, GET /status.
    #[arg(long, value_name = "N", allow_negative_numbers = true, requires = "serial_base", value_parser = whole::<u16>(1, 65_535))]
    pub operator_port: Option<u16>,
    /// Give the page of --live a button that stops the robot.
    #[arg(long, requires_all = ["serial_base", "live"])]
    pub operator: bool,
    /// Protocol of that base [default: native].
    #[arg(long, value_name = "P", requires = "serial_base", value_parser = protocol())]
    pub protocol: Option<Protocol>,
    /// Settings of that base: TOML with the tables [base], [supervisor] and [lidar].
    #[arg(long, value_name = "FILE.toml", requires = "serial_base")]
    pub base_config: Option<PathBuf>,
}

impl HardwareArguments {
    /// Describes the drive for its report.
    pub const fn description(&self) -> &'static str {
        match (&self.port, &self.lidar) {
            (None, _) => SIMULATED,
            (Some(_), None) => {
                "One mission, driven by a base on a serial line in real time; world and lidar are simulated."
            }
            (Some(_), Some(_)) => {
                "One mission, driven by a base and a lidar on serial lines in real time; contact and gaps are measured on the map \
                at the pose that the scans give."
            }
        }
    }

    /// Opens the ports of a drive, if any are given, and waits for the devices.
    pub fn connect(&self, start: Pose, config: &Config) -> anyhow::Result<Option<HardwareDrive>> {
        let Some(port) = &self.port else {
            return Ok(None);
        };
        ensure!(
            self.lidar.is_some() || self.simulated_senses,
            "--port {port}: without a lidar the robot sees nothing real: add --lidar P, or --simulated-senses for a base \
            that drives nowhere, such as on a test stand"
        );
        operator::require_arming(self.arm, self.operator_port)?;
        let path = |port: &str| Path::new(port).canonicalize().unwrap_or_else(|_| port.into());
        let is_twice = self.lidar.as_ref().is_some_and(|lidar| path(lidar) == path(port));
        ensure!(!is_twice, "--lidar {port}: it is the port of the base too: give the lidar's");
        let protocol = self.protocol.unwrap_or_default();
        let line = base::load_line(port, protocol, self.base_config.as_deref())?;
        line.warning().iter().for_each(output::warn);
        let end = interrupt_flag()?;
        let base = line.connect(Arc::clone(&end)).context("--port")?;
        let lidar = self.lidar.as_ref().map(|port| connect_lidar(port, line.config.lidar, &end));
        let lidar = lidar.transpose().context("--lidar")?;
        let layer = config.protective_layer(line.config.supervisor.period_s())?;
        let switch = layer.operator();
        let robot = HardwareRobot::new(base, lidar, layer, start);
        let operator = operator::serve(switch, self.arm, self.operator_port)?;
        Ok(Some(HardwareDrive { line, lidar_port: self.lidar.clone(), robot, operator }))
    }
}

/// A robot on serial lines.
pub struct HardwareDrive {
    line: SerialLine,
    pub lidar_port: Option<String>,
    pub robot: HardwareRobot,
    /// The operator, with the switch of the protective layer.
    pub operator: Operator,
}

/// State of the robot after a mission, as JSON and as text.
pub struct HardwareReport {
    pub object: Value,
    pub lines: Vec<String>,
    /// Whether the base followed its commands to the end.
    pub is_sound: bool,
}

impl HardwareDrive {
    /// Lowers a robot's limits to those of the base.
    pub fn cap_speed(&self, limits: &mut Limits) {
        self.line.cap_speed(limits);
    }

    /// The shortest range of the lidar, metres; none without a real one.
    pub fn lidar_range_min_m(&self) -> Option<f64> {
        self.lidar_port.as_ref().map(|_| self.line.config.lidar.range_min_m)
    }

    /// Stops the base, closes the ports and reports, with the number of late ticks of the mission.
    pub fn end(self, late_ticks: u64) -> HardwareReport {
        let Self { line, lidar_port, robot, .. } = self;
        let lidar = lidar_port.zip(robot.lidar_status());
        let status = robot.end();
        let mut object = base::line_object(&line, &status);
        // The mission may notice the signal before the base's thread does.
        let interrupted = is_interrupted() || !status.is_running;
        object["interrupted"] = json!(interrupted);
        object["late_ticks"] = json!(late_ticks);
        object["lidar"] = json!(null);
        let counters = status.counters;
        let mut lines = vec![format!(
            "base         {} on {}: {} commands, {} late; {late_ticks} ticks late; {} connection failures",
            line.protocol,
            line.port,
            counters.commands,
            counters.late_commands,
            counters.connection_failures,
        )];
        if let Some((port, status)) = lidar {
            object["lidar"] = json!({
                "port": port,
                "revolutions": status.revolutions,
                "packets": status.packets,
                "dropped_bytes": status.dropped_bytes,
                "connections": status.connections,
                "fault": status.fault.as_ref().map(ToString::to_string),
            });
            lines.push(format!(
                "lidar        LD19 on {port}: {} revolutions, {} bytes outside packets",
                status.revolutions, status.dropped_bytes
            ));
            lines.extend(status.fault.iter().map(|why| format!("no scans     {why}")));
            let dropped = status.dropped_bytes as f64;
            let share = dropped / (dropped + (status.packets * PACKET_LENGTH as u64) as f64);
            if share > BAD_LINE {
                let percent = 100.0 * share;
                lines.push(format!(
                    "lidar line   {percent:.0} % of its bytes are damaged: check the cable, its length and its ground"
                ));
            }
        }
        lines.extend(status.last_failure.iter().map(|why| format!("line failed  {why}")));
        if status.is_odometry_uncertain {
            lines.push(format!("odometry     {}", base::UNCERTAIN_ODOMETRY));
        }
        let cause = stop_cause(&status);
        let is_sound = cause.is_none();
        if let Some(why) = cause {
            lines.push(format!("stopped      {why}"));
        } else if interrupted {
            lines.push("stopped      by a signal".to_owned());
        }
        HardwareReport { object, lines, is_sound }
    }
}
