//! The page of a running drive. Its script requests the data that it does not have yet from a server.

use maud::html;
use serde_json::{Value, json};

use super::playback_recorder::{PlaybackPart, PlaybackRecorder};
use super::{STYLE, event_lists, figure, playback_json, script_with};
use crate::report::map::{MapPanel, PLAYER_RASTER, Viewport, ground};
use crate::report::page::live_document;
use crate::runtime::{Config, Mission};

const SCRIPT: &str = script_with!("script/live.js");

/// The identifier of the drive's section.
const SECTION: &str = "mission-1";

/// Most frames of a part: its encoding takes less than the time between two ticks.
const MOST_FRAMES: usize = 200;

/// The part of a playback that a page has already received.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct KnownPlayback {
    /// Number of frames.
    pub frames: usize,
    /// The shape of the frames, as the last part named it.
    pub shape: String,
    /// Number of ticks with events, as the last part named it.
    pub events: Option<usize>,
}

/// The page of a drive, and the encoding of its ticks.
pub(crate) struct LivePage {
    html: String,
    view: Viewport,
}

impl LivePage {
    /// Creates the page. All texts may hold any characters. With a stop button, the page can stop the robot.
    pub(crate) fn new(
        title: &str,
        command: &str,
        mission: &Mission,
        config: &Config,
        has_stop: bool,
    ) -> Self {
        let frame = mission.map.frame();
        let view = Viewport::around(frame.corners(), frame);
        let map =
            MapPanel::new(&view, &ground(&mission.map, &view, PLAYER_RASTER), String::new(), "");
        let content = html! {
            header class="live" {
                h1 { (title) }
                p { span class="badge" id="drive-state" { "waiting for the first tick" } " " span id="drive-text" role="status" {} }
                @if has_stop {
                    p {
                        button type="button" class="stop" id="stop" { "Stop the robot" }
                        " protective layer: " span id="operator-state" { "unknown" }
                    }
                }
            }
            section id=(SECTION) {
                (figure(mission, config, None, &view, SECTION))
                div hidden { (map.picture()) }
                h3 { "Reproduction" }
                div {
                    pre tabindex="0" { code { (command) } }
                    button type="button" class="copy" data-copy hidden { "Copy the command" }
                }
            }
        };
        Self { html: live_document(title, STYLE, SCRIPT, &content), view }
    }

    /// The page.
    pub(crate) fn html(&self) -> &str {
        &self.html
    }

    /// The part of a playback that a page has not received, at most 200 frames. It is a copy, so that the recorder can continue.
    pub(crate) fn unknown_part(playback: &PlaybackRecorder, known: &KnownPlayback) -> PlaybackPart {
        let is_same_shape = known.shape == playback.shape.key();
        let first = if is_same_shape { known.frames.min(playback.lasting_frames()) } else { 0 };
        playback.part(first, MOST_FRAMES, known.events)
    }

    /// A part as JSON.
    pub(crate) fn json(&self, part: &PlaybackPart) -> Value {
        let lists = part.events.as_ref().map(|(faults, protection)| {
            event_lists(faults, protection, part.shape.stride).into_string()
        });
        let mut object = playback_json::part_json(part, &self.view);
        object["event_lists"] = json!(lists);
        object
    }
}
