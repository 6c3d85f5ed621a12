//! Writes report pages and their folder.

use std::fs;
use std::path::Path;

use anyhow::Context;
use inbye::report::{MissionView, Report, ReportFile, html};
use inbye::runtime::MissionResult;

use super::{incident_text, output};

/// Further facts on a run for its page.
pub fn facts(result: &MissionResult) -> Vec<(String, String)> {
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
    facts
}

/// Introduction of a simulated drive's page.
pub const SIMULATED: &str = "One mission, simulated in a closed loop.";

/// Returns the page of one drive.
pub fn drive_page(drive: MissionView, intro: &str) -> String {
    html(&Report { title: "inbye drive", intro, missions: vec![drive], ..Report::default() })
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
