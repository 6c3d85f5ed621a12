//! Drives of the whole navigator from the playground.

use std::path::Path;
use std::process::Command;

use libtest_mimic::{Failed, Trial};
use serde_json::{Value, json};
use tempfile::TempDir;

use super::served::{Served, ServerTest};
use crate::support::browser::devtools::{DESKTOP, PHONE, Page};
use crate::support::browser::program::{self, BrowserTest, Program};

pub fn trials() -> Vec<Trial> {
    let in_browser: [(&str, BrowserTest); 1] = [("page_drives_to_the_goal", page_drives)];
    let mut trials = program::trials(&in_browser);
    let tests: [(&str, ServerTest); 2] = [
        ("drive_is_repeated_by_its_command", command_repeats_the_drive),
        ("drives_out_of_range_are_rejected", out_of_range),
    ];
    trials.extend(tests.map(|(name, test)| Trial::test(name, test)));
    trials
}

/// Pixels by which the page is wider than the window.
const OVERFLOW: &str = "Math.max(0, document.documentElement.scrollWidth - window.innerWidth)";

/// A drive in the crossing with a person on the way and other settings than the defaults.
fn request(served: &Served) -> Result<Value, Failed> {
    let problem = served.problem()?;
    Ok(json!({
        "scene": "crossing",
        "start": [2.3, 8.7, 0.0],
        "goal": [7.4, 8.9],
        "people": [{ "x": 6.0, "y": 9.1, "radius": 0.3, "vx": -0.5, "vy": 0.1 }],
        "vx_samples": 16,
        "vtheta_samples": 24,
        "sim_time_s": problem["sim_time_s"],
        "weights": { "heading": 0.3, "clearance": 0.2, "velocity": 0.2, "path": 0.3 },
        "normalization": "sum",
        "stopping": problem["stopping"],
    }))
}

fn command_repeats_the_drive() -> Result<(), Failed> {
    let served = Served::start(&["--set", "navigator.lookahead_m=2.5"])?;
    let drive = served.request("POST", "/drive", &request(&served)?.to_string())?.json()?;
    assert_eq!(drive["reached"], true, "{drive}");
    let page = drive["page"].as_str().ok_or("no page")?;
    let page = String::from_utf8(served.request("GET", page, "")?.body)?;
    assert!(page.contains("class=\"player\"") && page.contains("goal reached"));
    // The shell that a user pastes it into.
    let command = drive["command"].as_str().ok_or("no command")?;
    for part in ["local.vx_samples=16", "local.normalization=sum", "navigator.lookahead_m=2.5"] {
        assert!(command.contains(part), "{command}");
    }
    let folder = TempDir::new()?;
    let programs = Path::new(env!("CARGO_BIN_EXE_inbye")).parent().ok_or("no folder")?;
    let path = format!("{}:{}", programs.display(), std::env::var("PATH")?);
    let script = format!("{command} --json --engine cpu");
    let output = Command::new("sh")
        .args(["-c", &script])
        .current_dir(folder.path())
        .env("PATH", path)
        .output()?;
    let repeated: Value = serde_json::from_slice(&output.stdout)
        .map_err(|_| String::from_utf8_lossy(&output.stderr).into_owned())?;
    assert_eq!(repeated["trace_digest"], drive["trace_digest"], "{command}");
    Ok(())
}

fn out_of_range() -> Result<(), Failed> {
    let served = Served::start(&[])?;
    let changed = |key: &str, value: Value| -> Result<String, Failed> {
        let mut request = request(&served)?;
        request[key] = value;
        Ok(request.to_string())
    };
    let person = json!({ "x": 5.0, "y": 9.0, "radius": -0.3, "vx": 0.0, "vy": 0.0 });
    for (body, text) in [
        ("{}".to_owned(), "missing field"),
        (changed("scene", json!("elsewhere"))?, "no such scene"),
        (changed("start", json!([0.05, 0.05, 0.0]))?, "START_OCCUPIED"),
        (changed("goal", json!([1e9, 0.0]))?, "GOAL"),
        (changed("vx_samples", json!(100_000))?, "at most"),
        (changed("sim_time_s", json!(-1.0))?, "sim_time_s"),
        (changed("people", json!([person]))?, "radius"),
    ] {
        let answer = served.request("POST", "/drive", &body)?;
        let error = answer.json()?["error"].to_string();
        assert!(answer.status == 400 && error.contains(text), "{body}: {} {error}", answer.status);
    }
    let answer = served.request("GET", "/drives/7", "")?;
    assert_eq!(answer.status, 404);
    Ok(())
}

fn page_drives(program: &Program) -> Result<(), Failed> {
    let served = Served::start(&["--scene", "crossing"])?;
    let mut page = Page::open(program, &[], DESKTOP, &served.url)?;
    page.wait_for("document.querySelectorAll('.handle[aria-label]').length > 2")?;
    // A click adds a person.
    page.evaluate("document.querySelector('#click').value = 'obstacle'")?;
    let handles = "document.querySelectorAll('.handle[aria-label]').length";
    let before = page.evaluate(handles)?.as_u64().ok_or("no handles")?;
    let at = page.evaluate(
        "(() => { const box = document.querySelector('#canvas').getBoundingClientRect(); \
         return [box.x + 40, box.y + 60]; })()",
    )?;
    let place = |index: usize| at[index].as_f64().unwrap_or_default();
    page.click((place(0), place(1)))?;
    page.wait_for(&format!("{handles} === {}", before + 1))?;
    page.evaluate("document.querySelector('#drive').click()")?;
    page.wait_for("document.querySelector('#drive-state').textContent === 'goal reached'")?;
    // The page of the drive plays in its frame.
    let frame = "document.querySelector('#drive-page').contentDocument";
    page.wait_for(&format!("Number({frame}?.querySelector('[data-action=seek]')?.value) > 3"))?;
    page.evaluate("document.querySelector('#driven').scrollIntoView()")?;
    page.photograph("drive")?;
    page.look(PHONE)?;
    page.wait_for("window.innerWidth < 400")?;
    assert_eq!(page.evaluate(OVERFLOW)?, json!(0), "wider than the screen");
    page.photograph("drive-phone")?;
    assert_eq!(page.console, [""; 0], "messages on the console");
    Ok(())
}
