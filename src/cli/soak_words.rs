//! What `inbye bench soak` tells people.

use inbye::experiment::missions::{Comparison, Ending, MissionRow, Tally};
use inbye::experiment::{Part, SoakSummary};

pub(super) const HEADER: &str = "                              missions  reached  contacts: robot, other  given up  time up  \
    mean time s  mean gap m";

/// Tables of what came of the missions, and the story of each that did not arrive.
pub fn summary(
    summary: &SoakSummary,
    comparisons: &[Comparison],
    rows: &[&MissionRow],
) -> Vec<String> {
    let mut lines = vec![HEADER.to_owned(), tally("all", &summary.all)];
    for (title, parts) in [("by map", &summary.maps), ("by people", &summary.people)] {
        lines.push(format!("{title}:"));
        let part = |part: &Part| tally(&format!("  {}", part.name), &part.tally);
        lines.extend(parts.iter().map(part));
    }
    for (word, count) in &summary.all.faults {
        lines.push(format!("fault {word}: {count}"));
    }
    if let Some(speed) = summary.mean_speed_m_s {
        lines.push(format!(
            "mean speed   {speed:.2} m/s of the missions that arrived; {:.1} km driven in {:.1} h by all",
            summary.travelled_m / 1e3,
            summary.time_s / 3600.0
        ));
    }
    if let Some(error) = summary.final_error {
        lines.push(format!(
            "final error  mean {:.4} m and {:.4} rad, p95 {:.4} m and {:.4} rad",
            error.mean_m, error.mean_yaw_rad, error.p95_m, error.p95_yaw_rad
        ));
    }
    if summary.digests_compared > 0 {
        lines.push(format!(
            "traces       {} of {} equal on another engine",
            summary.digests_equal, summary.digests_compared
        ));
    }
    lines.extend(comparisons.iter().filter(|one| !one.equal).map(difference));
    let missed = rows.iter().filter(|row| row.result != Ending::Reached);
    lines.extend(missed.map(|row| story(row)));
    lines
}

pub(super) fn tally(title: &str, tally: &Tally) -> String {
    let number = |value: Option<f64>, decimals: usize| {
        value.map_or_else(|| "-".to_owned(), |value| format!("{value:.decimals$}"))
    };
    let share = format!("{:.1} %", tally.reached_share * 100.0);
    let contacts = format!("{}, {}", tally.contacts_robot, tally.contacts_other);
    format!(
        "{title:30}{:8} {share:>8} {contacts:>24} {:9} {:8} {:>12} {:>11}",
        tally.missions,
        tally.failed,
        tally.timeouts,
        number(tally.mean_time_s, 1),
        number(tally.mean_clearance_m, 3),
    )
}

fn difference(one: &Comparison) -> String {
    let digest = |digest: &Option<String>| digest.clone().unwrap_or_else(|| "no trace".to_owned());
    format!(
        "DIFFERS: {}, seed {}: {} gave {}, {} gave {}",
        one.map,
        one.seed,
        one.first,
        digest(&one.expected),
        one.engine,
        digest(&one.found)
    )
}

/// How a mission ended, in a line.
pub fn story(row: &MissionRow) -> String {
    let how = match row.result {
        Ending::Reached => "reached its goal",
        Ending::Failed => "gave up",
        Ending::Contact => "touched something",
        Ending::Timeout => "ran out of time",
    };
    let why = row
        .reason
        .as_ref()
        .map_or_else(String::new, |reason| format!(": {reason}"));
    format!(
        "  {}, seed {}: {how} after {:.1} s and {:.1} m of {:.1} m{why}",
        row.map, row.seed, row.time_s, row.travelled_m, row.path_m
    )
}
