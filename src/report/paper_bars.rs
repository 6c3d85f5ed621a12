//! Where the time goes: a bar for each search, parted into its stages.

use maud::{Markup, html};

use super::figure::area_key;
use super::number::{coordinate, significant};
use super::panel::chart;
use crate::bench::paper::StepRow;

/// Left ends of the bars, their longest length, and their height with the space below, drawing units.
const LEFT: f64 = 172.0;
const LONGEST: f64 = 205.0;
const PITCH: f64 = 24.0;
const BAR: f64 = 15.0;

/// A bar: the search, and the sums of its median times up to each stage.
struct Bar<'a> {
    label: &'a str,
    up_to_ms: Vec<f64>,
}

/// The bars of a table of steps.
pub(super) fn figure(title: &str, rows: &[StepRow]) -> Markup {
    let mut bars: Vec<Bar> = Vec::new();
    for row in rows {
        match (row.stage, bars.last_mut()) {
            ("raw", _) | (_, None) => bars.push(Bar {
                label: &row.label,
                up_to_ms: vec![row.time_ms],
            }),
            (_, Some(bar)) => bar.up_to_ms.push(row.time_ms),
        }
    }
    let longest_ms = bars
        .iter()
        .filter_map(|bar| bar.up_to_ms.last())
        .fold(f64::MIN_POSITIVE, |longest, &time| longest.max(time));
    let height = PITCH * bars.len() as f64 + 4.0;
    let said: Vec<String> = bars
        .iter()
        .map(|bar| {
            let total = bar.up_to_ms.last().copied().unwrap_or(0.0);
            format!("{} {} ms", bar.label, significant(total))
        })
        .collect();
    let content = html! {
        @for (index, bar) in bars.iter().enumerate() {
            @let top = PITCH * index as f64 + 4.0;
            @let middle = coordinate(top + BAR / 2.0);
            @let at = |ms: f64| LEFT + ms / longest_ms * LONGEST;
            text class="end" x=(coordinate(LEFT - 6.0)) y=(middle) dy=".35em" { (bar.label.split(" (").next().unwrap_or_default()) }
            @for (stage, &end) in bar.up_to_ms.iter().enumerate() {
                @let begin = stage.checked_sub(1).map_or(0.0, |before| bar.up_to_ms[before]).min(end);
                rect class=(format!("stage-{stage}")) x=(coordinate(at(begin))) y=(coordinate(top))
                    width=(coordinate(at(end) - at(begin))) height=(BAR) {}
            }
            @let total = bar.up_to_ms.last().copied().unwrap_or(0.0);
            text x=(coordinate(at(total) + 6.0)) y=(middle) dy=".35em" { (significant(total)) " ms" }
        }
    };
    html! {
        figure {
            h3 { (title) }
            (chart(height, &format!("Sums of median times: {}.", said.join("; ")), &content))
            ul class="legend" {
                li { (area_key("stage-0", "search")) }
                li { (area_key("stage-1", "pruning")) }
                li { (area_key("stage-2", "spline")) }
            }
        }
    }
}
