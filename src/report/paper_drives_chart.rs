//! Deviations of every drive beside those that the paper prints, on logarithmic scales.

use maud::{Markup, html};

use super::axis::Axis;
use super::curves::Plot;
use super::figure::line_mark;
use super::number::{coordinate, significant};
use super::panel::Panel;
use super::paper_charts::STYLE;
use crate::experiment::paper_drives::{Deviation, DriveTable, MEAN_LIMIT_M, MEAN_LIMIT_RAD};

const HEIGHT: f64 = 330.0;
/// Deviations are drawn from this on, metres or radians: less is not seen, and a logarithmic scale has no zero.
const LEAST: f64 = 1e-4;
const OURS: &str = "deviation ours";
const PAPERS: &str = "deviation papers";

/// Where the robot stood, and how it was turned.
pub(super) fn plots(table: &DriveTable) -> Vec<Plot> {
    vec![positions(table), angles(table)]
}

fn plot(title: &'static str, content: Markup, alternative: String) -> Plot {
    let mark = |class: &str| html! { circle class=(class) cx="14" cy="7" r="4.5" {} };
    Plot {
        title,
        style: STYLE,
        content,
        height: HEIGHT,
        keys: vec![
            (mark(OURS), "here, all scenes".to_owned()),
            (mark(PAPERS), "the paper's ten".to_owned()),
            (
                line_mark("limit"),
                "largest mean that is accepted".to_owned(),
            ),
        ],
        alternative,
    }
}

/// Ours that reached the goal, with their number within their scene, and the paper's.
fn series(table: &DriveTable) -> [(&'static str, Vec<(usize, Deviation)>); 2] {
    let scenes = table.rows.chunk_by(|a, b| a.scene == b.scene);
    let ours = scenes.flat_map(|runs| runs.iter().enumerate());
    let ours = ours.filter(|(_, run)| run.reached());
    let paper = table.paper.rows.iter().enumerate();
    [
        (
            OURS,
            ours.map(|(index, run)| (index + 1, run.deviation))
                .collect(),
        ),
        (
            PAPERS,
            paper.map(|(index, row)| (index + 1, *row)).collect(),
        ),
    ]
}

fn positions(table: &DriveTable) -> Plot {
    let series = series(table);
    let place = |(_, off): &(usize, Deviation)| [seen(off.dx_m), seen(off.dy_m)];
    let most = largest(&series, |off| off.dx_m.max(off.dy_m));
    let axis = || Axis::logarithmic(LEAST, most.max(2.0 * MEAN_LIMIT_M));
    let panel = Panel::across(32.0, 256.0, axis(), axis());
    let at = panel.x_at(MEAN_LIMIT_M);
    let content = html! {
        (panel.axes(Some("|dx|, m (logarithmic)"), "|dy|, m (logarithmic)"))
        line class="limit" x1=(coordinate(at)) x2=(coordinate(at)) y1=(coordinate(panel.top)) y2=(coordinate(panel.bottom())) {}
        (level(&panel, MEAN_LIMIT_M))
        @for (class, rows) in &series { (circles(&panel, class, rows.iter().map(place))) }
    };
    let words = |off: &Deviation| libm::hypot(off.dx_m, off.dy_m);
    plot(
        "Off the goal: |dy| against |dx|",
        content,
        alternative("distance", "m", &series, words),
    )
}

fn angles(table: &DriveTable) -> Plot {
    let series = series(table);
    let place = |(number, off): &(usize, Deviation)| [*number as f64, seen(off.dyaw_rad)];
    let most = largest(&series, |off| off.dyaw_rad);
    let numbers = series.iter().flat_map(|(_, rows)| rows);
    let last = numbers.map(|&(number, _)| number).max().unwrap_or(1);
    let panel = Panel::across(
        32.0,
        256.0,
        Axis::exact(0.0, last as f64 + 1.0),
        Axis::logarithmic(LEAST, most.max(2.0 * MEAN_LIMIT_RAD)),
    );
    let content = html! {
        (panel.axes(Some("number of the drive"), "|dyaw|, rad (logarithmic)"))
        (level(&panel, MEAN_LIMIT_RAD))
        @for (class, rows) in &series { (circles(&panel, class, rows.iter().map(place))) }
    };
    let words = |off: &Deviation| off.dyaw_rad;
    plot(
        "Off in yaw: |dyaw| of each drive",
        content,
        alternative("angle", "rad", &series, words),
    )
}

/// What a mean may be, without words: they would hide the marks.
fn level(panel: &Panel, value: f64) -> Markup {
    let y = coordinate(panel.y_at(value));
    html! { line class="limit" x1=(coordinate(panel.left)) x2=(coordinate(panel.right())) y1=(y) y2=(y) {} }
}

/// A deviation as it is drawn.
const fn seen(value: f64) -> f64 {
    value.max(LEAST)
}

fn largest(series: &[(&str, Vec<(usize, Deviation)>)], figure: impl Fn(&Deviation) -> f64) -> f64 {
    let all = series.iter().flat_map(|(_, rows)| rows);
    all.map(|(_, off)| figure(off)).fold(0.0, f64::max)
}

fn circles(panel: &Panel, class: &str, places: impl Iterator<Item = [f64; 2]>) -> Markup {
    html! {
        g class=(class) {
            @for [x, y] in places {
                circle cx=(coordinate(panel.x_at(x))) cy=(coordinate(panel.y_at(y))) r="4" {}
            }
        }
    }
}

fn alternative(
    what: &str,
    unit: &str,
    series: &[(&str, Vec<(usize, Deviation)>)],
    figure: impl Fn(&Deviation) -> f64,
) -> String {
    let range = |rows: &[(usize, Deviation)]| {
        let values = || rows.iter().map(|(_, off)| figure(off));
        let least = values().fold(f64::INFINITY, f64::min);
        let most = values().fold(0.0, f64::max);
        format!("{} to {} {unit}", significant(least), significant(most))
    };
    let [ours, papers] = [0, 1].map(|index: usize| range(&series[index].1));
    format!("Deviation from the goal, {what}: here {ours}; in the paper {papers}.")
}
