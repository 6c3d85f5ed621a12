//! The supervisor's connection to the base: opened, used, closed with zero commands, reopened.

use super::SupervisorSettings;
use super::backoff::Backoff;
use super::safety::OutgoingCommand;
use crate::base::{Base, BaseError, Feedback};
use crate::geometry::Twist;

/// Zero commands sent before a connection is closed. Three must arrive; a session that waits for a missing answer replaces
/// two of them by the next.
const STOP_REPEATS: usize = 5;

/// Opens a connection to a base with a new session.
pub type OpenBase = Box<dyn FnMut() -> Result<Box<dyn Base + Send>, BaseError> + Send>;

pub(super) struct Connection {
    open: OpenBase,
    base: Option<Box<dyn Base + Send>>,
    backoff: Backoff,
}

/// Result of one [`Connection::exchange`].
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Exchange {
    /// The command was sent. The feedback is none until the first report on this connection.
    Done(Option<Feedback>),
    /// There is no connection, and the next attempt is not due.
    Waiting,
    /// The connection was just lost, or could not be opened.
    Lost(BaseError),
    /// A connection was opened; nothing was sent on it yet.
    Opened,
}

impl Connection {
    /// Opens the connection.
    pub(super) fn new(
        mut open: OpenBase,
        settings: &SupervisorSettings,
    ) -> Result<Self, BaseError> {
        let base = Some(open()?);
        Ok(Self {
            open,
            base,
            backoff: Backoff::new(settings.reconnect_min_s, settings.reconnect_max_s),
        })
    }

    /// Sends a command and reads the latest report; without a connection, reopens it when the next attempt is due.
    pub(super) fn exchange(&mut self, command: OutgoingCommand, now_s: f64) -> Exchange {
        let Some(base) = &mut self.base else {
            return self.reopen(now_s);
        };
        let sent = match command {
            OutgoingCommand::Drive(twist) => base.send(&twist),
            OutgoingCommand::EngageStop => base.engage_stop(),
            OutgoingCommand::ReleaseStop => base.release(),
        };
        match sent.and_then(|()| base.feedback()) {
            Ok(feedback) => {
                self.backoff.succeeded();
                Exchange::Done(Some(feedback))
            }
            Err(BaseError::NoFeedbackYet { .. }) => Exchange::Done(None),
            Err(error) => {
                self.close();
                self.backoff.failed(now_s);
                Exchange::Lost(error)
            }
        }
    }

    fn reopen(&mut self, now_s: f64) -> Exchange {
        if !self.backoff.is_due(now_s) {
            return Exchange::Waiting;
        }
        match (self.open)() {
            Ok(base) => {
                self.base = Some(base);
                Exchange::Opened
            }
            Err(error) => {
                self.backoff.failed(now_s);
                Exchange::Lost(error)
            }
        }
    }

    /// Sends zero commands and closes the connection. Errors are ignored: a base that no longer answers may still receive.
    fn close(&mut self) {
        if let Some(mut base) = self.base.take() {
            for _ in 0..STOP_REPEATS {
                let _ = base.send(&Twist::STOP);
                // A session that waits for answers sends the next command only after the last answer.
                let _ = base.feedback();
            }
        }
    }
}

impl Drop for Connection {
    fn drop(&mut self) {
        self.close();
    }
}
