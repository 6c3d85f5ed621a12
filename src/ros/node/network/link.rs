//! The control process's link to the network process: starts it, watches it, and starts it again.

use core::mem::discriminant;
use std::process::Command;

use serde::Serialize;

use super::frame::{FromNetwork, ToNetwork};
use super::process::{NetworkProcess, PipeClosed};
use super::restart::RestartBackoff;
use crate::ros::node::IncomingMessage;

/// A process that sends no frame for this long, seconds, hangs. It sends one each 0.1 s.
const HANG_S: f64 = 1.0;
/// Longest time from the start to the first frame, seconds: DDS opens its sockets meanwhile.
const START_S: f64 = 10.0;
/// Maximum number of frames that one call of [`NetworkLink::poll`] takes.
const MAX_FRAMES: usize = 256;

/// Counters of the link.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct NetworkStats {
    /// Times that the network process was started again.
    pub network_restarts: u64,
    /// Messages that were not sent.
    pub unsent: u64,
}

/// What a poll of the link brings.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct LinkEvents {
    /// Messages that arrived.
    pub messages: Vec<IncomingMessage>,
    /// The network process ended or hung: nothing that is sent reaches the network.
    pub is_lost: bool,
    /// The network process is up, at first or again.
    pub is_up: bool,
    /// Notices for the user, a line each.
    pub notices: Vec<String>,
}

/// The link to a network process. It starts the process again with exponential backoff.
///
/// Times are seconds by a monotonic clock. No call waits.
pub struct NetworkLink {
    new_command: Box<dyn FnMut() -> Command>,
    process: Option<NetworkProcess>,
    backoff: RestartBackoff,
    started_s: f64,
    /// Time of the last frame since the start.
    frame_s: Option<f64>,
    has_started: bool,
    failure: Option<String>,
    /// The last messages of the latched topics: a new process does not know them.
    latched: Vec<ToNetwork>,
    /// Unsent messages by the control process, and by the present network process.
    dropped: u64,
    unsent: u64,
    restarts: u64,
}

impl NetworkLink {
    /// A link to the process of a command. The first poll starts it.
    #[must_use]
    pub fn new(new_command: Box<dyn FnMut() -> Command>) -> Self {
        Self {
            new_command,
            process: None,
            backoff: RestartBackoff::default(),
            started_s: 0.0,
            frame_s: None,
            has_started: false,
            failure: None,
            latched: Vec::new(),
            dropped: 0,
            unsent: 0,
            restarts: 0,
        }
    }

    /// Whether the network process is up.
    #[must_use]
    pub const fn is_up(&self) -> bool {
        self.process.is_some() && self.frame_s.is_some()
    }

    /// Why DDS did not start, if the network process sent the reason.
    #[must_use]
    pub fn failure(&self) -> Option<&str> {
        self.failure.as_deref()
    }

    /// The counters.
    #[must_use]
    pub const fn stats(&self) -> NetworkStats {
        NetworkStats { network_restarts: self.restarts, unsent: self.dropped + self.unsent }
    }

    /// Starts the process if it is due, takes the messages that arrived, and notices its end.
    pub fn poll(&mut self, now_s: f64) -> LinkEvents {
        let mut events = LinkEvents::default();
        if self.process.is_none() && self.backoff.is_due(now_s) {
            self.start(now_s, &mut events);
        }
        let Some(process) = &mut self.process else {
            return events;
        };
        let mut cause = None;
        for _ in 0..MAX_FRAMES {
            let frame = match process.receive() {
                Ok(Some(frame)) => frame,
                Ok(None) => break,
                Err(PipeClosed) => {
                    let status = process.exit_status();
                    let ended = || "it closed its pipe".to_owned();
                    cause = Some(status.map_or_else(ended, |status| status.to_string()));
                    break;
                }
            };
            match frame {
                FromNetwork::Alive { unsent } => self.unsent = unsent,
                FromNetwork::Message(message) => events.messages.push(message),
                // It ends, and was never up.
                FromNetwork::Failed(reason) => {
                    cause = Some(reason.clone());
                    self.failure = Some(reason);
                    break;
                }
            }
            events.is_up |= self.frame_s.is_none();
            self.frame_s = Some(now_s);
        }
        let silent_s = now_s - self.frame_s.unwrap_or(self.started_s);
        let limit_s = if self.frame_s.is_some() { HANG_S } else { START_S };
        if cause.is_none() && silent_s > limit_s {
            cause = Some(format!("no sign of life for {silent_s:.1} s"));
        }
        if let Some(cause) = cause {
            self.lose(now_s, &cause, &mut events);
        } else if events.is_up {
            core::mem::take(&mut self.latched).into_iter().for_each(|frame| self.send(frame));
        }
        events
    }

    fn start(&mut self, now_s: f64, events: &mut LinkEvents) {
        self.started_s = now_s;
        self.frame_s = None;
        self.failure = None;
        self.restarts += u64::from(self.has_started);
        self.has_started = true;
        match NetworkProcess::start(&mut (self.new_command)()) {
            Ok(process) => self.process = Some(process),
            Err(error) => self.lose(now_s, &error.to_string(), events),
        }
    }

    fn lose(&mut self, now_s: f64, cause: &str, events: &mut LinkEvents) {
        self.process = None;
        self.frame_s = None;
        self.dropped += self.unsent;
        self.unsent = 0;
        self.backoff.ended(now_s, now_s - self.started_s);
        events.is_lost = true;
        events.is_up = false;
        events.notices.push(format!(
            "the network process was lost ({cause}): the robot brakes to zero, and the process is started again"
        ));
    }

    /// Sends a frame. A frame that the process does not take is counted: one that starts would publish it late.
    pub fn send(&mut self, frame: ToNetwork) {
        if matches!(frame, ToNetwork::Path(_) | ToNetwork::UpdatedMap(_)) {
            self.latched.retain(|last| discriminant(last) != discriminant(&frame));
            self.latched.push(frame.clone());
        }
        let process = self.process.as_ref().filter(|_| self.is_up());
        let is_sent = process.is_some_and(|process| process.send(frame));
        self.dropped += u64::from(!is_sent);
    }

    /// Closes the pipe, which makes the network process publish zeros and end. Returns whether it has ended.
    pub fn close(&mut self) -> bool {
        let Some(process) = &mut self.process else {
            return true;
        };
        process.close();
        process.exit_status().is_some()
    }
}

#[cfg(all(test, unix))]
mod tests {
    use std::thread::sleep;
    use std::time::{Duration, Instant};

    use super::*;
    use crate::ros::msg::{OccupancyGrid, Path, PoseStamped};
    use crate::ros::node::network::frame::Frame;

    /// A link to a process that sends a sign of life with three unsent messages, and then runs a script.
    fn link(script: impl Into<String>) -> NetworkLink {
        let script = script.into();
        NetworkLink::new(Box::new(move || {
            let mut command = Command::new("sh");
            let alive = "printf '\\0\\010\\0\\0\\0\\003\\0\\0\\0\\0\\0\\0\\0'";
            command.args(["-c", &format!("{alive}; {script}")]);
            command
        }))
    }

    /// Polls with a simulated clock until a condition holds.
    fn until(link: &mut NetworkLink, now_s: &mut f64, done: impl Fn(&LinkEvents) -> bool) {
        let began = Instant::now();
        while began.elapsed() < Duration::from_secs(30) {
            if done(&link.poll(*now_s)) {
                return;
            }
            sleep(Duration::from_millis(2));
            *now_s += 0.002;
        }
        panic!("not within 30 s");
    }

    /// How often a file of what a process received holds a payload.
    fn times_received(file: &std::path::Path, payload: &[u8]) -> usize {
        let bytes = std::fs::read(file).unwrap_or_default();
        bytes.windows(payload.len()).filter(|window| *window == payload).count()
    }

    #[test]
    fn process_that_ends_is_started_again() {
        let mut link = link("exit 3");
        let mut now_s = 0.0;
        until(&mut link, &mut now_s, |events| events.is_lost);
        assert!(!link.is_up());
        until(&mut link, &mut now_s, |events| events.is_lost);
        until(&mut link, &mut now_s, |events| events.notices.iter().any(|it| it.contains("lost")));
        let stats = link.stats();
        assert!(stats.network_restarts >= 2 && stats.unsent >= 6, "{stats:?}");
    }

    #[test]
    fn process_that_hangs_is_killed_and_started_again() {
        let mut link = link("exec sleep 1000");
        let mut now_s = 0.0;
        until(&mut link, &mut now_s, |events| events.is_up);
        assert!(link.is_up());
        let silent_from_s = now_s;
        until(&mut link, &mut now_s, |events| events.is_lost);
        assert!((now_s - silent_from_s - HANG_S).abs() < 0.1, "{}", now_s - silent_from_s);
        until(&mut link, &mut now_s, |events| events.is_up);
        assert_eq!(link.stats().network_restarts, 1);
    }

    #[test]
    fn new_process_gets_the_last_path_and_the_last_updated_map() {
        let folder = std::env::temp_dir().join(format!("inbye-link-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a writable folder");
        let received = folder.join("received");
        let mut link = link(format!("cat >>{}", received.display()));
        let mut now_s = 0.0;
        until(&mut link, &mut now_s, |events| events.is_up);
        let frames = [
            ToNetwork::Path(Path { poses: vec![PoseStamped::default(); 7], ..Path::default() }),
            ToNetwork::UpdatedMap(OccupancyGrid { data: vec![100; 9], ..OccupancyGrid::default() }),
        ];
        let payloads = frames.each_ref().map(|frame| frame.to_parts().1);
        frames.into_iter().for_each(|frame| link.send(frame));
        until(&mut link, &mut now_s, |events| events.is_lost);
        until(&mut link, &mut now_s, |events| events.is_up);
        until(&mut link, &mut now_s, |_| {
            payloads.iter().all(|payload| times_received(&received, payload) == 2)
        });
        std::fs::remove_dir_all(&folder).expect("removable");
    }

    #[test]
    fn process_that_cannot_start_dds_is_never_up() {
        // The reason `no`, as a frame, from a process that does not end by itself.
        let failed = "printf '\\001\\002\\0\\0\\0no'; exec sleep 1000";
        let mut link = NetworkLink::new(Box::new(move || {
            let mut command = Command::new("sh");
            command.args(["-c", failed]);
            command
        }));
        let mut now_s = 0.0;
        for _ in 0..2 {
            until(&mut link, &mut now_s, |events| {
                assert!(!events.is_up);
                events.is_lost
            });
            assert_eq!(link.failure(), Some("no"));
        }
    }

    #[test]
    fn latched_messages_of_an_outage_are_sent_after_it() {
        let folder = std::env::temp_dir().join(format!("inbye-outage-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a writable folder");
        let received = folder.join("received");
        let mut link = link(format!("cat >>{}", received.display()));
        let path = Path { poses: vec![PoseStamped::default(); 7], ..Path::default() };
        let frame = ToNetwork::Path(path);
        let payload = frame.to_parts().1;
        link.send(frame);
        assert_eq!(link.stats().unsent, 1);
        let mut now_s = 0.0;
        until(&mut link, &mut now_s, |events| events.is_up);
        until(&mut link, &mut now_s, |_| times_received(&received, &payload) > 0);
        std::fs::remove_dir_all(&folder).expect("removable");
    }

    #[test]
    fn process_that_takes_nothing_does_not_block_the_sender() {
        let mut link = link("exec sleep 1000");
        until(&mut link, &mut 0.0, |events| events.is_up);
        let began = Instant::now();
        // Beyond the buffers of pipe and queue.
        for _ in 0..2000 {
            let path = Path { poses: vec![PoseStamped::default(); 100], ..Path::default() };
            link.send(ToNetwork::Path(path));
        }
        assert!(began.elapsed() < Duration::from_secs(10));
        assert!(link.stats().unsent > 0);
    }

    #[test]
    fn program_that_does_not_exist_is_a_loss() {
        let mut link = NetworkLink::new(Box::new(|| Command::new("/nonexistent/program")));
        let events = link.poll(0.0);
        assert!(events.is_lost && events.notices.len() == 1, "{events:?}");
        assert!(link.poll(0.05).notices.is_empty(), "it waits before the next start");
    }
}
