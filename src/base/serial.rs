//! A real base on a serial port. The only file that opens one, and, with it, that reads a clock.

use std::io::{self, ErrorKind, Read, Write};
use std::time::{Duration, Instant};

use serialport::{ClearBuffer, SerialPort};

use super::wheeltec::{BAUD, Command, Decoder, Report};
use super::{Base, BaseError, Feedback};
use crate::geometry::Twist;

/// How long [`Base::feedback`] waits for a first byte. Never zero: on some systems that means forever.
const READ_WAIT: Duration = Duration::from_millis(1);

/// Reads of one [`Base::feedback`] at most, so that a babbling peer cannot hold the caller.
const READS_PER_CALL: usize = 8;

/// How long to wait for the other end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SerialSettings {
    /// Longest time that sending a command may take. Default 20 ms: a frame takes 1 ms on the line.
    pub send_within: Duration,
    /// Age at which the last feedback is out of date. Default 0.5 s, ten frames of the controller.
    pub feedback_within: Duration,
}

impl Default for SerialSettings {
    fn default() -> Self {
        Self {
            send_within: Duration::from_millis(20),
            feedback_within: Duration::from_millis(500),
        }
    }
}

/// A base with WHEELTEC's frames on a serial port.
///
/// [`Base::send`] returns within [`SerialSettings::send_within`], [`Base::feedback`] within some 10 ms, and within
/// 1 ms when nothing has come. Feedback frames are decoded as they arrive in pieces; damaged ones are skipped and
/// counted.
pub struct SerialBase {
    port: Box<dyn SerialPort>,
    name: String,
    settings: SerialSettings,
    decoder: Decoder<Report>,
    newest: Option<Feedback>,
    /// When the newest feedback came, or the port was opened.
    heard: Instant,
}

impl SerialBase {
    /// Opens a port by its name, such as `/dev/ttyUSB0` or `COM3`, at WHEELTEC's speed.
    ///
    /// # Errors
    /// [`BaseError::CannotOpen`].
    pub fn open(name: &str, settings: SerialSettings) -> Result<Self, BaseError> {
        let port = serialport::new(name, BAUD)
            .timeout(READ_WAIT)
            .open()
            .map_err(|error| BaseError::CannotOpen {
                port: name.to_owned(),
                reason: error.to_string(),
            })?;
        Ok(Self::on(port, name, settings))
    }

    /// A base on a port that is open already; the name is for messages.
    #[must_use]
    pub fn on(port: Box<dyn SerialPort>, name: &str, settings: SerialSettings) -> Self {
        Self {
            port,
            name: name.to_owned(),
            settings,
            decoder: Decoder::default(),
            newest: None,
            heard: Instant::now(),
        }
    }

    /// Bytes of the line that belonged to no frame: zero on a clean line.
    #[must_use]
    pub const fn dropped_bytes(&self) -> u64 {
        self.decoder.dropped_bytes()
    }

    /// Sends all bytes or fails within the bound.
    ///
    /// One byte at a time: the port is in blocking mode, and the system's "ready" promises room for one byte only,
    /// so that a longer write may hang while the peer does not read.
    fn write_within_bound(&mut self, bytes: &[u8]) -> io::Result<()> {
        let deadline = Instant::now() + self.settings.send_within;
        for byte in bytes {
            loop {
                let left = deadline.saturating_duration_since(Instant::now());
                if left.is_zero() {
                    return Err(ErrorKind::TimedOut.into());
                }
                self.port.set_timeout(left)?;
                match self.port.write(&[*byte]) {
                    Ok(0) => return Err(ErrorKind::WriteZero.into()),
                    Ok(_) => break,
                    Err(error) if error.kind() == ErrorKind::Interrupted => {}
                    Err(error) => return Err(error),
                }
            }
        }
        Ok(())
    }

    /// Takes in what has arrived.
    fn read_pending(&mut self) -> io::Result<()> {
        self.port.set_timeout(READ_WAIT)?;
        let mut bytes = [0; 512];
        for _ in 0..READS_PER_CALL {
            match self.port.read(&mut bytes) {
                Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
                Ok(count) => {
                    self.decoder.push(&bytes[..count]);
                    if count < bytes.len() {
                        return Ok(());
                    }
                }
                Err(error) if is_silence(error.kind()) => return Ok(()),
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    fn explain(&self, error: &io::Error) -> BaseError {
        let port = self.name.clone();
        match error.kind() {
            ErrorKind::TimedOut | ErrorKind::WouldBlock => BaseError::TimedOut {
                port,
                waiting_for: "writing a command",
                bound_ms: self.settings.send_within.as_millis(),
            },
            ErrorKind::BrokenPipe
            | ErrorKind::UnexpectedEof
            | ErrorKind::WriteZero
            | ErrorKind::NotConnected
            | ErrorKind::NotFound => BaseError::Unplugged { port },
            _ => BaseError::Port {
                port,
                reason: error.to_string(),
            },
        }
    }
}

impl Base for SerialBase {
    fn send(&mut self, command: &Twist) -> Result<(), BaseError> {
        let bytes = Command { twist: *command }.encode()?;
        self.write_within_bound(&bytes).map_err(|error| {
            // What still waits to be sent would be obeyed late, by a robot that is elsewhere by then. A line that
            // cannot be cleared either is already being reported.
            let _ = self.port.clear(ClearBuffer::Output);
            self.explain(&error)
        })
    }

    fn feedback(&mut self) -> Result<Feedback, BaseError> {
        self.read_pending().map_err(|error| self.explain(&error))?;
        if let Some(report) = self.decoder.by_ref().last() {
            self.newest = Some(report.into());
            self.heard = Instant::now();
            return Ok(report.into());
        }
        if self.heard.elapsed() >= self.settings.feedback_within {
            return Err(BaseError::TimedOut {
                port: self.name.clone(),
                waiting_for: "waiting for feedback",
                bound_ms: self.settings.feedback_within.as_millis(),
            });
        }
        self.newest.ok_or_else(|| BaseError::NoFeedbackYet {
            port: self.name.clone(),
        })
    }
}

fn is_silence(kind: ErrorKind) -> bool {
    matches!(
        kind,
        ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted
    )
}
