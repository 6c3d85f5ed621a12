//! The two sides: the host sends commands and derives feedback from reports; the base behaves as reference firmware.

use std::collections::VecDeque;

use super::frames::{Command, Decoder, Report};
use super::{BAUD, REPORT_PERIOD_S, WATCHDOG_S};
use crate::base::protocol::{CommandCounter, RELEASE_GRACE_S, ReportTimer, SessionCore};
use crate::base::{
    BaseError, BaseSettings, CommandStats, DeviceProtocol, Faults, Feedback, MachineState, Session,
};
use crate::robot::TrackSpeeds;

/// Most unacknowledged commands that are remembered: several seconds at the usual rate.
const MAX_UNACKNOWLEDGED: usize = 256;

/// Host session of the native protocol.
#[derive(Clone, Debug)]
pub struct NativeSession {
    core: SessionCore,
    stop: bool,
    release: Release,
    sequence: u16,
    decoder: Decoder<Report>,
    clock: DeviceClock,
    /// Sequence of the last report.
    reported: Option<u16>,
    /// Sequence and sending time of each command that the base has not acknowledged, the oldest first.
    unacknowledged: VecDeque<(u16, f64)>,
}

/// The end of the base's latched stop.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Release {
    None,
    /// To be sent.
    Due,
    /// Each command repeats it, because one may be damaged, until the base acknowledges one of them. `first` is the sequence of the
    /// first one, `at_s` its time, seconds.
    Unacknowledged {
        first: u16,
        at_s: f64,
    },
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
            core: SessionCore::new(settings)?,
            stop: false,
            release: Release::None,
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
            if let Release::Unacknowledged { first, .. } = self.release
                && (echo.wrapping_sub(first) as i16) >= 0
            {
                // The base has ended its stop, or refused to.
                self.release = Release::None;
            }
        }
        let oldest_s = self.unacknowledged.front().map_or(now_s, |(_, sent_s)| *sent_s);
        Some(now_s - oldest_s)
    }

    /// Whether the command with the present sequence releases the stop. The release is not repeated for longer than its grace time: a stop
    /// that comes later is another one.
    fn releases(&mut self, now_s: f64) -> bool {
        self.release = match self.release {
            Release::Due => Release::Unacknowledged { first: self.sequence, at_s: now_s },
            Release::Unacknowledged { at_s, .. } if now_s - at_s >= RELEASE_GRACE_S => {
                Release::None
            }
            release => release,
        };
        self.release != Release::None
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
            bumper: report.bumper,
            cliff: report.cliff,
            ..Feedback::default()
        })
    }
}

impl Session for NativeSession {
    fn core(&self) -> &SessionCore {
        &self.core
    }

    fn core_mut(&mut self) -> &mut SessionCore {
        &mut self.core
    }

    fn baud(&self) -> u32 {
        BAUD
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
        self.core.counters.dropped_bytes = self.decoder.dropped_bytes();
    }

    fn transmit(&mut self, now_s: f64, line: &mut Vec<u8>) {
        if !self.core.is_pending {
            return;
        }
        let rates = self.core.take_rates();
        self.sequence = self.sequence.wrapping_add(1);
        let release = self.releases(now_s);
        let stands = self.stop || release;
        // The cast saturates.
        let speeds = if stands { [0, 0] } else { rates.map(|rate| rate.round() as i32) };
        let command = Command { sequence: self.sequence, stop: self.stop, release, speeds };
        if self.unacknowledged.len() == MAX_UNACKNOWLEDGED {
            self.unacknowledged.pop_front();
        }
        self.unacknowledged.push_back((self.sequence, now_s));
        line.extend(command.encode());
    }

    fn engage_stop(&mut self) {
        self.core.stop();
        self.stop = true;
        self.release = Release::None;
    }

    fn release(&mut self) {
        self.core.release();
        self.stop = false;
        self.release = Release::Due;
    }
}

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
    reports: ReportTimer,
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
            reports: ReportTimer::new(REPORT_PERIOD_S),
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
        self.stopped |= machine.button_pressed
            || machine.bumper.is_pressed()
            || machine.cliff
            || !machine.faults.is_empty();
        let silent = self.accepted.is_none_or(|(_, at_s)| now_s - at_s >= WATCHDOG_S);
        self.commands.watchdog(silent && !self.stopped && self.set != TrackSpeeds::default());
        if self.reports.is_due(now_s) {
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
                bumper: machine.bumper,
                cliff: machine.cliff,
            };
            line.extend(report.encode());
        }
        if self.stopped || silent { TrackSpeeds::default() } else { self.set }
    }

    fn command_stats(&self) -> CommandStats {
        self.commands.stats()
    }
}
