//! The supervisor's connection to the base: opened, used, closed with zero commands, reopened.

use super::{OutgoingCommand, SupervisorSettings};
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

/// Pauses that double with each failure, up to a maximum.
#[derive(Clone, Copy, Debug)]
pub(in crate::base) struct Backoff {
    min_s: f64,
    max_s: f64,
    failures: i32,
    due_s: f64,
}

impl Backoff {
    /// Creates a backoff without failures; times in seconds.
    pub(in crate::base) const fn new(min_s: f64, max_s: f64) -> Self {
        Self { min_s, max_s, failures: 0, due_s: f64::NEG_INFINITY }
    }

    /// Whether the next attempt is due.
    pub(in crate::base) fn is_due(&self, now_s: f64) -> bool {
        now_s >= self.due_s
    }

    /// Records a failed attempt and schedules the next one.
    pub(in crate::base) fn failed(&mut self, now_s: f64) {
        let pause_s = self.min_s * libm::ldexp(1.0, self.failures);
        self.due_s = now_s + pause_s.min(self.max_s);
        // The pause has long reached its maximum, and the count must not overflow.
        self.failures = (self.failures + 1).min(64);
    }

    /// Records a success: the next pause is the shortest again.
    pub(in crate::base) const fn succeeded(&mut self) {
        self.failures = 0;
    }
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use super::*;

    /// A base whose reports fail once it moves.
    struct Failing(Arc<Mutex<Vec<Twist>>>);

    impl Base for Failing {
        fn send(&mut self, command: &Twist) -> Result<(), BaseError> {
            self.0.lock().expect("not poisoned").push(*command);
            Ok(())
        }

        fn feedback(&mut self) -> Result<Feedback, BaseError> {
            Err(BaseError::Disconnected { port: "memory".to_owned() })
        }
    }

    #[test]
    fn failed_connection_is_closed_with_at_least_three_zeros() {
        let sent = Arc::new(Mutex::new(Vec::new()));
        let line = Arc::clone(&sent);
        let open: OpenBase = Box::new(move || Ok(Box::new(Failing(Arc::clone(&line)))));
        let settings = SupervisorSettings::default();
        let mut connection = Connection::new(open, &settings).expect("a connection");
        let forward = Twist::new(0.5, 0.0);
        let lost = connection.exchange(OutgoingCommand::Drive(forward), 1.0);
        assert!(matches!(lost, Exchange::Lost(_)), "{lost:?}");
        let commands = sent.lock().expect("not poisoned").clone();
        assert_eq!(commands[0], forward);
        assert!(commands.len() >= 4 && commands[1..].iter().all(|twist| *twist == Twist::STOP));
    }

    #[test]
    fn backoff_doubles_to_its_maximum_and_resets_on_success() {
        let mut backoff = Backoff::new(0.125, 0.5);
        let (mut now_s, mut attempts) = (0.0, Vec::new());
        // Sixteenths of a second add up without rounding.
        for _ in 0..64 {
            if backoff.is_due(now_s) {
                attempts.push(now_s);
                backoff.failed(now_s);
            }
            now_s += 0.0625;
        }
        let pauses: Vec<f64> = attempts.windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert_eq!(pauses[..4], [0.125, 0.25, 0.5, 0.5]);
        backoff.succeeded();
        backoff.failed(now_s);
        assert!(!backoff.is_due(now_s + 0.12) && backoff.is_due(now_s + 0.125));
    }
}
