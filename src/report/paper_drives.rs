//! The driving half of the paper's experiments: maps of the drives, their deviations as tables, and what follows.

use maud::{Markup, html};

use super::figure::Table;
use super::map_figure::MapFigure;
use super::mission::badge;
use super::number::fixed;
use super::paper_drives_maps;
use super::paper_page::PaperReport;
use super::paper_tables::findings;
use crate::experiment::TrafficKind;
use crate::experiment::paper_drives::{
    ALL_SCENES, Deviation, DriveRun, DriveSummary, DriveTable, MEAN_LIMIT_M, MEAN_LIMIT_RAD,
    PaperTable,
};

const RUN_HEADS: [&str; 16] = [
    "scene, seed",
    "|dx|, m",
    "|dy|, m",
    "|dyaw|, rad",
    "paper |dx|",
    "paper |dy|",
    "paper |dyaw|",
    "time, s",
    "driven, m",
    "path, m",
    "smallest gap, m",
    "to anybody, m",
    "plans",
    "stood, %",
    "longest stand, s",
    "end",
];

const SUMMARY_HEADS: [&str; 14] = [
    "drives",
    "number",
    "reached",
    "contacts",
    "mean |dx|, m",
    "mean |dy|, m",
    "mean |dyaw|, rad",
    "max |dx|, m",
    "max |dy|, m",
    "max |dyaw|, rad",
    "mean time, s",
    "mean way, m",
    "smallest gap, m",
    "stood, %",
];

/// The tables of driving, in their order.
fn drive_tables<'a>(report: &PaperReport<'a>) -> impl Iterator<Item = &'a DriveTable> {
    report.tables.iter().filter_map(|table| match table {
        PaperTable::Drives(table) => Some(table),
        _ => None,
    })
}

/// What came of all drives, in short; nothing where there were none.
pub(super) fn in_short(report: &PaperReport) -> Markup {
    html! {
        @for table in drive_tables(report) {
            h3 { (table.title) }
            p {
                (badge(table.acceptance.all_reached, if table.acceptance.all_reached { "every drive reached its goal" } else { "not every drive reached its goal" }))
                " "
                (badge(table.acceptance.no_contact, if table.acceptance.no_contact { "no contact" } else { "contact" }))
                " "
                (badge(table.acceptance.means_within_limits, &format!(
                    "mean deviations {} {MEAN_LIMIT_M} m and {MEAN_LIMIT_RAD} rad in every scene",
                    if table.acceptance.means_within_limits { "within" } else { "not within" }
                )))
            }
            (findings(&table.findings))
        }
    }
}

/// The drives of one kind of traffic on their maps.
pub(super) fn maps(report: &PaperReport, table: &DriveTable) -> MapFigure {
    let drives = report.drives.iter();
    let shown = drives
        .filter(|drives| drives.traffic == table.traffic)
        .flat_map(|drives| &drives.shown);
    let figure = match table.traffic {
        TrafficKind::None => ["figure_12", "Fig. 12: nobody about"],
        TrafficKind::Yielding | TrafficKind::Appearing => {
            ["figure_13", "Fig. 13: people who mind the robot"]
        }
        TrafficKind::NonYielding => [
            "figure_13_heedless",
            "Fig. 13 again: people who do not mind the robot",
        ],
    };
    paper_drives_maps::side_by_side(figure, report.courses, shown, report.footprint)
}

/// Tables of one kind of traffic, below its maps and charts.
pub(super) fn section(table: &DriveTable, pictures: &Markup) -> Markup {
    html! {
        section id=(table.name) {
            h2 { (table.title) }
            (pictures)
            div class="whole steps" { (summary_table(table)) }
            div class="whole steps narrow" { (run_table(table).markup()) }
        }
    }
}

fn summary_table(table: &DriveTable) -> Markup {
    let ours = table.summaries.iter().map(summary_row);
    let paper = &table.paper;
    let printed = |whose: &str, number: String, spread: [Deviation; 2]| {
        let mut cells = vec![whose.to_owned(), number, String::new(), String::new()];
        let digits = spread.into_iter().flat_map(Deviation::to_array);
        cells.extend(digits.map(|value| fixed(value, 3)));
        cells.resize(SUMMARY_HEADS.len(), String::new());
        cells
    };
    let (of_rows, of_text) = (paper.of_rows, paper.of_text);
    let rows = ours.chain([
        printed(
            "the paper's rows",
            paper.rows.len().to_string(),
            [of_rows.mean, of_rows.max],
        ),
        printed(
            "the paper's text",
            String::new(),
            [of_text.mean, of_text.max],
        ),
    ]);
    Table {
        title: format!("{}: means", table.title),
        heads: &SUMMARY_HEADS,
        rows: rows.collect(),
    }
    .markup()
}

fn summary_row(summary: &DriveSummary) -> Vec<String> {
    let name = if summary.scene == ALL_SCENES {
        "all scenes".to_owned()
    } else {
        summary.scene.clone()
    };
    let mut cells = vec![
        name,
        summary.runs.to_string(),
        summary.reached.to_string(),
        summary.contacts.to_string(),
    ];
    let spread = summary.deviation;
    let [mean, max] = [
        spread.map(|spread| spread.mean),
        spread.map(|spread| spread.max),
    ];
    for deviation in [mean, max] {
        let values = deviation.map_or([f64::NAN; 3], Deviation::to_array);
        cells.extend(values.map(|value| fixed(value, 4)));
    }
    cells.extend([
        fixed(summary.time_s, 1),
        fixed(summary.travelled_m, 2),
        fixed(summary.min_clearance_m, 3),
        fixed(100.0 * summary.waited_share, 1),
    ]);
    cells
}

pub(super) fn run_table(table: &DriveTable) -> Table<'static> {
    let first = table.rows.first().map(|run| run.scene.as_str());
    let rows = table.rows.iter().enumerate().map(|(index, run)| {
        // The paper's ten stand beside those of the first scene.
        let of_first = Some(run.scene.as_str()) == first;
        run_row(run, table.paper.rows.get(index).filter(|_| of_first))
    });
    Table {
        title: format!("{}: every drive", table.title),
        heads: &RUN_HEADS,
        rows: rows.collect(),
    }
}

fn run_row(run: &DriveRun, paper: Option<&Deviation>) -> Vec<String> {
    let mut cells = vec![format!("{}, {}", run.scene, run.seed)];
    cells.extend(run.deviation.to_array().map(|value| fixed(value, 4)));
    match paper {
        Some(row) => cells.extend(row.to_array().map(|value| fixed(value, 3))),
        None => cells.extend([const { String::new() }; 3]),
    }
    cells.extend([
        fixed(run.time_s, 1),
        fixed(run.travelled_m, 2),
        fixed(run.path_length_m, 2),
        fixed(run.min_clearance_m, 3),
        fixed(run.nearest_person_m.unwrap_or(f64::NAN), 3),
        run.plans.to_string(),
        fixed(100.0 * run.waited_share, 1),
        fixed(run.longest_wait_s, 1),
        run.outcome.text().to_owned(),
    ]);
    cells
}
