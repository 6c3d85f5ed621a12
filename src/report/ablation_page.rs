//! The page of an ablation: success and time of each variant.

use maud::{Markup, html};

use super::ablation_chart::{figures, plots};
use super::figure::files_beside;
use super::own_picture::own_picture;
use super::page::{Extras, document};
use super::report_files::{ReportFile, json_text};
use crate::bench::csv_text;
use crate::experiment::Group as AblationRow;

const OWN_STYLE: &str = concat!(include_str!("ablation.css"), include_str!("rows.css"));

const TITLE: &str = "inbye: what each part of the navigator buys";

/// All that the page shows.
#[derive(Clone, Copy, Debug)]
pub struct AblationReport<'a> {
    /// Where it was measured: processor, system.
    pub machine: &'a str,
    /// What repeats the run.
    pub command: &'a str,
    /// Names of the maps.
    pub maps: &'a [&'a str],
    /// The table, from the least variant to the whole navigator.
    pub rows: &'a [AblationRow],
}

/// The page, `ablation.html`, which holds everything it needs, its charts as a picture, and its rows as CSV and JSON.
#[must_use]
pub fn ablation_files(report: &AblationReport) -> Vec<ReportFile> {
    vec![
        ReportFile::new("ablation.html", page(report)),
        ReportFile::new("ablation.csv", csv_text(report.rows)),
        ReportFile::new("ablation.json", json_text(report.rows)),
        ReportFile::new("ablation.svg", own_picture(&plots(report.rows), "")),
    ]
}

fn page(report: &AblationReport) -> String {
    let missions = report.rows.first().map_or(0, |row| row.runs);
    let content = html! {
        header {
            h1 { (TITLE) }
            p {
                "The same " (missions) " random missions, simulated, by one navigator after the other, each with one part more \
                 than the one before. Moving obstacles cross the way; on some missions things stand on it that the map does \
                 not show. Maps: " (report.maps.join(", ")) "."
            }
            p class="machine" { "Measured on: " (report.machine) }
        }
        (section(report.rows))
        section {
            h2 { "The same again" }
            pre tabindex="0" { code { (report.command) } }
        }
    };
    document(TITLE, &Extras::of_style(OWN_STYLE), &content)
}

fn section(rows: &[AblationRow]) -> Markup {
    html! {
        section id="ablation" {
            h2 { "Success and time" }
            div class="charts" { @for figure in figures(rows) { (figure) } }
            (files_beside("ablation", &["csv", "json", "svg"]))
        }
    }
}
