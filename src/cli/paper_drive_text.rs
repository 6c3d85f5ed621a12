//! Text of the drives of `inbye bench paper`.

use inbye::experiment::RunRow;
use inbye::experiment::paper_drives::{Deviation, DriveSummary, DriveTable, Spread, scene};

use super::paper_text::number;

/// Heads the rows of [`run_row`].
const RUN_HEADER: &str = "scene      seed  |dx| m  |dy| m  |dyaw| rad    paper's |dx| |dy| |dyaw|  time s  driven m  path m  gap m  to person m   \
    plans  stood %  longest s  end";

/// Heads the rows of [`summary_row`].
const SUMMARY_HEADER: &str =
    "means (largest)            |dx| m             |dy| m         |dyaw| rad  reached  contacts";

/// Every drive with the paper's, the means, and the findings.
pub fn table(table: &DriveTable) -> Vec<String> {
    let mut lines = vec![table.title.clone(), RUN_HEADER.to_owned()];
    let first = table.rows.first().map(scene);
    for (index, run) in table.rows.iter().enumerate() {
        let of_first = Some(scene(run)) == first;
        let paper = table.paper.rows.get(index).filter(|_| of_first);
        lines.push(run_row(run, paper));
    }
    lines.push(SUMMARY_HEADER.to_owned());
    lines.extend(table.summaries.iter().map(summary_row));
    lines.push(spread_row("the paper's rows", &table.paper.of_rows));
    lines.push(spread_row("the paper's text", &table.paper.of_text));
    lines.extend(table.findings.iter().cloned());
    lines
}

fn run_row(run: &RunRow, paper: Option<&Deviation>) -> String {
    let [dx_m, dy_m, dyaw_rad] = Deviation::of(run).to_array();
    let printed = paper.map_or_else(String::new, |row| {
        row.to_array().map(|value| format!("{value:.3}")).join("  ")
    });
    format!(
        "{:9} {:5} {dx_m:7.4} {dy_m:7.4} {dyaw_rad:11.4} {printed:>27} {:7.1} {:9.2} {:>7} {:>6} {:>13} {:6} {:>8} {:>10}  {}",
        scene(run),
        run.seed,
        run.time_s,
        run.travelled_m,
        number(run.path_m, 2),
        number(run.min_clearance_m, 3),
        number(run.nearest_moving_m, 3),
        run.plans,
        number(run.waited_share.map(|share| 100.0 * share), 1),
        number(run.longest_wait_s, 1),
        run.outcome.text(),
    )
}

fn summary_row(summary: &DriveSummary) -> String {
    let (scene, runs) = (&summary.scene, summary.runs);
    let spread = summary.deviation.map_or_else(
        || format!("{scene:16} {:>56}", "no arrival"),
        |spread| spread_row(scene, &spread),
    );
    format!(
        "{spread} {:>8} {:>9}",
        format!("{}/{runs}", summary.reached),
        format!("{}/{runs}", summary.contacts)
    )
}

fn spread_row(whose: &str, spread: &Spread) -> String {
    let (mean, max) = (spread.mean.to_array(), spread.max.to_array());
    let columns = [0, 1, 2].map(|column| {
        let (mean, max) = (mean[column], max[column]);
        format!("{:>18}", format!("{mean:.4} ({max:.4})"))
    });
    format!("{whose:16} {}", columns.join(" "))
}
