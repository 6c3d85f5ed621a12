//! A real base on a serial port. The only file of this module that opens a port.

use std::io::{self, ErrorKind, Read, Write};
use std::time::{Duration, Instant};

use serialport::{ClearBuffer, SerialPort};

use super::error::is_timeout;
use super::ld19::BAUD;
use super::{Base, BaseError, Feedback, Session, SessionCounters};
use crate::geometry::Twist;

/// Shortest timeout, and the time a read waits for its first byte. Never zero: on some systems zero means forever.
const MIN_TIMEOUT: Duration = Duration::from_millis(1);

/// Time a read waits for a lidar's bytes.
const LIDAR_TIMEOUT: Duration = Duration::from_millis(10);

/// Most reads in one call, so that a device that never stops sending cannot block the caller.
const MAX_READS: usize = 8;

/// Timeouts of a [`SerialBase`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SerialSettings {
    /// Longest time to send a command. Default 20 ms: a frame takes 1 to 3 ms on the line.
    pub send_timeout: Duration,
    /// Longest time to request feedback, for a protocol with requests. Default 20 ms, one poll cycle.
    pub request_timeout: Duration,
    /// Age at which feedback is out of date. Default 0.5 s, ten frames of the slowest controller.
    pub feedback_timeout: Duration,
}

impl Default for SerialSettings {
    fn default() -> Self {
        Self {
            send_timeout: Duration::from_millis(20),
            request_timeout: Duration::from_millis(20),
            feedback_timeout: Duration::from_millis(500),
        }
    }
}

/// A base on a serial port, with the protocol of its session.
///
/// [`Base::send`] returns within [`SerialSettings::send_timeout`] plus 1 ms for the last byte. [`Base::feedback`] returns within
/// 1 ms if nothing has arrived and no request is due, else within about 10 ms; while a request is outstanding within
/// [`SerialSettings::request_timeout`] plus that time. A protocol with requests makes progress only in these two calls.
pub struct SerialBase {
    port: Box<dyn SerialPort>,
    name: String,
    settings: SerialSettings,
    session: Box<dyn Session>,
    /// Origin of the session's time.
    opened: Instant,
    /// Buffer of outgoing bytes.
    line: Vec<u8>,
}

impl SerialBase {
    /// Opens a port by its name, such as `/dev/ttyUSB0` or `COM3`, at the session's speed.
    ///
    /// # Errors
    /// [`BaseError::CannotOpen`] and [`BaseError::InUse`].
    pub fn open(
        name: &str,
        session: Box<dyn Session>,
        settings: SerialSettings,
    ) -> Result<Self, BaseError> {
        let port = serialport::new(name, session.baud()).timeout(MIN_TIMEOUT).open();
        let port = port.map_err(|error| cannot_open(name, &error))?;
        // Older bytes are no answer to this session. An error here shows again at the first use.
        let _ = port.clear(ClearBuffer::All);
        Ok(Self::from_port(port, name, session, settings))
    }

    /// Uses a port that is already open, with a new session; the name is for messages.
    #[must_use]
    pub fn from_port(
        port: Box<dyn SerialPort>,
        name: &str,
        session: Box<dyn Session>,
        settings: SerialSettings,
    ) -> Self {
        Self {
            port,
            name: name.to_owned(),
            settings,
            session,
            opened: Instant::now(),
            line: Vec::new(),
        }
    }

    /// Counts of line errors so far.
    #[must_use]
    pub fn counters(&self) -> SessionCounters {
        self.session.counters()
    }

    fn now_s(&self) -> f64 {
        self.opened.elapsed().as_secs_f64()
    }

    /// Sends the pending command. An answer that the session waits for is read first.
    fn flush(&mut self) -> Result<(), BaseError> {
        let deadline = Instant::now() + self.settings.send_timeout;
        self.read_answer()?;
        while !self.write_pending()? && self.session.is_waiting() && Instant::now() < deadline {
            self.read()?;
        }
        Ok(())
    }

    /// Reads an answer that may have arrived since the last call, before the session counts it as lost.
    fn read_answer(&mut self) -> Result<(), BaseError> {
        if self.session.is_waiting() {
            self.read()?;
        }
        Ok(())
    }

    /// Writes the session's pending bytes and returns whether there were any.
    fn write_pending(&mut self) -> Result<bool, BaseError> {
        let mut line = std::mem::take(&mut self.line);
        line.clear();
        self.session.transmit(self.now_s(), &mut line);
        let result = self.write_with_timeout(&line);
        let any = !line.is_empty();
        self.line = line;
        result.map_err(|error| {
            // Bytes still in the buffer would be obeyed late, by a robot that is elsewhere by then. The error is reported
            // already if clearing fails too.
            let _ = self.port.clear(ClearBuffer::Output);
            self.convert_error(&error)
        })?;
        Ok(any)
    }

    /// Reads the bytes that have arrived.
    fn read(&mut self) -> Result<(), BaseError> {
        self.read_pending().map_err(|error| self.convert_error(&error))
    }

    /// Writes all bytes or fails after the timeout.
    ///
    /// One byte at a time: the port is in blocking mode and "ready" promises space for one byte only, so that a longer write
    /// may hang while the device does not read. Only a blocked line fails: a thread that was scheduled late continues while
    /// there is space.
    fn write_with_timeout(&mut self, bytes: &[u8]) -> io::Result<()> {
        let deadline = Instant::now() + self.settings.send_timeout;
        for byte in bytes {
            loop {
                let left = deadline.saturating_duration_since(Instant::now());
                self.port.set_timeout(left.max(MIN_TIMEOUT))?;
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

    fn read_pending(&mut self) -> io::Result<()> {
        self.port.set_timeout(MIN_TIMEOUT)?;
        let mut bytes = [0; 512];
        for _ in 0..MAX_READS {
            match self.port.read(&mut bytes) {
                Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
                Ok(count) => {
                    let now_s = self.now_s();
                    self.session.receive(&bytes[..count], now_s);
                    if count < bytes.len() {
                        return Ok(());
                    }
                }
                Err(error) if is_timeout(error.kind()) => return Ok(()),
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    fn convert_error(&self, error: &io::Error) -> BaseError {
        let port = self.name.clone();
        match error.kind() {
            ErrorKind::TimedOut | ErrorKind::WouldBlock => BaseError::TimedOut {
                port,
                waiting_for: "writing a command",
                timeout_ms: self.settings.send_timeout.as_millis(),
            },
            ErrorKind::BrokenPipe
            | ErrorKind::UnexpectedEof
            | ErrorKind::WriteZero
            | ErrorKind::NotConnected
            | ErrorKind::NotFound => BaseError::Disconnected { port },
            _ => BaseError::Port { port, reason: error.to_string() },
        }
    }
}

impl Base for SerialBase {
    /// If an earlier answer does not come in time, the command stays pending and is sent by the next call of either method.
    fn send(&mut self, command: &Twist) -> Result<(), BaseError> {
        self.session.command(command)?;
        self.flush()
    }

    fn feedback(&mut self) -> Result<Feedback, BaseError> {
        let deadline = Instant::now() + self.settings.request_timeout;
        self.read_answer()?;
        self.write_pending()?;
        self.read()?;
        // An answer may allow the next request.
        while (self.write_pending()? || self.session.is_waiting()) && Instant::now() < deadline {
            self.read()?;
        }
        let timeout_s = self.settings.feedback_timeout.as_secs_f64();
        let latest = self.session.latest();
        let received_s = latest.map_or(0.0, |latest| latest.received_s);
        if self.now_s() - received_s >= timeout_s {
            return Err(BaseError::TimedOut {
                port: self.name.clone(),
                waiting_for: "waiting for feedback",
                timeout_ms: self.settings.feedback_timeout.as_millis(),
            });
        }
        let age_s = self.now_s() - received_s;
        let latest = latest.map(|latest| Feedback { age_s, ..latest.feedback });
        latest.ok_or_else(|| BaseError::NoFeedbackYet { port: self.name.clone() })
    }

    fn engage_stop(&mut self) -> Result<(), BaseError> {
        self.session.engage_stop();
        self.flush()
    }

    fn release(&mut self) -> Result<(), BaseError> {
        self.session.release();
        self.flush()
    }
}

fn cannot_open(name: &str, error: &serialport::Error) -> BaseError {
    // The system's word for a file that is no terminal.
    let is_terminal = !error.description.starts_with("Not a typewriter");
    let reason = if is_terminal { error.to_string() } else { "it is no serial port".to_owned() };
    let port = name.to_owned();
    // On Unix this kind stands for a port that is locked or busy, elsewhere for one that does not exist.
    let is_in_use = cfg!(unix) && error.kind == serialport::ErrorKind::NoDevice;
    if is_in_use { BaseError::InUse { port } } else { BaseError::CannotOpen { port, reason } }
}

/// Opens the port of an LD19 lidar by its name. Reads block for 10 ms at most.
///
/// # Errors
/// [`BaseError::CannotOpen`] and [`BaseError::InUse`].
pub fn open_lidar_port(name: &str) -> Result<Box<dyn Read + Send>, BaseError> {
    let port = serialport::new(name, BAUD).timeout(LIDAR_TIMEOUT).open();
    let port = port.map_err(|error| cannot_open(name, &error))?;
    // Older bytes measure from where the robot was before.
    let _ = port.clear(ClearBuffer::Input);
    Ok(port)
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn file_that_is_no_terminal_is_named_so() {
        let error = open_lidar_port("/dev/null").err().map(|error| error.to_string());
        let error = error.expect("no port");
        assert!(error.starts_with("/dev/null: cannot be opened (it is no serial port)"), "{error}");
    }
}
