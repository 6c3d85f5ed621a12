//! A real base on a serial port. The only file that opens one; it reads a clock with it.

use std::io::{self, ErrorKind, Read, Write};
use std::time::{Duration, Instant};

use serialport::{ClearBuffer, SerialPort};

use super::ld19::BAUD;
use super::{Base, BaseError, Counters, Feedback, Session};
use crate::geometry::Twist;

/// Shortest wait, and how long a read waits for a first byte. Never zero: on some systems that means forever.
const SHORTEST_WAIT: Duration = Duration::from_millis(1);

/// How long a read waits for a lidar's bytes.
const LISTENING: Duration = Duration::from_millis(10);

/// Reads of one look at the line at most, so that a babbling peer cannot hold the caller.
const READS_PER_LOOK: usize = 8;

/// How long to wait for the other end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SerialSettings {
    /// Longest time that sending a command may take. Default 20 ms: a frame takes 1 to 3 ms on the line.
    pub send_within: Duration,
    /// Longest time that asking for feedback may take, of a base that must be asked. Default 20 ms, a round of
    /// questions.
    pub ask_within: Duration,
    /// Age at which the last feedback is out of date. Default 0.5 s, ten frames of the slowest controller.
    pub feedback_within: Duration,
}

impl Default for SerialSettings {
    fn default() -> Self {
        Self {
            send_within: Duration::from_millis(20),
            ask_within: Duration::from_millis(20),
            feedback_within: Duration::from_millis(500),
        }
    }
}

/// A base on a serial port, in the language of a session.
///
/// [`Base::send`] returns within [`SerialSettings::send_within`] and 1 ms for a byte, if the line is slow. [`Base::feedback`] returns within 1 ms when nothing has
/// come and nothing is asked, else within some 10 ms; while a question is under way within
/// [`SerialSettings::ask_within`] and that. A base that must be asked gets on only in these two calls.
pub struct SerialBase<S = Box<dyn Session>> {
    port: Box<dyn SerialPort>,
    name: String,
    settings: SerialSettings,
    session: S,
    /// When the port was opened: the origin of the session's time.
    opened: Instant,
    /// Where bytes on their way out are put together.
    line: Vec<u8>,
}

impl<S: Session> SerialBase<S> {
    /// Opens a port by its name, such as `/dev/ttyUSB0` or `COM3`, at the session's speed.
    ///
    /// # Errors
    /// [`BaseError::CannotOpen`].
    pub fn open(name: &str, session: S, settings: SerialSettings) -> Result<Self, BaseError> {
        let port = serialport::new(name, session.baud())
            .timeout(SHORTEST_WAIT)
            .open()
            .map_err(|error| BaseError::CannotOpen {
                port: name.to_owned(),
                reason: error.to_string(),
            })?;
        // What came before is no answer to this session. A line that cannot be cleared is told by its first use.
        let _ = port.clear(ClearBuffer::All);
        Ok(Self::on(port, name, session, settings))
    }

    /// A base on a port that is open already; the name is for messages. The session is a new one.
    #[must_use]
    pub fn on(port: Box<dyn SerialPort>, name: &str, session: S, settings: SerialSettings) -> Self {
        Self {
            port,
            name: name.to_owned(),
            settings,
            session,
            opened: Instant::now(),
            line: Vec::new(),
        }
    }

    /// What went wrong on the line so far.
    pub fn counters(&self) -> Counters {
        self.session.counters()
    }

    /// The conversation.
    pub const fn session(&self) -> &S {
        &self.session
    }

    fn now_s(&self) -> f64 {
        self.opened.elapsed().as_secs_f64()
    }

    /// Sends what the session has to say. While it waits for an answer that is on its way, that is taken in first.
    fn hand_over(&mut self) -> Result<(), BaseError> {
        let deadline = Instant::now() + self.settings.send_within;
        self.catch_up()?;
        while !self.write_due()? && self.session.is_waiting() && Instant::now() < deadline {
            self.look()?;
        }
        Ok(())
    }

    /// Takes in an answer that may lie there since the last call, before the session judges by the time that it is lost.
    fn catch_up(&mut self) -> Result<(), BaseError> {
        if self.session.is_waiting() {
            self.look()?;
        }
        Ok(())
    }

    /// Writes what the session has to say now, and returns whether there was anything.
    fn write_due(&mut self) -> Result<bool, BaseError> {
        let mut line = std::mem::take(&mut self.line);
        line.clear();
        self.session.transmit(self.now_s(), &mut line);
        let outcome = self.write_within_bound(&line);
        let any = !line.is_empty();
        self.line = line;
        outcome.map_err(|error| {
            // What still waits to be sent would be obeyed late, by a robot that is elsewhere by then. A line that
            // cannot be cleared either is already being reported.
            let _ = self.port.clear(ClearBuffer::Output);
            self.explain(&error)
        })?;
        Ok(any)
    }

    /// Takes in what has arrived.
    fn look(&mut self) -> Result<(), BaseError> {
        self.read_pending().map_err(|error| self.explain(&error))
    }

    /// Sends all bytes or fails within the bound.
    ///
    /// One byte at a time: the port is in blocking mode, and the system's "ready" promises room for one byte only,
    /// so that a longer write may hang while the peer does not read. It is the line that must be late to fail: a thread
    /// that the system let wait past the bound goes on as long as there is room.
    fn write_within_bound(&mut self, bytes: &[u8]) -> io::Result<()> {
        let deadline = Instant::now() + self.settings.send_within;
        for byte in bytes {
            loop {
                let left = deadline.saturating_duration_since(Instant::now());
                self.port.set_timeout(left.max(SHORTEST_WAIT))?;
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
        self.port.set_timeout(SHORTEST_WAIT)?;
        let mut bytes = [0; 512];
        for _ in 0..READS_PER_LOOK {
            match self.port.read(&mut bytes) {
                Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
                Ok(count) => {
                    let now_s = self.now_s();
                    self.session.receive(&bytes[..count], now_s);
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

impl<S: Session> Base for SerialBase<S> {
    /// Where an answer to an earlier question does not come in time the command waits in the session, and goes out with the
    /// next call of either kind.
    fn send(&mut self, command: &Twist) -> Result<(), BaseError> {
        self.session.command(command)?;
        self.hand_over()
    }

    fn feedback(&mut self) -> Result<Feedback, BaseError> {
        let deadline = Instant::now() + self.settings.ask_within;
        self.catch_up()?;
        self.write_due()?;
        self.look()?;
        // An answer may make room for the next question.
        while (self.write_due()? || self.session.is_waiting()) && Instant::now() < deadline {
            self.look()?;
        }
        let bound_s = self.settings.feedback_within.as_secs_f64();
        let newest = self.session.newest();
        let heard_s = newest.map_or(0.0, |heard| heard.at_s);
        if self.now_s() - heard_s >= bound_s {
            return Err(BaseError::TimedOut {
                port: self.name.clone(),
                waiting_for: "waiting for feedback",
                bound_ms: self.settings.feedback_within.as_millis(),
            });
        }
        let newest = newest.map(|heard| heard.feedback);
        newest.ok_or_else(|| BaseError::NoFeedbackYet {
            port: self.name.clone(),
        })
    }

    fn engage_stop(&mut self) -> Result<(), BaseError> {
        self.session.engage_stop();
        self.hand_over()
    }

    fn release(&mut self) -> Result<(), BaseError> {
        self.session.release();
        self.hand_over()
    }
}

/// Opens the port of an LD19 by its name; reads wait for a hundredth of a second at most.
///
/// # Errors
/// [`BaseError::CannotOpen`].
pub fn open_lidar(name: &str) -> Result<Box<dyn Read + Send>, BaseError> {
    let port = serialport::new(name, BAUD)
        .timeout(LISTENING)
        .open()
        .map_err(|error| BaseError::CannotOpen {
            port: name.to_owned(),
            reason: error.to_string(),
        })?;
    // What came before tells where the robot was then.
    let _ = port.clear(ClearBuffer::Input);
    Ok(port)
}

fn is_silence(kind: ErrorKind) -> bool {
    matches!(
        kind,
        ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted
    )
}
