//! Protocol of the WHEELTEC STM32 lower controller. It mixes the tracks itself, reports periodically, and has no watchdog.
//!
//! 115200 baud, 8N1. A frame starts with `7B` and ends with `7D`; the byte before the end is the exclusive or of all
//! before it. Numbers are big-endian signed 16-bit in mm/s and mrad/s. Both marks also occur inside frames, so a frame is valid
//! only if its length, both marks and the check byte agree. The check is weak: two flips of the same bit in two bytes pass it.

use super::encoder_speed::max_plausible_speed;
use super::frame_decoder::Frame;
#[doc(hidden)]
pub use super::frame_decoder::FrameDecoder as Decoder;
use super::protocol::{CommandCounter, ReportTimer, SessionCore};
use super::tilt::TiltFilter;
use super::{
    BaseError, BaseSettings, CommandStats, DeviceProtocol, Feedback, MachineState, Session, Tilt,
    require_finite,
};
use crate::geometry::Twist;
use crate::robot::{TrackSpeeds, TrackedDrive};

/// Speed of the serial line, baud.
pub const BAUD: u32 = 115_200;

/// Time between reports, seconds: 20 Hz.
pub const REPORT_PERIOD_S: f64 = 0.05;

const HEAD: u8 = 0x7B;
const TAIL: u8 = 0x7D;

/// Length of a command frame, bytes.
#[doc(hidden)]
pub const COMMAND_LENGTH: usize = 11;

/// Length of a feedback frame, bytes.
#[doc(hidden)]
pub const FEEDBACK_LENGTH: usize = 24;

/// Raw accelerometer counts per m/s^2.
const COUNTS_PER_M_S2: f64 = 1671.84;

/// Turn rate of one raw gyro count, rad/s (range of +-500 degrees per second).
const RAD_S_PER_COUNT: f64 = 0.000_266_44;

/// A velocity command.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Command {
    /// Commanded velocity.
    pub twist: Twist,
}

/// A report of the base, about 20 per second.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report {
    /// Whether the motors are disabled.
    pub motors_disabled: bool,
    /// Measured velocity.
    pub twist: Twist,
    /// Measured speed to the left, m/s: zero on tracks.
    pub lateral: f64,
    /// Acceleration along x, y and z, m/s^2.
    pub acceleration: [f64; 3],
    /// Turn rate about x, y and z, rad/s.
    pub gyro: [f64; 3],
    /// Battery voltage.
    pub battery_v: f64,
}

impl Command {
    /// Encodes the frame. Rates are rounded to mm/s and mrad/s, halves away from zero, and saturate at 32.767 m/s or rad/s.
    ///
    /// # Errors
    /// [`BaseError::NotFinite`] for a rate that is NaN or infinite.
    pub fn encode(&self) -> Result<[u8; COMMAND_LENGTH], BaseError> {
        let twist = require_finite(&self.twist)?;
        let mut bytes = [0; COMMAND_LENGTH];
        write_i16(&mut bytes, 3, twist.linear * 1000.0);
        write_i16(&mut bytes, 7, twist.angular * 1000.0);
        seal(&mut bytes);
        Ok(bytes)
    }
}

impl Frame for Command {
    const LENGTH: usize = COMMAND_LENGTH;
    const HEADER: &'static [u8] = &[HEAD];

    fn decode(bytes: &[u8]) -> Option<Self> {
        is_sealed(bytes).then(|| Self {
            twist: Twist::new(read_i16(bytes, 3) / 1000.0, read_i16(bytes, 7) / 1000.0),
        })
    }
}

impl Report {
    /// Encodes the frame, for an emulated base. Rounds and saturates like [`Command::encode`]; NaN becomes zero.
    #[must_use]
    pub fn encode(&self) -> [u8; FEEDBACK_LENGTH] {
        let mut bytes = [0; FEEDBACK_LENGTH];
        bytes[1] = self.motors_disabled.into();
        write_i16(&mut bytes, 2, self.twist.linear * 1000.0);
        write_i16(&mut bytes, 4, self.lateral * 1000.0);
        write_i16(&mut bytes, 6, self.twist.angular * 1000.0);
        for axis in 0..3 {
            write_i16(&mut bytes, 8 + 2 * axis, self.acceleration[axis] * COUNTS_PER_M_S2);
            write_i16(&mut bytes, 14 + 2 * axis, self.gyro[axis] / RAD_S_PER_COUNT);
        }
        let millivolts = (self.battery_v * 1000.0).round() as u16;
        bytes[20..22].copy_from_slice(&millivolts.to_be_bytes());
        seal(&mut bytes);
        bytes
    }
}

impl Frame for Report {
    const LENGTH: usize = FEEDBACK_LENGTH;
    const HEADER: &'static [u8] = &[HEAD];

    fn decode(bytes: &[u8]) -> Option<Self> {
        let acceleration = |axis: usize| read_i16(bytes, 8 + 2 * axis) / COUNTS_PER_M_S2;
        let gyro = |axis: usize| read_i16(bytes, 14 + 2 * axis) * RAD_S_PER_COUNT;
        is_sealed(bytes).then(|| Self {
            motors_disabled: bytes[1] != 0,
            twist: Twist::new(read_i16(bytes, 2) / 1000.0, read_i16(bytes, 6) / 1000.0),
            lateral: read_i16(bytes, 4) / 1000.0,
            acceleration: [0, 1, 2].map(acceleration),
            gyro: [0, 1, 2].map(gyro),
            battery_v: f64::from(u16::from_be_bytes([bytes[20], bytes[21]])) / 1000.0,
        })
    }
}

impl From<Report> for Feedback {
    fn from(report: Report) -> Self {
        Self {
            twist: report.twist,
            emergency_stop: report.motors_disabled,
            battery_v: Some(report.battery_v),
            yaw_rate: Some(report.gyro[2]),
            ..Self::default()
        }
    }
}

fn write_i16(bytes: &mut [u8], at: usize, value: f64) {
    // The cast saturates; `round` rounds halves away from zero.
    bytes[at..at + 2].copy_from_slice(&(value.round() as i16).to_be_bytes());
}

fn read_i16(bytes: &[u8], at: usize) -> f64 {
    f64::from(i16::from_be_bytes([bytes[at], bytes[at + 1]]))
}

/// Exclusive or of all bytes before the check byte.
fn check_byte(frame: &[u8]) -> u8 {
    frame[..frame.len() - 2].iter().fold(0, |check, byte| check ^ byte)
}

fn seal(frame: &mut [u8]) {
    let last = frame.len() - 1;
    frame[0] = HEAD;
    frame[last - 1] = check_byte(frame);
    frame[last] = TAIL;
}

fn is_sealed(frame: &[u8]) -> bool {
    let last = frame.len() - 1;
    frame[0] == HEAD && frame[last] == TAIL && frame[last - 1] == check_byte(frame)
}

/// Host session of the WHEELTEC protocol.
///
/// The firmware mixes the tracks by the geometric width, so the session scales turn rates by the ratio of the effective width in
/// both directions. The protocol cannot latch a stop.
///
/// Damage that passes the weak check may show disabled motors. So a single such report suspects a stop, and a second one in
/// succession is an emergency stop.
#[doc(hidden)]
#[derive(Clone, Debug)]
pub struct WheeltecSession {
    core: SessionCore,
    decoder: Decoder<Report>,
    tilt: TiltFilter,
    /// Whether the last report showed disabled motors.
    was_disabled: bool,
}

impl WheeltecSession {
    /// Creates a session.
    ///
    /// # Errors
    /// Settings out of range.
    pub fn new(settings: BaseSettings) -> Result<Self, BaseError> {
        Ok(Self {
            core: SessionCore::new(settings)?,
            decoder: Decoder::default(),
            tilt: TiltFilter::default(),
            was_disabled: false,
        })
    }

    /// Converts a report, or returns none if no track runs that fast: the check byte accepts one of 256 damaged frames.
    fn feedback(&self, report: Report) -> Option<Feedback> {
        let settings = &self.core.settings;
        let mut feedback = Feedback::from(report);
        feedback.twist.angular /= settings.effective_width_ratio;
        let tracks = settings.drive().tracks(&feedback.twist);
        let max = max_plausible_speed(settings);
        (tracks.left.abs().max(tracks.right.abs()) <= max).then_some(feedback)
    }
}

impl Session for WheeltecSession {
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
            match self.feedback(report) {
                Some(feedback) => {
                    let was_disabled =
                        std::mem::replace(&mut self.was_disabled, report.motors_disabled);
                    let feedback = Feedback {
                        emergency_stop: report.motors_disabled && was_disabled,
                        is_stop_suspected: report.motors_disabled && !was_disabled,
                        tilt: self.tilt.update(report.acceleration, report.gyro, now_s),
                        ..feedback
                    };
                    self.core.report(feedback, now_s);
                }
                None => self.core.counters.rejected_readings += 1,
            }
        }
        self.core.counters.dropped_bytes = self.decoder.dropped_bytes();
    }

    fn transmit(&mut self, _now_s: f64, line: &mut Vec<u8>) {
        if core::mem::take(&mut self.core.is_pending) {
            let Twist { linear, angular } = self.core.target;
            let angular = angular * self.core.settings.effective_width_ratio;
            // The session accepts finite motions only.
            let command = Command { twist: Twist::new(linear, angular) }.encode();
            line.extend(command.into_iter().flatten());
        }
    }
}

/// Acceleration that a tilted accelerometer at rest measures, m/s^2.
fn gravity(tilt: &Tilt) -> [f64; 3] {
    const GRAVITY: f64 = 9.8;
    let Tilt { roll, pitch } = *tilt;
    let across = GRAVITY * libm::cos(pitch);
    [-GRAVITY * libm::sin(pitch), across * libm::sin(roll), across * libm::cos(roll)]
}

/// A lower controller with the WHEELTEC protocol. It follows the last command forever: the command-loss stop of the published
/// firmware is commented out.
#[doc(hidden)]
#[derive(Clone, Debug)]
pub struct WheeltecDevice {
    /// The firmware's kinematics, with the geometric track width.
    drive: TrackedDrive,
    decoder: Decoder<Command>,
    set: Twist,
    reports: ReportTimer,
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
            reports: ReportTimer::new(REPORT_PERIOD_S),
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
        if self.reports.is_due(now_s) {
            let report = Report {
                motors_disabled: stopped,
                twist: self.drive.twist(&machine.speeds),
                acceleration: gravity(&machine.tilt),
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
