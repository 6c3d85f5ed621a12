//! Writes report pages and their folder.

use std::fs;
use std::path::Path;

use anyhow::Context;
use inbye::geometry::Pose;
use inbye::report::{MissionView, Outcome, PlaybackRecorder, Report, ReportFile, html};
use inbye::runtime::{Config, Mission, MissionResult};

use super::{incident_text, output};

/// Data of a mission's page that [`MissionView`] borrows.
pub struct MissionPage {
    title: String,
    command: String,
    latency_ms: Vec<f64>,
    facts: Vec<(String, String)>,
}

impl MissionPage {
    /// Creates the page of a run; `command` repeats the run.
    pub fn new(title: &str, command: &str, result: &MissionResult) -> Self {
        let mut facts = vec![
            ("Version".to_owned(), format!("inbye {}", env!("CARGO_PKG_VERSION"))),
            ("Global plans".to_owned(), result.plans.len().to_string()),
            ("Trace digest".to_owned(), result.trace.digest()),
        ];
        if let Some(fault) = &result.fault {
            facts.push(("Fault".to_owned(), fault.to_string()));
        }
        let incidents = incident_text::facts(result).into_iter();
        facts.extend(incidents.map(|(name, fact)| (name.to_owned(), fact)));
        Self {
            title: title.to_owned(),
            command: command.to_owned(),
            latency_ms: result.decision_s.iter().map(|seconds| seconds * 1e3).collect(),
            facts,
        }
    }

    /// The view of a run for the report.
    pub fn view<'a>(
        &'a self,
        mission: &'a Mission,
        config: &'a Config,
        result: &'a MissionResult,
        playback: &'a PlaybackRecorder,
    ) -> MissionView<'a> {
        let first = result.plans.first();
        let points = |path: fn(&inbye::global::Plan) -> &inbye::global::Path| {
            first.map_or(&[][..], |plan| path(plan).points())
        };
        let (x, y) = result.final_error_m;
        MissionView {
            title: &self.title,
            command: &self.command,
            map: &mission.map,
            start: mission.start,
            goal: mission.goal.position,
            searched: points(|plan| &plan.raw),
            pruned: points(|plan| &plan.pruned),
            smoothed: points(|plan| &plan.smoothed),
            trace: &result.trace,
            footprint: &config.robot.footprint,
            latency_ms: &self.latency_ms,
            engine: &result.engine,
            outcome: Outcome {
                reached: result.reached,
                collided: result.collided,
                time_s: result.time_s,
                travelled_m: result.travelled_m,
                min_clearance_m: result.min_clearance_m,
                final_error: Pose::new(x, y, result.final_yaw_error.unwrap_or(f64::NAN)),
            },
            control_period_s: config.local.control_period_s,
            playback: Some(playback),
            facts: &self.facts,
        }
    }
}

/// Introduction of a simulated drive's page.
pub const SIMULATED: &str = "One mission, simulated in a closed loop.";

/// Returns the page of one drive.
pub fn drive_page(
    mission: &Mission,
    config: &Config,
    result: &MissionResult,
    playback: &PlaybackRecorder,
    map_name: &str,
    command: &str,
    intro: &str,
) -> String {
    let page = MissionPage::new(map_name, command, result);
    html(&Report {
        title: "inbye drive",
        intro,
        missions: vec![page.view(mission, config, result, playback)],
        ..Report::default()
    })
}

/// Creates the folder of a report.
pub fn create_folder(folder: &Path) -> anyhow::Result<()> {
    fs::create_dir_all(folder).with_context(|| {
        let name = folder.display();
        format!("--report {name}: cannot be a folder: choose another name")
    })
}

/// Writes a page as `index.html` into a folder, which is created if missing.
pub fn write(folder: &Path, page: &str) -> anyhow::Result<()> {
    create_folder(folder)?;
    let file = folder.join("index.html");
    fs::write(&file, page).with_context(|| format!("--report {}", folder.display()))?;
    output::note(format!("report: {}", file.display()));
    Ok(())
}

/// Writes the files of a report into a folder, which is created if missing, and prints the name of the first, its page.
pub fn write_files(folder: &Path, files: &[ReportFile]) -> anyhow::Result<()> {
    create_folder(folder)?;
    for file in files {
        fs::write(folder.join(&file.name), &file.text)
            .with_context(|| format!("--report {}", folder.display()))?;
    }
    if let Some(page) = files.first() {
        output::note(format!("report: {}", folder.join(&page.name).display()));
    }
    Ok(())
}

/// The command line, with the program's name without its folder.
pub fn command_line() -> String {
    let words = std::env::args().skip(1);
    let words: Vec<String> = ["inbye".to_owned()].into_iter().chain(words).collect();
    words.join(" ")
}
