//! The host's side: a command for each motion, and feedback from reports.

use std::collections::VecDeque;

use super::BAUD;
use super::frames::{Command, Decoder, Report};
use crate::base::tick_meter::TickMeter;
use crate::base::{BaseError, BaseSettings, Counters, Feedback, Heard, Session};
use crate::geometry::Twist;
use crate::robot::TrackSpeeds;

/// So many commands are remembered until the base has them: several seconds at the usual rate.
const REMEMBERED: usize = 256;

/// A base that speaks our own frames.
#[derive(Clone, Debug)]
pub struct NativeSession {
    settings: BaseSettings,
    wanted: TrackSpeeds,
    /// Whether there is something to send that did not go out yet.
    is_due: bool,
    stop: bool,
    release: bool,
    sequence: u16,
    decoder: Decoder<Report>,
    meter: TickMeter,
    clock: DeviceClock,
    newest: Option<Heard>,
    /// Number of the last report.
    reported: Option<u16>,
    echo: Option<u16>,
    /// Numbers of the commands that the base has not said to have, and when they were sent, the oldest first.
    under_way: VecDeque<(u16, f64)>,
}

/// The controller's milliseconds without their wrap-around.
#[derive(Clone, Copy, Debug, Default)]
struct DeviceClock {
    last_ms: u32,
    time_ms: i64,
}

impl DeviceClock {
    /// Seconds since the first reading. A base that was switched on anew runs backwards once.
    fn read(&mut self, now_ms: u32) -> f64 {
        self.time_ms += i64::from(now_ms.wrapping_sub(self.last_ms) as i32);
        self.last_ms = now_ms;
        self.time_ms as f64 / 1000.0
    }
}

impl NativeSession {
    /// A session whose first command is numbered 1.
    ///
    /// # Errors
    /// Those of [`BaseSettings::validate`].
    pub fn new(settings: BaseSettings) -> Result<Self, BaseError> {
        settings.validate()?;
        Ok(Self {
            settings,
            wanted: TrackSpeeds::default(),
            is_due: false,
            stop: false,
            release: false,
            sequence: 0,
            decoder: Decoder::default(),
            meter: TickMeter::new(&settings),
            clock: DeviceClock::default(),
            newest: None,
            reported: None,
            echo: None,
            under_way: VecDeque::new(),
        })
    }

    /// Number of commands sent since the last one that the base has said to have: none before it said so at all.
    #[must_use]
    pub fn commands_under_way(&self) -> Option<u16> {
        self.echo.map(|echo| self.sequence.wrapping_sub(echo))
    }

    /// Takes note of what the base has, and returns how far it is behind, seconds.
    fn acknowledge(&mut self, report: &Report, now_s: f64) -> Option<f64> {
        self.echo = report.echo;
        let echo = report.echo?;
        // Commands that were lost on the way are passed over by a later one's echo.
        if let Some(taken) = self
            .under_way
            .iter()
            .position(|(number, _)| *number == echo)
        {
            self.under_way.drain(..=taken);
        }
        let oldest_s = self.under_way.front().map_or(now_s, |(_, sent_s)| *sent_s);
        Some(now_s - oldest_s)
    }

    fn feedback(&mut self, report: &Report, behind_s: Option<f64>) -> Option<Feedback> {
        let ticks = self.settings.track_ticks(report.counts);
        let time_s = self.clock.read(report.time_ms);
        let speeds = self.meter.read(ticks, time_s)?;
        Some(Feedback {
            twist: self.settings.drive().twist(&speeds),
            emergency_stop: report.stopped || report.button_pressed,
            battery_v: report
                .battery_mv
                .map(|millivolts| f64::from(millivolts) / 1000.0),
            ticks: Some(ticks),
            yaw_rate: report.yaw_rate_mrad_s.map(|rate| f64::from(rate) / 1000.0),
            faults: report.faults.and(self.meter.faults()),
            behind_s,
        })
    }
}

impl Session for NativeSession {
    fn baud(&self) -> u32 {
        BAUD
    }

    fn command(&mut self, wanted: &Twist) -> Result<(), BaseError> {
        let possible = self.settings.possible(wanted)?;
        self.wanted = self.settings.drive().tracks(&possible);
        self.is_due = true;
        Ok(())
    }

    fn receive(&mut self, bytes: &[u8], now_s: f64) {
        self.decoder.push(bytes);
        while let Some(report) = self.decoder.next() {
            // The same again comes from a buffer, not from a controller that lives.
            if self.reported.replace(report.sequence) == Some(report.sequence) {
                continue;
            }
            let behind_s = self.acknowledge(&report, now_s);
            if let Some(feedback) = self.feedback(&report, behind_s) {
                self.newest = Some(Heard {
                    at_s: now_s,
                    feedback,
                });
            }
        }
    }

    fn transmit(&mut self, now_s: f64, line: &mut Vec<u8>) {
        if !self.is_due {
            return;
        }
        self.is_due = false;
        self.sequence = self.sequence.wrapping_add(1);
        let still = self.stop || self.release;
        let speeds = if still {
            [0, 0]
        } else {
            // The cast brings what does not fit to the nearest that does.
            self.settings
                .channel_rates(&self.wanted)
                .map(|rate| rate.round() as i32)
        };
        let command = Command {
            sequence: self.sequence,
            stop: self.stop,
            release: self.release,
            speeds,
        };
        self.release = false;
        if self.under_way.len() == REMEMBERED {
            self.under_way.pop_front();
        }
        self.under_way.push_back((self.sequence, now_s));
        line.extend(command.encode());
    }

    fn is_waiting(&self) -> bool {
        false
    }

    fn newest(&self) -> Option<&Heard> {
        self.newest.as_ref()
    }

    fn counters(&self) -> Counters {
        Counters {
            dropped_bytes: self.decoder.dropped_bytes(),
            refused_readings: self.meter.refused(),
            ..Counters::default()
        }
    }

    fn engage_stop(&mut self) {
        self.wanted = TrackSpeeds::default();
        self.stop = true;
        self.release = false;
        self.is_due = true;
    }

    fn release(&mut self) {
        self.wanted = TrackSpeeds::default();
        self.stop = false;
        self.release = true;
        self.is_due = true;
        self.meter.release();
    }
}
