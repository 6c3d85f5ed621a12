//! Plays a run back tick by tick: the robot, its lidar, the sampled trajectories, and the chosen command.
//!
//! This is the only part of a page that needs a script. The page's content policy allows this script and no other. The
//! pictures and tables of the page show the same run without it.

mod event_list;
mod legend;
#[cfg(feature = "server")]
mod live_page;
mod playback_json;
pub(super) mod playback_recorder;
mod protection;
mod readings;

use event_list::EventList;
use maud::{Markup, PreEscaped, html};
use protection::ProtectionEvents;

use super::map::Viewport;
use crate::runtime::{Config, FaultEvents, Mission, TickEvent};
#[cfg(feature = "server")]
pub(crate) use live_page::{KnownPlayback, LivePage};
pub use playback_recorder::PlaybackRecorder;

/// Joins the scripts that all players need with that which starts them.
macro_rules! script_with {
    ($start:literal) => {
        concat!(
            include_str!("script/playback.js"),
            include_str!("script/drawing.js"),
            include_str!("script/view.js"),
            include_str!("script/map.js"),
            include_str!("script/timeline.js"),
            include_str!("script/links.js"),
            include_str!("script/copy.js"),
            include_str!("script/player.js"),
            include_str!($start),
        )
    };
}
#[cfg(feature = "server")]
use script_with;

/// The script of all players on a page.
pub(super) const SCRIPT: &str = script_with!("script/start.js");

/// The script of buttons that copy the text next to them.
#[cfg(feature = "playground")]
pub(crate) const COPY_SCRIPT: &str = include_str!("script/copy.js");

/// The style of a page with players.
pub(super) const STYLE: &str = include_str!("player.css");

/// The keys of the map, and their effects.
const KEYS: [(&str, &str); 9] = [
    ("Space", "play or pause"),
    ("← →", "one tick back or forward"),
    ("Home, End", "first or last tick"),
    ("+ −", "zoom in or out"),
    ("Shift + arrows", "move the map"),
    ("F", "follow the robot, or stop following"),
    ("W", "whole map"),
    ("0", "reset: follow the robot at the first zoom"),
    ("?", "show or hide this list, from anywhere in the player"),
];

/// The player of a mission. The section must have an identifier, and contain the map picture of the same viewport. A
/// running drive has no playback yet.
pub(super) fn figure(
    mission: &Mission,
    config: &Config,
    playback: Option<&PlaybackRecorder>,
    view: &Viewport,
    section_id: &str,
) -> Markup {
    let mut json = playback_json::drive_json(mission, config, view);
    if let Some(playback) = playback {
        json["part"] = playback_json::part_json(&playback.whole(), view);
    }
    // It may contain text of a GPU driver. `<` is the only character that could end the element.
    let json = json.to_string().replace('<', "\\u003c");
    let last = playback.map_or(0, |playback| playback.frames.len().saturating_sub(1));
    html! {
        figure class="player" id=(format!("{section_id}-playback")) {
            h3 { "Playback" }
            noscript { p { "The playback needs a script. The pictures below show the same run." } }
            div class="stage" {
                div class="screen" {
                    canvas class="map-canvas" role="img" tabindex="0"
                        aria-label="The robot on the map at the selected time, with its lidar returns, the sampled trajectories coloured by score, the chosen trajectory, and the moving obstacles." {}
                    (view_controls())
                    (time_controls(last, playback.is_none()))
                    canvas class="timeline" role="img" aria-label=(timeline_text(playback)) {}
                    div class="controls" {
                        button type="button" data-action="link" { "Copy link to this moment" }
                        code class="moment-link" hidden {}
                    }
                }
                div class="side" {
                    (readings::readings(section_id))
                    (legend::legend(mission, view))
                    (key_help())
                    div class="event-lists" {
                        @if let Some(playback) = playback {
                            (event_lists(&playback.faults, &playback.protection, playback.shape.stride))
                        }
                    }
                }
            }
            script type="application/json" class="playback" { (PreEscaped(json)) }
        }
    }
}

/// The text alternative of the strip charts.
fn timeline_text(playback: Option<&PlaybackRecorder>) -> String {
    let events = playback.map(|playback| {
        format!(" {} {}", playback.faults.alt_text(), playback.protection.alt_text())
    });
    format!(
        "Speed, turn rate, gap and decision time over the run, with a line and the values at the selected time.{}",
        events.unwrap_or_default()
    )
}

/// The lists of faults and of actions of the protective layer.
fn event_lists(faults: &FaultList, protection: &ProtectionEvents, stride: usize) -> Markup {
    html! {
        div class="events faults" {
            h4 { "Faults" }
            (faults.list.list("faults", stride))
        }
        (protection.lists(stride))
    }
}

fn view_controls() -> Markup {
    let buttons = [
        ("zoom-in", "+", "zoom in"),
        ("zoom-out", "−", "zoom out"),
        ("whole", "Whole map", "show the whole map"),
        ("reset", "Reset view", "follow the robot at the first zoom"),
    ];
    html! {
        div class="controls" role="group" aria-label="View of the map" {
            @for (action, text, label) in buttons {
                button type="button" data-action=(action) aria-label=(label) title=(label) { (text) }
            }
            label { input type="checkbox" data-action="follow" checked; " follow the robot" }
        }
    }
}

fn time_controls(last: usize, is_live: bool) -> Markup {
    let speeds = ["0.25", "0.5", "1", "2", "4", "8", "16"];
    html! {
        div class="controls" role="group" aria-label="Time" {
            button type="button" data-action="back" aria-label="one tick back" { "◀" }
            button type="button" data-action="play" { "Play" }
            button type="button" data-action="forward" aria-label="one tick forward" { "▶" }
            @if is_live { button type="button" data-action="live" aria-pressed="true" { "Newest" } }
            input type="range" data-action="seek" min="0" max=(last) value="0" step="1" aria-label="tick";
            label { "speed " select data-action="speed" aria-label="playback speed" {
                @for speed in speeds { option value=(speed) selected[speed == "1"] { "×" (speed) } }
            } }
        }
    }
}

/// The list of the keys and of what a pointer does.
fn key_help() -> Markup {
    html! {
        details class="key-help" {
            summary { "Keyboard and pointer (" kbd { "?" } ")" }
            p { "Drag the map to move it; use the wheel or two fingers to zoom. Press or drag on the charts to select a time. The keys work while the map has the focus." }
            dl class="facts" { @for (keys, effect) in KEYS { dt { kbd { (keys) } } dd { (effect) } } }
        }
    }
}

/// All faults of a drive.
#[derive(Clone, Debug, Default)]
struct FaultList {
    list: EventList,
    events: FaultEvents,
}

impl FaultList {
    /// Records the faults of a tick. Ticks are recorded in order, without gaps.
    fn record(&mut self, tick: usize, event: &TickEvent<'_>) {
        for text in self.events.update(event) {
            self.list.record(tick, event.row.time_s, text, None);
        }
    }

    /// A sentence for the text alternative of the timeline.
    fn alt_text(&self) -> String {
        match self.list.len() {
            0 => "No faults.".to_owned(),
            1 => "One fault is marked; it is listed below.".to_owned(),
            count => format!("{count} faults are marked; they are listed below."),
        }
    }
}
