//! The page of missions: each with its outcome, player, map, charts and facts.

use maud::{Markup, html};

use super::figure::{Table, scrolling_table};
use super::map::{PathStages, Viewport};
use super::mission_charts::{self, Latency};
use super::number::{fixed, optional, significant};
use super::page::{Tile, badge, document, page_header, tiles};
use super::player::PlaybackRecorder;
use super::sample_charts::{SampleRows, density_notes, density_tiles};
use super::svg::TOLERANCE;
use super::{map_pictures, player};
use crate::bench::{DensityRow, QualityRow, SkippedCell};
use crate::geometry::Point;
use crate::runtime::{Config, EarlyEnd, Mission, MissionEnd, MissionResult};

/// Titles of the sections that are not on a mission.
const ENGINES_TITLE: &str = "Do the engines agree?";
const DENSITY_TITLE: &str = "How many samples are possible, and how many are necessary?";

/// The content of a page on missions. All texts may hold any characters.
#[derive(Clone, Debug, Default)]
pub struct Report<'a> {
    /// The title.
    pub title: &'a str,
    /// The introduction. An empty line starts a new paragraph.
    pub intro: &'a str,
    /// Processor, adapter and system of the measurements; empty: unknown.
    pub machine: &'a str,
    /// The missions, in their order on the page.
    pub missions: Vec<MissionView<'a>>,
    /// The digests of all engines for the same problems; empty: no such section.
    pub comparisons: &'a [EngineComparison],
    /// The density benchmark; the section is left out if this and its command are empty.
    pub density: &'a [DensityRow],
    /// The cells that the density benchmark left out.
    pub skipped: &'a [SkippedCell],
    /// Regrets against the densest sampling; empty: no such chart.
    pub quality: &'a [QualityRow],
    /// The command that repeats the density benchmark; empty: unknown.
    pub density_command: &'a str,
}

/// One mission of a page. Numbers that are not finite are left out of the pictures; the texts show a dash.
#[derive(Clone, Debug)]
pub struct MissionView<'a> {
    /// Heading of the section.
    pub title: &'a str,
    /// The command that repeats the mission.
    pub command: &'a str,
    /// The mission.
    pub mission: &'a Mission,
    /// The settings of the robot.
    pub config: &'a Config,
    /// How the mission ended. The map shows the stages of its first plan.
    pub result: &'a MissionResult,
    /// The recorded ticks for the player; none: no player and no script.
    pub playback: Option<&'a PlaybackRecorder>,
    /// Further rows of the table of facts: name and value.
    pub facts: &'a [(String, String)],
}

impl<'a> MissionView<'a> {
    /// The control period, s, which is the deadline of a decision.
    pub(super) const fn control_period_s(&self) -> f64 {
        self.config.local.control_period_s
    }

    /// The stages of the first global path.
    pub(super) fn stages(&self) -> PathStages<'a> {
        let first = self.result.plans.first();
        first.map_or_else(PathStages::default, |plan| PathStages {
            searched: plan.raw.points(),
            pruned: plan.pruned.points(),
            smoothed: plan.smoothed.points(),
        })
    }
}

/// The answers of one engine to problems that all engines solved.
#[derive(Clone, Debug, PartialEq)]
pub struct EngineComparison {
    /// The name of the engine, with its adapter.
    pub name: String,
    /// The digest of its answers.
    pub digest: String,
    /// Whether its answers equal those of the reference, bit for bit.
    pub agrees: bool,
}

/// Returns the page as text, to be written to a file with the extension `.html`.
#[must_use]
pub fn html(report: &Report) -> String {
    let has_player = report.missions.iter().any(|view| view.playback.is_some());
    let content = html! {
        (page_header(report.title, report.intro, report.machine, &html! {
            @if !report.comparisons.is_empty() { p { (agreement(report.comparisons)) } }
            (contents(report))
        }))
        @for (index, view) in report.missions.iter().enumerate() { (section(view, index + 1)) }
        @if report.missions.is_empty() {
            section { p class="nothing" { "There is no mission in this report." } }
        }
        @if !report.comparisons.is_empty() { (comparisons(report.comparisons)) }
        @if has_density(report) { (density(report)) }
        footer {
            p {
                "SI units. On the maps x points right and y up; yaw and turn rates are positive counter-clockwise \
                 (REP-103). Lines deviate from the data by at most " (TOLERANCE) " drawing units, less than a pixel. \
                 Tables of long runs show one tick in several."
            }
        }
    };
    let (style, script) = if has_player { (player::STYLE, player::SCRIPT) } else { ("", "") };
    document(report.title, style, script, &content)
}

/// Whether all engines returned the same bits, in one statement.
fn agreement(comparisons: &[EngineComparison]) -> Markup {
    let agree = comparisons.iter().all(|engine| engine.agrees);
    let count = comparisons.len();
    let text = if agree { "engines returned the same bits" } else { "engines differ" };
    badge(agree, &format!("{count} {text}"))
}

/// The contents: all sections, each mission with its outcome and its parts.
fn contents(report: &Report) -> Markup {
    html! {
        nav aria-label="Contents" { ol {
            @for (index, mission) in report.missions.iter().enumerate() {
                @let id = section_id(index + 1);
                li {
                    a href=(format!("#{id}")) { (mission.title) }
                    " " (outcome_badges(mission.result))
                    ul {
                        @if recorded(mission).is_some() {
                            li { a href=(format!("#{id}-playback")) { "Playback" } }
                        }
                        @for part in ["Map", "Charts", "Facts", "Reproduction"] {
                            li { a href=(format!("#{id}-{}", part.to_lowercase())) { (part) } }
                        }
                    }
                }
            }
            @if !report.comparisons.is_empty() { li { a href="#engines" { (ENGINES_TITLE) } } }
            @if has_density(report) { li { a href="#density" { (DENSITY_TITLE) } } }
        } }
    }
}

fn section_id(number: usize) -> String {
    format!("mission-{number}")
}

/// The playback of a mission, if it has ticks.
fn recorded<'a>(mission: &MissionView<'a>) -> Option<&'a PlaybackRecorder> {
    mission.playback.filter(|playback| !playback.is_empty())
}

const fn has_density(report: &Report) -> bool {
    !report.density.is_empty() || !report.density_command.is_empty()
}

fn section(mission: &MissionView, number: usize) -> Markup {
    let id = section_id(number);
    let latency = Latency::new(mission);
    let view: Viewport = map_pictures::mission_viewport(mission);
    let playback = recorded(mission);
    let rows = &mission.result.trace.rows;
    html! {
        section id=(id) {
            h2 { (mission.title) }
            p { (outcome_badges(mission.result)) }
            (results(mission.result, latency.as_ref()))
            @if playback.is_some() {
                (player::figure(mission.mission, mission.config, playback, &view, &id))
            }
            div class="map" id=(format!("{id}-map")) { (map_pictures::mission_figure(mission, &view)) }
            div class="charts" id=(format!("{id}-charts")) {
                (mission_charts::motion(mission).figure())
                (mission_charts::gap(mission).figure())
                @for chart in mission_charts::latency(rows, latency.as_ref()) { (chart.figure()) }
            }
            (details(mission, &id, playback.is_some()))
        }
    }
}

fn outcome_badges(result: &MissionResult) -> Markup {
    let reached = match (result.end(), result.early_end) {
        _ if result.reached => "goal reached",
        (_, Some(EarlyEnd::Interrupted)) => "interrupted before the goal",
        (MissionEnd::Timeout, None) => "time limit before the goal",
        _ => "goal not reached",
    };
    let contact = if result.collided { "contact" } else { "no contact" };
    html! { (badge(result.reached, reached)) " " (badge(!result.collided, contact)) }
}

fn results(result: &MissionResult, latency: Option<&Latency>) -> Markup {
    let (x, y) = result.final_error_m;
    let mut cards: Vec<Tile> = vec![
        ("time".to_owned(), fixed(result.time_s, 1), "s"),
        ("distance driven".to_owned(), fixed(result.travelled_m, 2), "m"),
        ("smallest gap".to_owned(), fixed(result.min_clearance_m, 3), "m"),
        ("sign changes of omega".to_owned(), optional(result.omega_sign_changes_per_m(), 2), "1/m"),
        ("goal error".to_owned(), fixed(libm::hypot(x, y), 3), "m"),
        ("yaw error".to_owned(), optional(result.final_yaw_error, 3), "rad"),
    ];
    if let Some(Latency { summary, .. }) = latency {
        for (name, ms) in
            [("p50", summary.p50_ms), ("p99", summary.p99_ms), ("slowest", summary.max_ms)]
        {
            cards.push((format!("decision, {name}"), significant(ms), "ms"));
        }
    }
    tiles(&cards)
}

/// The facts, the table of paths and the command. A script can show a button that copies the command.
fn details(mission: &MissionView, id: &str, has_script: bool) -> Markup {
    let result = mission.result;
    let (x, y) = result.final_error_m;
    let yaw = optional(result.final_yaw_error, 4);
    let Mission { map, start, goal, .. } = mission.mission;
    let frame = map.frame();
    let mut facts = vec![
        (
            "Start",
            format!(
                "x {} m, y {} m, yaw {} rad",
                fixed(start.x, 3),
                fixed(start.y, 3),
                fixed(start.yaw, 4)
            ),
        ),
        ("Goal", format!("x {} m, y {} m", fixed(goal.position.x, 3), fixed(goal.position.y, 3))),
        (
            "Map",
            format!(
                "{} x {} cells of {} m",
                frame.width,
                frame.height,
                significant(frame.resolution_m)
            ),
        ),
        ("Engine", result.engine.clone()),
        ("Control period", format!("{} s", significant(mission.control_period_s()))),
        ("Ticks", result.trace.rows.len().to_string()),
        ("Final error", format!("x {} m, y {} m, yaw {yaw} rad", fixed(x, 4), fixed(y, 4))),
    ];
    let further = mission.facts.iter();
    facts.extend(further.map(|(name, value)| (name.as_str(), value.clone())));
    let stages = mission.stages();
    let paths = Table::new(
        "the global path in its stages",
        &[("searched", stages.searched), ("pruned", stages.pruned), ("smoothed", stages.smoothed)],
        &[
            ("stage", |(stage, _)| (*stage).to_owned()),
            ("points", |(_, path)| path.len().to_string()),
            ("length, m", |(_, path)| fixed(length_m(path), 2)),
        ],
    );
    html! {
        div class="details" {
            div id=(format!("{id}-facts")) {
                h3 { "Facts" }
                dl class="facts" { @for (name, value) in facts { dt { (name) } dd { (value) } } }
            }
            div { h3 { "Global path" } (paths.markup()) }
            div class="full-row" id=(format!("{id}-reproduction")) {
                h3 { "Reproduction" }
                pre tabindex="0" { code { (mission.command) } }
                @if has_script {
                    button type="button" class="copy" data-copy hidden { "Copy the command" }
                }
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
    let rows = html! {
        @for engine in comparisons { tr {
            td { (engine.name) }
            td { (if engine.agrees { "yes" } else { "no" }) }
            td { code { (engine.digest) } }
        } }
    };
    let headers = ["engine", "agrees", "digest of all answers"];
    html! {
        section id="engines" {
            h2 { (ENGINES_TITLE) }
            p { (badge(agree, verdict)) }
            (tiles(&engine_tiles(comparisons)))
            (scrolling_table("engines", Some("words"), headers, &rows))
        }
    }
}

/// How many engines returned the bits of the first.
fn engine_tiles(comparisons: &[EngineComparison]) -> [Tile; 2] {
    let agreeing = comparisons.iter().filter(|engine| engine.agrees).count();
    [
        ("engines compared".to_owned(), comparisons.len().to_string(), ""),
        ("with the same bits".to_owned(), agreeing.to_string(), ""),
    ]
}

fn density(report: &Report) -> Markup {
    let rows = SampleRows { density: report.density, quality: report.quality, closed_loop: &[] };
    html! {
        section id="density" {
            h2 { (DENSITY_TITLE) }
            (tiles(&density_tiles(report.density)))
            div class="charts" {
                (rows.latency().figure())
                @if !report.quality.is_empty() { (rows.quality().figure()) }
                (density_notes(report.density, report.skipped))
            }
            @if !report.density_command.is_empty() {
                h3 { "Reproduction" }
                pre tabindex="0" { code { (report.density_command) } }
            }
        }
    }
}
