//! Drives of the whole navigator from the playground.

use std::fs;
use std::path::Path;
use std::process::Command;

use image::{GrayImage, Luma};
use libtest_mimic::{Failed, Trial};
use serde_json::{Value, json};
use tempfile::TempDir;

use super::served::{Served, ServerTest};
use crate::support::browser::devtools::{DESKTOP, PHONE, Page};
use crate::support::browser::program::{self, BrowserTest, Program};

pub fn trials() -> Vec<Trial> {
    let in_browser: [(&str, BrowserTest); 1] = [("page_drives_to_the_goal", page_drives)];
    let mut trials = program::trials(&in_browser);
    let tests: [(&str, ServerTest); 4] = [
        ("drive_is_repeated_by_its_command", command_repeats_the_drive),
        ("first_drive_on_an_own_map_reaches_its_goal", first_drive_on_an_own_map),
        ("zones_are_shown_and_kept", zones_are_shown_and_kept),
        ("drives_out_of_range_are_rejected", out_of_range),
    ];
    trials.extend(tests.map(|(name, test)| Trial::test(name, test)));
    trials
}

/// Pixels by which the page is wider than the window.
const OVERFLOW: &str = "Math.max(0, document.documentElement.scrollWidth - window.innerWidth)";

/// Whether the heading of the drive and its result are in the window.
const RESULT_IS_IN_VIEW: &str = "['#driven h2', '#drive-state'].every((one) => { \
    const box = document.querySelector(one).getBoundingClientRect(); return box.top >= 0 && box.bottom <= window.innerHeight; })";

/// Red and blue of the page's picture, 0.17 m to the side of the robot's centre, which looks along x. The goal is 5.104 m away.
const BESIDE_THE_CENTRE: &str = "(() => { \
    const centre = (name) => { const box = document.querySelector(`[data-handle=${name}]`).getBoundingClientRect(); \
        return [box.x + box.width / 2, box.y + box.height / 2]; }; \
    const canvas = document.querySelector('#canvas'), box = canvas.getBoundingClientRect(), fine = canvas.width / box.width; \
    const [x, y] = centre('robot'), [goalX, goalY] = centre('goal'), metre = Math.hypot(goalX - x, goalY - y) / 5.104; \
    const [red, , blue] = canvas.getContext('2d').getImageData((x - box.x) * fine, (y - box.y - 0.17 * metre) * fine, 1, 1).data; \
    return [red, blue]; })()";

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
    assert_eq!(repeated(command)?["trace_digest"], drive["trace_digest"], "{command}");
    Ok(())
}

/// The result of a command that the page shows.
fn repeated(command: &str) -> Result<Value, Failed> {
    let folder = TempDir::new()?;
    let programs = Path::new(env!("CARGO_BIN_EXE_inbye")).parent().ok_or("no folder")?;
    let path = format!("{}:{}", programs.display(), std::env::var("PATH")?);
    let script = format!("{command} --json --engine cpu");
    let output = Command::new("sh")
        .args(["-c", &script])
        .current_dir(folder.path())
        .env("PATH", path)
        .output()?;
    let result = serde_json::from_slice(&output.stdout);
    Ok(result.map_err(|_| String::from_utf8_lossy(&output.stderr).into_owned())?)
}

/// A hall with a closed zone across its middle, which leaves a way along the upper wall, and a speed limit there.
fn zones_are_shown_and_kept() -> Result<(), Failed> {
    let folder = TempDir::new()?;
    let rows = |cell: &dyn Fn(usize, usize) -> char| -> String {
        let row = |row| (0..40).map(|column| cell(column, row)).chain(['\n']).collect::<String>();
        (0..24).map(row).collect()
    };
    let border = |column, row| column == 0 || column == 39 || row == 0 || row == 23;
    let is_middle = |column| (18..22).contains(&column);
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    fs::write(at("hall.txt"), rows(&|column, row| if border(column, row) { '#' } else { '.' }))?;
    let closed = |column, row| if is_middle(column) && row >= 10 { '#' } else { '.' };
    fs::write(at("closed.txt"), rows(&closed))?;
    let slow = GrayImage::from_fn(40, 24, |column, row| {
        Luma([if is_middle(column as usize) && row < 10 { 128 } else { 255 }])
    });
    slow.save(at("slow.png"))?;
    let yaml = "image: slow.png\nresolution: 0.25\norigin: [0, 0, 0]\nnegate: 0\nmode: scale\n\
        occupied_thresh: 1.0\nfree_thresh: 0.0\n";
    fs::write(at("slow.yaml"), yaml)?;
    let [map, closed, slow] = [at("hall.txt"), at("closed.txt"), at("slow.yaml")];
    let words =
        ["--map", &map, "--resolution", "0.25", "--keepout", &closed, "--speed-zones", &slow];
    let served = Served::start(&words)?;
    let cells = served.request("GET", "/scenes/map/cells", "")?.body;
    let mut counts = [0; 5];
    cells.iter().for_each(|&kind| counts[usize::from(kind)] += 1);
    // The lowest row of the closed zone and the highest of the other one are walls.
    assert_eq!(counts[3..], [4 * 13, 4 * 9]);
    let mut request = request(&served)?;
    let (start, goal) = (json!([2.0, 1.0, 0.0]), json!([8.0, 1.0]));
    for (key, value) in
        [("scene", json!("map")), ("start", start), ("goal", goal), ("people", json!([]))]
    {
        request[key] = value;
    }
    let drive = served.request("POST", "/drive", &request.to_string())?.json()?;
    assert_eq!(drive["reached"], true, "{drive}");
    let command = drive["command"].as_str().ok_or("no command")?;
    let repeated = repeated(command)?;
    assert_eq!(repeated["trace_digest"], drive["trace_digest"], "{command}");
    let zones = &repeated["zones"];
    assert_eq!(zones["intrusions"], json!(0), "{repeated}");
    assert!(zones["limited_ticks"].as_u64() > Some(5), "{repeated}");
    request["goal"] = json!([5.0, 1.0]);
    let answer = served.request("POST", "/drive", &request.to_string())?;
    assert!(answer.status == 400 && answer.json()?["error"].to_string().contains("GOAL_OCCUPIED"));
    // Without a map there is nothing that the masks belong to.
    let mut alone = Command::new(env!("CARGO_BIN_EXE_inbye"));
    let alone = alone.args(["playground", "--keepout", &closed]).output()?;
    let said = String::from_utf8_lossy(&alone.stderr).into_owned();
    assert!(alone.status.code() == Some(2) && said.contains("belong to a map"), "{said}");
    Ok(())
}

/// Maps without walls at their edge, and one that is turned: the first drive of the page succeeds.
fn first_drive_on_an_own_map() -> Result<(), Failed> {
    let folder = TempDir::new()?;
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    // The farthest places from the block are the corners, where no robot fits.
    let block = GrayImage::from_fn(60, 60, |column, row| {
        let is_solid = (25..35).contains(&column) && (25..35).contains(&row);
        Luma([if is_solid { 0 } else { 254 }])
    });
    block.save(at("block.png"))?;
    for (name, yaw) in [("open.yaml", 0.0), ("turned.yaml", 0.6)] {
        let yaml = format!(
            "image: block.png\nresolution: 0.1\norigin: [1, 2, {yaw}]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
        );
        fs::write(at(name), yaml)?;
        let served = Served::start(&["--map", &at(name)])?;
        let problem = served.problem()?;
        let mut request = request(&served)?;
        for (key, value) in [
            ("scene", &json!("map")),
            ("start", &problem["robot"]["pose"]),
            ("goal", &problem["target"]),
            ("people", &json!([])),
        ] {
            request[key] = value.clone();
        }
        let drive = served.request("POST", "/drive", &request.to_string())?.json()?;
        assert_eq!(drive["reached"], true, "{name}: {drive}");
    }
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
    let at = |x: f64, y: f64| json!({ "x": x, "y": y, "radius": 0.3, "vx": 0.0, "vy": 0.0 });
    for (body, text) in [
        ("{}".to_owned(), "missing field"),
        (changed("scene", json!("elsewhere"))?, "no such scene"),
        (changed("start", json!([0.05, 0.05, 0.0]))?, "START_OCCUPIED"),
        (changed("goal", json!([1e9, 0.0]))?, "GOAL"),
        (changed("vx_samples", json!(100_000))?, "at most"),
        (changed("sim_time_s", json!(-1.0))?, "sim_time_s"),
        (changed("people", json!([person]))?, "radius"),
        (changed("people", json!([at(2.3, 8.7)]))?, "touches the robot"),
        (changed("people", json!([at(-1.0, 8.7)]))?, "outside the map"),
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
    // The body is drawn, blue on white.
    page.wait_for(&format!("(([red, blue]) => red < 100 && blue > 100)({BESIDE_THE_CENTRE})"))?;
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
    assert_eq!(page.evaluate(RESULT_IS_IN_VIEW)?, json!(true));
    page.photograph("drive")?;
    page.look(PHONE)?;
    page.wait_for("window.innerWidth < 400")?;
    assert_eq!(page.evaluate(OVERFLOW)?, json!(0), "wider than the screen");
    page.photograph("drive-phone")?;
    // Reset discards the drive, also one that is being computed.
    let [click, reset] =
        ["drive", "reset"].map(|id| format!("document.querySelector('#{id}').click()"));
    let is_hidden = "document.querySelector('#driven').hidden";
    page.evaluate(&reset)?;
    assert_eq!(page.evaluate(is_hidden)?, json!(true));
    page.evaluate(&format!("{click}; {reset}"))?;
    page.evaluate("new Promise((resolve) => setTimeout(resolve, 2000))")?;
    assert_eq!(page.evaluate(is_hidden)?, json!(true));
    page.evaluate(&click)?;
    page.wait_for("document.querySelector('#drive-state').textContent === 'goal reached'")?;
    assert_eq!(page.console, [""; 0], "messages on the console");
    Ok(())
}
