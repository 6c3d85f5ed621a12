//! The host's side: sets the watchdog first, then sends commands and polls the controller between them.

use super::frames::{Reply, Request};
use super::status;
use crate::base::request::{RequestState, RequestTracker, RetryPolicy};
use crate::base::session::TrackSession;
use crate::base::{BaseError, BaseSettings, Feedback, Session, SessionCounters, TimedFeedback};
use crate::geometry::Twist;
use crate::robot::TrackSpeeds;

/// The queries of a poll cycle, in order. Each cycle includes the battery: it takes about 20 ms at 38,400 baud.
const POLL_CYCLE: [Request; 6] = [
    Request::Encoder { second: false },
    Request::Encoder { second: true },
    Request::Speed { second: false },
    Request::Speed { second: true },
    Request::Status,
    Request::Battery,
];

/// Number of leading queries that read the encoders.
const ENCODER_QUERIES: usize = 2;

/// Host session of a `RoboClaw`.
///
/// One request is outstanding at a time, and a command goes before the next query of a poll cycle. Until the controller has
/// confirmed its watchdog the session sends only the watchdog setting and zero commands: it does not drive a base that would not
/// stop by itself. A controller that receives but does not answer still gets zero commands, because queries alone keep its
/// watchdog from acting.
#[derive(Clone, Debug)]
pub struct RoboClawSession {
    core: TrackSession,
    requests: RequestTracker<Request>,
    received: Vec<u8>,
    watchdog: Watchdog,
    /// Position in the poll cycle.
    next_query: usize,
    answers: Answers,
    next_poll_s: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Watchdog {
    Unconfirmed,
    Set,
    Confirmed,
}

#[derive(Clone, Copy, Debug, Default)]
struct Answers {
    counts: [u32; 2],
    speeds: [i32; 2],
    status: u32,
    battery: u16,
}

impl RoboClawSession {
    /// Creates a session.
    ///
    /// # Errors
    /// Settings out of range.
    pub fn new(settings: BaseSettings) -> Result<Self, BaseError> {
        let core = TrackSession::new(settings)?;
        let policy = RetryPolicy {
            answer_timeout_s: settings.roboclaw.answer_timeout_s,
            max_attempts: settings.roboclaw.max_attempts,
        };
        Ok(Self {
            core,
            requests: RequestTracker::new(policy),
            received: Vec::new(),
            watchdog: Watchdog::Unconfirmed,
            next_query: POLL_CYCLE.len(),
            answers: Answers::default(),
            next_poll_s: f64::NEG_INFINITY,
        })
    }

    /// Whether the controller has confirmed its watchdog.
    #[must_use]
    pub fn is_ready(&self) -> bool {
        self.watchdog == Watchdog::Confirmed
    }

    /// Whether the pending command may be sent.
    fn may_drive(&self) -> bool {
        self.is_ready() || self.core.target == TrackSpeeds::default()
    }

    /// The next request, if one is due.
    fn next_request(&mut self, now_s: f64) -> Option<Request> {
        if self.core.is_pending && self.may_drive() {
            return Some(self.drive());
        }
        match self.watchdog {
            Watchdog::Unconfirmed => {
                let tenths = self.core.settings.roboclaw.watchdog_tenths();
                return Some(Request::SetTimeout(tenths));
            }
            Watchdog::Set => return Some(Request::GetTimeout),
            Watchdog::Confirmed => {}
        }
        if self.next_query == POLL_CYCLE.len() && now_s >= self.next_poll_s {
            self.next_query = 0;
            self.next_poll_s = now_s + self.core.settings.roboclaw.poll_period_s;
        }
        POLL_CYCLE.get(self.next_query).copied()
    }

    /// Takes the latest command.
    fn drive(&mut self) -> Request {
        // The cast saturates.
        let rates = self.core.take_rates();
        Request::Drive(rates.map(|rate| rate.round() as i32))
    }

    fn send(&mut self, request: Request, line: &mut Vec<u8>) {
        self.drop_received();
        line.extend(request.encode(self.core.settings.roboclaw.address));
    }

    fn drop_received(&mut self) {
        self.core.counters.dropped_bytes += self.received.len() as u64;
        self.received.clear();
    }

    fn take(&mut self, request: Request, reply: Reply, now_s: f64) {
        match (request, reply) {
            (Request::SetTimeout(_), _) => self.watchdog = Watchdog::Set,
            (_, Reply::Timeout(tenths)) => {
                let confirmed = tenths == self.core.settings.roboclaw.watchdog_tenths();
                self.watchdog = if confirmed { Watchdog::Confirmed } else { Watchdog::Unconfirmed };
            }
            (Request::Encoder { second }, Reply::Encoder(count)) => {
                self.answers.counts[usize::from(second)] = count;
            }
            (Request::Speed { second }, Reply::Speed(speed)) => {
                self.answers.speeds[usize::from(second)] = speed;
            }
            (_, Reply::Status(bits)) => self.answers.status = bits,
            (_, Reply::Battery(decivolts)) => self.answers.battery = decivolts,
            _ => {}
        }
        if POLL_CYCLE.get(self.next_query) == Some(&request) {
            self.next_query += 1;
            if self.next_query == POLL_CYCLE.len() {
                self.finish_cycle(now_s);
            }
        }
    }

    fn finish_cycle(&mut self, now_s: f64) {
        let counts = self.core.settings.track_counts(self.answers.counts);
        // The controller's speeds are more accurate, but implausible counts invalidate the whole answer.
        if self.core.encoder_speed.update(counts, now_s).is_none() {
            return;
        }
        let speeds = self.answers.speeds.map(f64::from);
        let speeds = self.core.settings.track_speeds(speeds);
        let (emergency_stop, faults) = status::read(&self.core.settings, self.answers.status);
        let feedback = Feedback {
            twist: self.core.settings.drive().twist(&speeds),
            emergency_stop,
            battery_v: Some(f64::from(self.answers.battery) / 10.0),
            encoder_counts: Some(counts),
            faults: faults.union(self.core.encoder_speed.faults()),
            ..Feedback::default()
        };
        self.core.report(feedback, now_s);
    }
}

const fn is_drive(request: Request) -> bool {
    matches!(request, Request::Drive(_))
}

impl Session for RoboClawSession {
    fn baud(&self) -> u32 {
        self.core.settings.roboclaw.baud
    }

    fn command(&mut self, twist: &Twist) -> Result<(), BaseError> {
        self.core.command(twist)
    }

    /// An answer is taken as a whole or not at all. If its check fails, all received bytes are dropped and the request is repeated
    /// after its timeout. Unexpected bytes are dropped.
    fn receive(&mut self, bytes: &[u8], now_s: f64) {
        self.received.extend_from_slice(bytes);
        let Some(request) = self.requests.outstanding() else {
            self.drop_received();
            return;
        };
        let length = request.reply_length(self.core.settings.roboclaw.status_bytes);
        if self.received.len() < length {
            return;
        }
        let reply = request.reply(self.core.settings.roboclaw.address, &self.received);
        let Some(reply) = reply else {
            self.drop_received();
            return;
        };
        self.received.clear();
        self.requests.finish();
        self.take(request, reply, now_s);
    }

    fn transmit(&mut self, now_s: f64, line: &mut Vec<u8>) {
        match self.requests.poll(now_s) {
            RequestState::Waiting => return,
            // A command does not wait for the retry of a query.
            RequestState::Retry(request)
                if self.core.is_pending && self.is_ready() && !is_drive(request) =>
            {
                self.requests.finish();
                self.core.counters.unanswered += 1;
                // The cycle continues where it was, or a slow line would never complete one; but both encoders are read together.
                if self.next_query < ENCODER_QUERIES {
                    self.next_query = 0;
                }
            }
            // A zero command sent before the watchdog was confirmed, which the latest command would turn into motion.
            RequestState::Retry(request) if is_drive(request) && !self.may_drive() => {
                self.requests.finish();
                self.core.counters.unanswered += 1;
            }
            RequestState::Retry(request) => {
                self.core.counters.retries += 1;
                // A repeated command carries the latest target.
                let request = if is_drive(request) { self.drive() } else { request };
                self.send(request, line);
                return;
            }
            RequestState::GivenUp(_) => {
                self.core.counters.unanswered += 1;
                self.next_query = POLL_CYCLE.len();
                // A controller that was restarted has lost its watchdog setting.
                self.watchdog = Watchdog::Unconfirmed;
            }
            RequestState::Idle => {}
        }
        if let Some(request) = self.next_request(now_s) {
            self.requests.start(request, now_s);
            self.send(request, line);
        }
    }

    fn is_waiting(&self) -> bool {
        self.requests.outstanding().is_some()
    }

    fn latest(&self) -> Option<&TimedFeedback> {
        self.core.latest.as_ref()
    }

    fn counters(&self) -> SessionCounters {
        self.core.counters()
    }

    fn engage_stop(&mut self) {
        self.core.stop();
    }

    fn release(&mut self) {
        self.core.release();
    }
}
