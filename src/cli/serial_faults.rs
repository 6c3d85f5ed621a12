//! Faults of `inbye bench faults` on emulated serial lines: a base and its lidar in one process, the drive in another.

use std::env;
use std::fs;
use std::path::PathBuf;
use std::time::Duration;

use anyhow::Context;
use inbye::base::{InjectedFault, Protocol};
use inbye::experiment::FaultRow;

use super::child_process::{ChildProcess, program};

/// Begin of each fault, seconds after the base is switched on: the robot has its cruising speed.
const AT_S: f64 = 9.0;
/// Longest drive, seconds.
const TIME_LIMIT_S: u32 = 60;
/// Longest time until a process has started or has ended, and that of a whole drive with its start.
const ANSWER_TIME: Duration = Duration::from_secs(20);
const DRIVE_TIME: Duration = Duration::from_secs(TIME_LIMIT_S as u64 + 60);
/// Least distance that the robot drives before and after the fault, metres.
const MIN_TRAVEL_M: f64 = 1.5;
/// Side of a cell of the map, metres.
const RESOLUTION_M: f64 = 0.1;
const START: &str = "1.5,2.0";
const GOAL: &str = "24.5,2.0";

/// What must follow a fault.
#[derive(Clone, Copy, Debug)]
pub enum Required {
    /// The robot stands for good within this time, seconds.
    Stands(f64),
    /// No contact; the robot may drive on.
    NoContact,
    /// The drive ends with a reason: no command reaches such a base, so only its own watchdog or its operator can stop it.
    Reported,
}

/// A fault on a serial line.
#[derive(Clone, Copy, Debug)]
pub struct SerialCase {
    pub fault: Option<InjectedFault>,
    pub protocol: Protocol,
    pub required: Required,
    name: &'static str,
}

const fn case(name: &'static str, fault: InjectedFault, required: Required) -> SerialCase {
    SerialCase { fault: Some(fault), protocol: Protocol::Native, required, name }
}

/// Every fault. A limit is the time until the fault is known plus that of braking from 1 m/s at 1 m/s^2, with lags.
pub const CASES: [SerialCase; 23] = [
    case("left track is stuck", InjectedFault::StuckLeft, Required::Stands(2.8)),
    case("right track is stuck", InjectedFault::StuckRight, Required::Stands(2.8)),
    case("left track runs in reverse", InjectedFault::Reversed, Required::Stands(2.8)),
    case("left track runs away", InjectedFault::Runaway, Required::Reported),
    case("emergency button", InjectedFault::Button, Required::Stands(1.8)),
    case("base is silent", InjectedFault::Silence, Required::Stands(2.0)),
    case("base reads slowly", InjectedFault::SlowReads, Required::Stands(3.0)),
    case("garbage on the line", InjectedFault::Garbage, Required::NoContact),
    case("bits are flipped", InjectedFault::BitFlips, Required::NoContact),
    case("reports are corrupt", InjectedFault::CorruptReports, Required::Stands(2.5)),
    case("base ignores commands", InjectedFault::IgnoredCommands, Required::Reported),
    case("controller hangs", InjectedFault::Wedge, Required::Reported),
    case("one report shows the button", InjectedFault::StopGlitch, Required::NoContact),
    case("belts spin, robot stands", InjectedFault::Bogged, Required::NoContact),
    case("base tilts", InjectedFault::Tilt, Required::NoContact),
    case("bumper", InjectedFault::Bumper, Required::Stands(1.8)),
    case("cliff", InjectedFault::Cliff, Required::Stands(1.8)),
    case("port becomes another device", InjectedFault::PortReplaced, Required::Stands(2.0)),
    case("lidar repeats a revolution", InjectedFault::LidarFrozen, Required::Stands(2.5)),
    case("lidar receives no echo", InjectedFault::LidarBlind, Required::Stands(2.5)),
    case("lidar is blind ahead", InjectedFault::LidarSectorBlind, Required::NoContact),
    SerialCase {
        fault: None,
        protocol: Protocol::Native,
        required: Required::Stands(2.0),
        name: "lidar is unplugged",
    },
    SerialCase {
        fault: Some(InjectedFault::Tilt),
        protocol: Protocol::Wheeltec,
        required: Required::Stands(2.5),
        name: "base tilts",
    },
];

/// A folder with the map of a roadway; removed when dropped.
pub struct Roadway(PathBuf);

impl Roadway {
    /// Writes the map: 26 by 4 m with two machines at its sides.
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
        fs::write(roadway.map(), text).with_context(|| roadway.map().display().to_string())?;
        Ok(roadway)
    }

    fn map(&self) -> PathBuf {
        self.0.join("roadway.txt")
    }
}

impl Drop for Roadway {
    fn drop(&mut self) {
        // A folder for temporary files: the system removes it, if this fails.
        let _ = fs::remove_dir_all(&self.0);
    }
}

impl SerialCase {
    /// Drives along the roadway with this fault. A drive that cannot be made has failed, with the reason.
    pub fn drive(&self, roadway: &Roadway) -> FaultRow {
        let mut row = FaultRow::new(self.name, self.protocol.name());
        row.runs = 1;
        if let Err(error) = self.drive_into(&mut row, roadway) {
            (row.passed, row.reason) = (false, Some(format!("{error:#}")));
        }
        row
    }

    fn drive_into(&self, row: &mut FaultRow, roadway: &Roadway) -> anyhow::Result<()> {
        let protocol = self.protocol.name();
        let mut base = program("base emulate");
        base.args(["--protocol", protocol, "--start", START, "--json"]);
        base.args(["--resolution", &RESOLUTION_M.to_string()]);
        base.arg("--lidar-map").arg(roadway.map());
        // It ends by itself if this process is killed.
        base.args(["--for", &(DRIVE_TIME + ANSWER_TIME).as_secs().to_string()]);
        match self.fault {
            Some(fault) => base.args(["--fault", &format!("{fault}@{AT_S}")]),
            None => base.args(["--lidar-until", &AT_S.to_string()]),
        };
        let mut base = ChildProcess::start(&mut base)?;
        let ports = base.line(ANSWER_TIME)?;
        let port = |name: &str| ports[name].as_str().unwrap_or_default().to_owned();
        let mut drive = program("drive");
        drive.arg("--map").arg(roadway.map()).args(["--resolution", &RESOLUTION_M.to_string()]);
        drive.args(["--start", START, "--goal", GOAL, "--engine", "cpu", "--threads", "1"]);
        drive.args(["--port", &port("port"), "--protocol", protocol]);
        drive.args(["--lidar", &port("lidar"), "--json", "--arm"]);
        drive.args(["--time-limit", &TIME_LIMIT_S.to_string()]);
        let driven = ChildProcess::start(&mut drive)?.line(DRIVE_TIME)?;
        base.interrupt()?;
        let machine = base.line(ANSWER_TIME)?;
        let number =
            |name: &str| machine[name].as_f64().with_context(|| format!("base emulate: no {name}"));
        let (stood_s, gap_m) = ((number("last_motion_s")? - AT_S).max(0.0), number("min_gap_m")?);
        let reason = driven["fault"].as_str().map(str::to_owned);
        let touched = gap_m <= 0.0;
        // A robot that did not drive proves nothing.
        let travelled_m = number("travelled_m")?;
        let has_driven = travelled_m >= MIN_TRAVEL_M;
        let (limit_s, passed) = match self.required {
            Required::Stands(limit_s) => (Some(limit_s), stood_s <= limit_s && !touched),
            Required::NoContact => (None, !touched),
            Required::Reported => (None, reason.is_some()),
        };
        row.stood_s = limit_s.map(|_| stood_s);
        row.limit_s = limit_s;
        row.min_gap_m = Some(gap_m);
        row.contacts_robot = usize::from(touched);
        row.passed = passed && has_driven;
        row.reason = if has_driven {
            reason
        } else {
            Some(format!("the robot drove {travelled_m:.2} m only"))
        };
        Ok(())
    }
}
