//! Plays a run back tick by tick: the robot, its lidar, the sampled trajectories, and the chosen command.
//!
//! This is the only part of a page that needs a script. The page's content policy allows this script and no other. The
//! pictures and tables of the page show the same run without it.

mod event_list;
mod playback_json;
pub(super) mod playback_recorder;
mod protection;

use event_list::EventList;
use maud::{Markup, PreEscaped, html};

use super::map::Viewport;
use super::mission_page::MissionView;
use crate::runtime::{FaultEvents, TickEvent};
pub use playback_recorder::PlaybackRecorder;

/// The script of all players on a page.
pub(super) const SCRIPT: &str = include_str!("player.js");

/// The values shown next to the map: label, name in the script, unit, and class of one that is wider than a number.
const READINGS: [(&str, &str, &str, Option<&str>); 16] = [
    ("time", "time", "s", None),
    ("mode", "mode", "", None),
    ("fault", "fault", "", Some("full-line")),
    ("speed", "speed", "m/s", None),
    ("turn rate", "turn_rate", "rad/s", None),
    ("protective layer", "protection", "", Some("full-line")),
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
                aria-label=(format!("Speed, gap and decision time over the run, with a line at the selected time. {} {}", playback.faults.alt_text(), playback.protection.alt_text())) {}
            div class="events faults" {
                h4 { "Faults" }
                (playback.faults.list.list("faults", playback.stride))
            }
            (playback.protection.lists(playback.stride))
            script type="application/json" class="playback" { (PreEscaped(json)) }
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
