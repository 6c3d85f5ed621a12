//! Protocol of `ROSArduinoBridge`: lines of text without a checksum.
//!
//! A command is a letter, its arguments after spaces, and a carriage return. Each is answered by one line that ends with
//! carriage return and line feed. `m L R` sets the speeds of both motors in encoder ticks per cycle of the firmware's speed
//! control and is answered by `OK`; `e` reads both encoders. The cycle takes 1000 / 30 milliseconds in integers: 33 ms. The
//! firmware stops 2 s after the last `m`.
//!
//! Without a checksum the session validates otherwise. An answer is valid only if it is exactly `OK` or exactly two integers, and
//! counts that ran farther than a track can are rejected. A lost carriage return would join two commands, and the firmware joins
//! their arguments to a wild speed. So each command waits for the answer to the previous one; after a missing answer a carriage
//! return goes first and ends any partial line.
//!
//! The firmware applies its first argument to the left motor, but its own Python driver sends the right one first. Turn on the spot
//! to find the order on your robot, and set `swap_tracks`: encoders alone show nothing, as they are swapped too; with a gyro the
//! turn rates differ in sign.

use serde::{Deserialize, Serialize};

use super::protocol::{CommandCounter, SessionCore};
use super::request::{RequestState, RequestTracker};
use super::{
    BaseError, BaseSettings, CommandStats, DeviceProtocol, Feedback, MachineState, Session,
};
use crate::robot::TrackSpeeds;
use crate::settings::{require, settings};

/// Time after the last motor command at which the firmware stops, seconds.
pub const WATCHDOG_S: f64 = 2.0;

settings! {
    /// Protocol settings of a `ROSArduinoBridge`.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct ArduinoSettings {
        /// Speed of the serial line. Default 57,600, the firmware's.
        pub baud: u32 = 57_600, ["baud", at_least 1];
        /// Cycle time of the firmware's speed control. Default 0.033 s.
        pub pid_interval_s: f64 = 0.033, ["s", above 0 to 0.2];
        /// Time until an answer counts as lost. Default 0.05 s: the firmware may move servos between two reads, and
        /// USB adapters delay bytes for up to 0.016 s.
        pub answer_timeout_s: f64 = 0.05, ["s", above 0];
        /// Attempts of each request. Default 3.
        pub max_attempts: u32 = 3, ["", at_least 1];
        /// Time between encoder readings. Default 0.033 s, one cycle of the firmware.
        pub poll_period_s: f64 = 0.033, ["s", above 0];
    }
}

/// Longest valid answer line, bytes: two signed 32-bit integers of eleven characters, a space and the line end.
const MAX_LINE: usize = 25;

/// An answer of the firmware.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// `OK`.
    Ok,
    /// Two integers: the encoder counts of the first and the second channel, modulo 2^32.
    Counts([u32; 2]),
}

/// Parses a line without its line end; returns none for any other line.
///
/// Counts are two 32-bit integers separated by one space, without plus sign, extra spaces or leading zeros. The firmware writes
/// them so; any other spelling is a damaged line.
#[doc(hidden)]
#[must_use]
pub fn parse_answer(line: &[u8]) -> Option<Answer> {
    if line == b"OK" {
        return Some(Answer::Ok);
    }
    let text = str::from_utf8(line).ok()?;
    let (first, second) = text.split_once(' ')?;
    Some(Answer::Counts([count(first)?, count(second)?]))
}

fn count(text: &str) -> Option<u32> {
    let digits = text.strip_prefix('-').unwrap_or(text);
    let is_canonical =
        digits == "0" && text == "0" || digits.starts_with(|first| matches!(first, '1'..='9'));
    if !is_canonical {
        return None;
    }
    text.parse::<i32>().ok().map(|count| count as u32)
}

/// The kinds of request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Request {
    /// `m`: set the motor speeds.
    SetSpeeds,
    /// `e`: read the encoders.
    ReadEncoders,
}

/// Host session of a `ROSArduinoBridge`. It reports encoder counts only.
#[doc(hidden)]
#[derive(Clone, Debug)]
pub struct ArduinoSession {
    core: SessionCore,
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
        let core = SessionCore::new(settings)?;
        let ArduinoSettings { pid_interval_s, answer_timeout_s, max_attempts, .. } =
            settings.arduino;
        for ticks_per_m in [settings.ticks_per_m.left, settings.ticks_per_m.right] {
            let fastest = settings.tracks.max_track_speed * ticks_per_m * pid_interval_s;
            require(
                fastest <= f64::from(i16::MAX),
                "ticks_per_m",
                ticks_per_m,
                "smaller: a ROSArduinoBridge has 16 bits for max_track_speed * ticks_per_m * pid_interval_s",
            )?;
        }
        Ok(Self {
            core,
            requests: RequestTracker::new(answer_timeout_s, max_attempts),
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
                // Integers have 16 bits on the smaller boards. Every speed fits, by the check of the settings.
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
        let Some(speeds) = self.core.encoder_speed.update_on_arrival(counts, now_s) else {
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
    fn core(&self) -> &SessionCore {
        &self.core
    }

    fn core_mut(&mut self) -> &mut SessionCore {
        &mut self.core
    }

    fn baud(&self) -> u32 {
        self.core.settings.arduino.baud
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
}

/// Size of the firmware's argument buffer, bytes. The firmware writes beyond it; the emulator does not.
const MAX_ARGUMENT: usize = 31;

/// A lower controller that runs `ROSArduinoBridge`.
///
/// Like the firmware's parser, it takes the last letter before the first space as the command and joins all arguments from the
/// second on.
#[doc(hidden)]
#[derive(Clone, Debug)]
pub struct ArduinoDevice {
    settings: BaseSettings,
    command: u8,
    arguments: [Vec<u8>; 2],
    /// Spaces in the line so far, at most two.
    spaces: usize,
    /// Received lines to be answered; none for an invalid one.
    requests: Vec<Option<Request>>,
    set: [i32; 2],
    last_command_s: f64,
    commands: CommandCounter,
}

impl ArduinoDevice {
    /// Creates a controller at power-on.
    ///
    /// # Errors
    /// Settings out of range.
    pub fn new(settings: BaseSettings) -> Result<Self, BaseError> {
        settings.validate()?;
        Ok(Self {
            settings,
            command: 0,
            arguments: [Vec::new(), Vec::new()],
            spaces: 0,
            requests: Vec::new(),
            set: [0, 0],
            last_command_s: f64::NEG_INFINITY,
            commands: CommandCounter::default(),
        })
    }

    fn finish_line(&mut self, now_s: f64) {
        let request = match self.command {
            b'm' => {
                self.set = [0, 1].map(|index: usize| leading_integer(&self.arguments[index]));
                self.last_command_s = now_s;
                self.commands.command(self.set == [0, 0]);
                Some(Request::SetSpeeds)
            }
            b'e' => Some(Request::ReadEncoders),
            _ => None,
        };
        self.requests.push(request);
        self.command = 0;
        self.arguments = [Vec::new(), Vec::new()];
        self.spaces = 0;
    }
}

/// Parses like C's `atoi`, saturating.
fn leading_integer(text: &[u8]) -> i32 {
    let (sign, digits) = match text {
        [b'-', digits @ ..] => (-1, digits),
        digits => (1, digits),
    };
    digits
        .iter()
        .map_while(|digit| digit.is_ascii_digit().then(|| i32::from(digit - b'0')))
        .fold(0, |number: i32, digit| number.saturating_mul(10).saturating_add(sign * digit))
}

impl DeviceProtocol for ArduinoDevice {
    fn receive(&mut self, bytes: &[u8], now_s: f64) {
        for byte in bytes {
            match (*byte, self.spaces) {
                (b'\r', _) => self.finish_line(now_s),
                (b' ', spaces) => self.spaces = (spaces + 1).min(2),
                (letter, 0) => self.command = letter,
                (letter, spaces) => {
                    let argument = &mut self.arguments[spaces - 1];
                    if argument.len() < MAX_ARGUMENT {
                        argument.push(letter);
                    }
                }
            }
        }
    }

    fn step(&mut self, now_s: f64, machine: &MachineState, line: &mut Vec<u8>) -> TrackSpeeds {
        for request in std::mem::take(&mut self.requests) {
            match request {
                Some(Request::SetSpeeds) => line.extend(*b"OK\r\n"),
                Some(Request::ReadEncoders) => {
                    let counts = self.settings.channel_counts(machine.encoder_counts);
                    let [first, second] = counts.map(|count| count as i32);
                    line.extend(format!("{first} {second}\r\n").into_bytes());
                }
                None => line.extend(*b"Invalid Command\r\n"),
            }
        }
        let is_silent = now_s - self.last_command_s > WATCHDOG_S;
        self.commands.watchdog(is_silent && self.set != [0, 0]);
        if is_silent || machine.button_pressed {
            return TrackSpeeds::default();
        }
        let interval_s = self.settings.arduino.pid_interval_s;
        let rates = self.set.map(|ticks| f64::from(ticks) / interval_s);
        self.settings.track_speeds(rates)
    }

    fn command_stats(&self) -> CommandStats {
        self.commands.stats()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn longest_answer_is_taken() {
        let mut session = ArduinoSession::new(BaseSettings::default()).expect("valid settings");
        session.transmit(0.0, &mut Vec::new());
        let answer = format!("{0} {0}\r\n", i32::MIN);
        assert_eq!(answer.len(), MAX_LINE);
        session.receive(answer.as_bytes(), 0.01);
        let counts = session.latest().and_then(|latest| latest.feedback.encoder_counts);
        assert_eq!(counts.map(|counts| counts.left), Some(1 << 31));
        assert_eq!(session.counters().dropped_bytes, 0);
    }
}
