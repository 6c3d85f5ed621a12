//! The base's side: what the published firmware does.

use super::REPORT_EVERY_S;
use super::frames::{Command, Decoder, Report};
use crate::base::peer::{OrderBook, Orders};
use crate::base::{BaseError, BaseSettings, Machine, Peer};
use crate::geometry::Twist;
use crate::robot::{TrackSpeeds, TrackedDrive};

/// A lower controller that speaks WHEELTEC's frames. It obeys the last command for ever: the command-loss stop of the
/// published firmware is commented out.
#[derive(Clone, Debug)]
pub struct WheeltecPeer {
    /// The firmware's own drive, of the geometric width.
    drive: TrackedDrive,
    decoder: Decoder<Command>,
    set: Twist,
    next_report_s: f64,
    orders: OrderBook,
}

impl WheeltecPeer {
    /// A controller that was just switched on, of a machine that is as the settings say.
    ///
    /// # Errors
    /// Those of [`BaseSettings::validate`].
    pub fn new(settings: &BaseSettings) -> Result<Self, BaseError> {
        settings.validate()?;
        Ok(Self {
            drive: TrackedDrive {
                track_width_m: settings.track_width_m,
            },
            decoder: Decoder::default(),
            set: Twist::STOP,
            next_report_s: f64::NEG_INFINITY,
            orders: OrderBook::default(),
        })
    }
}

impl Peer for WheeltecPeer {
    fn receive(&mut self, bytes: &[u8], _now_s: f64) {
        self.decoder.push(bytes);
        for command in self.decoder.by_ref() {
            self.orders.command(command.twist == Twist::STOP);
            self.set = command.twist;
        }
    }

    fn step(&mut self, now_s: f64, machine: &Machine, line: &mut Vec<u8>) -> TrackSpeeds {
        let stopped = machine.button_pressed || !machine.faults.is_none();
        if now_s >= self.next_report_s {
            let next_s = self.next_report_s + REPORT_EVERY_S;
            // No burst of reports after a pause.
            self.next_report_s = if next_s > now_s {
                next_s
            } else {
                now_s + REPORT_EVERY_S
            };
            let report = Report {
                motors_disabled: stopped,
                twist: self.drive.twist(&machine.speeds),
                gyro: [0.0, 0.0, machine.yaw_rate],
                battery_v: machine.battery_v,
                ..Report::default()
            };
            line.extend(report.encode());
        }
        if stopped {
            TrackSpeeds::default()
        } else {
            self.drive.tracks(&self.set)
        }
    }

    fn orders(&self) -> Orders {
        self.orders.orders()
    }
}
