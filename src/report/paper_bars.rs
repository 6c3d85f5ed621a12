//! Bars side by side: where the time goes, and what an angle of the distance model makes of time and length.

use maud::html;

use super::curves::Plot;
use super::figure::area_mark;
use super::number::{coordinate, significant};
use super::paper_charts::STYLE;
use crate::bench::paper::{PathRow, StepRow};

/// Left ends of the bars, their longest length, and their height with the space below, drawing units.
const LEFT: f64 = 172.0;
const LONGEST: f64 = 205.0;
const PITCH: f64 = 24.0;
const BAR: f64 = 15.0;

/// A bar: what it stands for, and where each of its parts ends.
struct Bar<'a> {
    label: &'a str,
    ends: Vec<f64>,
}

impl Bar<'_> {
    fn total(&self) -> f64 {
        self.ends.last().copied().unwrap_or(0.0)
    }
}

/// Where the time goes, from a table of steps: a bar for each search, parted into its stages.
pub(super) fn stages(rows: &[StepRow]) -> Plot {
    let mut bars: Vec<Bar> = Vec::new();
    for row in rows {
        match (row.stage, bars.last_mut()) {
            ("raw", _) | (_, None) => bars.push(Bar {
                label: &row.label,
                ends: vec![row.time_ms],
            }),
            (_, Some(bar)) => bar.ends.push(row.time_ms),
        }
    }
    let stages = ["search", "pruning", "spline"].into_iter().enumerate();
    let keys = stages.map(|(stage, name)| (area_mark(&format!("stage-{stage}")), name.to_owned()));
    Plot {
        keys: keys.collect(),
        ..plot("Where the time goes: sums of median times", &bars, "ms")
    }
}

/// Fig. 5: sums over all scenes for each angle, of times and of lengths.
pub(super) fn angles(rows: &[PathRow]) -> Vec<Plot> {
    let summed = |figure: fn(&PathRow) -> f64| {
        let mut bars: Vec<Bar> = Vec::new();
        for row in rows {
            match bars.iter_mut().find(|bar| bar.label == row.label) {
                Some(bar) => bar.ends[0] += figure(row),
                None => bars.push(Bar {
                    label: row.label,
                    ends: vec![figure(row)],
                }),
            }
        }
        bars
    };
    let times = summed(|row| row.time_ms.p50_ms);
    let lengths = summed(|row| row.length_m);
    vec![
        plot(
            "(a) Time of planning: sums of medians over the scenes",
            &times,
            "ms",
        ),
        plot(
            "(b) Length of the paths: sums over the scenes",
            &lengths,
            "m",
        ),
    ]
}

/// The longest bar fills the width.
fn plot(title: &'static str, bars: &[Bar], unit: &str) -> Plot {
    let longest = bars
        .iter()
        .map(Bar::total)
        .fold(f64::MIN_POSITIVE, f64::max);
    let said: Vec<String> = bars
        .iter()
        .map(|bar| format!("{} {} {unit}", bar.label, significant(bar.total())))
        .collect();
    let content = html! {
        @for (index, bar) in bars.iter().enumerate() {
            @let top = PITCH * index as f64 + 4.0;
            @let middle = coordinate(top + BAR / 2.0);
            @let at = |value: f64| LEFT + value / longest * LONGEST;
            text class="end" x=(coordinate(LEFT - 6.0)) y=(middle) dy=".35em" { (bar.label.split(" (").next().unwrap_or_default()) }
            @for (stage, &end) in bar.ends.iter().enumerate() {
                @let begin = stage.checked_sub(1).map_or(0.0, |before| bar.ends[before]).min(end);
                rect class=(format!("stage-{stage}")) x=(coordinate(at(begin))) y=(coordinate(top))
                    width=(coordinate(at(end) - at(begin))) height=(BAR) {}
            }
            text x=(coordinate(at(bar.total()) + 6.0)) y=(middle) dy=".35em" { (significant(bar.total())) " " (unit) }
        }
    };
    Plot {
        title,
        style: STYLE,
        content,
        height: PITCH * bars.len() as f64 + 4.0,
        keys: Vec::new(),
        alternative: format!("{title}: {}.", said.join("; ")),
    }
}
