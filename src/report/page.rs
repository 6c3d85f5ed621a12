//! The page around the missions and charts.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::samples_axis::samples_axis;
use super::simplify::TOLERANCE;
use super::{EngineComparison, MissionView, Report, density_chart, mission, player, quality_chart};

/// The style of all pages.
pub const STYLE: &str = concat!(
    include_str!("colours.css"),
    include_str!("drawing.css"),
    include_str!("chart.css"),
    include_str!("map.css"),
    include_str!("drive_map.css"),
    include_str!("style.css")
);

/// What the page may load: nothing but what it holds.
const POLICY: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'";

/// What a page adds to all pages' own: a style, and the scripts that it may run.
#[derive(Default)]
pub(super) struct Extras {
    pub(super) style: &'static str,
    pub(super) script_source: Option<String>,
}

impl Extras {
    /// Nothing but a style.
    pub(super) const fn of_style(style: &'static str) -> Self {
        Self {
            style,
            script_source: None,
        }
    }
}

/// The page as text, complete, to be written to a file that ends in `.html`.
#[must_use]
pub fn html(report: &Report) -> String {
    let plays = report.missions.iter().any(|view| view.reel.is_some());
    let content = html! {
        (head(report))
        @for (index, view) in report.missions.iter().enumerate() {
            (mission::section(view, index + 1))
        }
        @if report.missions.is_empty() {
            section { p class="nothing" { "There is no mission in this report." } }
        }
        @if !report.comparisons.is_empty() { (comparisons(report.comparisons)) }
        @if !report.density.is_empty() || !report.density_command.is_empty() { (density(report)) }
        (foot())
        @if plays { (player::script()) }
    };
    let extras = if plays {
        Extras {
            style: player::STYLE,
            script_source: Some(player::script_source()),
        }
    } else {
        Extras::default()
    };
    document(report.title, &extras, &content)
}

/// A whole page: a title, what it adds to all pages' own, and what it shows.
pub(super) fn document(title: &str, extras: &Extras, content: &Markup) -> String {
    let scripts = extras.script_source.iter();
    let policy = scripts.fold(POLICY.to_owned(), |policy, source| {
        format!("{policy}; script-src {source}")
    });
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(policy);
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) }
                style { (PreEscaped(STYLE)) (PreEscaped(extras.style)) }
            }
            body { main { (content) } }
        }
    }
    .into_string()
}

fn head(report: &Report) -> Markup {
    html! {
        header {
            h1 { (report.title) }
            @for paragraph in report.intro.split("\n\n").filter(|paragraph| !paragraph.trim().is_empty()) {
                p { (paragraph) }
            }
            @if !report.machine.is_empty() { p class="machine" { "Measured on: " (report.machine) } }
            @if report.missions.len() > 1 { (overview(&report.missions)) }
        }
    }
}

/// The missions at a glance, each linked to its section.
fn overview(missions: &[MissionView]) -> Markup {
    html! {
        nav aria-label="Missions" { ol {
            @for (index, mission) in missions.iter().enumerate() {
                li {
                    a href=(format!("#mission-{}", index + 1)) { (mission.title) }
                    " "
                    (mission::verdict(&mission.outcome))
                }
            }
        } }
    }
}

fn comparisons(comparisons: &[EngineComparison]) -> Markup {
    let agree = comparisons.iter().all(|engine| engine.agrees);
    html! {
        section id="engines" {
            h2 { "Do the engines agree?" }
            p { (mission::badge(agree, if agree { "all agree, bit for bit" } else { "they differ" })) }
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
    let samples = samples_axis(report.density, report.quality, &[]);
    html! {
        section id="density" {
            h2 { "How dense can the samples be, and how dense need they be?" }
            div class="charts" {
                (density_chart::figure(report.density, samples))
                @if !report.quality.is_empty() { (quality_chart::figure(report.quality, samples)) }
                (density_chart::beside(report.density, report.skipped))
            }
            @if !report.density_command.is_empty() {
                h3 { "The same again" }
                pre tabindex="0" { code { (report.density_command) } }
            }
        }
    }
}

fn foot() -> Markup {
    html! {
        footer {
            p {
                "SI units. On the maps x points right and y up; yaw and turn rates count counter-clockwise (REP-103). \
                 Drawn lines keep within " (TOLERANCE) " drawing units of the data, less than a pixel; tables of long \
                 runs show one tick in so many."
            }
        }
    }
}
