//! The paper's tables with ours beside them, as tables of the page.

use maud::{Markup, html};

use super::figure::Table;
use super::number::{fixed, significant};
use crate::bench::paper::{
    AblationTable, Measure, PathRow, PathTable, PublishedRow, Reduced, StepRow, label_of, targets,
};

const PATH_HEADS: [&str; 12] = [
    "scene or path",
    "variant",
    "length, m",
    "turns",
    "turns, smoothed",
    "clearance, m",
    "time, ms",
    "95 % within, ms",
    "search, ms",
    "pruning + spline, ms",
    "cells expanded",
    "raw path over shortest, %",
];

const STEP_HEADS: [&str; 8] = [
    "step",
    "time, ms",
    "length, m",
    "turns",
    "clearance, m",
    "cells expanded",
    "raw paths over shortest, %",
    "the worst, %",
];

/// What was measured, and the paper's rows.
pub(super) fn path_table(table: &PathTable) -> Table<'static> {
    let rows = table.rows.iter().map(path_row);
    let rows = rows.chain(table.paper.iter().map(printed_row)).collect();
    Table {
        title: table.title.clone(),
        heads: &PATH_HEADS,
        rows,
    }
}

fn path_row(row: &PathRow) -> Vec<String> {
    let after = row.stage_ms.prune.zip(row.stage_ms.smooth);
    vec![
        row.task.clone(),
        row.label.to_owned(),
        fixed(row.length_m, 2),
        row.turns.to_string(),
        row.turns_smoothed
            .map_or_else(dash, |turns| turns.to_string()),
        fixed(row.min_clearance_m, 3),
        significant(row.time_ms.p50_ms),
        significant(row.time_ms.p95_ms),
        significant(row.stage_ms.search),
        after.map_or_else(dash, |(prune, smooth)| significant(prune + smooth)),
        row.expanded.to_string(),
        fixed(100.0 * row.over_shortest, 2),
    ]
}

fn printed_row(row: &PublishedRow) -> Vec<String> {
    let mut cells = vec![String::new(); PATH_HEADS.len()];
    row.task.clone_into(&mut cells[0]);
    cells[1] = format!("the paper's, {}", row.variant);
    cells[2] = row.length_m.map_or_else(dash, |length| fixed(length, 2));
    cells[3] = row.turns.map_or_else(dash, |turns| turns.to_string());
    cells[6] = row.time_ms.map_or_else(dash, |time| fixed(time, 2));
    cells
}

fn dash() -> String {
    "–".to_owned()
}

/// Changes of the sums, coloured by whether they reach the paper's.
pub(super) fn reduction_table(table: &PathTable) -> Markup {
    let targets = targets(&table.paper);
    html! {
        div class="scroll" tabindex="0" role="region" aria-label=(format!("Reductions: {}", table.title)) {
            table class="reductions" {
                thead { tr {
                    th scope="col" { "change of the sums (mean change of the rows)" }
                    @for measure in Measure::ALL { th scope="col" { (measure.word()) } }
                } }
                tbody {
                    @for found in &table.reductions { tr {
                        td { (label_of(&found.variant)) " against " (label_of(&found.against)) }
                        @for (measure, target) in targets {
                            (change(measure, found.of(measure), Some(target)))
                        }
                    } }
                    @for found in &table.paper_reductions { tr class="of-paper" {
                        td { "the paper's own" }
                        @for measure in Measure::ALL { (change(measure, found.of(measure), None)) }
                    } }
                }
            }
        }
    }
}

/// A reduction as a change; with a target, marked as reaching it or not.
fn change(measure: Measure, reduced: Reduced, target: Option<f64>) -> Markup {
    // Lengths differ by little.
    let decimals = if measure == Measure::Length { 2 } else { 1 };
    let Some(of_sums) = reduced.of_sums else {
        return html! { td { (dash()) } };
    };
    let reaches = target.map(|target| of_sums >= target - 5e-4);
    let (class, mark) = match reaches {
        Some(true) => ("good", " ✓"),
        Some(false) => ("short", ""),
        None => ("", ""),
    };
    html! {
        td class=(class) {
            (signed(of_sums, decimals)) " %"
            @if let Some(mean) = reduced.mean_of_rows { " (" (signed(mean, decimals)) ")" }
            (mark)
        }
    }
}

/// A reduction as a change in percent, with its sign.
fn signed(reduction: f64, decimals: usize) -> String {
    let text = fixed(-100.0 * reduction, decimals);
    if reduction < 0.0 && text.bytes().any(|digit| matches!(digit, b'1'..=b'9')) {
        format!("+{text}")
    } else {
        text.replace('-', "−")
    }
}

/// What each step earns.
pub(super) fn step_table(table: &AblationTable) -> Table<'static> {
    Table {
        title: table.title.clone(),
        heads: &STEP_HEADS,
        rows: table.rows.iter().map(step_row).collect(),
    }
}

fn step_row(row: &StepRow) -> Vec<String> {
    vec![
        row.label.clone(),
        significant(row.time_ms),
        fixed(row.length_m, 2),
        row.turns.to_string(),
        fixed(row.min_clearance_m, 3),
        row.expanded.to_string(),
        fixed(100.0 * row.over_shortest, 2),
        fixed(100.0 * row.worst_over_shortest, 1),
    ]
}

/// Sentences as a list.
pub(super) fn findings(sentences: &[String]) -> Markup {
    html! { ul class="findings" { @for sentence in sentences { li { (sentence) } } } }
}
