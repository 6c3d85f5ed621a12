//! Plays a run back tick by tick: the robot, its lidar, the sampled trajectories, and the chosen command.
//!
//! This is the only part of a page that needs a script. The page's content policy allows this script and no other. The
//! pictures and tables of the page show the same run without it.

mod playback_json;
mod playback_recorder;

use maud::{Markup, PreEscaped, html};
use serde_json::{Value, json};

use super::map::Viewport;
use super::mission_page::MissionView;
use super::number::fixed;
use crate::runtime::{FaultEvents, TickEvent};
pub use playback_recorder::PlaybackRecorder;

/// The script of all players on a page.
pub(super) const SCRIPT: &str = include_str!("player.js");

/// The values shown next to the map: label, name in the script, unit, and class of one that is wider than a number.
const READINGS: [(&str, &str, &str, Option<&str>); 15] = [
    ("time", "time", "s", None),
    ("mode", "mode", "", None),
    ("fault", "fault", "", Some("full-line")),
    ("speed", "speed", "m/s", None),
    ("turn rate", "turn_rate", "rad/s", None),
    ("command", "command", "", Some("wide")),
    ("gap", "gap", "m", None),
    ("decision time", "decision_time", "ms", None),
    ("admissible", "admissible", "", None),
    ("heading", "heading", "rad", None),
    ("clearance", "clearance", "m", None),
    ("velocity", "velocity", "m/s", None),
    ("path", "path", "m", None),
    ("score", "score", "", None),
    ("plan", "plan", "", None),
];

/// Most faults in the list. The timeline and the readings show the others too.
const MAX_LISTED: usize = 200;

/// The style of a page with players.
pub(super) const STYLE: &str = include_str!("player.css");

/// The player of a mission. The section must also contain the map picture of the same viewport.
pub(super) fn figure(
    mission: &MissionView,
    playback: &PlaybackRecorder,
    view: &Viewport,
) -> Markup {
    // It may contain text of a GPU driver. `<` is the only character that could end the element.
    let json =
        playback_json::playback_json(mission, playback, view).to_string().replace('<', "\\u003c");
    let speeds = ["0.25", "0.5", "1", "2", "4", "8", "16"];
    let layers = ["follow", "lidar", "trajectories", "predictions"];
    html! {
        figure class="player" {
            h3 { "Playback" }
            noscript { p { "The playback needs a script. The pictures below show the same run." } }
            canvas class="map-canvas" role="img" tabindex="0"
                aria-label="The robot on the map at the selected time, with its lidar returns, the sampled trajectories coloured by score, the chosen trajectory, and the moving obstacles." {}
            div class="controls" {
                button type="button" data-action="back" aria-label="one tick back" { "◀" }
                button type="button" data-action="play" { "Play" }
                button type="button" data-action="forward" aria-label="one tick forward" { "▶" }
                input type="range" min="0" max=(playback.frames.len().saturating_sub(1)) value="0" step="1" aria-label="tick";
                label { "speed " select data-action="speed" aria-label="playback speed" {
                    @for speed in speeds { option value=(speed) selected[speed == "1"] { "×" (speed) } }
                } }
            }
            div class="controls" {
                @for layer in layers {
                    label { input type="checkbox" data-layer=(layer) checked; " " (layer) }
                }
            }
            dl class="readings" aria-live="off" {
                @for (label, name, unit, class) in READINGS {
                    div class=[class] { dt { (label) } dd { span data-reading=(name) { "–" } " " (unit) } }
                }
            }
            canvas class="timeline" role="img"
                aria-label=(format!("Speed, gap and decision time over the run, with a line at the selected time. {}", playback.faults.alt_text())) {}
            (playback.faults.list(playback.stride))
            script type="application/json" class="playback" { (PreEscaped(json)) }
        }
    }
}

/// A fault over consecutive ticks.
#[derive(Clone, Debug, PartialEq)]
struct Span {
    /// Index of its first tick.
    tick: usize,
    ticks: usize,
    /// Times of its first and last tick, s.
    from_s: f64,
    to_s: f64,
    text: String,
}

/// All faults of a drive, sorted by their first tick.
#[derive(Clone, Debug, Default)]
struct FaultList {
    spans: Vec<Span>,
    events: FaultEvents,
}

impl FaultList {
    /// Records the faults of a tick. Ticks are recorded in order, without gaps.
    fn record(&mut self, tick: usize, event: &TickEvent<'_>) {
        let time_s = event.row.time_s;
        for text in self.events.update(event) {
            let continues = |span: &&mut Span| span.tick + span.ticks == tick && span.text == text;
            if let Some(span) = self.spans.iter_mut().rev().find(continues) {
                span.ticks += 1;
                span.to_s = time_s;
            } else {
                self.spans.push(Span { tick, ticks: 1, from_s: time_s, to_s: time_s, text });
            }
        }
    }

    /// The faults for the script: all distinct texts, and for each fault its first frame, its last frame and the index of
    /// its text. A frame covers `stride` ticks.
    fn json(&self, stride: usize) -> Value {
        let mut texts: Vec<&str> = Vec::new();
        let mut spans: Vec<[usize; 3]> = Vec::new();
        for span in &self.spans {
            let index = texts.iter().position(|text| *text == span.text);
            let index = index.unwrap_or_else(|| {
                texts.push(&span.text);
                texts.len() - 1
            });
            let last = span.tick + span.ticks - 1;
            spans.push([span.tick / stride, last / stride, index]);
        }
        json!({ "texts": texts, "spans": spans })
    }

    /// A sentence for the text alternative of the timeline.
    fn alt_text(&self) -> String {
        match self.spans.len() {
            0 => "No faults.".to_owned(),
            1 => "One fault is marked; it is listed below.".to_owned(),
            count => format!("{count} faults are marked; they are listed below."),
        }
    }

    /// The list. Each entry is a button that selects the first tick of its fault.
    fn list(&self, stride: usize) -> Markup {
        let unlisted = self.spans.len().saturating_sub(MAX_LISTED);
        html! {
            div class="faults" {
                h4 { "Faults" }
                @if self.spans.is_empty() { p { "none" } } @else {
                    ol {
                        @for span in self.spans.iter().take(MAX_LISTED) {
                            li {
                                button type="button" data-frame=(span.tick / stride) {
                                    b { (fixed(span.from_s, 2)) " s" } " " (span.text)
                                    @if span.ticks > 1 { " (" (span.ticks) " ticks, until " (fixed(span.to_s, 2)) " s)" }
                                }
                            }
                        }
                    }
                    @if unlisted > 0 { p { (unlisted) " more faults are marked on the timeline above." } }
                }
            }
        }
    }
}
