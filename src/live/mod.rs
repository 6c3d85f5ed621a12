//! The page of a running drive, on `127.0.0.1`: the player of the report, which shows each tick as soon as it is driven.
//!
//! The page cannot control the drive, unless it gets the operator's switch. Then it has a stop button; it never arms the robot.

use std::collections::BTreeMap;
use std::io;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use hyper::Request;
use hyper::body::Bytes;
use serde_json::{Value, json};

use crate::base::OperatorSwitch;
use crate::report::{KnownPlayback, LivePage, PlaybackRecorder};
use crate::runtime::{Config, Mission, MissionResult, TickEvent};
use crate::server::{self, HttpError, Response, Server, Service};

/// The longest wait at the end for pages that have not yet got the last tick, and the time between two looks.
const END_TIME: Duration = Duration::from_secs(2);
const POLL_TIME: Duration = Duration::from_millis(20);

/// What a live page shows.
#[derive(Clone, Debug)]
pub struct LiveDrive<'a> {
    /// Heading. Any characters.
    pub title: &'a str,
    /// The command that repeats the drive. Any characters.
    pub command: &'a str,
    /// The mission.
    pub mission: &'a Mission,
    /// The settings of the robot.
    pub config: &'a Config,
    /// The operator's switch, for a page with a stop button.
    pub stop: Option<OperatorSwitch>,
}

/// A served drive.
pub struct LiveView {
    server: Server,
    drive: Arc<ServedDrive>,
}

struct ServedDrive {
    page: LivePage,
    stop: Option<OperatorSwitch>,
    state: Mutex<DriveState>,
    /// Whether a page asks for ticks, and whether one has the end of the drive.
    is_watched: AtomicBool,
    has_end: AtomicBool,
}

#[derive(Default)]
struct DriveState {
    playback: PlaybackRecorder,
    end: Option<Value>,
}

impl LiveView {
    /// Serves a drive at a port, or at any free port if it is 0.
    ///
    /// # Errors
    /// When the port is in use or the system provides no threads.
    pub fn start(port: u16, drive: LiveDrive<'_>) -> io::Result<Self> {
        let LiveDrive { title, command, mission, config, stop } = drive;
        let drive = Arc::new(ServedDrive {
            page: LivePage::new(title, command, mission, config, stop.is_some()),
            stop,
            state: Mutex::default(),
            is_watched: AtomicBool::new(false),
            has_end: AtomicBool::new(false),
        });
        let service: Arc<dyn Service> = Arc::clone(&drive) as _;
        Ok(Self { server: Server::start(port, service)?, drive })
    }

    /// The address of the page.
    #[must_use]
    pub const fn address(&self) -> SocketAddr {
        self.server.address()
    }

    /// Shows the next tick. Ticks come in order, without gaps. It waits for no page.
    pub fn record(&self, event: &TickEvent<'_>) {
        self.drive.state().playback.record(event);
    }

    /// Shows the end of the drive, waits up to 2 s until a page has it, if there is one, and returns all ticks.
    #[must_use]
    pub fn end(self, result: &MissionResult) -> PlaybackRecorder {
        let text = result.why().unwrap_or_else(|| "goal reached without contact".to_owned());
        let is_good = result.reached && !result.collided;
        self.drive.state().end = Some(json!({ "is_good": is_good, "text": text }));
        let began = Instant::now();
        let is_waited_for = || {
            self.drive.is_watched.load(Ordering::Relaxed)
                && !self.drive.has_end.load(Ordering::Relaxed)
        };
        while is_waited_for() && began.elapsed() < END_TIME {
            thread::sleep(POLL_TIME);
        }
        let _ = self.server.finish();
        // A copy: another page may still ask.
        self.drive.state().playback.clone()
    }
}

impl Service for ServedDrive {
    fn answer(&self, request: &Request<Bytes>) -> Result<Response, HttpError> {
        match request.uri().path() {
            "/" => {
                server::check_get(request)?;
                Ok(server::page(self.page.html().to_owned()))
            }
            "/ticks" => {
                server::check_get(request)?;
                let query = request.uri().query().unwrap_or_default();
                Ok(server::json(&self.ticks(&known_playback(query)?)))
            }
            "/stop" => {
                let switch = self.stop.as_ref().ok_or_else(|| server::nothing_at("/stop"))?;
                server::check_post(request)?;
                switch.stop();
                Ok(server::json(&json!({ "state": switch.state().name() })))
            }
            path => Err(server::nothing_at(path)),
        }
    }
}

impl ServedDrive {
    fn state(&self) -> MutexGuard<'_, DriveState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn ticks(&self, known: &KnownPlayback) -> Value {
        self.is_watched.store(true, Ordering::Relaxed);
        // The drive waits for this copy, not for its encoding.
        let (part, all, end) = {
            let state = self.state();
            let part = LivePage::unknown_part(&state.playback, known);
            (part, state.playback.frame_count(), state.end.clone())
        };
        let is_whole = part.end() == all;
        if end.is_some() && is_whole {
            self.has_end.store(true, Ordering::Relaxed);
        }
        let part = self.page.json(&part);
        let operator = self.stop.as_ref().map(|switch| switch.state().name());
        json!({ "part": part, "drive": { "frames": all, "end": end, "operator": operator } })
    }
}

/// What the page knows, by the query of its request.
fn known_playback(query: &str) -> Result<KnownPlayback, HttpError> {
    let values: BTreeMap<&str, &str> =
        query.split('&').filter_map(|pair| pair.split_once('=')).collect();
    let number = |name: &str| match values.get(name).filter(|text| !text.is_empty()) {
        None => Ok(None),
        Some(text) => text.parse().map(Some).map_err(|_| {
            HttpError::bad_request(format!("{name} must be a whole number of frames or ticks"))
        }),
    };
    Ok(KnownPlayback {
        frames: number("frames")?.unwrap_or(0),
        shape: values.get("shape").copied().unwrap_or_default().to_owned(),
        events: number("events")?,
    })
}

#[cfg(test)]
mod tests {
    use hyper::Method;
    use hyper::header::{CONTENT_TYPE, HOST, ORIGIN};

    use super::*;
    use crate::base::OperatorState;
    use crate::local::CpuEngine;
    use crate::runtime::Observer;
    use crate::sim::{Simulation, roadway};

    #[test]
    fn query_says_what_a_page_knows() {
        let known = known_playback("frames=12&shape=1-120-55&events=3").expect("a query");
        let expected = KnownPlayback { frames: 12, shape: "1-120-55".to_owned(), events: Some(3) };
        assert_eq!(known, expected);
        let first = known_playback("frames=0&shape=&events=").expect("a query");
        assert_eq!(first, KnownPlayback::default());
        assert_eq!(known_playback("").expect("a query"), KnownPlayback::default());
        assert!(known_playback("frames=-1").is_err() && known_playback("events=x").is_err());
    }

    fn served(stop: Option<OperatorSwitch>) -> (LiveView, Simulation) {
        let simulation = Simulation::new(roadway().mission(60.0));
        let config = Config::default();
        let drive = LiveDrive {
            title: "<drive>",
            command: "inbye drive",
            mission: &simulation.mission,
            config: &config,
            stop,
        };
        (LiveView::start(0, drive).expect("a free port"), simulation)
    }

    fn request(method: Method, path: &str, origin: Option<&str>) -> Request<Bytes> {
        let mut request = Request::builder().method(method).uri(path).header(HOST, "127.0.0.1:80");
        request = request.header(CONTENT_TYPE, "application/json");
        if let Some(origin) = origin {
            request = request.header(ORIGIN, origin);
        }
        request.body(Bytes::new()).expect("a request")
    }

    #[test]
    fn page_can_only_look_unless_it_has_the_switch() {
        let (live, _) = served(None);
        let status = |request| match live.drive.answer(&request) {
            Ok(response) => response.status().as_u16(),
            Err(error) => Response::from(error).status().as_u16(),
        };
        assert_eq!(status(request(Method::GET, "/", None)), 200);
        assert_eq!(status(request(Method::POST, "/", None)), 405);
        assert_eq!(status(request(Method::POST, "/stop", None)), 404);
        assert!(!live.drive.page.html().contains("id=\"stop\""));
        assert!(live.drive.page.html().contains("<h1>&lt;drive&gt;</h1>"));
    }

    #[test]
    fn stop_button_stops_and_nothing_arms() {
        let switch = OperatorSwitch::default();
        switch.arm();
        let (live, _) = served(Some(switch.clone()));
        assert!(live.drive.page.html().contains("id=\"stop\""));
        let foreign = request(Method::POST, "/stop", Some("http://example.org"));
        assert!(live.drive.answer(&foreign).is_err());
        assert!(live.drive.answer(&request(Method::GET, "/stop", None)).is_err());
        assert_eq!(switch.state(), OperatorState::Armed);
        let own = request(Method::POST, "/stop", Some("http://127.0.0.1:80"));
        assert!(live.drive.answer(&own).is_ok());
        assert_eq!(switch.state(), OperatorState::Stopped);
        assert!(live.drive.answer(&request(Method::POST, "/arm", None)).is_err());
    }

    /// A page that asks again and again gets each tick once, and the events only when there are more.
    #[test]
    fn parts_join_to_the_whole_drive() {
        let (live, simulation) = served(None);
        let mut known = KnownPlayback::default();
        let (mut frames, mut lists, mut replies) = (0, 0, 0);
        let mut ask = || {
            let reply = live.drive.ticks(&known);
            let part = &reply["part"];
            let first = part["first"].as_u64().expect("an index") as usize;
            let count = frame_count(part);
            assert!(first == known.frames || first == 0, "{first} after {}", known.frames);
            frames = first + count;
            lists += usize::from(!part["event_lists"].is_null());
            replies += 1;
            known = KnownPlayback {
                frames,
                shape: part["shape"].as_str().expect("a shape").to_owned(),
                events: part["events"].as_u64().map(|count| count as usize),
            };
            reply["drive"]["end"].clone()
        };
        let mut tick = 0;
        let mut on_tick = |event: &TickEvent<'_>| {
            live.record(event);
            tick += 1;
            if tick % 7 == 0 {
                assert!(ask().is_null());
            }
        };
        let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut on_tick };
        let engine = Box::new(CpuEngine::single_threaded());
        let result = simulation.run(&Config::default(), engine, &mut observer).expect("a drive");
        assert!(result.reached);
        live.drive.state().end = Some(json!("over"));
        assert_eq!(ask(), json!("over"));
        assert_eq!(frames, result.trace.rows.len());
        assert!(live.drive.has_end.load(Ordering::Relaxed));
        assert!(lists < replies / 2, "{lists} of {replies}");
    }

    /// Number of frames of a part: four bytes each, as base64.
    fn frame_count(part: &Value) -> usize {
        let text = part["numbers"]["time"].as_str().expect("encoded numbers");
        (text.len() / 4 * 3 - text.matches('=').count()) / 4
    }
}
