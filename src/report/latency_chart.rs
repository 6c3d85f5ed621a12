//! How long the decisions took: over time, and how they are distributed.

use maud::{Markup, html};

use super::axis::Axis;
use super::figure::{Figure, Table, area_key, key, line_key, nothing_to_show};
use super::latency::Latency;
use super::motion_chart::time_axis;
use super::number::{coordinate, fixed, significant};
use super::panel::{Panel, chart};
use crate::runtime::TraceRow;

const HEIGHT: f64 = 300.0;

/// Bars of the distribution.
const BARS: usize = 80;

/// Both pictures.
pub(super) fn figures(rows: &[TraceRow], latency: Option<&Latency>) -> Markup {
    let Some(latency) = latency else {
        return nothing_to_show("Decision latency", "No decision of this run was timed.");
    };
    html! { (over_time(rows, latency)) (distribution(latency)) }
}

fn over_time(rows: &[TraceRow], latency: &Latency) -> Markup {
    let highest_ms = latency.slowest_ms().max(latency.deadline_ms.unwrap_or(0.0));
    let panel = Panel::across(
        32.0,
        226.0,
        time_axis(rows),
        // Room for the deadline's label above its line.
        Axis::logarithmic(latency.least_ms(), highest_ms * 1.5),
    );
    let picture = html! {
        (panel.axes(Some("Time, s"), "Latency of one decision, ms (logarithmic)"))
        (panel.dots("latency", latency.ticks.iter().copied()))
        @if let Some(deadline_ms) = latency.deadline_ms {
            (panel.level(deadline_ms, &format!("control period, {} ms", significant(deadline_ms))))
        }
    };
    let caption = late_in_words(latency);
    Figure {
        title: "Decision latency over time",
        picture: chart(
            HEIGHT,
            &format!(
                "Decision latency over time. {} {caption}",
                latency.in_words()
            ),
            &picture,
        ),
        legend: vec![
            key(
                &html! { path class="latency" d="M6 8h0M14 5h0M22 9h0" {} },
                "one decision, measured end to end",
            ),
            line_key("limit", "deadline"),
        ],
        caption,
        table: Table::of_ticks(
            "latency",
            &["time, s", "latency, ms"],
            &latency.ticks,
            |_, &(time, ms)| vec![fixed(time, 2), significant(ms)],
        ),
    }
    .markup()
}

fn late_in_words(latency: &Latency) -> String {
    let late = latency.deadline_ms.map(|deadline_ms| {
        let late = latency.ticks.iter().filter(|(_, ms)| *ms > deadline_ms);
        format!(
            "{} of {} decisions took longer than the control period.",
            late.count(),
            latency.summary.count
        )
    });
    let left_out = (latency.left_out > 0).then(|| {
        format!(
            "{} entries are no times or belong to no tick and are left out.",
            latency.left_out
        )
    });
    let sentences: Vec<String> = late.into_iter().chain(left_out).collect();
    sentences.join(" ")
}

fn distribution(latency: &Latency) -> Markup {
    let x = Axis::logarithmic(latency.least_ms(), latency.slowest_ms());
    let mut counts = [0_u32; BARS];
    for &(_, ms) in &latency.ticks {
        let place = x.fraction(ms) * BARS as f64;
        counts[(place.max(0.0) as usize).min(BARS - 1)] += 1;
    }
    let percent = |count: u32| 100.0 * f64::from(count) / latency.ticks.len() as f64;
    let highest = counts.iter().copied().max().map_or(0.0, percent);
    let panel = Panel::across(76.0, 182.0, x, Axis::rounded(0.0, highest));
    let bar_width = panel.width / BARS as f64;
    let marks = [
        ("p50", latency.summary.p50_ms),
        ("p99", latency.summary.p99_ms),
        ("slowest", latency.slowest_ms()),
    ];
    let picture = html! {
        (panel.axes(Some("Latency of one decision, ms (logarithmic)"), ""))
        text class="title" x="0" y="14" { "Share of decisions, %" }
        @for (index, &count) in counts.iter().enumerate().filter(|&(_, &count)| count > 0) {
            @let top = panel.y_at(percent(count));
            rect class="bar" x=(coordinate(panel.left + index as f64 * bar_width)) y=(coordinate(top))
                width=(coordinate(bar_width)) height=(coordinate(panel.bottom() - top)) {}
        }
        @for (row, &(name, ms)) in marks.iter().enumerate() {
            (percentile(&panel, 32.0 + 17.0 * row as f64, name, ms))
        }
    };
    Figure {
        title: "Distribution of the decision latency",
        picture: chart(
            HEIGHT,
            &format!(
                "Distribution of the decision latency. {}",
                latency.in_words()
            ),
            &picture,
        ),
        legend: vec![
            area_key("bar", "share of decisions"),
            line_key("percentile", "percentiles and the slowest"),
        ],
        caption: margin_in_words(latency),
        table: Table {
            title: "percentiles".to_owned(),
            heads: &["share of decisions not slower", "latency, ms"],
            rows: [0.5, 0.9, 0.95, 0.99, 0.999, 1.0]
                .iter()
                .map(|&share| {
                    let share_percent = format!("{} %", fixed(share * 100.0, 1));
                    vec![share_percent, significant(latency.quantile_ms(share))]
                })
                .collect(),
        },
    }
    .markup()
}

fn margin_in_words(latency: &Latency) -> String {
    latency.deadline_ms.map_or_else(String::new, |deadline_ms| {
        format!(
            "The control period of {} ms is {} times the slowest decision.",
            significant(deadline_ms),
            significant(deadline_ms / latency.slowest_ms())
        )
    })
}

/// A vertical line at a latency, with its label on a height of its own so that no two labels meet.
fn percentile(panel: &Panel, label_y: f64, name: &str, ms: f64) -> Markup {
    let x = panel.x_at(ms);
    let (side, shift) = if x > panel.left + panel.width / 2.0 {
        ("end halo", -5.0)
    } else {
        ("halo", 5.0)
    };
    html! {
        line class="percentile" x1=(coordinate(x)) x2=(coordinate(x))
            y1=(coordinate(label_y - 9.0)) y2=(coordinate(panel.bottom())) {}
        text class=(side) x=(coordinate(x + shift)) y=(coordinate(label_y)) {
            (name) " " (significant(ms)) " ms"
        }
    }
}
