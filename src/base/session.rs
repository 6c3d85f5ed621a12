//! The host's side of a protocol, without I/O: bytes and time in, bytes and feedback out.

use super::{BaseError, Feedback};
use crate::geometry::Twist;

/// A conversation with a base. It has no port and no clock: the caller carries the bytes and tells the time.
///
/// Time is in seconds from any origin and never runs backwards. A session never renews a command by itself: a frame or
/// question goes out for each [`Session::command`], and is repeated only where its answer was lost, with the newest
/// command in it. So a caller that falls silent lets the base's own watchdog act, where it has one.
pub trait Session: Send {
    /// Speed of the line, baud.
    fn baud(&self) -> u32;

    /// Takes the motion to command next, which the caller has limited already; it replaces one that did not go out yet.
    /// What is still beyond the tracks' highest speed is scaled down with its curvature kept.
    ///
    /// # Errors
    /// [`BaseError::NotFinite`]; the last command then stays.
    fn command(&mut self, wanted: &Twist) -> Result<(), BaseError>;

    /// Takes bytes that came, in pieces of any size.
    fn receive(&mut self, bytes: &[u8], now_s: f64);

    /// Appends the bytes that are to be written now, if any. To be called after [`Session::command`], after
    /// [`Session::receive`], and while [`Session::is_waiting`], when time has passed.
    fn transmit(&mut self, now_s: f64, line: &mut Vec<u8>);

    /// Whether an answer is outstanding, after which there may be more to write.
    fn is_waiting(&self) -> bool;

    /// The newest complete feedback, and when it came.
    fn newest(&self) -> Option<&Heard>;

    /// What went wrong on the line so far.
    fn counters(&self) -> Counters;

    /// Stops the base for good: until [`Session::release`] where the protocol can latch a stop, else by a command of
    /// zero, and then it is the caller who must keep to it.
    fn engage_stop(&mut self);

    /// Ends a stop that is latched, as an operator's explicit wish, and forgets the faults that the session itself found.
    /// The commanded motion becomes zero. A button that is still pressed keeps the base stopped.
    fn release(&mut self);
}

/// Feedback and the time it came, seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heard {
    /// When its last byte was taken in.
    pub at_s: f64,
    /// What it says.
    pub feedback: Feedback,
}

/// What went wrong on a line since the session began. All zero on a clean line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Bytes that belonged to no frame or answer.
    pub dropped_bytes: u64,
    /// Questions and commands that were repeated because no good answer came in time.
    pub repeated: u64,
    /// Those given up after the last try.
    pub unanswered: u64,
    /// Encoder readings and speeds refused because no track runs so fast.
    pub refused_readings: u64,
}

impl<S: Session + ?Sized> Session for Box<S> {
    fn baud(&self) -> u32 {
        (**self).baud()
    }

    fn command(&mut self, wanted: &Twist) -> Result<(), BaseError> {
        (**self).command(wanted)
    }

    fn receive(&mut self, bytes: &[u8], now_s: f64) {
        (**self).receive(bytes, now_s);
    }

    fn transmit(&mut self, now_s: f64, line: &mut Vec<u8>) {
        (**self).transmit(now_s, line);
    }

    fn is_waiting(&self) -> bool {
        (**self).is_waiting()
    }

    fn newest(&self) -> Option<&Heard> {
        (**self).newest()
    }

    fn counters(&self) -> Counters {
        (**self).counters()
    }

    fn engage_stop(&mut self) {
        (**self).engage_stop();
    }

    fn release(&mut self) {
        (**self).release();
    }
}
