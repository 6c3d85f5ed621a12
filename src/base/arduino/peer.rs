//! The base's side: what the firmware makes of lines, its weaknesses included.

use super::WATCHDOG_S;
use crate::base::peer::{OrderBook, Orders};
use crate::base::{BaseError, BaseSettings, Machine, Peer};
use crate::robot::TrackSpeeds;

/// Length of the firmware's buffer of an argument, bytes; it writes beyond it, which is not to be imitated.
const ARGUMENT: usize = 31;

/// A `ROSArduinoBridge`.
///
/// Its parser takes the last letter before the first space for the command and joins all arguments from the second on,
/// as that of the firmware does.
#[derive(Clone, Debug)]
pub struct ArduinoPeer {
    settings: BaseSettings,
    command: u8,
    arguments: [Vec<u8>; 2],
    /// Spaces seen in the line, two at most.
    spaces: usize,
    lines: Vec<Line>,
    set: [i32; 2],
    last_run_s: f64,
    orders: OrderBook,
}

/// A line that is to be answered.
#[derive(Clone, Copy, Debug)]
enum Line {
    Run,
    Read,
    Invalid,
}

impl ArduinoPeer {
    /// A controller that was just switched on, of a machine that is as the settings say.
    ///
    /// # Errors
    /// Those of [`BaseSettings::validate`].
    pub fn new(settings: BaseSettings) -> Result<Self, BaseError> {
        settings.validate()?;
        Ok(Self {
            settings,
            command: 0,
            arguments: [Vec::new(), Vec::new()],
            spaces: 0,
            lines: Vec::new(),
            set: [0, 0],
            last_run_s: f64::NEG_INFINITY,
            orders: OrderBook::default(),
        })
    }

    fn obey(&mut self, now_s: f64) {
        let line = match self.command {
            b'm' => {
                self.set = [0, 1].map(|index: usize| leading_integer(&self.arguments[index]));
                self.last_run_s = now_s;
                self.orders.command(self.set == [0, 0]);
                Line::Run
            }
            b'e' => Line::Read,
            _ => Line::Invalid,
        };
        self.lines.push(line);
        self.command = 0;
        self.arguments = [Vec::new(), Vec::new()];
        self.spaces = 0;
    }
}

/// What C's `atoi` reads, saturated.
fn leading_integer(text: &[u8]) -> i32 {
    let (sign, digits) = match text {
        [b'-', digits @ ..] => (-1, digits),
        digits => (1, digits),
    };
    digits
        .iter()
        .map_while(|digit| digit.is_ascii_digit().then(|| i32::from(digit - b'0')))
        .fold(0, |number: i32, digit| {
            number.saturating_mul(10).saturating_add(sign * digit)
        })
}

impl Peer for ArduinoPeer {
    fn receive(&mut self, bytes: &[u8], now_s: f64) {
        for byte in bytes {
            match (*byte, self.spaces) {
                (b'\r', _) => self.obey(now_s),
                (b' ', spaces) => self.spaces = (spaces + 1).min(2),
                (letter, 0) => self.command = letter,
                (letter, spaces) => {
                    let argument = &mut self.arguments[spaces - 1];
                    if argument.len() < ARGUMENT {
                        argument.push(letter);
                    }
                }
            }
        }
    }

    fn step(&mut self, now_s: f64, machine: &Machine, line: &mut Vec<u8>) -> TrackSpeeds {
        for question in std::mem::take(&mut self.lines) {
            match question {
                Line::Run => line.extend(*b"OK\r\n"),
                Line::Read => {
                    let counts = self.settings.channel_counts(machine.ticks);
                    let [first, second] = counts.map(|count| count as i32);
                    line.extend(format!("{first} {second}\r\n").into_bytes());
                }
                Line::Invalid => line.extend(*b"Invalid Command\r\n"),
            }
        }
        let is_silent = now_s - self.last_run_s > WATCHDOG_S;
        self.orders.starved(is_silent && self.set != [0, 0]);
        if is_silent || machine.button_pressed {
            return TrackSpeeds::default();
        }
        let interval_s = self.settings.arduino.pid_interval_s;
        let rates = self.set.map(|ticks| f64::from(ticks) / interval_s);
        self.settings.track_speeds(rates)
    }

    fn orders(&self) -> Orders {
        self.orders.orders()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(lines: &[u8]) -> [i32; 2] {
        let mut peer = ArduinoPeer::new(BaseSettings::default()).expect("sound settings");
        peer.receive(lines, 0.0);
        peer.set
    }

    #[test]
    fn arguments_are_read_as_the_firmware_reads_them() {
        assert_eq!(run(b"m 20 -30\r"), [20, -30]);
        assert_eq!(run(b"m 20\r"), [20, 0]);
        assert_eq!(run(b"m 2x0 +3\r"), [2, 0]);
        // Two commands whose first lost its carriage return are one with a wild speed.
        assert_eq!(run(b"m 10 10m 20 20\r"), [10, 10]);
        assert_eq!(run(b"m 10 1020 20\r"), [10, 102_020]);
    }
}
