//! The base's side: behaviour of the published firmware.

use super::Decoder;
use super::REPORT_PERIOD_S;
use super::frames::{Command, Report};
use crate::base::device::{CommandCounter, CommandStats};
use crate::base::{BaseError, BaseSettings, DeviceProtocol, MachineState};
use crate::geometry::Twist;
use crate::robot::{TrackSpeeds, TrackedDrive};

/// A lower controller with the WHEELTEC protocol. It follows the last command forever: the command-loss stop of the published
/// firmware is commented out.
#[derive(Clone, Debug)]
pub struct WheeltecDevice {
    /// The firmware's kinematics, with the geometric track width.
    drive: TrackedDrive,
    decoder: Decoder<Command>,
    set: Twist,
    next_report_s: f64,
    commands: CommandCounter,
}

impl WheeltecDevice {
    /// Creates a controller at power-on.
    ///
    /// # Errors
    /// Settings out of range.
    pub fn new(settings: &BaseSettings) -> Result<Self, BaseError> {
        settings.validate()?;
        Ok(Self {
            drive: TrackedDrive { track_width_m: settings.track_width_m },
            decoder: Decoder::default(),
            set: Twist::STOP,
            next_report_s: f64::NEG_INFINITY,
            commands: CommandCounter::default(),
        })
    }
}

impl DeviceProtocol for WheeltecDevice {
    fn receive(&mut self, bytes: &[u8], _now_s: f64) {
        self.decoder.push(bytes);
        for command in self.decoder.by_ref() {
            self.commands.command(command.twist == Twist::STOP);
            self.set = command.twist;
        }
    }

    fn step(&mut self, now_s: f64, machine: &MachineState, line: &mut Vec<u8>) -> TrackSpeeds {
        let stopped = machine.button_pressed || !machine.faults.is_empty();
        if now_s >= self.next_report_s {
            let next_s = self.next_report_s + REPORT_PERIOD_S;
            // No burst of reports after a pause.
            self.next_report_s = if next_s > now_s { next_s } else { now_s + REPORT_PERIOD_S };
            let report = Report {
                motors_disabled: stopped,
                twist: self.drive.twist(&machine.speeds),
                gyro: [0.0, 0.0, machine.yaw_rate],
                battery_v: machine.battery_v,
                ..Report::default()
            };
            line.extend(report.encode());
        }
        if stopped { TrackSpeeds::default() } else { self.drive.tracks(&self.set) }
    }

    fn command_stats(&self) -> CommandStats {
        self.commands.stats()
    }
}
