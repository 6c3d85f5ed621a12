//! What `inbye bench barn` tells people.

use inbye::experiment::barn::{BarnRow, Outcome, PublishedMeans, Summary};
use inbye::experiment::campaign::Row;
use inbye::experiment::worlds::Verdict;

use super::worlds::in_one_line;

/// What the figures are worth beside published ones.
pub const SIMULATOR: &str = "inbye's own planar simulator, not Gazebo: no physics engine, but slip, lag, drift and noise; contacts are exact";

const HEADER: &str =
    "                                worlds   runs  success  collided  timeout  given up   score";

/// A table of what came of the runs, the published figures beside it, and the runs that did not arrive.
pub fn tables(summary: &Summary, rows: &[&BarnRow], max_speed: f64) -> Vec<String> {
    let mut lines = vec![HEADER.to_owned()];
    lines.push(ours(
        &format!("here, {max_speed} m/s at most"),
        &summary.all,
    ));
    if let Some(official) = &summary.official {
        lines.push(ours("  official worlds of these", official));
    }
    if let Some(published) = &summary.published {
        lines.push(theirs(published));
        lines.push(format!(
            "The published row was measured in Gazebo; the others in {SIMULATOR}."
        ));
    }
    lines.extend(rows.iter().copied().filter_map(story));
    lines
}

fn ours(title: &str, outcome: &Outcome) -> String {
    format!(
        "{title:30} {:7} {:6} {:8.3} {:9} {:8} {:9} {:7.4}",
        outcome.worlds,
        outcome.runs,
        outcome.success,
        outcome.collided,
        outcome.timeout,
        outcome.failed,
        outcome.score,
    )
}

fn theirs(published: &PublishedMeans) -> String {
    let share = |share: f64| format!("{:.1} %", share * 100.0);
    format!(
        "{:30} {:7} {:>6} {:8.3} {:>9} {:>8} {:>9} {:7.4}",
        "  published there, DWA 0.5 m/s",
        published.worlds,
        "-",
        published.success,
        share(published.collided),
        share(published.timeout),
        "-",
        published.score,
    )
}

/// Why a run did not arrive.
fn story(row: &BarnRow) -> Option<String> {
    (row.result != Verdict::Succeeded).then(|| format!("  {}", one_run(row)))
}

/// A run in one line.
pub fn one_run(row: &BarnRow) -> String {
    let how = match row.result {
        Verdict::Succeeded => "arrived",
        Verdict::Collided => "touched something",
        Verdict::Timeout => "ran out of time",
        Verdict::Failed => "gave up",
    };
    let fault = row.fault.as_deref();
    in_one_line(row.key(), how, row.time_s, row.travelled_m, fault)
}
