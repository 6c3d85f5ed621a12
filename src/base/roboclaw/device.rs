//! The base's side: the controller's answers.

use super::frames::Request;
use super::{PACKET_PAUSE_S, status};
use crate::base::device::{CommandCounter, CommandStats};
use crate::base::{BaseError, BaseSettings, DeviceProtocol, MachineState};
use crate::robot::TrackSpeeds;

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
                let bits = status::write(settings, machine.button_pressed, machine.faults);
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
