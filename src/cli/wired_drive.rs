//! `inbye drive --port`: a base on a line, in real time; a simulated world for it, or with `--lidar` the one that it is in.

use std::path::PathBuf;
use std::thread;
use std::time::Duration;

use clap::Args;
use inbye::base::{BaseSupervisor, Protocol, SupervisorStatus};
use inbye::geometry::{Pose, Twist};
use inbye::map::TimedScan;
use inbye::runtime::{OdometryReading, Robot};
use serde_json::{Value, json};

use super::base_line::BaseLine;
use super::lidar_line::{LidarEnding, LidarLine};
use super::{base_text, process, report_file, value_parsers};

/// How long a mission waits for a base that does not answer, seconds.
const ANSWER_WITHIN_S: f64 = 10.0;

/// The base of a drive.
#[derive(Debug, Args)]
pub struct WiredArguments {
    /// Drive the base on this port, in real time; without --lidar, world and lidar stay simulated.
    #[arg(long, value_name = "P")]
    pub port: Option<String>,
    /// Look through the LD19 lidar on this port: the pose is from its scans, matched to the map, and from the base's odometry.
    #[arg(long, value_name = "P", requires = "port")]
    pub lidar: Option<String>,
    /// Protocol of that base [default: native].
    #[arg(long, value_name = "P", requires = "port", value_parser = value_parsers::protocol())]
    pub protocol: Option<Protocol>,
    /// That base's settings, TOML with the tables [base], [supervisor] and [lidar].
    #[arg(long, value_name = "FILE.toml", requires = "port")]
    pub base_config: Option<PathBuf>,
}

impl WiredArguments {
    /// What such a drive is, for its report.
    pub const fn in_words(&self) -> &'static str {
        match (&self.port, &self.lidar) {
            (None, _) => report_file::SIMULATED,
            (Some(_), None) => {
                "One mission, driven by a base on a serial line in real time; world and lidar were simulated."
            }
            (Some(_), Some(_)) => {
                "One mission, driven by a base and seen by a lidar on serial lines in real time; contact and gaps are those of \
                where the scans put the robot on the map."
            }
        }
    }
}

/// A base on a line that drives a mission.
pub struct Wired {
    line: BaseLine,
    supervisor: BaseSupervisor,
    lidar: Option<LidarLine>,
    /// Where the mission starts, and what the odometer says there; none before the first command.
    origin: Option<(Pose, Pose)>,
    start: Pose,
    /// When the next tick is due, and how many were late by more than one.
    due_s: f64,
    late: u64,
    heard_s: f64,
}

/// How a base came out of a mission.
pub struct Ending {
    line: BaseLine,
    status: SupervisorStatus,
    lidar: Option<LidarEnding>,
    late: u64,
}

/// Opens the port of a drive and waits for the base, if one was named.
pub fn connect(arguments: &WiredArguments, start: Pose) -> anyhow::Result<Option<Wired>> {
    let Some(port) = &arguments.port else {
        return Ok(None);
    };
    let file = arguments.base_config.as_deref();
    let line = BaseLine::new(port, arguments.protocol.unwrap_or_default(), file)?;
    let supervisor = line.supervisor(process::interrupt_flag()?)?;
    line.await_answer(&supervisor)?;
    let lidar = arguments.lidar.as_deref();
    let lidar = lidar.map(|port| LidarLine::connect(port, line.settings.lidar));
    let lidar = lidar.transpose()?;
    Ok(Some(Wired {
        line,
        supervisor,
        lidar,
        origin: None,
        start,
        due_s: 0.0,
        late: 0,
        heard_s: 0.0,
    }))
}

impl Wired {
    /// Stops the base and leaves it.
    pub fn end(self) -> Ending {
        Ending {
            status: self.supervisor.status(),
            lidar: self.lidar.map(LidarLine::end),
            line: self.line,
            late: self.late,
        }
    }

    fn motion(&self) -> Twist {
        let feedback = self.supervisor.status().feedback;
        feedback.map_or(Twist::STOP, |feedback| feedback.twist)
    }

    /// Whether the base is heard, or may be again.
    fn may_go_on(&mut self) -> bool {
        let (status, now_s) = (self.supervisor.status(), self.supervisor.now_s());
        if status.feedback.is_some() {
            self.heard_s = now_s;
        }
        status.stop_cause.is_none() && status.is_running && now_s - self.heard_s < ANSWER_WITHIN_S
    }
}

impl Robot for Wired {
    fn pose(&self) -> Pose {
        let Some((start, origin)) = &self.origin else {
            return self.start;
        };
        start.transform_pose(&origin.inverse_transform_pose(&self.supervisor.status().pose))
    }

    fn twist(&self) -> Twist {
        self.motion()
    }

    fn odometry(&self) -> OdometryReading {
        OdometryReading {
            pose: self.pose(),
            twist: self.motion(),
        }
    }

    fn trouble(&self) -> Option<String> {
        let status = self.supervisor.status();
        let reported = || {
            let faults = status.feedback.as_ref()?.faults;
            (!faults.is_empty()).then(|| format!("the base reports: {faults}"))
        };
        base_text::stop_cause(&status).or_else(reported)
    }

    fn sweep(&mut self, time_s: f64) -> Option<TimedScan> {
        self.lidar.as_mut().map(|lidar| lidar.sweep(time_s))
    }

    fn drive(&mut self, command: &Twist, period_s: f64) -> bool {
        let now_s = self.supervisor.now_s();
        if self.origin.is_none() {
            self.origin = Some((self.start, self.supervisor.status().pose));
            (self.due_s, self.heard_s) = (now_s, now_s);
        }
        // A refusal is a stop, which ends the mission below.
        let _ = self.supervisor.set_target(command, now_s);
        self.due_s += period_s;
        if self.due_s + period_s < now_s {
            self.late += 1;
            self.due_s = now_s;
        }
        thread::sleep(Duration::from_secs_f64((self.due_s - now_s).max(0.0)));
        self.may_go_on()
    }
}

impl Ending {
    /// As scripts read it.
    pub fn object(&self) -> Value {
        let mut object = base_text::status(&self.status);
        object["port"] = json!(self.line.port);
        object["protocol"] = json!(self.line.protocol.name());
        object["interrupted"] = json!(!self.status.is_running);
        object["late_ticks"] = json!(self.late);
        object["lidar"] = json!(self.lidar.as_ref().map(LidarEnding::object));
        object
    }

    /// As people read it.
    pub fn lines(&self) -> Vec<String> {
        let counters = self.status.counters;
        let mut lines = vec![format!(
            "base         {} on {}: {} commands, {} late; {} ticks late; {} line failures",
            self.line.protocol,
            self.line.port,
            counters.commands,
            counters.late_commands,
            self.late,
            counters.connection_failures,
        )];
        lines.extend(self.lidar.iter().flat_map(LidarEnding::lines));
        if let Some(why) = &self.status.last_failure {
            lines.push(format!("line failed  {why}"));
        }
        if let Some(why) = base_text::stop_cause(&self.status) {
            lines.push(format!("stopped      {why}"));
        } else if !self.status.is_running {
            lines.push("stopped      by a signal".to_owned());
        }
        lines
    }
}
