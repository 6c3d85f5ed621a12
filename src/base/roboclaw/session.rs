//! The host's side: the watchdog first, then commands as they come and rounds of questions between them.

use super::frames::{Reply, Request};
use super::status;
use crate::base::exchange::{Exchange, Patience, Turn};
use crate::base::tick_meter::TickMeter;
use crate::base::{BaseError, BaseSettings, Counters, Feedback, Heard, Session};
use crate::geometry::Twist;
use crate::robot::TrackSpeeds;

/// The questions of a round, in order. The battery is asked for in each: a round takes some 20 ms at 38,400 baud.
const ROUND: [Request; 6] = [
    Request::Encoder { second: false },
    Request::Encoder { second: true },
    Request::Speed { second: false },
    Request::Speed { second: true },
    Request::Status,
    Request::Battery,
];

/// So many of them, the first, read the counters.
const ENCODERS: usize = 2;

/// A base driven by a `RoboClaw`.
///
/// One question is under way at a time, and a command goes before the next question of a round. Nothing but the setting
/// of the watchdog and commands to stand are sent until the controller has confirmed it: a base that would not stop by
/// itself is not driven; but one that hears and does not answer is stopped, for the questions alone keep its watchdog quiet.
#[derive(Clone, Debug)]
pub struct RoboClawSession {
    settings: BaseSettings,
    wanted: TrackSpeeds,
    is_due: bool,
    exchange: Exchange<Request>,
    received: Vec<u8>,
    watchdog: Watchdog,
    /// Position in the round, and what it brought so far.
    asked: usize,
    answers: Answers,
    next_round_s: f64,
    meter: TickMeter,
    newest: Option<Heard>,
    counters: Counters,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Watchdog {
    Unknown,
    Sent,
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
    /// A session that has sent nothing.
    ///
    /// # Errors
    /// Those of [`BaseSettings::validate`].
    pub fn new(settings: BaseSettings) -> Result<Self, BaseError> {
        settings.validate()?;
        let patience = Patience {
            answer_within_s: settings.roboclaw.answer_within_s,
            tries: settings.roboclaw.tries,
        };
        Ok(Self {
            settings,
            wanted: TrackSpeeds::default(),
            is_due: false,
            exchange: Exchange::new(patience),
            received: Vec::new(),
            watchdog: Watchdog::Unknown,
            asked: ROUND.len(),
            answers: Answers::default(),
            next_round_s: f64::NEG_INFINITY,
            meter: TickMeter::new(&settings),
            newest: None,
            counters: Counters::default(),
        })
    }

    /// Whether the controller has confirmed its watchdog, so that it is commanded.
    #[must_use]
    pub fn is_ready(&self) -> bool {
        self.watchdog == Watchdog::Confirmed
    }

    /// Whether the command may go now.
    fn may_drive(&self) -> bool {
        self.is_ready() || self.wanted == TrackSpeeds::default()
    }

    /// What to ask next, if anything.
    fn next_request(&mut self, now_s: f64) -> Option<Request> {
        if self.is_due && self.may_drive() {
            return Some(self.drive());
        }
        match self.watchdog {
            Watchdog::Unknown => {
                let tenths = self.settings.roboclaw.watchdog_tenths();
                return Some(Request::SetTimeout(tenths));
            }
            Watchdog::Sent => return Some(Request::GetTimeout),
            Watchdog::Confirmed => {}
        }
        if self.asked == ROUND.len() && now_s >= self.next_round_s {
            self.asked = 0;
            self.next_round_s = now_s + self.settings.roboclaw.poll_every_s;
        }
        ROUND.get(self.asked).copied()
    }

    /// The newest command, which is then on its way.
    fn drive(&mut self) -> Request {
        self.is_due = false;
        // The cast brings what does not fit to the nearest that does.
        let rates = self.settings.channel_rates(&self.wanted);
        Request::Drive(rates.map(|rate| rate.round() as i32))
    }

    fn send(&mut self, request: Request, line: &mut Vec<u8>) {
        self.drop_received();
        line.extend(request.encode(self.settings.roboclaw.address));
    }

    fn drop_received(&mut self) {
        self.counters.dropped_bytes += self.received.len() as u64;
        self.received.clear();
    }

    fn take(&mut self, request: Request, reply: Reply, now_s: f64) {
        match (request, reply) {
            (Request::SetTimeout(_), _) => self.watchdog = Watchdog::Sent,
            (_, Reply::Timeout(tenths)) => {
                let confirmed = tenths == self.settings.roboclaw.watchdog_tenths();
                self.watchdog = if confirmed {
                    Watchdog::Confirmed
                } else {
                    Watchdog::Unknown
                };
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
        if ROUND.get(self.asked) == Some(&request) {
            self.asked += 1;
            if self.asked == ROUND.len() {
                self.finish_round(now_s);
            }
        }
    }

    fn finish_round(&mut self, now_s: f64) {
        let ticks = self.settings.track_ticks(self.answers.counts);
        // Its speeds are better than ours, but its counters must be plausible before anything is believed.
        if self.meter.read(ticks, now_s).is_none() {
            return;
        }
        let speeds = self.answers.speeds.map(f64::from);
        let speeds = self.settings.track_speeds(speeds);
        let (emergency_stop, faults) = status::read(&self.settings, self.answers.status);
        let feedback = Feedback {
            twist: self.settings.drive().twist(&speeds),
            emergency_stop,
            battery_v: Some(f64::from(self.answers.battery) / 10.0),
            ticks: Some(ticks),
            faults: faults.and(self.meter.faults()),
            ..Feedback::default()
        };
        self.newest = Some(Heard {
            at_s: now_s,
            feedback,
        });
    }
}

const fn is_drive(request: Request) -> bool {
    matches!(request, Request::Drive(_))
}

impl Session for RoboClawSession {
    fn baud(&self) -> u32 {
        self.settings.roboclaw.baud
    }

    fn command(&mut self, wanted: &Twist) -> Result<(), BaseError> {
        let possible = self.settings.possible(wanted)?;
        self.wanted = self.settings.drive().tracks(&possible);
        self.is_due = true;
        Ok(())
    }

    /// An answer is taken as a whole or not at all: where its check fails everything that came is dropped, and the
    /// question asked again when its time is up. Bytes that nobody waits for are dropped.
    fn receive(&mut self, bytes: &[u8], now_s: f64) {
        self.received.extend_from_slice(bytes);
        let Some(request) = self.exchange.question() else {
            self.drop_received();
            return;
        };
        let length = request.reply_length(self.settings.roboclaw.status_bytes);
        if self.received.len() < length {
            return;
        }
        let reply = request.reply(self.settings.roboclaw.address, &self.received);
        let Some(reply) = reply else {
            self.drop_received();
            return;
        };
        self.received.clear();
        self.exchange.settle();
        self.take(request, reply, now_s);
    }

    fn transmit(&mut self, now_s: f64, line: &mut Vec<u8>) {
        match self.exchange.turn(now_s) {
            Turn::Wait => return,
            // A command does not wait for the second try of a question.
            Turn::Again(request) if self.is_due && self.is_ready() && !is_drive(request) => {
                self.exchange.settle();
                self.counters.unanswered += 1;
                // The round goes on where it was, or a slow line would never end one; but both counters are read together.
                if self.asked < ENCODERS {
                    self.asked = 0;
                }
            }
            // It was to stand when the watchdog was not confirmed, and is to move by now.
            Turn::Again(request) if is_drive(request) && !self.may_drive() => {
                self.exchange.settle();
                self.counters.unanswered += 1;
            }
            Turn::Again(request) => {
                self.counters.repeated += 1;
                // A command is repeated as what is wanted by now.
                let request = if is_drive(request) {
                    self.drive()
                } else {
                    request
                };
                self.send(request, line);
                return;
            }
            Turn::GivenUp(_) => {
                self.counters.unanswered += 1;
                self.asked = ROUND.len();
                // It may have been switched off and on, and knows of no watchdog then.
                self.watchdog = Watchdog::Unknown;
            }
            Turn::Free => {}
        }
        if let Some(request) = self.next_request(now_s) {
            self.exchange.ask(request, now_s);
            self.send(request, line);
        }
    }

    fn is_waiting(&self) -> bool {
        self.exchange.question().is_some()
    }

    fn newest(&self) -> Option<&Heard> {
        self.newest.as_ref()
    }

    fn counters(&self) -> Counters {
        Counters {
            refused_readings: self.meter.refused(),
            ..self.counters
        }
    }

    fn engage_stop(&mut self) {
        self.wanted = TrackSpeeds::default();
        self.is_due = true;
    }

    fn release(&mut self) {
        self.engage_stop();
        self.meter.release();
    }
}
