//! Text of `inbye bench paper`.

use inbye::bench::paper::{
    AblationTable, Measure, PathRow, PathTable, PublishedRow, Reduced, Reduction, StepRow, label_of,
};

use inbye::experiment::paper_drives::PaperTable as Table;

use super::paper_drive_text;

/// Heads the rows of [`path_row`].
const PATH_HEADER: &str = "scene or path    variant                          length m  turns  smoothed  clearance m    p50 ms    p95 ms    \
    search    prune   smooth  expanded  raw over shortest";

/// Heads the rows of [`step_row`].
const STEP_HEADER: &str = "step                                             time ms   length m  turns  expanded  clearance m  over shortest  \
    worst";

/// A table, with the paper's values, the reductions and what follows.
pub fn table(table: &Table) -> Vec<String> {
    match table {
        Table::Paths(table) => paths(table),
        Table::Ablation(table) => steps(table),
        Table::Drives(table) => paper_drive_text::table(table),
    }
}

fn paths(table: &PathTable) -> Vec<String> {
    let mut lines = vec![table.title.clone(), PATH_HEADER.to_owned()];
    lines.extend(table.rows.iter().map(path_row));
    lines.extend(table.paper.iter().map(printed_row));
    if !table.reductions.is_empty() {
        lines.push(
            "change of the sums (mean change of the rows)                           time                length                 turns        turns smoothed"
                .to_owned(),
        );
        lines.extend(table.reductions.iter().map(reduction));
        lines.extend(
            table.paper_reductions.iter().map(|of_paper| figures("the paper's own", of_paper)),
        );
    }
    lines.extend(table.findings.iter().cloned());
    lines
}

fn path_row(row: &PathRow) -> String {
    let stage = |time: Option<f64>| number(time, 3);
    let smoothed = row.turns_smoothed.map(|turns| turns as f64);
    format!(
        "{:16} {:31} {:9.2} {:6} {:>9} {:12.3} {:9.3} {:9.3} {:9.3} {:>8} {:>8} {:9} {:>17}",
        row.task,
        row.label,
        row.length_m,
        row.turns,
        number(smoothed, 0),
        row.min_clearance_m,
        row.time_ms.p50_ms,
        row.time_ms.p95_ms,
        row.stage_ms.search,
        stage(row.stage_ms.prune),
        stage(row.stage_ms.smooth),
        row.expanded,
        format!("{:.2} %", 100.0 * row.over_shortest),
    )
}

fn printed_row(row: &PublishedRow) -> String {
    format!(
        "{:16} {:31} {:>9} {:>6} {:>9} {:>12} {:>9}",
        row.task,
        format!("the paper's, {}", row.variant),
        number(row.length_m, 2),
        number(row.turns.map(f64::from), 0),
        "",
        "",
        number(row.time_ms, 2),
    )
}

fn reduction(found: &Reduction) -> String {
    let (variant, against) = (label_of(found.variant), label_of(found.against));
    figures(&format!("{variant} against {against}"), found)
}

fn figures(what: &str, found: &Reduction) -> String {
    let columns =
        Measure::ALL.map(|measure| format!("{:>22}", changes(measure, found.of(measure))));
    format!("{what:53}{}", columns.join(""))
}

/// A reduction as a change in percent: of the sums, and in brackets the mean of the rows.
fn changes(measure: Measure, reduced: Reduced) -> String {
    // Lengths differ by little.
    let decimals = if measure == Measure::Length { 2 } else { 1 };
    let percent = |share: Option<f64>| {
        share.map_or_else(|| "-".to_owned(), |share| format!("{:+.decimals$}", -100.0 * share))
    };
    match reduced {
        Reduced { of_sums: None, .. } => "-".to_owned(),
        Reduced { of_sums, mean_of_rows } => {
            format!("{} % ({} %)", percent(of_sums), percent(mean_of_rows))
        }
    }
}

fn steps(table: &AblationTable) -> Vec<String> {
    let mut lines = vec![table.title.clone(), STEP_HEADER.to_owned()];
    lines.extend(table.rows.iter().map(step_row));
    lines.extend(table.findings.iter().cloned());
    lines
}

fn step_row(row: &StepRow) -> String {
    format!(
        "{:46} {:9.3} {:10.2} {:6} {:9} {:12.3} {:>14} {:>6}",
        row.label,
        row.time_ms,
        row.length_m,
        row.turns,
        row.expanded,
        row.min_clearance_m,
        format!("{:.2} %", 100.0 * row.over_shortest),
        format!("{:.1} %", 100.0 * row.worst_over_shortest),
    )
}

/// A value with this number of decimals; `-` without one.
pub fn number(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.decimals$}"))
}
