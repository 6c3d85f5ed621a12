//! What `inbye bench dynabarn` tells people.

use inbye::experiment::campaign::Row;
use inbye::experiment::dynabarn::{Culprit, DynaBarnRow, Summary};
use inbye::experiment::worlds::Verdict;

use super::worlds::in_one_line;

/// What the figures are worth beside published ones.
pub const SIMULATOR: &str = "inbye's own planar simulator, not Gazebo: no physics engine, but slip, lag, drift and \
    noise; contacts are exact; the cylinders go as in Gazebo, on a spline through their keyframes";

/// What came of the runs, how both shares are counted, and the runs that did not arrive.
pub fn tables(summary: &Summary, rows: &[&DynaBarnRow]) -> Vec<String> {
    let Summary {
        worlds,
        runs,
        succeeded,
        success,
        collided,
        by_robot,
        avoidable,
        other,
        timeout,
        failed,
        ..
    } = summary;
    let share = |share: Option<f64>| share.map_or("none".to_owned(), |share| format!("{share:.3}"));
    let time = |time_s: f64| format!(", in {time_s:.1} s on average");
    let in_time = summary.mean_time_s.map_or_else(String::new, time);
    let attributed = share(summary.success_attributed);
    let mut lines = vec![
        format!("worlds {worlds}, runs {runs}: {succeeded} arrived{in_time}"),
        format!("  success                 {success:.3}   every contact is a failure"),
        format!(
            "  success, attributed     {attributed}   without the runs whose contact was neither the robot's nor avoidable"
        ),
        format!("  contacts                {collided:5}"),
        format!("    driven into           {by_robot:5}   the robot closed the gap itself"),
        format!(
            "    run into, avoidable   {avoidable:5}   a steady command 2.5 s before would have kept clear"
        ),
        format!("    run into, other       {other:5}   none of those tried would have"),
        format!("  out of time             {timeout:5}"),
        format!("  given up                {failed:5}"),
        format!("Driven in {SIMULATOR}."),
    ];
    let missed = rows.iter().filter(|row| row.result != Verdict::Succeeded);
    lines.extend(missed.map(|row| format!("  {}", one_run(row))));
    lines
}

/// A run in one line.
pub fn one_run(row: &DynaBarnRow) -> String {
    let how = match (row.result, row.blame) {
        (Verdict::Succeeded, _) => "arrived",
        (Verdict::Collided, Culprit::Robot) => "drove into something",
        (Verdict::Collided, Culprit::Avoidable) => "was run into, avoidably,",
        (Verdict::Collided, _) => "was run into",
        (Verdict::Timeout, _) => "ran out of time",
        (Verdict::Failed, _) => "gave up",
    };
    let fault = row.fault.as_deref();
    in_one_line(row.key(), how, row.time_s, row.travelled_m, fault)
}
