//! Encoding and decoding of the command and report frames.

use crate::base::frame_decoder::Frame;
use crate::base::{BaseError, Feedback, require_finite};
use crate::geometry::Twist;

const HEAD: u8 = 0x7B;
const TAIL: u8 = 0x7D;

/// Length of a command frame, bytes.
pub const COMMAND_LENGTH: usize = 11;

/// Length of a feedback frame, bytes.
pub const FEEDBACK_LENGTH: usize = 24;

/// Raw accelerometer counts per m/s^2.
const COUNTS_PER_M_S2: f64 = 1671.84;

/// Turn rate of one raw gyro count, rad/s (range of +-500 degrees per second).
const RAD_S_PER_COUNT: f64 = 0.000_266_44;

/// A velocity command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Command {
    /// Commanded velocity.
    pub twist: Twist,
}

/// A report of the base, about 20 per second.
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
