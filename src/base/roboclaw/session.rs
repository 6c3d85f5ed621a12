//! The two sides: the host sets the watchdog first, then sends commands and polls the controller between them; the
//! controller answers.

use super::frames::{POLL_CYCLE, Request, read_status, write_status};
use super::{PACKET_PAUSE_S, RoboClawSettings};
use crate::base::protocol::{CommandCounter, SessionCore};
use crate::base::request::{RequestState, RequestTracker};
use crate::base::{
    BaseError, BaseSettings, CommandStats, DeviceProtocol, Feedback, MachineState, Session,
};
use crate::robot::TrackSpeeds;

/// Number of leading queries that read the encoders.
const ENCODER_QUERIES: usize = 2;

/// Host session of a `RoboClaw`.
///
/// One request is outstanding at a time, and a command goes before the next query of a poll cycle. Until the controller has
/// confirmed its watchdog the session sends only the watchdog setting and zero commands: it does not drive a base that would not
/// stop by itself. A controller that receives but does not answer gets zero for every command, because the session's requests keep
/// its watchdog from acting.
#[derive(Clone, Debug)]
pub struct RoboClawSession {
    core: SessionCore,
    requests: RequestTracker<Request>,
    received: Vec<u8>,
    watchdog: Watchdog,
    /// Position in the poll cycle.
    next_query: usize,
    /// The number in the last answer to each query of the poll cycle.
    answers: [u32; POLL_CYCLE.len()],
    next_poll_s: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Watchdog {
    Unconfirmed,
    Set,
    Confirmed,
}

impl RoboClawSession {
    /// Creates a session.
    ///
    /// # Errors
    /// Settings out of range.
    pub fn new(settings: BaseSettings) -> Result<Self, BaseError> {
        let core = SessionCore::new(settings)?;
        let RoboClawSettings { answer_timeout_s, max_attempts, .. } = settings.roboclaw;
        Ok(Self {
            core,
            requests: RequestTracker::new(answer_timeout_s, max_attempts),
            received: Vec::new(),
            watchdog: Watchdog::Unconfirmed,
            next_query: POLL_CYCLE.len(),
            answers: [0; POLL_CYCLE.len()],
            next_poll_s: f64::NEG_INFINITY,
        })
    }

    /// Whether the controller has confirmed its watchdog.
    pub(crate) fn is_ready(&self) -> bool {
        self.watchdog == Watchdog::Confirmed
    }

    /// The next request, if one is due.
    fn next_request(&mut self, now_s: f64) -> Option<Request> {
        if self.core.is_pending {
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

    /// Takes the latest command. Until the watchdog is confirmed it becomes zero: the controller may still run at an earlier speed.
    fn drive(&mut self) -> Request {
        let rates = self.core.take_rates();
        // The cast saturates.
        let rate = |rate: f64| if self.is_ready() { rate.round() as i32 } else { 0 };
        Request::Drive(rates.map(rate))
    }

    fn send(&mut self, request: Request, line: &mut Vec<u8>) {
        self.drop_received();
        line.extend(request.encode(self.core.settings.roboclaw.address));
    }

    fn drop_received(&mut self) {
        self.core.counters.dropped_bytes += self.received.len() as u64;
        self.received.clear();
    }

    fn take(&mut self, request: Request, number: u32, now_s: f64) {
        match request {
            Request::SetTimeout(_) => self.watchdog = Watchdog::Set,
            Request::GetTimeout => {
                let confirmed = number == u32::from(self.core.settings.roboclaw.watchdog_tenths());
                self.watchdog = if confirmed { Watchdog::Confirmed } else { Watchdog::Unconfirmed };
            }
            query if POLL_CYCLE.get(self.next_query) == Some(&query) => {
                self.answers[self.next_query] = number;
                self.next_query += 1;
                if self.next_query == POLL_CYCLE.len() {
                    self.finish_cycle(now_s);
                }
            }
            _ => {}
        }
    }

    fn finish_cycle(&mut self, now_s: f64) {
        let [first, second, first_speed, second_speed, status, decivolts] = self.answers;
        let counts = self.core.settings.track_counts([first, second]);
        // The controller's speeds are more accurate, but implausible counts invalidate the whole answer.
        if self.core.encoder_speed.update_on_arrival(counts, now_s).is_none() {
            // They may be those of a controller that was restarted and has lost its watchdog setting.
            self.watchdog = Watchdog::Unconfirmed;
            return;
        }
        let speeds = [first_speed, second_speed].map(|speed| f64::from(speed as i32));
        let speeds = self.core.settings.track_speeds(speeds);
        let (emergency_stop, faults) = read_status(&self.core.settings, status);
        let feedback = Feedback {
            twist: self.core.settings.drive().twist(&speeds),
            emergency_stop,
            battery_v: Some(f64::from(decivolts) / 10.0),
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
    fn core(&self) -> &SessionCore {
        &self.core
    }

    fn core_mut(&mut self) -> &mut SessionCore {
        &mut self.core
    }

    fn baud(&self) -> u32 {
        self.core.settings.roboclaw.baud
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
        let Some(number) = reply else {
            self.drop_received();
            return;
        };
        self.received.clear();
        self.requests.finish();
        self.take(request, number, now_s);
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
}

/// A `RoboClaw` controller. Its watchdog is off at power-on, and any received byte resets it.
#[derive(Clone, Debug)]
pub struct RoboClawDevice {
    settings: BaseSettings,
    received: Vec<u8>,
    requests: Vec<Request>,
    last_byte_s: f64,
    watchdog_tenths: u8,
    set: [i32; 2],
    commands: CommandCounter,
}

impl RoboClawDevice {
    /// Creates a controller at power-on.
    ///
    /// # Errors
    /// Settings out of range.
    pub fn new(settings: BaseSettings) -> Result<Self, BaseError> {
        settings.validate()?;
        Ok(Self {
            settings,
            received: Vec::new(),
            requests: Vec::new(),
            last_byte_s: f64::NEG_INFINITY,
            watchdog_tenths: 0,
            set: [0, 0],
            commands: CommandCounter::default(),
        })
    }

    fn answer(&mut self, request: Request, machine: &MachineState) -> Vec<u8> {
        let settings = &self.settings;
        let with_flags = |number: [u8; 4]| [&number[..], &[0]].concat();
        let data = match request {
            Request::SetTimeout(tenths) => {
                self.watchdog_tenths = tenths;
                return vec![0xFF];
            }
            Request::Drive(speeds) => {
                self.set = speeds;
                self.commands.command(speeds == [0, 0]);
                return vec![0xFF];
            }
            Request::GetTimeout => vec![self.watchdog_tenths],
            Request::Encoder { second } => {
                let counts = settings.channel_counts(machine.encoder_counts);
                with_flags(counts[usize::from(second)].to_be_bytes())
            }
            Request::Speed { second } => {
                let rate = settings.channel_rates(&machine.speeds)[usize::from(second)];
                with_flags((rate.round() as i32).to_be_bytes())
            }
            Request::Battery => {
                let decivolts = (machine.battery_v * 10.0).round() as u16;
                decivolts.to_be_bytes().to_vec()
            }
            Request::Status => {
                let bits = write_status(settings, machine.button_pressed, machine.faults);
                bits.to_be_bytes()[4 - settings.roboclaw.status_bytes..].to_vec()
            }
        };
        request.encode_reply(settings.roboclaw.address, data)
    }
}

impl DeviceProtocol for RoboClawDevice {
    fn receive(&mut self, bytes: &[u8], now_s: f64) {
        if bytes.is_empty() {
            return;
        }
        if now_s - self.last_byte_s > PACKET_PAUSE_S {
            self.received.clear();
        }
        self.last_byte_s = now_s;
        self.received.extend_from_slice(bytes);
        loop {
            match Request::decode(&self.received, self.settings.roboclaw.address) {
                Ok(Some((request, length))) => {
                    self.requests.push(request);
                    self.received.drain(..length);
                }
                Ok(None) => return,
                // The controller stays silent; the host's pause resynchronizes it.
                Err(_) => {
                    self.received.clear();
                    return;
                }
            }
        }
    }

    fn step(&mut self, now_s: f64, machine: &MachineState, line: &mut Vec<u8>) -> TrackSpeeds {
        for request in std::mem::take(&mut self.requests) {
            line.extend(self.answer(request, machine));
        }
        let watchdog_s = f64::from(self.watchdog_tenths) / 10.0;
        let is_silent = self.watchdog_tenths > 0 && now_s - self.last_byte_s >= watchdog_s;
        self.commands.watchdog(is_silent && self.set != [0, 0]);
        if is_silent {
            // The set speeds are cleared, so that later queries do not restart the motors.
            self.set = [0, 0];
        }
        if machine.button_pressed {
            TrackSpeeds::default()
        } else {
            self.settings.track_speeds(self.set.map(f64::from))
        }
    }

    fn command_stats(&self) -> CommandStats {
        self.commands.stats()
    }
}
