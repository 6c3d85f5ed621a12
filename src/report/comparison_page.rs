//! The page of a comparison: a ranking of the planners for each kind of worlds, and every run.

use std::collections::BTreeMap;

use maud::{Markup, html};

use super::figure::{Table, file_links, scrolling_table};
use super::number::fixed;
use super::page::{ReportFile, document, json_text, page_header, reproduction};
use crate::bench::csv_text;
use crate::experiment::{RankedPlanner, RunOutcome, RunRow, WorldKind, planner_names};

/// The content of the page.
#[derive(Clone, Copy, Debug)]
pub struct ComparisonReport<'a> {
    /// The title.
    pub title: &'a str,
    /// A paragraph before the introduction, such as that runs are missing; empty for none.
    pub note: &'a str,
    /// Processor and system of the measurements.
    pub machine: &'a str,
    /// The command that repeats the comparison.
    pub command: &'a str,
    /// The ranking of each kind of worlds, one after the other.
    pub ranked: &'a [RankedPlanner],
    /// All runs.
    pub rows: &'a [RunRow],
    /// File name of a page that plays a run, by the run's key.
    pub plays: &'a BTreeMap<String, String>,
    /// The search of settings that the runs judge; none of another comparison.
    pub search: Option<SearchResult<'a>>,
}

/// The result of a search of settings. Its successes are means weighted by completion time: that of the settings without changes,
/// then that of the tuned ones.
#[derive(Clone, Copy, Debug)]
pub struct SearchResult<'a> {
    /// The tuned settings as TOML, those that differ; empty where no candidate was better.
    pub changes: &'a str,
    /// On the worlds of the search.
    pub train: [f64; 2],
    /// On the other worlds.
    pub judge: [f64; 2],
}

/// Columns of the table of motions.
const MOTION: &str = "rank planner path_weighted_success near_share stopped_share speed_change_m_s2 jerk_rms_m_s3 control_effort_m_s2 drive_work_j_per_kg angle_per_m \
    curvature_per_m off_path_rms_m intimate_share personal_share";

/// Returns the files of the report: `index.html`, and rankings and runs as CSV and JSON.
#[must_use]
pub fn comparison_files(report: &ComparisonReport<'_>) -> Vec<ReportFile> {
    let ComparisonReport { title, note, machine, command, ranked, rows, .. } = *report;
    let data = vec![
        ReportFile::new("ranking.csv", csv_text(ranked)),
        ReportFile::new("ranking.json", json_text(ranked)),
        ReportFile::new("runs.csv", csv_text(rows)),
        ReportFile::new("runs.json", json_text(rows)),
    ];
    let intro = format!(
        "{note}\n\n\
        Every planner drives the same worlds with the same seeds. What its settings do not change is the same for all. \
        The order is that of the mean success weighted by completion time: ideal over actual time where the goal was reached, \
        else 0. The ideal time of a world and seed is the same for all: that of the world's own robot, before a planner's settings \
        change it, along its first path at its highest speed; in BARN, that of the benchmark's path at 2 m/s.\n\n\
        The difference to the best planner is paired by world and seed. Its interval of 95 % confidence comes from 10,000 \
        resamples of the worlds; with fewer than 6 worlds there is none. Where it contains zero, the difference may be chance."
    );
    let names = planner_names(rows);
    let content = html! {
        (page_header(title, &intro, machine, &html! {}))
        @if let Some(search) = &report.search { (search_section(search)) }
        @for ranking in ranked.chunk_by(|one, next| one.kind == next.kind) {
            (kind_section(report, &names, ranking))
        }
        section { (file_links(&data)) }
        (reproduction(command))
    };
    let page = document(title, "", "", &content);
    [vec![ReportFile::new("index.html", page)], data].concat()
}

/// The tuned settings, and their gain on both sets of worlds.
fn search_section(search: &SearchResult<'_>) -> Markup {
    let SearchResult { changes, train, judge } = *search;
    let rows = html! {
        @for (worlds, [default, tuned]) in [("of the search", train), ("others", judge)] { tr {
            td { (worlds) }
            td { (fixed(default, 3)) }
            td { (fixed(tuned, 3)) }
            td { (fixed(tuned - default, 3)) }
        } }
    };
    html! {
        section {
            h2 { "Tuned settings" }
            @if changes.is_empty() {
                p { "No candidate was better than the settings without changes." }
            } @else {
                pre { (changes.trim_end()) }
            }
            p { "A gain on the worlds of the search alone is overfitting." }
            (scrolling_table("gain", None, ["worlds", "default", "tuned", "gain"].into_iter(), &rows))
        }
    }
}

/// A ranking with its tables.
fn kind_section(
    report: &ComparisonReport<'_>,
    names: &[String],
    ranking: &[RankedPlanner],
) -> Markup {
    let kind = ranking.first().map(|planner| planner.kind).unwrap_or_default();
    let summary = Table::of_columns("ranking", ranking, RankedPlanner::SUMMARY);
    let motion = Table::of_columns("motion and distances", ranking, MOTION);
    html! {
        section {
            h2 { "Worlds: " (kind.name()) }
            @for planner in ranking { p { (sentence(planner)) } }
            (summary.markup())
            details { summary { "Table: " (motion.title) } (motion.markup()) }
            details open[ranking.len() < 2] { summary { "Every run" } (runs_table(report, names, kind, ranking)) }
        }
    }
}

/// The place of a planner, in words.
fn sentence(planner: &RankedPlanner) -> String {
    let RankedPlanner { rank, planner: name, runs, reached_share, contact_share, .. } = planner;
    let reached = fixed(100.0 * reached_share, 1);
    let contacts = fixed(100.0 * contact_share, 1);
    let verdict = planner.difference.map(|difference| {
        let interval = planner.difference_low.zip(planner.difference_high);
        let interval = interval.map_or_else(String::new, |(low, high)| {
            format!(", interval {} to {}", fixed(low, 3), fixed(high, 3))
        });
        format!("; {} ({}{interval})", planner.verdict.text(), fixed(difference, 3))
    });
    let left_out = (planner.left_out > 0).then(|| {
        format!(
            "; {} other runs do not count, because another planner did not drive in their worlds with their seeds",
            planner.left_out
        )
    });
    let faults = planner.faults.as_ref().map(|faults| format!("; faults: {faults}"));
    let notes: String = [verdict, left_out, faults].into_iter().flatten().collect();
    let success = fixed(planner.time_weighted_success, 3);
    format!(
        "{rank}. {name}: {success}; {reached} % of {runs} runs reached their goal, {contacts} % ended in contact{notes}."
    )
}

/// A row for each world and seed, a column for each planner.
fn runs_table(
    report: &ComparisonReport<'_>,
    names: &[String],
    kind: WorldKind,
    ranking: &[RankedPlanner],
) -> Markup {
    let mut tasks: Vec<(&str, u64, bool)> = Vec::new();
    let mut runs: BTreeMap<((&str, u64, bool), &str), &RunRow> = BTreeMap::new();
    for (row, name) in report.rows.iter().zip(names).filter(|(row, _)| row.kind == kind) {
        let task = (row.world.as_str(), row.seed, row.latency);
        if runs.insert((task, name), row).is_none() && !tasks.contains(&task) {
            tasks.push(task);
        }
    }
    let cell = |task, planner| runs.get(&(task, planner)).copied();
    let planners = || ranking.iter().map(|planner| planner.planner.as_str());
    let rows = html! {
        @for &task in &tasks { tr {
            td { (task.0) ", " (task.1) @if task.2 { ", latency" } }
            @for planner in planners() {
                td { @if let Some(row) = cell(task, planner) { (run_cell(report, row)) } @else { "-" } }
            }
        } }
    };
    scrolling_table("every run", None, ["world, seed"].into_iter().chain(planners()), &rows)
}

/// How a run ended, with a link to the page that plays it.
fn run_cell(report: &ComparisonReport<'_>, row: &RunRow) -> Markup {
    let text = match row.outcome {
        RunOutcome::Reached => format!("{} s", fixed(row.time_s, 1)),
        RunOutcome::Contact => "contact".to_owned(),
        RunOutcome::Timeout => "timeout".to_owned(),
        RunOutcome::Failed => "gave up".to_owned(),
        RunOutcome::Error => "no start".to_owned(),
    };
    let reason = row.reason.as_deref().unwrap_or("reached the goal");
    html! {
        @if let Some(file) = report.plays.get(&row.key) {
            a href=(file) title=(reason) { (text) }
        } @else {
            span title=(reason) { (text) }
        }
    }
}
