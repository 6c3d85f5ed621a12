//! Findings of the drives: sentences made from their figures.

use std::collections::BTreeSet;

use super::deviation::COLUMNS;
use super::{
    ALL_SCENES, DriveSummary, DriveTable, MEAN_LIMIT_M, MEAN_LIMIT_RAD, MET_WITHIN_M,
    PublishedDeviations, Spread, scene,
};
use crate::experiment::{RunRow, TrafficKind};

/// Factor by which deviations should be smaller than the paper's.
const TARGET_RATIO: f64 = 10.0;
/// The paper prints thousandths: its text contradicts its rows where they differ by more than this.
const PRINTED: f64 = 0.001;
/// Units of the components.
const UNITS: [&str; 3] = ["m", "m", "rad"];

/// All findings of a table.
pub(super) fn findings(table: &DriveTable) -> Vec<String> {
    let paper = &table.paper;
    let [first, .., all] = &table.summaries[..] else {
        return Vec::new();
    };
    let mut findings = vec![ends(&table.rows, all)];
    findings.extend(distinct_traces(&table.rows));
    for summary in [first, all] {
        let compared = summary.deviation.map(|found| {
            let subject = if summary.scene == ALL_SCENES {
                "All scenes".to_owned()
            } else {
                format!("Scene {}", summary.scene)
            };
            accuracy(&subject, summary, &found, &paper.of_rows)
        });
        findings.extend(compared);
    }
    findings.push(limits(&table.summaries));
    if table.traffic != TrafficKind::None {
        findings.push(people(&table.rows, all));
    }
    findings.extend(waits(&table.rows, all));
    findings.extend(contradiction(paper));
    findings
}

fn ends(rows: &[RunRow], all: &DriveSummary) -> String {
    let count = |count: usize| match count {
        0 => "none".to_owned(),
        count if count == all.runs => "all".to_owned(),
        count => format!("{count} of {}", all.runs),
    };
    let standing = || rows.iter().filter(|run| run.collided() && !run.was_moving());
    let of_these = match all.contacts {
        0 => String::new(),
        _ => format!(" ({} of these while standing)", standing().count()),
    };
    format!(
        "{} drives: {} reached the goal, {} touched anything{of_these}; smallest gap to anything {:.3} m.",
        all.runs,
        count(all.reached),
        count(all.contacts),
        all.min_clearance_m
    )
}

/// States the number of distinct drives; identical drives add no evidence.
fn distinct_traces(rows: &[RunRow]) -> Option<String> {
    let digests: BTreeSet<&str> =
        rows.iter().filter_map(|run| run.trace_digest.as_deref()).collect();
    (digests.len() < rows.len()).then(|| {
        format!("Only {} of them differ: the seed has no effect on the others.", digests.len())
    })
}

fn accuracy(subject: &str, summary: &DriveSummary, found: &Spread, paper: &Spread) -> String {
    let (ours, theirs) = (found.mean.to_array(), paper.mean.to_array());
    let columns = [0, 1, 2];
    let each = |text: &dyn Fn(usize) -> String| columns.map(text).join(", ");
    let means = each(&|column| {
        let (name, value, unit) = (COLUMNS[column], ours[column], UNITS[column]);
        format!("{name} {value:.4} {unit}")
    });
    let largest = found.max.to_array();
    let largest = each(&|column| format!("{:.4}", largest[column]));
    let times = each(&|column| times_smaller(ours[column], theirs[column]));
    let is_good = |column: &usize| ours[*column] * TARGET_RATIO <= theirs[*column];
    let good: Vec<&str> =
        columns.iter().filter(|column| is_good(column)).map(|&column| COLUMNS[column]).collect();
    let verdict = match good.len() {
        3 => "all three ten times better than the paper's table".to_owned(),
        0 => "none of them ten times better than the paper's table".to_owned(),
        _ => format!("ten times better than the paper's table in {} only", good.join(" and ")),
    };
    let drives = match (summary.reached, summary.runs) {
        (1, 1) => "its one drive".to_owned(),
        (arrived, runs) if arrived == runs => format!("means of {runs} drives"),
        (arrived, runs) => format!("means of the {arrived} of {runs} drives that arrived"),
    };
    format!(
        "{subject}, {drives}: {means} (largest {largest}); {times} times smaller than the means of the paper's \
         rows: {verdict}."
    )
}

/// A ratio as text, rounded down: it must not look better than it is.
fn times_smaller(ours: f64, theirs: f64) -> String {
    let ratio = theirs / ours;
    if ratio < TARGET_RATIO {
        format!("{:.1}", libm::floor(10.0 * ratio) / 10.0)
    } else if ratio < 1000.0 {
        format!("{:.0}", libm::floor(ratio))
    } else {
        "1000 or more".to_owned()
    }
}

fn limits(summaries: &[DriveSummary]) -> String {
    let wanted = format!("{MEAN_LIMIT_M} m and {MEAN_LIMIT_RAD} rad");
    let beyond: Vec<&str> = summaries
        .iter()
        .filter(|summary| !summary.is_within_limits())
        .map(|summary| summary.scene.as_str())
        .collect();
    if beyond.is_empty() {
        format!("In every scene the mean deviations are within {wanted}.")
    } else {
        format!("Mean deviations beyond {wanted}, or no arrival: {}.", beyond.join(", "))
    }
}

fn people(rows: &[RunRow], all: &DriveSummary) -> String {
    let gaps = rows.iter().filter_map(|run| run.nearest_moving_m);
    let nearest_m = gaps.fold(f64::INFINITY, f64::min);
    format!(
        "A person came within {MET_WITHIN_M} m in {} of {} drives; the smallest gap to a person was {nearest_m:.3} m.",
        all.near_people, all.runs
    )
}

fn waits(rows: &[RunRow], all: &DriveSummary) -> Option<String> {
    let wait_s = |run: &RunRow| run.longest_wait_s.unwrap_or_default();
    // `max_by` returns the last of equal ones; from the end that is the first.
    let longest = rows.iter().rev().max_by(|a, b| wait_s(a).total_cmp(&wait_s(b)))?;
    Some(format!(
        "The robot stood for {:.1} % of the time, at most {:.1} s at a time, in {} with seed {}.",
        100.0 * all.waited_share,
        wait_s(longest),
        scene(longest),
        longest.seed
    ))
}

/// The differences between the paper's text and its rows.
fn contradiction(paper: &PublishedDeviations) -> Option<String> {
    let mut differences = Vec::new();
    let figures = [
        ("mean", paper.of_rows.mean, paper.of_text.mean),
        ("largest", paper.of_rows.max, paper.of_text.max),
    ];
    for (what, of_rows, of_text) in figures {
        let (of_rows, of_text) = (of_rows.to_array(), of_text.to_array());
        for (column, name) in COLUMNS.iter().enumerate() {
            let (rows, text, unit) = (of_rows[column], of_text[column], UNITS[column]);
            if (rows - text).abs() > PRINTED {
                differences
                    .push(format!("{what} {name} {text:.3} {unit}, its rows have {rows:.3}"));
            }
        }
    }
    (!differences.is_empty()).then(|| {
        format!(
            "The paper's text contradicts its table: {}. This comparison uses the rows.",
            differences.join("; ")
        )
    })
}
