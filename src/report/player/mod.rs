//! A run to be played back: the robot, what it saw, what it could have done, and what it chose, tick by tick.
//!
//! The one part of a page that needs a script. The script is the page's own and the only one that its policy allows; the
//! pictures and tables around it show the run without one.

mod faults;
mod film;
mod reel;

use maud::{Markup, PreEscaped, html};
use sha2::{Digest, Sha256};

use super::MissionView;
use super::viewport::Viewport;
pub use reel::Reel;

const SCRIPT: &str = include_str!("player.js");

/// What is shown in step with the map: its name, the player's name for it, its unit and decimals.
const READINGS: [(&str, &str, &str); 15] = [
    ("time", "time", "s"),
    ("doing", "mode", ""),
    ("fault", "fault", ""),
    ("speed", "speed", "m/s"),
    ("turn rate", "turn", "rad/s"),
    ("told", "told", ""),
    ("gap", "gap", "m"),
    ("decision", "took", "ms"),
    ("admissible", "admissible", ""),
    ("heading", "heading", "rad"),
    ("clearance", "dist", "m"),
    ("velocity", "vel", "m/s"),
    ("path", "combine", "m"),
    ("score", "score", ""),
    ("plan", "path", ""),
];

/// The style of a page with players.
pub(super) const STYLE: &str = include_str!("player.css");

/// The player of a mission, for a map picture of this viewport in the same section.
pub(super) fn figure(mission: &MissionView, reel: &Reel, view: &Viewport) -> Markup {
    // Words of a GPU's driver may be in it: the one character that could end the element is written otherwise.
    let film = film::film(mission, reel, view)
        .to_string()
        .replace('<', "\\u003c");
    html! {
        figure class="player" {
            h3 { "Play it back" }
            noscript { p { "Playing needs a script. The pictures below show the same run." } }
            canvas class="stage" role="img" tabindex="0"
                aria-label="The robot on the map at the chosen time: its lidar, the arcs it could drive, coloured by score, the chosen one, and what moves." {}
            div class="controls" {
                button type="button" data-does="back" aria-label="one tick back" { "◀" }
                button type="button" data-does="play" { "Play" }
                button type="button" data-does="forward" aria-label="one tick forward" { "▶" }
                input type="range" min="0" max=(reel.frames.len().saturating_sub(1)) value="0" step="1" aria-label="tick";
                label { "speed " select data-does="speed" aria-label="speed of playing" {
                    @for speed in ["0.25", "0.5", "1", "2", "4", "8", "16"] {
                        option value=(speed) selected[speed == "1"] { "×" (speed) }
                    }
                } }
            }
            div class="controls" {
                @for (name, layer, on) in [("follow", "follow", true), ("lidar", "lidar", true), ("fan", "fan", true), ("predictions", "predicted", true)] {
                    label { input type="checkbox" data-layer=(layer) checked[on]; " " (name) }
                }
            }
            dl class="readings" aria-live="off" {
                @for (name, reading, unit) in READINGS {
                    div class=[room(reading)] { dt { (name) } dd { span data-reading=(reading) { "–" } " " (unit) } }
                }
            }
            canvas class="strip" role="img"
                aria-label=(format!("Speed, smallest gap and decision time over the run, with a mark at the chosen time. {}", reel.faults.said())) {}
            (reel.faults.list(reel.stride))
            script type="application/json" class="film" { (PreEscaped(film)) }
        }
    }
}

/// The class of a reading that needs more room than a number does.
fn room(reading: &str) -> Option<&'static str> {
    match reading {
        "told" => Some("wide"),
        "fault" => Some("whole-line"),
        _ => None,
    }
}

/// The script of all players on a page.
pub(super) fn script() -> Markup {
    html! { script { (PreEscaped(SCRIPT)) } }
}

/// The source of scripts that a page with players allows: this very text and no other.
pub(super) fn script_source() -> String {
    use base64::Engine;
    let digest = Sha256::digest(SCRIPT.as_bytes());
    let digest = base64::engine::general_purpose::STANDARD.encode(digest);
    format!("'sha256-{digest}'")
}
