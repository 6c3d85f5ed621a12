//! Runs and their groups as text.

use inbye::bench::text_table;
use inbye::experiment::{ContactCause, Group, RunOutcome, RunRow, WorldKind};

/// Columns of a table of groups.
const GROUP: [&str; 11] = [
    "name",
    "runs",
    "reached_share",
    "contacts_robot",
    "contacts_avoidable",
    "contacts_other",
    "timeouts",
    "failed",
    "mean_time_s",
    "mean_clearance_reached_m",
    "mean_score",
];

/// A table of groups.
pub fn group_table(groups: &[Group]) -> Vec<String> {
    let has_score = groups.iter().any(|group| group.mean_score.is_some());
    text_table(groups, if has_score { &GROUP } else { &GROUP[..10] })
}

/// One line for each run that did not reach its goal.
pub fn unreached(rows: &[RunRow]) -> impl Iterator<Item = String> {
    let unreached = rows.iter().filter(|row| !row.reached());
    unreached.map(|row| format!("  {}", run_text(row)))
}

/// A run in one line: how it ended, when, and why the goal was not reached.
pub fn run_text(row: &RunRow) -> String {
    let how = match (row.outcome, row.contact_cause) {
        (RunOutcome::Contact, Some(ContactCause::Avoidable)) => "was hit, avoidably,",
        (RunOutcome::Contact, Some(ContactCause::Other)) => "was hit",
        (outcome, _) => outcome.text(),
    };
    let path = row.path_m.map_or_else(String::new, |path_m| format!(" of {path_m:.1} m"));
    let why = row.reason.as_ref().map_or_else(String::new, |reason| format!(": {reason}"));
    format!(
        "{}: {how} after {:.1} s and {:.1} m{path}{why}",
        run_name(row),
        row.time_s,
        row.travelled_m
    )
}

/// World and seed of a run.
pub fn run_name(row: &RunRow) -> String {
    let is_numbered = matches!(row.kind, WorldKind::Barn | WorldKind::DynaBarn);
    let world = if is_numbered { "world " } else { "" };
    format!("{world}{}, seed {}", row.world, row.seed)
}
