//! The base's side: the firmware's parser, including its weaknesses.

use super::WATCHDOG_S;
use crate::base::device::{CommandCounter, CommandStats};
use crate::base::{BaseError, BaseSettings, DeviceProtocol, MachineState};
use crate::robot::TrackSpeeds;

/// Size of the firmware's argument buffer, bytes. The firmware writes beyond it; the emulator does not.
const MAX_ARGUMENT: usize = 31;

/// A lower controller that runs `ROSArduinoBridge`.
///
/// Like the firmware's parser, it takes the last letter before the first space as the command and joins all arguments from the
/// second on.
#[derive(Clone, Debug)]
pub struct ArduinoDevice {
    settings: BaseSettings,
    command: u8,
    arguments: [Vec<u8>; 2],
    /// Spaces in the line so far, at most two.
    spaces: usize,
    requests: Vec<Request>,
    set: [i32; 2],
    last_command_s: f64,
    commands: CommandCounter,
}

/// A received line, to be answered.
#[derive(Clone, Copy, Debug)]
enum Request {
    SetSpeeds,
    ReadEncoders,
    Invalid,
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
                Request::SetSpeeds
            }
            b'e' => Request::ReadEncoders,
            _ => Request::Invalid,
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
                Request::SetSpeeds => line.extend(*b"OK\r\n"),
                Request::ReadEncoders => {
                    let counts = self.settings.channel_counts(machine.encoder_counts);
                    let [first, second] = counts.map(|count| count as i32);
                    line.extend(format!("{first} {second}\r\n").into_bytes());
                }
                Request::Invalid => line.extend(*b"Invalid Command\r\n"),
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

    fn set_speeds(lines: &[u8]) -> [i32; 2] {
        let mut device = ArduinoDevice::new(BaseSettings::default()).expect("valid settings");
        device.receive(lines, 0.0);
        device.set
    }

    #[test]
    fn arguments_are_parsed_like_firmware() {
        assert_eq!(set_speeds(b"m 20 -30\r"), [20, -30]);
        assert_eq!(set_speeds(b"m 20\r"), [20, 0]);
        assert_eq!(set_speeds(b"m 2x0 +3\r"), [2, 0]);
        // Two commands become one with a wild speed if the first loses its carriage return.
        assert_eq!(set_speeds(b"m 10 10m 20 20\r"), [10, 10]);
        assert_eq!(set_speeds(b"m 10 1020 20\r"), [10, 102_020]);
    }
}
