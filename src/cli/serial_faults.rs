//! Drives the cases of `inbye bench faults` on emulated serial lines: a base and its lidar in one process, the drive in another.

use std::env;
use std::fs;
use std::io::{Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::PathBuf;
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, ensure};
use inbye::experiment::FaultRow;
use inbye::geometry::{Pose, wrap_angle};
use serde_json::Value;

use super::arguments::Place;
use super::child_process::{ChildProcess, program};
use super::serial_cases::{AT_S, Event, SerialCase};
use super::serial_verdict::SerialOutcome;

/// Longest drive, seconds.
const TIME_LIMIT_S: u32 = 60;
/// Longest time until a process has started or has ended, and that of a whole drive with its start.
const ANSWER_TIME: Duration = Duration::from_secs(20);
const DRIVE_TIME: Duration = Duration::from_secs(TIME_LIMIT_S as u64 + 60);
/// Time in which a base stops after the end of its drive: its watchdog's and that of braking.
const STOP_TIME: Duration = Duration::from_millis(1500);
/// Most drives of a case.
const MAX_RUNS: usize = 3;
/// Side of a cell of the map, metres.
const RESOLUTION_M: f64 = 0.1;
const START: &str = "1.5,2.0";
/// Settings that the drive has for its base.
const BASE_CONFIG: &str = "[base]\nmin_battery_v = 18.0\n";

/// A folder with the map of a roadway and the settings of the base; removed when dropped.
pub struct Roadway(PathBuf);

impl Roadway {
    /// Writes the map: 26 by 4 m with three machines at its sides.
    pub fn write() -> anyhow::Result<Self> {
        let folder = env::temp_dir().join(format!("inbye-faults-{}", std::process::id()));
        fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
        let roadway = Self(folder);
        let cell = |column: i32, row: i32| {
            let is_wall = column == 0 || row == 0 || column == 259 || row == 39;
            let is_machine = (80..95).contains(&column) && row < 9
                || (150..170).contains(&column) && row > 30
                || (200..204).contains(&column) && row < 6;
            if is_wall || is_machine { '#' } else { '.' }
        };
        let rows = (0..40).map(|row| (0..260).map(|column| cell(column, row)).collect::<String>());
        let text = rows.collect::<Vec<_>>().join("\n") + "\n";
        for (file, text) in [(roadway.map(), text.as_str()), (roadway.base_config(), BASE_CONFIG)] {
            fs::write(&file, text).with_context(|| file.display().to_string())?;
        }
        Ok(roadway)
    }

    fn map(&self) -> PathBuf {
        self.0.join("roadway.txt")
    }

    fn base_config(&self) -> PathBuf {
        self.0.join("base.toml")
    }
}

impl Drop for Roadway {
    fn drop(&mut self) {
        // A folder for temporary files: the system removes it, if this fails.
        let _ = fs::remove_dir_all(&self.0);
    }
}

impl SerialCase {
    /// Drives along the roadway with this case. A drive that cannot be made has failed, with the reason. One in which the robot stood
    /// before the fault, such as a lost one, shows nothing about the fault and is repeated. Missions without a fault are not.
    pub fn drive(&self, roadway: &Roadway) -> FaultRow {
        let mut row = FaultRow::new(self.name, self.protocol.name());
        for runs in 1..=MAX_RUNS {
            row.runs = runs;
            match self.outcome(roadway) {
                Ok(outcome) => {
                    outcome.judge(self.required, &mut row);
                    if !outcome.stood_before {
                        break;
                    }
                }
                Err(error) => {
                    (row.passed, row.reason) = (false, Some(format!("{error:#}")));
                    break;
                }
            }
        }
        row
    }

    fn outcome(&self, roadway: &Roadway) -> anyhow::Result<SerialOutcome> {
        let mut base = self.start_base(roadway)?;
        let ports = base.line(ANSWER_TIME)?;
        let switched_on = Instant::now();
        let operator_port = matches!(self.event, Event::StopRequest).then(free_port).transpose()?;
        let mut drive = self.start_drive(roadway, &ports, operator_port)?;
        let wait_until = |at_s: f64| {
            thread::sleep(Duration::from_secs_f64(at_s).saturating_sub(switched_on.elapsed()));
        };
        if let Some(port) = operator_port {
            wait_until(AT_S);
            request_stop(port)?;
        }
        let mut is_killed = false;
        for (at_s, signal) in self.signals() {
            wait_until(at_s);
            drive.signal(signal)?;
            is_killed |= signal == "KILL";
        }
        let driven = if is_killed { Value::Null } else { drive.line(DRIVE_TIME)? };
        let end_s = switched_on.elapsed().as_secs_f64();
        thread::sleep(STOP_TIME);
        base.signal("INT")?;
        let summary = base.line(ANSWER_TIME)?;
        let outcome = SerialOutcome::read(&summary, &driven, (AT_S, end_s));
        let mut outcome = outcome.context("base emulate: its summary is not complete")?;
        // Without a fault the time of one means nothing.
        outcome.stood_before &= !matches!(self.event, Event::None);
        let pose: Pose = serde_json::from_value(summary["map_pose"].clone())
            .context("base emulate: no map_pose")?;
        let goal: Place = self.goal.parse().map_err(anyhow::Error::msg)?;
        outcome.error_m = (goal.position - pose.position()).norm();
        outcome.yaw_error_rad = goal.yaw.map(|yaw| wrap_angle(pose.yaw - yaw).abs());
        Ok(outcome)
    }

    fn start_base(&self, roadway: &Roadway) -> anyhow::Result<ChildProcess> {
        let mut base = program("base emulate");
        base.args(["--protocol", self.protocol.name(), "--start", START, "--goal", self.goal]);
        base.args(["--json", "--resolution", &RESOLUTION_M.to_string()]);
        base.arg("--lidar-map").arg(roadway.map());
        base.args(self.machine.split(' ')).args(self.emulate());
        // It ends by itself if this process is killed.
        base.args(["--for", &(DRIVE_TIME + ANSWER_TIME).as_secs().to_string()]);
        ChildProcess::start(&mut base)
    }

    fn start_drive(
        &self,
        roadway: &Roadway,
        ports: &Value,
        operator_port: Option<u16>,
    ) -> anyhow::Result<ChildProcess> {
        let port = |name: &str| ports[name].as_str().unwrap_or_default().to_owned();
        let mut drive = program("drive");
        drive.arg("--map").arg(roadway.map()).args(["--resolution", &RESOLUTION_M.to_string()]);
        drive.args(["--start", START, "--goal", self.goal, "--engine", "cpu", "--threads", "1"]);
        drive.args(["--port", &port("port"), "--protocol", self.protocol.name()]);
        drive.arg("--base-config").arg(roadway.base_config());
        drive.args(["--lidar", &port("lidar"), "--json", "--arm"]);
        drive.args(["--time-limit", &TIME_LIMIT_S.to_string()]);
        if let Some(port) = operator_port {
            drive.args(["--operator-port", &port.to_string()]);
        }
        ChildProcess::start(&mut drive)
    }
}

/// A port of localhost that is free now.
fn free_port() -> anyhow::Result<u16> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).context("no free port")?;
    Ok(listener.local_addr().context("a port without an address")?.port())
}

/// Stops the robot at the operator's port.
fn request_stop(port: u16) -> anyhow::Result<()> {
    let mut stream = TcpStream::connect((Ipv4Addr::LOCALHOST, port)).context("operator's port")?;
    stream.write_all(b"POST /stop HTTP/1.1\r\n\r\n").context("operator's port")?;
    let mut answer = String::new();
    stream.read_to_string(&mut answer).context("operator's port")?;
    ensure!(answer.starts_with("HTTP/1.1 200"), "operator's port: {answer}");
    Ok(())
}
