//! One mission: what came of it, the map, and the charts.

use maud::{Markup, html};

use super::figure::Table;
use super::latency::Latency;
use super::number::{fixed, significant};
use super::{MissionView, Outcome, gap_chart, latency_chart, map_picture, motion_chart, player};
use crate::geometry::Point;

pub(super) fn section(mission: &MissionView, number: usize) -> Markup {
    let latency = Latency::of(mission);
    let view = map_picture::viewport(mission);
    let reel = mission.reel.filter(|reel| !reel.is_empty());
    html! {
        section id=(format!("mission-{number}")) {
            h2 { (mission.title) }
            p { (verdict(&mission.outcome)) }
            (results(&mission.outcome, latency.as_ref()))
            @if let Some(reel) = reel { (player::figure(mission, reel, &view)) }
            div class="map" { (map_picture::figure(mission, &view)) }
            div class="charts" {
                (motion_chart::figure(mission))
                (gap_chart::figure(mission))
                (latency_chart::figures(&mission.trace.rows, latency.as_ref()))
            }
            (details(mission))
        }
    }
}

/// A short statement marked as good or bad, by colour and by sign.
pub(super) fn badge(good: bool, text: &str) -> Markup {
    let (class, sign) = if good {
        ("badge good", "✓")
    } else {
        ("badge bad", "✗")
    };
    html! { span class=(class) { (sign) " " (text) } }
}

/// Whether the goal was reached, and whether anything was touched.
pub(super) fn verdict(outcome: &Outcome) -> Markup {
    let (reached, contact) = (
        if outcome.reached {
            "goal reached"
        } else {
            "goal not reached"
        },
        if outcome.collided {
            "contact"
        } else {
            "no contact"
        },
    );
    html! { (badge(outcome.reached, reached)) " " (badge(!outcome.collided, contact)) }
}

fn results(outcome: &Outcome, latency: Option<&Latency>) -> Markup {
    let error = &outcome.final_error;
    let mut cards = vec![
        ("time", fixed(outcome.time_s, 1), "s"),
        ("travelled", fixed(outcome.travelled_m, 2), "m"),
        ("smallest gap", fixed(outcome.min_clearance_m, 3), "m"),
        ("off the goal", fixed(libm::hypot(error.x, error.y), 3), "m"),
        ("off in yaw", fixed(error.yaw, 3), "rad"),
    ];
    if let Some(Latency { summary, .. }) = latency {
        cards.push(("decision, p50", significant(summary.p50_ms), "ms"));
        cards.push(("decision, p99", significant(summary.p99_ms), "ms"));
        cards.push(("decision, slowest", significant(summary.max_ms), "ms"));
    }
    html! {
        dl class="cards" {
            @for (name, value, unit) in cards {
                div { dt { (name) } dd { (value) " " span { (unit) } } }
            }
        }
    }
}

fn details(mission: &MissionView) -> Markup {
    let error = &mission.outcome.final_error;
    let error = format!(
        "x {} m, y {} m, yaw {} rad",
        fixed(error.x, 4),
        fixed(error.y, 4),
        fixed(error.yaw, 4)
    );
    let mut rows = vec![
        ("Engine", mission.engine.to_owned()),
        (
            "Control period",
            format!("{} s", significant(mission.control_period_s)),
        ),
        ("Ticks", mission.trace.rows.len().to_string()),
        ("Final error", error),
    ];
    rows.extend(
        mission
            .facts
            .iter()
            .map(|(name, value)| (name.as_str(), value.clone())),
    );
    let paths = [
        ("as searched", mission.searched),
        ("redundant nodes removed", mission.pruned),
        ("smoothed", mission.smoothed),
    ];
    let paths = Table {
        title: "the global path, stage by stage".to_owned(),
        heads: &["stage", "points", "length, m"],
        rows: paths
            .iter()
            .map(|(stage, path)| {
                vec![
                    (*stage).to_owned(),
                    path.len().to_string(),
                    fixed(length_m(path), 2),
                ]
            })
            .collect(),
    };
    html! {
        div class="details" {
            div {
                h3 { "Facts" }
                dl class="facts" { @for (name, value) in rows { dt { (name) } dd { (value) } } }
            }
            div {
                h3 { "Global path" }
                (paths.markup())
            }
            div class="whole-row" {
                h3 { "The same again" }
                pre tabindex="0" { code { (mission.command) } }
            }
        }
    }
}

fn length_m(path: &[Point]) -> f64 {
    path.windows(2)
        .map(|ends| libm::hypot(ends[1].x - ends[0].x, ends[1].y - ends[0].y))
        .sum()
}
