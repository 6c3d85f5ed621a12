//! The page of an ablation: success and time of each variant.

use maud::{Markup, html};

use super::figure::{Table, area_key, files_beside};
use super::number::{coordinate, fixed};
use super::page::{Extras, document};
use super::panel::chart;
use super::report_files::{ReportFile, json_text};
use crate::bench::{AblationRow, csv_text};

const OWN_STYLE: &str = include_str!("ablation.css");

const TITLE: &str = "inbye: what each part of the navigator buys";

/// Left ends of the bars, their longest length, and their height with the space below, drawing units.
const LEFT: f64 = 180.0;
const LONGEST: f64 = 185.0;
const PITCH: f64 = 26.0;
const BAR: f64 = 16.0;

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

/// The page, `ablation.html`, which holds everything it needs, and its rows as CSV and JSON.
#[must_use]
pub fn ablation_files(report: &AblationReport) -> Vec<ReportFile> {
    vec![
        ReportFile::new("ablation.html", page(report)),
        ReportFile::new("ablation.csv", csv_text(report.rows)),
        ReportFile::new("ablation.json", json_text(report.rows)),
    ]
}

fn page(report: &AblationReport) -> String {
    let missions = report.rows.first().map_or(0, |row| row.tally.missions);
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
    let shared = rows.first().map_or(0, |row| row.shared);
    html! {
        section id="ablation" {
            h2 { "Success and time" }
            div class="charts" { (endings(rows)) (times(rows)) }
            p class="machine" {
                (shared) " missions were reached by every variant that reached any; the lighter bar is the mean time over these."
            }
            (table(rows).markup())
            (files_beside("ablation", &["csv", "json"]))
        }
    }
}

/// How the missions of each variant ended: a bar of the full length for each.
fn endings(rows: &[AblationRow]) -> Markup {
    const CLASSES: [&str; 4] = ["end-reached", "end-stopped", "end-other", "end-robot"];
    let parts = |row: &AblationRow| {
        let tally = &row.tally;
        let stopped = tally.failed + tally.timeouts;
        [
            tally.reached,
            stopped,
            tally.contacts_other,
            tally.contacts_robot,
        ]
    };
    let said: Vec<String> = rows
        .iter()
        .map(|row| format!("{} {}", row.title, percent(row)))
        .collect();
    let content = html! {
        @for (index, row) in rows.iter().enumerate() {
            @let top = PITCH * index as f64 + 4.0;
            (label(&row.title, top))
            @let whole = row.tally.missions.max(1) as f64;
            @let counts = parts(row);
            @for (part, (&count, class)) in counts.iter().zip(CLASSES).enumerate() {
                @let before = counts[..part].iter().sum::<usize>() as f64;
                (bar(class, before / whole, count as f64 / whole, top, BAR))
            }
            (value(&percent(row), 1.0, top))
        }
    };
    html! {
        figure {
            h3 { "How the missions ended" }
            (chart(PITCH * rows.len() as f64 + 4.0, &format!("Missions that reached their goal: {}.", said.join("; ")), &content))
            ul class="legend" {
                li { (area_key(CLASSES[0], "reached")) }
                li { (area_key(CLASSES[1], "gave up, or time up")) }
                li { (area_key(CLASSES[2], "contact, not by the robot's motion")) }
                li { (area_key(CLASSES[3], "contact by the robot")) }
            }
        }
    }
}

/// Mean times: of a variant's own successes, and of the missions that all share.
fn times(rows: &[AblationRow]) -> Markup {
    let pair = |row: &AblationRow| [row.tally.mean_time_s, row.mean_shared_time_s];
    let longest = rows
        .iter()
        .flat_map(pair)
        .flatten()
        .fold(f64::MIN_POSITIVE, f64::max);
    let seconds = |time_s: Option<f64>| {
        time_s.map_or_else(
            || "none reached".to_owned(),
            |time_s| format!("{} s", fixed(time_s, 1)),
        )
    };
    let said: Vec<String> = rows
        .iter()
        .map(|row| format!("{} {}", row.title, seconds(row.tally.mean_time_s)))
        .collect();
    let content = html! {
        @for (index, row) in rows.iter().enumerate() {
            @let top = PITCH * index as f64 + 4.0;
            (label(&row.title, top))
            @let [own, shared] = pair(row).map(|time_s| time_s.unwrap_or(0.0) / longest);
            (bar("own-time", 0.0, own, top, BAR / 2.0))
            (bar("shared-time", 0.0, shared, top + BAR / 2.0, BAR / 2.0))
            (value(&seconds(row.tally.mean_time_s), own.max(shared), top))
        }
    };
    html! {
        figure {
            h3 { "Mean time of the missions reached" }
            (chart(PITCH * rows.len() as f64 + 4.0, &format!("Mean times: {}.", said.join("; ")), &content))
            ul class="legend" {
                li { (area_key("own-time", "its own successes")) }
                li { (area_key("shared-time", "missions that all reached")) }
            }
        }
    }
}

fn label(title: &str, top: f64) -> Markup {
    let short = title.split([',', ':']).next().unwrap_or_default();
    html! {
        text class="end" x=(coordinate(LEFT - 6.0)) y=(coordinate(top + BAR / 2.0)) dy=".35em" { (short) }
    }
}

/// A bar from a share of the longest on, so much of it long.
fn bar(class: &str, from: f64, length: f64, top: f64, height: f64) -> Markup {
    html! {
        @if length > 0.0 {
            rect class=(class) x=(coordinate(LEFT + from * LONGEST)) y=(coordinate(top))
                width=(coordinate(length * LONGEST)) height=(coordinate(height)) {}
        }
    }
}

fn value(text: &str, end: f64, top: f64) -> Markup {
    let x = LEFT + end * LONGEST + 6.0;
    html! {
        text x=(coordinate(x)) y=(coordinate(top + BAR / 2.0)) dy=".35em" { (text) }
    }
}

fn percent(row: &AblationRow) -> String {
    format!("{} %", fixed(row.tally.reached_share * 100.0, 1))
}

fn table(rows: &[AblationRow]) -> Table<'static> {
    let number = |value: Option<f64>, decimals| fixed(value.unwrap_or(f64::NAN), decimals);
    Table {
        title: "what each part buys".to_owned(),
        heads: &[
            "navigator",
            "missions",
            "reached",
            "reached, %",
            "contacts by the robot",
            "other contacts",
            "gave up",
            "time up",
            "mean time, s",
            "mean time over shared missions, s",
            "mean smallest gap, m",
        ],
        rows: rows
            .iter()
            .map(|row| {
                let tally = &row.tally;
                vec![
                    row.title.clone(),
                    tally.missions.to_string(),
                    tally.reached.to_string(),
                    fixed(tally.reached_share * 100.0, 1),
                    tally.contacts_robot.to_string(),
                    tally.contacts_other.to_string(),
                    tally.failed.to_string(),
                    tally.timeouts.to_string(),
                    number(tally.mean_time_s, 1),
                    number(row.mean_shared_time_s, 1),
                    number(tally.mean_clearance_m, 3),
                ]
            })
            .collect(),
    }
}
