//! The cells of a sweep on a Ray cluster of two workers. The test kills one of them during the sweep.
//!
//! It needs a Python with `ray`: the one that `tests/run` made in `target/ray`, or the one that `INBYE_RAY_PYTHON` names.
//! Without it the trials are ignored, or fail if the variable `INBYE_REQUIRE` contains the word `ray`.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};
use std::{env, fs};

use libtest_mimic::{Failed, Trial};

use super::plan_folder::{CELLS, INBYE, PlanFolder};
use crate::support::python::Python;

const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/sweep_ray.py");
static RAY: Python = Python::with(
    "ray",
    "INBYE_RAY_PYTHON",
    &[concat!(env!("CARGO_MANIFEST_DIR"), "/target/ray/bin/python")],
    "ray",
);
/// Longer than a cluster takes on an overloaded machine.
const TIMEOUT: Duration = Duration::from_secs(300);

pub fn trials() -> Vec<Trial> {
    let trial = |name: &str, test: fn(&Path) -> Result<(), Failed>| {
        Trial::ignorable_test(name, move || RAY.run(test))
    };
    vec![
        trial("on Ray, a worker killed on the way, results returned: the same table", |python| {
            killed_on_the_way(python, &[])
        }),
        trial("on Ray, a worker killed on the way, one folder for all: the same table", |python| {
            killed_on_the_way(python, &["--shared"])
        }),
    ]
}

fn killed_on_the_way(python: &Path, flags: &[&str]) -> Result<(), Failed> {
    let place = PlanFolder::new();
    let mut driver = place
        .command(python)
        .args([SCRIPT, "plan.toml", "--out", "out", "--inbye", INBYE, "--cpus", "2"])
        .args(flags)
        // Ray keeps sockets here, and their paths must be short.
        .env("TMPDIR", env::temp_dir())
        .env("RAY_USAGE_STATS_ENABLED", "0")
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()?;
    let plan = fs::canonicalize(place.path("plan.toml"))?;
    let killed = kill_a_worker(&place, &plan, &mut driver);
    let output = driver.wait_with_output()?;
    let message = String::from_utf8_lossy(&output.stderr);
    let killed = killed.map_err(|why| format!("{why}: {message}"))?;
    if !output.status.success() {
        return Err(format!("worker {killed} was killed, and the sweep gave up: {message}").into());
    }
    if !message.contains(&format!("{CELLS}/{CELLS} cells")) {
        return Err(format!("no progress was shown: {message}").into());
    }
    place.assert_same_table("out");
    Ok(())
}

/// Kills a worker that runs a cell, once some cells are done; returns its process number. The worker is the parent of one
/// of our programs.
fn kill_a_worker(place: &PlanFolder, plan: &Path, driver: &mut Child) -> Result<u32, String> {
    let began = Instant::now();
    while began.elapsed() < TIMEOUT {
        if driver.try_wait().is_ok_and(|ended| ended.is_some()) {
            return Err("all was over before a worker could be killed".to_owned());
        }
        if place.finished("out").len() >= 4
            && let Some(worker) = worker_at(plan)
        {
            let killed = Command::new("kill").args(["-KILL", &worker.to_string()]).status();
            if killed.is_ok_and(|status| status.success()) {
                return Ok(worker);
            }
        }
        sleep(Duration::from_millis(2));
    }
    Err("no worker was found".to_owned())
}

/// The parent of a program that runs a cell of this plan.
fn worker_at(plan: &Path) -> Option<u32> {
    let plan = plan.to_str()?;
    let process = |entry: fs::DirEntry| {
        let folder = entry.path();
        let words = fs::read(folder.join("cmdline")).ok()?;
        let words: Vec<String> = words
            .split(|&byte| byte == 0)
            .map(|word| String::from_utf8_lossy(word).into_owned())
            .collect();
        let is_cell = words.first()? == INBYE
            && words.iter().any(|word| word == plan)
            && words.iter().any(|word| word == "--cell");
        if !is_cell {
            return None;
        }
        let status = fs::read_to_string(folder.join("status")).ok()?;
        let parent = status.lines().find_map(|line| line.strip_prefix("PPid:"))?;
        let parent: u32 = parent.trim().parse().ok()?;
        // Ray's process name of a worker that runs a task.
        let name = fs::read(format!("/proc/{parent}/cmdline")).ok()?;
        name.starts_with(b"ray::run_cell").then_some(parent)
    };
    fs::read_dir("/proc").ok()?.flatten().find_map(process)
}
