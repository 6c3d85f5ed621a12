//! Reads recordings with the Python packages `mcap` and `mcap-ros2-support` and compares them with the trace.
//!
//! The reader needs a Python with both: the one that `tests/run` made in `target/python`, `python3`, or the one that
//! `INBYE_PYTHON` names. Without one the trials are ignored, or fail if the variable `INBYE_REQUIRE` holds the word `python`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use inbye::runtime::Config;
use inbye::sim::Simulation;
use libtest_mimic::{Failed, Trial};

use super::drives::{crowded, record, tour};
use crate::support::mcap_copy::altered;
use crate::support::python::Python;

const SCRIPT: &str =
    concat!(env!("CARGO_MANIFEST_DIR"), "/tests/support/reference_recording_reader.py");
static PYTHON: Python = Python::with(
    "mcap, mcap_ros2",
    "INBYE_PYTHON",
    &[
        concat!(env!("CARGO_MANIFEST_DIR"), "/target/python/bin/python"),
        "python3",
        "/usr/bin/python3",
    ],
    "python",
);

pub fn trials() -> Vec<Trial> {
    let trial = |name: &str, test: fn(&Path) -> Result<(), Failed>| {
        Trial::ignorable_test(name, move || PYTHON.run(test))
    };
    vec![
        trial("python_reader_returns_equal_values", |python| {
            for (simulation, config) in [tour(), crowded()] {
                let place = Place::new(&simulation, &config)?;
                let output = place.compare(python)?;
                // Seven messages in each tick, the map and at least one plan.
                let messages: u64 = output.trim().parse()?;
                if messages < 7 * place.ticks + 2 {
                    return Err(format!("{messages} messages of {} ticks", place.ticks).into());
                }
            }
            Ok(())
        }),
        trial("python_reader_reports_flipped_bits", |python| {
            let (simulation, config) = tour();
            let place = Place::new(&simulation, &config)?;
            place.compare(python)?;
            let whole = fs::read(place.file())?;
            // The turn rate, the odometry's x, the first range rounded, the second exactly, a cell, the frame's x.
            for (topic, byte) in [
                ("/cmd_vel", 70),
                ("/odom", 46),
                ("/scan", 61),
                ("/inbye/tick", 136),
                ("/map", 300),
                ("/tf", 41),
            ] {
                let number = if topic == "/map" { 0 } else { 20 };
                let copy = altered(&whole, topic, number, |message| message[byte] ^= 0x40);
                fs::write(place.file(), copy)?;
                if let Ok(output) = place.compare(python) {
                    return Err(
                        format!("{topic}: the flipped bit is not reported: {output}").into()
                    );
                }
            }
            Ok(())
        }),
    ]
}

/// A folder with a recording, the rows of the trace, and the cells of the map.
struct Place {
    folder: tempfile::TempDir,
    ticks: u64,
}

impl Place {
    fn new(simulation: &Simulation, config: &Config) -> Result<Self, Failed> {
        let folder = tempfile::tempdir()?;
        let (result, file) = record(simulation, config);
        fs::write(folder.path().join("run.mcap"), file)?;
        let lines: Vec<String> =
            result.trace.rows.iter().map(serde_json::to_string).collect::<Result<_, _>>()?;
        fs::write(folder.path().join("rows.jsonl"), lines.join("\n"))?;
        let grid = &simulation.mission.map;
        let frame = grid.frame();
        let map = serde_json::json!({
            "width": frame.width,
            "height": frame.height,
            "resolution_m": frame.resolution_m,
            "origin": frame.origin,
            "cells": grid.cells(),
        });
        fs::write(folder.path().join("map.json"), map.to_string())?;
        let paths = serde_json::to_string(&result.trace.paths)?;
        fs::write(folder.path().join("paths.json"), paths)?;
        Ok(Self { folder, ticks: lines.len() as u64 })
    }

    fn file(&self) -> PathBuf {
        self.folder.path().join("run.mcap")
    }

    /// The output of the Python reader, or an error if it finds a difference.
    fn compare(&self, python: &Path) -> Result<String, Failed> {
        let output = Command::new(python).arg(SCRIPT).current_dir(self.folder.path()).output()?;
        if output.status.success() {
            Ok(String::from_utf8(output.stdout)?)
        } else {
            Err(String::from_utf8_lossy(&output.stderr).into())
        }
    }
}
