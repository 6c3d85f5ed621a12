//! The host's side: sends commands, derives feedback from reports.

use std::collections::VecDeque;

use super::BAUD;
use super::frames::{Command, Decoder, Report};
use crate::base::session::TrackSession;
use crate::base::{BaseError, BaseSettings, Feedback, Session, SessionCounters, TimedFeedback};
use crate::geometry::Twist;

/// Most unacknowledged commands that are remembered: several seconds at the usual rate.
const MAX_UNACKNOWLEDGED: usize = 256;

/// Host session of the native protocol.
#[derive(Clone, Debug)]
pub struct NativeSession {
    core: TrackSession,
    stop: bool,
    release: bool,
    sequence: u16,
    decoder: Decoder<Report>,
    clock: DeviceClock,
    /// Sequence of the last report.
    reported: Option<u16>,
    /// Sequence and sending time of each command that the base has not acknowledged, the oldest first.
    unacknowledged: VecDeque<(u16, f64)>,
}

/// Unwraps the controller's millisecond clock.
#[derive(Clone, Copy, Debug, Default)]
struct DeviceClock {
    last_ms: u32,
    time_ms: i64,
}

impl DeviceClock {
    /// Seconds since the first reading. The clock steps back once after the base was restarted.
    fn unwrap_ms(&mut self, now_ms: u32) -> f64 {
        self.time_ms += i64::from(now_ms.wrapping_sub(self.last_ms) as i32);
        self.last_ms = now_ms;
        self.time_ms as f64 / 1000.0
    }
}

impl NativeSession {
    /// Creates a session whose first command has sequence 1.
    ///
    /// # Errors
    /// Settings out of range.
    pub fn new(settings: BaseSettings) -> Result<Self, BaseError> {
        Ok(Self {
            core: TrackSession::new(settings)?,
            stop: false,
            release: false,
            sequence: 0,
            decoder: Decoder::default(),
            clock: DeviceClock::default(),
            reported: None,
            unacknowledged: VecDeque::new(),
        })
    }

    /// Drops the acknowledged commands and returns the age of the oldest one left, seconds.
    fn acknowledge(&mut self, report: &Report, now_s: f64) -> Option<f64> {
        let echo = report.echo?;
        // A later command's echo also covers commands that were lost.
        if let Some(index) = self.unacknowledged.iter().position(|(number, _)| *number == echo) {
            self.unacknowledged.drain(..=index);
        }
        let oldest_s = self.unacknowledged.front().map_or(now_s, |(_, sent_s)| *sent_s);
        Some(now_s - oldest_s)
    }

    fn feedback(&mut self, report: &Report, command_delay_s: Option<f64>) -> Option<Feedback> {
        let counts = self.core.settings.track_counts(report.counts);
        let time_s = self.clock.unwrap_ms(report.time_ms);
        let speeds = self.core.encoder_speed.update(counts, time_s)?;
        Some(Feedback {
            twist: self.core.settings.drive().twist(&speeds),
            emergency_stop: report.stopped || report.button_pressed,
            battery_v: report.battery_mv.map(|millivolts| f64::from(millivolts) / 1000.0),
            encoder_counts: Some(counts),
            yaw_rate: report.yaw_rate_mrad_s.map(|rate| f64::from(rate) / 1000.0),
            faults: report.faults.union(self.core.encoder_speed.faults()),
            command_delay_s,
        })
    }
}

impl Session for NativeSession {
    fn baud(&self) -> u32 {
        BAUD
    }

    fn command(&mut self, twist: &Twist) -> Result<(), BaseError> {
        self.core.command(twist)
    }

    fn receive(&mut self, bytes: &[u8], now_s: f64) {
        self.decoder.push(bytes);
        while let Some(report) = self.decoder.next() {
            // A repeated sequence comes from a stuck buffer, not from a running controller.
            if self.reported.replace(report.sequence) == Some(report.sequence) {
                continue;
            }
            let command_delay_s = self.acknowledge(&report, now_s);
            if let Some(feedback) = self.feedback(&report, command_delay_s) {
                self.core.report(feedback, now_s);
            }
        }
    }

    fn transmit(&mut self, now_s: f64, line: &mut Vec<u8>) {
        if !self.core.is_pending {
            return;
        }
        self.core.is_pending = false;
        self.sequence = self.sequence.wrapping_add(1);
        let stands = self.stop || self.release;
        let speeds = if stands {
            [0, 0]
        } else {
            // The cast saturates.
            self.core.settings.channel_rates(&self.core.target).map(|rate| rate.round() as i32)
        };
        let command =
            Command { sequence: self.sequence, stop: self.stop, release: self.release, speeds };
        self.release = false;
        if self.unacknowledged.len() == MAX_UNACKNOWLEDGED {
            self.unacknowledged.pop_front();
        }
        self.unacknowledged.push_back((self.sequence, now_s));
        line.extend(command.encode());
    }

    fn is_waiting(&self) -> bool {
        false
    }

    fn latest(&self) -> Option<&TimedFeedback> {
        self.core.latest.as_ref()
    }

    fn counters(&self) -> SessionCounters {
        SessionCounters { dropped_bytes: self.decoder.dropped_bytes(), ..self.core.counters() }
    }

    fn engage_stop(&mut self) {
        self.core.stop();
        self.stop = true;
        self.release = false;
    }

    fn release(&mut self) {
        self.core.release();
        self.stop = false;
        self.release = true;
    }
}
