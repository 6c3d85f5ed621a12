//! The charts of the paper's experiments: times by stage, paths by angle, and deviations of the drives.

use super::chart::{Axis, Chart, Mark, Panel, Row, RowMark, XAxis, range};
use super::number::significant;
use super::svg::LegendEntry;
use crate::bench::paper::{PathRow, Stage, StepRow};
use crate::experiment::paper_drives::{
    Deviation, DriveTable, MEAN_LIMIT_M, MEAN_LIMIT_RAD, PaperTable, scene,
};

/// Name of the table whose paths are shown as bars.
const FIGURE_5: &str = "figure_5";
/// Classes of the stages of a search, and their names.
const STAGES: [(&str, &str); 3] =
    [("stage-0", "search"), ("stage-1", "pruning"), ("stage-2", "spline")];
/// Least deviation of the charts, m or rad. A logarithmic axis has no zero.
const MIN_DEVIATION: f64 = 1e-4;
const MEASURED: &str = "deviation measured";
const PUBLISHED: &str = "deviation published";

/// The charts of a table; none for a table that is shown by maps.
pub(super) fn charts(table: &PaperTable) -> Vec<Chart> {
    match table {
        PaperTable::Paths(table) if table.name == FIGURE_5 => vec![
            angles(
                ("(a) Planning time: sums of medians over the scenes", "ms"),
                &table.rows,
                |row| row.time_ms.p50_ms,
            ),
            angles(("(b) Length of the paths: sums over the scenes", "m"), &table.rows, |row| {
                row.length_m
            }),
        ],
        PaperTable::Paths(_) => Vec::new(),
        PaperTable::Ablation(table) => vec![stages(&table.rows)],
        PaperTable::Drives(table) => vec![positions(table), angle_errors(table)],
    }
}

/// The time of each search, divided into its stages. Rows hold the time up to the end of a stage.
fn stages(rows: &[StepRow]) -> Chart {
    let mut bars: Vec<(&str, Vec<f64>)> = Vec::new();
    for row in rows {
        match (row.stage, bars.last_mut()) {
            (Stage::Raw, _) | (_, None) => bars.push((&row.label, vec![row.time_ms])),
            (_, Some((_, ends))) => ends.push(row.time_ms),
        }
    }
    let legend = STAGES.map(|(class, name)| LegendEntry::area(class, name)).to_vec();
    let chart = bar_chart(("Planning time by stage: sums of median times", "ms"), &bars);
    Chart { legend, ..chart }
}

/// Sums over the scenes for each angle of the distance model (fig. 5).
fn angles(
    title_and_unit: (&'static str, &'static str),
    rows: &[PathRow],
    value: fn(&PathRow) -> f64,
) -> Chart {
    let mut bars: Vec<(&str, Vec<f64>)> = Vec::new();
    for row in rows {
        match bars.iter_mut().find(|(label, _)| *label == row.label) {
            Some((_, sum)) => sum[0] += value(row),
            None => bars.push((row.label, vec![value(row)])),
        }
    }
    bar_chart(title_and_unit, &bars)
}

/// A row for each bar: its label, and the positions at which its parts end.
fn bar_chart((title, unit): (&'static str, &'static str), bars: &[(&str, Vec<f64>)]) -> Chart {
    let row = |(label, ends): &(&str, Vec<f64>)| {
        let starts = [0.0].iter().chain(ends);
        let parts = starts.zip(ends).zip(STAGES);
        let parts = parts.map(|((start, end), (class, _))| (class, (end - start).max(0.0)));
        Row {
            group: 0,
            label: label.split(" (").next().unwrap_or_default().to_owned(),
            value: format!("{} {unit}", significant(ends.last().copied().unwrap_or(0.0))),
            mark: RowMark::Stack(parts.collect()),
        }
    };
    let longest = bars.iter().flat_map(|(_, ends)| ends).copied().fold(0.0, f64::max);
    let axis = (Axis::rounded(0.0, longest), unit);
    Chart::of_rows(title, axis, bars.iter().map(row).collect(), Vec::new())
}

/// The deviations of the drives that reached the goal, over their number within the scene, and those of the paper.
fn deviations(table: &DriveTable) -> [Vec<(usize, Deviation)>; 2] {
    let scenes = table.rows.chunk_by(|a, b| scene(a) == scene(b));
    let measured = scenes
        .flat_map(|runs| runs.iter().enumerate())
        .filter(|(_, run)| run.reached())
        .map(|(index, run)| (index + 1, Deviation::of(run)));
    let published = table.paper.rows.iter().enumerate();
    [measured.collect(), published.map(|(index, row)| (index + 1, *row)).collect()]
}

fn positions(table: &DriveTable) -> Chart {
    let all = deviations(table);
    let largest = all.iter().flatten().flat_map(|(_, off)| [off.dx_m, off.dy_m]);
    let axis = Axis::logarithmic(MIN_DEVIATION, largest.fold(2.0 * MEAN_LIMIT_M, f64::max));
    let alt_text = alt_text("distance", "m", &all, |off| libm::hypot(off.dx_m, off.dy_m));
    deviation_chart(
        ("Position error: |dy| against |dx|", "|dy|, m (logarithmic)", alt_text),
        XAxis::new(axis, "|dx|, m (logarithmic)"),
        axis,
        vec![Mark::Position(MEAN_LIMIT_M, None), Mark::Level(MEAN_LIMIT_M, None)],
        all.map(|of| of.iter().map(|(_, off)| [off.dx_m, off.dy_m].map(charted)).collect()),
    )
}

fn angle_errors(table: &DriveTable) -> Chart {
    let all = deviations(table);
    let largest = all.iter().flatten().map(|(_, off)| off.dyaw_rad);
    let most = largest.fold(2.0 * MEAN_LIMIT_RAD, f64::max);
    let last = all.iter().flatten().map(|&(number, _)| number).max();
    let axis = Axis::exact(0.0, last.unwrap_or(1) as f64 + 1.0);
    let alt_text = alt_text("angle", "rad", &all, |off| off.dyaw_rad);
    let point = |(number, off): &(usize, Deviation)| [*number as f64, charted(off.dyaw_rad)];
    deviation_chart(
        ("Yaw error: |dyaw| of each drive", "|dyaw|, rad (logarithmic)", alt_text),
        XAxis::new(axis, "number of the drive"),
        Axis::logarithmic(MIN_DEVIATION, most),
        vec![Mark::Level(MEAN_LIMIT_RAD, None)],
        all.map(|of| of.iter().map(point).collect()),
    )
}

/// A chart of measured and published deviations. `marks` are the limits.
fn deviation_chart(
    (title, y_title, alt_text): (&'static str, &str, String),
    x: XAxis,
    y: Axis,
    mut marks: Vec<Mark>,
    [measured, published]: [Vec<[f64; 2]>; 2],
) -> Chart {
    marks.push(Mark::Circles(MEASURED, 4.0, measured));
    marks.push(Mark::Circles(PUBLISHED, 4.0, published));
    Chart {
        legend: vec![
            LegendEntry::circle(MEASURED, 4.5, "measured, all scenes"),
            LegendEntry::circle(PUBLISHED, 4.5, "the ten drives of the paper"),
            LegendEntry::line("limit", "accepted mean"),
        ],
        ..Chart::of_panels(title, x, vec![Panel::new(y_title, 256.0, y, marks)], alt_text)
    }
}

/// A deviation that the chart can show.
const fn charted(value: f64) -> f64 {
    value.max(MIN_DEVIATION)
}

fn alt_text(
    name: &str,
    unit: &str,
    all: &[Vec<(usize, Deviation)>; 2],
    value: impl Fn(&Deviation) -> f64,
) -> String {
    let [measured, published] = all.each_ref().map(|rows| {
        let (least, most) =
            range(rows.iter().map(|(_, off)| value(off))).unwrap_or((f64::NAN, 0.0));
        format!("{} to {} {unit}", significant(least), significant(most))
    });
    format!("Deviation from the goal, {name}: measured {measured}, in the paper {published}.")
}
