//! A lidar on a port, by the clock of a mission.

use std::thread;

use anyhow::{Context, bail};
use inbye::base::ld19::{LidarReader, LidarSettings, LidarStatus, OpenLidar};
use inbye::map::TimedScan;
use serde_json::{Value, json};

use super::base_line::POLL_PERIOD;

/// How long a lidar may take to its first whole turn, seconds: its motor has to run up.
const TURNS_WITHIN_S: f64 = 5.0;

/// An LD19 that a mission sees by.
pub struct LidarLine {
    port: String,
    reader: LidarReader,
    /// The newest turn by the mission's clock, and its number.
    newest: (u64, TimedScan),
}

/// How it came out of a mission.
pub struct LidarEnding {
    port: String,
    status: LidarStatus,
}

impl LidarLine {
    /// Opens the port and waits for the first whole turn.
    pub fn connect(port: &str, settings: LidarSettings) -> anyhow::Result<Self> {
        let reader = LidarReader::start(opener(port), settings).context("--lidar")?;
        loop {
            let status = reader.status();
            if status.scan.is_some() {
                break;
            }
            if reader.now_s() > TURNS_WITHIN_S {
                let why = status.fault.map_or_else(String::new, |why| why.to_string());
                bail!("--lidar {port}: no turn within {TURNS_WITHIN_S} s: {why}");
            }
            thread::sleep(POLL_PERIOD);
        }
        Ok(Self {
            port: port.to_owned(),
            reader,
            newest: (0, TimedScan::default()),
        })
    }

    /// The newest whole turn by a clock that is at a time now, seconds. A turn has the same times whenever it is asked for.
    pub fn sweep(&mut self, now_s: f64) -> TimedScan {
        let status = self.reader.status();
        let ahead_s = now_s - self.reader.now_s();
        if let Some(sweep) = status.scan.filter(|_| status.revolutions != self.newest.0) {
            let mut sweep = TimedScan::clone(&sweep);
            for beam in &mut sweep.beams {
                beam.time_s += ahead_s;
            }
            self.newest = (status.revolutions, sweep);
        }
        self.newest.1.clone()
    }

    /// Leaves it.
    pub fn end(self) -> LidarEnding {
        LidarEnding {
            status: self.reader.status(),
            port: self.port,
        }
    }
}

impl LidarEnding {
    /// As scripts read it.
    pub fn object(&self) -> Value {
        let LidarStatus {
            revolutions,
            packets,
            dropped_bytes,
            connections,
            ..
        } = &self.status;
        json!({
            "port": self.port,
            "revolutions": revolutions,
            "packets": packets,
            "dropped_bytes": dropped_bytes,
            "connections": connections,
            "fault": self.status.fault.as_ref().map(ToString::to_string),
        })
    }

    /// As people read it.
    pub fn lines(&self) -> Vec<String> {
        let status = &self.status;
        let mut lines = vec![format!(
            "lidar        LD19 on {}: {} turns, {} bytes of no packet",
            self.port, status.revolutions, status.dropped_bytes
        )];
        lines.extend(status.fault.iter().map(|why| format!("no scans     {why}")));
        lines
    }
}

#[cfg(feature = "serial")]
fn opener(port: &str) -> OpenLidar {
    let port = port.to_owned();
    Box::new(move || inbye::base::open_lidar_port(&port))
}

#[cfg(not(feature = "serial"))]
fn opener(port: &str) -> OpenLidar {
    let port = port.to_owned();
    Box::new(move || {
        Err(inbye::base::BaseError::CannotOpen {
            port: port.clone(),
            reason: "this program was built without its feature `serial`".to_owned(),
        })
    })
}
