//! The tables of the paper's experiments: measured values, and below them the published ones.

use maud::{Markup, html};

use super::figure::{Table, scrolling_table};
use super::number::{NONE, fixed, optional, significant};
use crate::bench::paper::{
    AblationTable, Measure, PathTable, PublishedRow, Reduced, Reduction, label_of, targets,
};
use crate::experiment::RunRow;
use crate::experiment::paper_drives::{
    ALL_SCENES, Deviation, DriveSummary, DriveTable, PaperTable, scene,
};

/// Returns a table of the paper as lines of text: measured values, published values, and findings.
#[must_use]
pub fn paper_text(table: &PaperTable) -> Vec<String> {
    let (tables, findings) = match table {
        PaperTable::Paths(table) => {
            (vec![path_table(table), reduction_text(table)], &table.findings)
        }
        PaperTable::Ablation(table) => (vec![step_table(table)], &table.findings),
        PaperTable::Drives(table) => {
            (vec![run_table(table), summary_table(table)], &table.findings)
        }
    };
    let tables = tables.iter().filter(|table| !table.rows.is_empty());
    let lines = tables.flat_map(Table::lines).chain(findings.iter().cloned());
    lines.chain([String::new()]).collect()
}

/// The paths of all variants.
pub(super) fn path_table(table: &PathTable) -> Table {
    let mut paths = Table::new(
        table.title.as_str(),
        &table.rows,
        &[
            ("scene or path", |row| row.task.clone()),
            ("variant", |row| row.label.to_owned()),
            ("length, m", |row| fixed(row.length_m, 2)),
            ("turns", |row| row.turns.to_string()),
            ("turns, smoothed", |row| {
                row.turns_smoothed.map_or_else(dash, |turns| turns.to_string())
            }),
            ("clearance, m", |row| fixed(row.min_clearance_m, 3)),
            ("time, ms", |row| significant(row.time_ms.p50_ms)),
            ("time, 95th percentile, ms", |row| significant(row.time_ms.p95_ms)),
            ("search, ms", |row| significant(row.stage_ms.search)),
            ("pruning, ms", |row| row.stage_ms.prune.map_or_else(dash, significant)),
            ("spline, ms", |row| row.stage_ms.smooth.map_or_else(dash, significant)),
            ("cells expanded", |row| row.expanded.to_string()),
            ("raw path over shortest, %", |row| fixed(100.0 * row.over_shortest, 2)),
        ],
    );
    paths.text_columns = &["scene or path", "variant"];
    let columns = paths.headers.len();
    paths.rows.extend(table.paper.iter().map(|row| published_path(row, columns)));
    paths
}

fn published_path(row: &PublishedRow, columns: usize) -> Vec<String> {
    let mut cells = vec![String::new(); columns];
    row.task.clone_into(&mut cells[0]);
    cells[1] = format!("paper: {}", row.variant);
    cells[2] = row.length_m.map_or_else(dash, |length| fixed(length, 2));
    cells[3] = row.turns.map_or_else(dash, |turns| turns.to_string());
    cells[6] = row.time_ms.map_or_else(dash, |time| fixed(time, 2));
    cells
}

fn dash() -> String {
    NONE.to_owned()
}

/// Header of the column that names a reduction.
const REDUCTION: &str = "change of the sums (mean change of the rows)";

/// The headers of a table of reductions.
fn reduction_headers() -> impl Iterator<Item = &'static str> {
    [REDUCTION].into_iter().chain(Measure::ALL.map(Measure::word))
}

/// The measured reductions with their names, and those of the paper with whether they are its.
fn named_reductions(table: &PathTable) -> impl Iterator<Item = (String, &Reduction, bool)> {
    let name = |found: &Reduction| {
        format!("{} against {}", label_of(found.variant), label_of(found.against))
    };
    let measured = table.reductions.iter().map(move |found| (name(found), found, false));
    measured.chain(table.paper_reductions.iter().map(|found| ("paper".to_owned(), found, true)))
}

/// Changes of the sums, coloured by whether they reach those of the paper.
pub(super) fn reduction_table(table: &PathTable) -> Markup {
    let targets = targets(&table.paper);
    let rows = html! {
        @for (name, found, is_published) in named_reductions(table) {
            tr class=[is_published.then_some("published-row")] {
                td { (name) }
                @for (measure, target) in targets {
                    (change(measure, found.of(measure), (!is_published).then_some(target)))
                }
            }
        }
    };
    let title = format!("Reductions: {}", table.title);
    scrolling_table(&title, Some("reductions"), reduction_headers(), &rows)
}

/// The cell of a reduction. With a target, it shows whether the reduction reaches it.
fn change(measure: Measure, reduced: Reduced, target: Option<f64>) -> Markup {
    let (class, mark) = match target.and_then(|target| reduced.reaches(target)) {
        Some(true) => ("good", " ✓"),
        Some(false) => ("missed", ""),
        None => ("", ""),
    };
    html! { td class=(class) { (change_text(measure, reduced)) (mark) } }
}

/// A reduction as a change in percent: of the sums, and in brackets the mean of the rows.
fn change_text(measure: Measure, reduced: Reduced) -> String {
    let signed = |reduction| signed(reduction, measure.decimals());
    let mean = reduced.mean_of_rows.map_or_else(String::new, |mean| format!(" ({})", signed(mean)));
    reduced.of_sums.map_or_else(dash, |of_sums| format!("{} %{mean}", signed(of_sums)))
}

/// Changes of the sums, as text.
fn reduction_text(table: &PathTable) -> Table {
    let row = |(name, found, _): (String, &Reduction, bool)| {
        let changes = Measure::ALL.map(|measure| change_text(measure, found.of(measure)));
        [name].into_iter().chain(changes).collect()
    };
    Table {
        headers: reduction_headers().map(str::to_owned).collect(),
        text_columns: &[REDUCTION],
        rows: named_reductions(table).map(row).collect(),
        ..Table::default()
    }
}

/// A reduction as a signed change in percent.
fn signed(reduction: f64, decimals: usize) -> String {
    let text = fixed(-100.0 * reduction, decimals);
    if reduction < 0.0 && text.bytes().any(|digit| matches!(digit, b'1'..=b'9')) {
        format!("+{text}")
    } else {
        text.replace('-', "−")
    }
}

/// The values after each step.
pub(super) fn step_table(table: &AblationTable) -> Table {
    let steps = Table::new(
        table.title.as_str(),
        &table.rows,
        &[
            ("step", |row| row.label.clone()),
            ("time, ms", |row| significant(row.time_ms)),
            ("length, m", |row| fixed(row.length_m, 2)),
            ("turns", |row| row.turns.to_string()),
            ("clearance, m", |row| fixed(row.min_clearance_m, 3)),
            ("cells expanded", |row| row.expanded.to_string()),
            ("raw paths over shortest, %", |row| fixed(100.0 * row.over_shortest, 2)),
            ("worst, %", |row| fixed(100.0 * row.worst_over_shortest, 1)),
        ],
    );
    Table { text_columns: &["step"], ..steps }
}

/// Sentences as a list.
pub(super) fn findings(sentences: &[String]) -> Markup {
    html! { ul class="findings" { @for sentence in sentences { li { (sentence) } } } }
}

/// Means and maxima of the drives in each scene.
pub(super) fn summary_table(table: &DriveTable) -> Table {
    let mut summaries = Table::new(
        format!("{}: means", table.title),
        &table.summaries,
        &[
            ("drives", |summary| match summary.scene.as_str() {
                ALL_SCENES => "all scenes".to_owned(),
                scene => scene.to_owned(),
            }),
            ("number", |summary| summary.runs.to_string()),
            ("reached", |summary| summary.reached.to_string()),
            ("contacts", |summary| summary.contacts.to_string()),
            ("mean |dx|, m", |summary| deviation_text(summary, false, 0)),
            ("mean |dy|, m", |summary| deviation_text(summary, false, 1)),
            ("mean |dyaw|, rad", |summary| deviation_text(summary, false, 2)),
            ("max |dx|, m", |summary| deviation_text(summary, true, 0)),
            ("max |dy|, m", |summary| deviation_text(summary, true, 1)),
            ("max |dyaw|, rad", |summary| deviation_text(summary, true, 2)),
            ("mean time, s", |summary| fixed(summary.time_s, 1)),
            ("mean distance, m", |summary| fixed(summary.travelled_m, 2)),
            ("smallest gap, m", |summary| fixed(summary.min_clearance_m, 3)),
            ("standing, %", |summary| fixed(100.0 * summary.waited_share, 1)),
            ("omega sign changes, 1/m", |summary| optional(summary.omega_sign_changes_per_m, 3)),
            ("time lost per person, s", |summary| optional(summary.time_lost_per_person_s, 2)),
        ],
    );
    summaries.text_columns = &["drives"];
    let columns = summaries.headers.len();
    let published = |name: &str, number: String, spread: [Deviation; 2]| {
        let mut cells = vec![name.to_owned(), number, String::new(), String::new()];
        let values = spread.into_iter().flat_map(Deviation::to_array);
        cells.extend(values.map(|value| fixed(value, 3)));
        cells.resize(columns, String::new());
        cells
    };
    let paper = &table.paper;
    let (of_rows, of_text) = (paper.of_rows, paper.of_text);
    summaries.rows.extend([
        published("rows of the paper", paper.rows.len().to_string(), [of_rows.mean, of_rows.max]),
        published("text of the paper", String::new(), [of_text.mean, of_text.max]),
    ]);
    summaries
}

/// The mean or greatest deviation of the drives along an axis.
fn deviation_text(summary: &DriveSummary, is_max: bool, axis: usize) -> String {
    let deviation = summary.deviation.map(|spread| if is_max { spread.max } else { spread.mean });
    fixed(deviation.map_or(f64::NAN, |deviation| deviation.to_array()[axis]), 4)
}

/// Every drive. The ten drives of the paper stand next to those of the first scene.
pub(super) fn run_table(table: &DriveTable) -> Table {
    let first_scene = table.rows.first().map(scene);
    let rows: Vec<(&RunRow, [f64; 3])> = table
        .rows
        .iter()
        .enumerate()
        .map(|(index, run)| {
            let is_first = Some(scene(run)) == first_scene;
            let paper = table.paper.rows.get(index).filter(|_| is_first);
            (run, paper.map_or([f64::NAN; 3], |row| row.to_array()))
        })
        .collect();
    let drives = Table::new(
        format!("{}: every drive", table.title),
        &rows,
        &[
            ("scene, seed", |(run, _)| format!("{}, {}", scene(run), run.seed)),
            ("|dx|, m", |(run, _)| fixed(Deviation::of(run).dx_m, 4)),
            ("|dy|, m", |(run, _)| fixed(Deviation::of(run).dy_m, 4)),
            ("|dyaw|, rad", |(run, _)| fixed(Deviation::of(run).dyaw_rad, 4)),
            ("paper |dx|", |(_, paper)| published_text(paper[0])),
            ("paper |dy|", |(_, paper)| published_text(paper[1])),
            ("paper |dyaw|", |(_, paper)| published_text(paper[2])),
            ("time, s", |(run, _)| fixed(run.time_s, 1)),
            ("distance, m", |(run, _)| fixed(run.travelled_m, 2)),
            ("path, m", |(run, _)| fixed(run.path_m.unwrap_or(f64::NAN), 2)),
            ("smallest gap, m", |(run, _)| fixed(run.min_clearance_m.unwrap_or(f64::NAN), 3)),
            ("to a pedestrian, m", |(run, _)| fixed(run.nearest_moving_m.unwrap_or(f64::NAN), 3)),
            ("plans", |(run, _)| run.plans.to_string()),
            ("standing, %", |(run, _)| fixed(100.0 * run.waited_share.unwrap_or(f64::NAN), 1)),
            ("longest stop, s", |(run, _)| fixed(run.longest_wait_s.unwrap_or(f64::NAN), 1)),
            ("omega sign changes, 1/m", |(run, _)| optional(run.omega_sign_changes_per_m, 3)),
            ("time lost to people, s", |(run, _)| optional(run.people_time_lost_s, 1)),
            ("end", |(run, _)| run.outcome.text().to_owned()),
        ],
    );
    Table { text_columns: &["scene, seed", "end"], ..drives }
}

/// A published value; empty if the paper has no drive.
fn published_text(value: f64) -> String {
    if value.is_finite() { fixed(value, 3) } else { String::new() }
}
