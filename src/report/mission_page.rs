//! The page of missions: each with its outcome, player, map, charts and facts.

use maud::{Markup, html};

use super::figure::Table;
use super::map::Viewport;
use super::mission_latency::{self, Latency};
use super::number::{fixed, significant};
use super::page::{Extras, badge, document, page_header};
use super::sample_charts::{SampleRows, density_notes};
use super::svg::TOLERANCE;
use super::views::{EngineComparison, MissionView, Outcome, Report};
use super::{mission_charts, mission_map, player};
use crate::geometry::Point;

/// Returns the page as text, to be written to a file with the extension `.html`.
#[must_use]
pub fn html(report: &Report) -> String {
    let has_player = report.missions.iter().any(|view| view.playback.is_some());
    let content = html! {
        (page_header(report.title, report.intro, report.machine, &overview(&report.missions)))
        @for (index, view) in report.missions.iter().enumerate() { (section(view, index + 1)) }
        @if report.missions.is_empty() {
            section { p class="nothing" { "There is no mission in this report." } }
        }
        @if !report.comparisons.is_empty() { (comparisons(report.comparisons)) }
        @if !report.density.is_empty() || !report.density_command.is_empty() { (density(report)) }
        footer {
            p {
                "SI units. On the maps x points right and y up; yaw and turn rates are positive counter-clockwise \
                 (REP-103). Lines deviate from the data by at most " (TOLERANCE) " drawing units, less than a pixel. \
                 Tables of long runs show one tick in several."
            }
        }
        @if has_player { (player::script()) }
    };
    let extras = if has_player {
        Extras { style: player::STYLE, script_source: Some(player::script_source()) }
    } else {
        Extras::default()
    };
    document(report.title, &extras, &content)
}

/// The outcomes of several missions, with links to their sections.
fn overview(missions: &[MissionView]) -> Markup {
    html! {
        @if missions.len() > 1 {
            nav aria-label="Missions" { ol {
                @for (index, mission) in missions.iter().enumerate() {
                    li {
                        a href=(format!("#mission-{}", index + 1)) { (mission.title) }
                        " " (outcome_badges(&mission.outcome))
                    }
                }
            } }
        }
    }
}

fn section(mission: &MissionView, number: usize) -> Markup {
    let latency = Latency::new(mission);
    let view: Viewport = mission_map::viewport(mission);
    let playback = mission.playback.filter(|playback| !playback.is_empty());
    let rows = &mission.trace.rows;
    html! {
        section id=(format!("mission-{number}")) {
            h2 { (mission.title) }
            p { (outcome_badges(&mission.outcome)) }
            (results(&mission.outcome, latency.as_ref()))
            @if let Some(playback) = playback { (player::figure(mission, playback, &view)) }
            div class="map" { (mission_map::figure(mission, &view)) }
            div class="charts" {
                (mission_charts::motion(mission).markup())
                (mission_charts::gap(mission).markup())
                @for figure in mission_latency::figures(rows, latency.as_ref()) { (figure.markup()) }
            }
            (details(mission))
        }
    }
}

fn outcome_badges(outcome: &Outcome) -> Markup {
    let reached = if outcome.reached { "goal reached" } else { "goal not reached" };
    let contact = if outcome.collided { "contact" } else { "no contact" };
    html! { (badge(outcome.reached, reached)) " " (badge(!outcome.collided, contact)) }
}

fn results(outcome: &Outcome, latency: Option<&Latency>) -> Markup {
    let error = &outcome.final_error;
    let mut cards = vec![
        ("time", fixed(outcome.time_s, 1), "s"),
        ("distance driven", fixed(outcome.travelled_m, 2), "m"),
        ("smallest gap", fixed(outcome.min_clearance_m, 3), "m"),
        ("goal error", fixed(libm::hypot(error.x, error.y), 3), "m"),
        ("yaw error", fixed(error.yaw, 3), "rad"),
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
    let period = format!("{} s", significant(mission.control_period_s));
    let mut facts = vec![
        ("Engine", mission.engine.to_owned()),
        ("Control period", period),
        ("Ticks", mission.trace.rows.len().to_string()),
        ("Final error", error),
    ];
    let further = mission.facts.iter();
    facts.extend(further.map(|(name, value)| (name.as_str(), value.clone())));
    let paths = Table::new(
        "the global path in its stages",
        &[
            ("searched", mission.searched),
            ("pruned", mission.pruned),
            ("smoothed", mission.smoothed),
        ],
        &[
            ("stage", |(stage, _)| (*stage).to_owned()),
            ("points", |(_, path)| path.len().to_string()),
            ("length, m", |(_, path)| fixed(length_m(path), 2)),
        ],
    );
    html! {
        div class="details" {
            div {
                h3 { "Facts" }
                dl class="facts" { @for (name, value) in facts { dt { (name) } dd { (value) } } }
            }
            div { h3 { "Global path" } (paths.markup()) }
            div class="full-row" {
                h3 { "Reproduction" }
                pre tabindex="0" { code { (mission.command) } }
            }
        }
    }
}

fn length_m(path: &[Point]) -> f64 {
    path.windows(2).map(|ends| libm::hypot(ends[1].x - ends[0].x, ends[1].y - ends[0].y)).sum()
}

fn comparisons(comparisons: &[EngineComparison]) -> Markup {
    let agree = comparisons.iter().all(|engine| engine.agrees);
    let verdict = if agree { "all agree, bit for bit" } else { "they differ" };
    html! {
        section id="engines" {
            h2 { "Do the engines agree?" }
            p { (badge(agree, verdict)) }
            div class="scroll" tabindex="0" role="region" aria-label="engines" {
                table class="words" {
                    thead { tr {
                        th scope="col" { "engine" }
                        th scope="col" { "agrees" }
                        th scope="col" { "digest of all answers" }
                    } }
                    tbody { @for engine in comparisons { tr {
                        td { (engine.name) }
                        td { (if engine.agrees { "yes" } else { "no" }) }
                        td { code { (engine.digest) } }
                    } } }
                }
            }
        }
    }
}

fn density(report: &Report) -> Markup {
    let rows = SampleRows::new(report.density, report.quality, &[]);
    html! {
        section id="density" {
            h2 { "How many samples are possible, and how many are necessary?" }
            div class="charts" {
                (rows.latency().markup())
                @if !report.quality.is_empty() { (rows.quality().markup()) }
                (density_notes(report.density, report.skipped))
            }
            @if !report.density_command.is_empty() {
                h3 { "Reproduction" }
                pre tabindex="0" { code { (report.density_command) } }
            }
        }
    }
}
