//! Plays a run back tick by tick: the robot, its lidar, the sampled trajectories, and the chosen command.
//!
//! This is the only part of a page that needs a script. The page's content policy allows this script and no other. The
//! pictures and tables of the page show the same run without it.

mod playback_json;

use maud::{Markup, PreEscaped, html};
use sha2::{Digest, Sha256};

use super::map::Viewport;
use super::playback_recorder::PlaybackRecorder;
use super::views::MissionView;

const SCRIPT: &str = include_str!("player.js");

/// The values shown next to the map: label, name in the script, and unit.
const READINGS: [(&str, &str, &str); 15] = [
    ("time", "time", "s"),
    ("mode", "mode", ""),
    ("fault", "fault", ""),
    ("speed", "speed", "m/s"),
    ("turn rate", "turn_rate", "rad/s"),
    ("command", "command", ""),
    ("gap", "gap", "m"),
    ("decision time", "decision_time", "ms"),
    ("admissible", "admissible", ""),
    ("heading", "heading", "rad"),
    ("clearance", "clearance", "m"),
    ("velocity", "velocity", "m/s"),
    ("path", "path", "m"),
    ("score", "score", ""),
    ("plan", "plan", ""),
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
    let layers = [
        ("follow", "follow"),
        ("lidar", "lidar"),
        ("trajectories", "trajectories"),
        ("predictions", "predictions"),
    ];
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
                @for (name, layer) in layers {
                    label { input type="checkbox" data-layer=(layer) checked; " " (name) }
                }
            }
            dl class="readings" aria-live="off" {
                @for (label, name, unit) in READINGS {
                    div class=[width_class(name)] { dt { (label) } dd { span data-reading=(name) { "–" } " " (unit) } }
                }
            }
            canvas class="timeline" role="img"
                aria-label=(format!("Speed, gap and decision time over the run, with a line at the selected time. {}", playback.faults.alt_text())) {}
            (playback.faults.list(playback.stride))
            script type="application/json" class="playback" { (PreEscaped(json)) }
        }
    }
}

/// The class of a reading that is wider than a number.
fn width_class(reading: &str) -> Option<&'static str> {
    match reading {
        "command" => Some("wide"),
        "fault" => Some("full-line"),
        _ => None,
    }
}

/// The script of all players on a page.
pub(super) fn script() -> Markup {
    html! { script { (PreEscaped(SCRIPT)) } }
}

/// The script source that the content policy of a page with players allows: the digest of [`script`].
pub(super) fn script_source() -> String {
    use base64::Engine;
    let digest = Sha256::digest(SCRIPT.as_bytes());
    let digest = base64::engine::general_purpose::STANDARD.encode(digest);
    format!("'sha256-{digest}'")
}
