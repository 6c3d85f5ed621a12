//! The host's side: one line, one answer.

use super::lines::{Answer, MAX_LINE, parse_answer};
use crate::base::request::{RequestState, RequestTracker, RetryPolicy};
use crate::base::session::TrackSession;
use crate::base::{BaseError, BaseSettings, Feedback, Session, SessionCounters, TimedFeedback};
use crate::geometry::Twist;

/// The kinds of request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Request {
    /// `m`: set the motor speeds.
    SetSpeeds,
    /// `e`: read the encoders.
    ReadEncoders,
}

/// Host session of a `ROSArduinoBridge`. It reports encoder counts only.
#[derive(Clone, Debug)]
pub struct ArduinoSession {
    core: TrackSession,
    requests: RequestTracker<Request>,
    /// Whether the firmware may hold a partial line: at the start and after each lost answer.
    needs_flush: bool,
    /// Bytes since the last line feed, at most [`MAX_LINE`].
    line: Vec<u8>,
    next_poll_s: f64,
}

impl ArduinoSession {
    /// Creates a session.
    ///
    /// # Errors
    /// Settings out of range.
    pub fn new(settings: BaseSettings) -> Result<Self, BaseError> {
        let core = TrackSession::new(settings)?;
        let policy = RetryPolicy {
            answer_timeout_s: settings.arduino.answer_timeout_s,
            max_attempts: settings.arduino.max_attempts,
        };
        Ok(Self {
            core,
            requests: RequestTracker::new(policy),
            needs_flush: true,
            line: Vec::new(),
            next_poll_s: f64::NEG_INFINITY,
        })
    }

    fn send(&mut self, request: Request, line: &mut Vec<u8>) {
        if self.needs_flush {
            line.push(b'\r');
            self.needs_flush = false;
        }
        match request {
            Request::SetSpeeds => {
                let interval_s = self.core.settings.arduino.pid_interval_s;
                let rates = self.core.take_rates();
                // Integers have 16 bits on the smaller boards.
                let [first, second] = rates.map(|rate| (rate * interval_s).round() as i16);
                line.extend(format!("m {first} {second}\r").into_bytes());
            }
            Request::ReadEncoders => line.extend(*b"e\r"),
        }
    }

    fn take_line(&mut self, now_s: f64) {
        let line = std::mem::take(&mut self.line);
        let content = line.strip_suffix(b"\r\n");
        match (self.requests.outstanding(), content.and_then(parse_answer)) {
            (Some(Request::SetSpeeds), Some(Answer::Ok)) => self.requests.finish(),
            (Some(Request::ReadEncoders), Some(Answer::Counts(counts))) => {
                self.requests.finish();
                self.take_counts(counts, now_s);
            }
            // This includes the answer to the carriage return that flushes a partial line.
            _ => self.core.counters.dropped_bytes += line.len() as u64,
        }
    }

    fn take_counts(&mut self, counts: [u32; 2], now_s: f64) {
        let counts = self.core.settings.track_counts(counts);
        let Some(speeds) = self.core.encoder_speed.update(counts, now_s) else {
            return;
        };
        let feedback = Feedback {
            twist: self.core.settings.drive().twist(&speeds),
            encoder_counts: Some(counts),
            faults: self.core.encoder_speed.faults(),
            ..Feedback::default()
        };
        self.core.report(feedback, now_s);
    }
}

impl Session for ArduinoSession {
    fn baud(&self) -> u32 {
        self.core.settings.arduino.baud
    }

    fn command(&mut self, twist: &Twist) -> Result<(), BaseError> {
        self.core.command(twist)
    }

    fn receive(&mut self, bytes: &[u8], now_s: f64) {
        for byte in bytes {
            if self.line.len() < MAX_LINE {
                self.line.push(*byte);
            } else {
                self.core.counters.dropped_bytes += 1;
            }
            if *byte == b'\n' {
                self.take_line(now_s);
            }
        }
    }

    fn transmit(&mut self, now_s: f64, line: &mut Vec<u8>) {
        let state = self.requests.poll(now_s);
        self.needs_flush |= matches!(state, RequestState::Retry(_) | RequestState::GivenUp(_));
        match state {
            RequestState::Waiting => return,
            // A command does not wait for the retry of a query.
            RequestState::Retry(Request::ReadEncoders) if self.core.is_pending => {
                self.requests.finish();
                self.core.counters.unanswered += 1;
            }
            RequestState::Retry(request) => {
                self.core.counters.retries += 1;
                self.send(request, line);
                return;
            }
            RequestState::GivenUp(_) => self.core.counters.unanswered += 1,
            RequestState::Idle => {}
        }
        let request = if self.core.is_pending {
            Request::SetSpeeds
        } else if now_s >= self.next_poll_s {
            self.next_poll_s = now_s + self.core.settings.arduino.poll_period_s;
            Request::ReadEncoders
        } else {
            return;
        };
        self.requests.start(request, now_s);
        self.send(request, line);
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
