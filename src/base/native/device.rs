//! The base's side: reference behaviour of the firmware.

use super::frames::{Command, Decoder, Report};
use super::{REPORT_PERIOD_S, WATCHDOG_S};
use crate::base::device::{CommandCounter, CommandStats};
use crate::base::{BaseError, BaseSettings, DeviceProtocol, Faults, MachineState};
use crate::robot::TrackSpeeds;

/// A lower controller with the native protocol, its watchdog and its latched stop.
#[derive(Clone, Debug)]
pub struct NativeDevice {
    settings: BaseSettings,
    decoder: Decoder<Command>,
    set: TrackSpeeds,
    /// Sequence and time of the last accepted command.
    accepted: Option<(u16, f64)>,
    stopped: bool,
    /// Whether to release the stop in the next cycle, unless the button is pressed.
    release: bool,
    next_report_s: f64,
    sequence: u16,
    commands: CommandCounter,
}

impl NativeDevice {
    /// Creates a controller at power-on.
    ///
    /// # Errors
    /// Settings out of range.
    pub fn new(settings: BaseSettings) -> Result<Self, BaseError> {
        settings.validate()?;
        Ok(Self {
            settings,
            decoder: Decoder::default(),
            set: TrackSpeeds::default(),
            accepted: None,
            stopped: false,
            release: false,
            next_report_s: f64::NEG_INFINITY,
            sequence: 0,
            commands: CommandCounter::default(),
        })
    }

    fn accept(&mut self, command: &Command, now_s: f64) {
        if self.accepted.is_some_and(|(last, _)| last == command.sequence) {
            return;
        }
        self.accepted = Some((command.sequence, now_s));
        self.commands.command(command.speeds == [0, 0]);
        let rates = command.speeds.map(f64::from);
        self.set = self.settings.track_speeds(rates);
        if command.stop {
            self.stopped = true;
            self.release = false;
        } else if command.release && command.speeds == [0, 0] {
            self.release = true;
        }
    }
}

impl DeviceProtocol for NativeDevice {
    fn receive(&mut self, bytes: &[u8], now_s: f64) {
        self.decoder.push(bytes);
        while let Some(command) = self.decoder.next() {
            self.accept(&command, now_s);
        }
    }

    fn step(&mut self, now_s: f64, machine: &MachineState, line: &mut Vec<u8>) -> TrackSpeeds {
        if self.release {
            self.stopped = false;
            self.release = false;
        }
        self.stopped |= machine.button_pressed || !machine.faults.is_empty();
        let silent = self.accepted.is_none_or(|(_, at_s)| now_s - at_s >= WATCHDOG_S);
        self.commands.watchdog(silent && !self.stopped && self.set != TrackSpeeds::default());
        if now_s >= self.next_report_s {
            let next_s = self.next_report_s + REPORT_PERIOD_S;
            // No burst of reports after a pause.
            self.next_report_s = if next_s > now_s { next_s } else { now_s + REPORT_PERIOD_S };
            self.sequence = self.sequence.wrapping_add(1);
            let report = Report {
                sequence: self.sequence,
                echo: self.accepted.map(|(sequence, _)| sequence),
                stopped: self.stopped,
                button_pressed: machine.button_pressed,
                faults: machine.faults.union(Faults::WATCHDOG.when(silent)),
                time_ms: (now_s * 1000.0).round() as i64 as u32,
                counts: self.settings.channel_counts(machine.encoder_counts),
                yaw_rate_mrad_s: Some((machine.yaw_rate * 1000.0).round() as i16),
                battery_mv: Some((machine.battery_v * 1000.0).round() as u16),
            };
            line.extend(report.encode());
        }
        if self.stopped || silent { TrackSpeeds::default() } else { self.set }
    }

    fn command_stats(&self) -> CommandStats {
        self.commands.stats()
    }
}
