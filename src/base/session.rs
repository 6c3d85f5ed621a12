//! The host's side of a protocol, without I/O: bytes and time in, bytes and feedback out.

use super::encoder_speed::EncoderSpeed;
use super::{BaseError, BaseSettings, Feedback};
use crate::geometry::Twist;
use crate::robot::TrackSpeeds;

/// The host's side of a protocol. It has no port and no clock: the caller transfers the bytes and passes the time.
///
/// Time is in seconds from any origin and never runs backwards. A session never renews a command by itself: each
/// [`Session::command`] sends one frame, which is repeated, with the latest command in it, only if its answer was lost. So the
/// base's own watchdog, if it has one, acts when the caller stops sending.
pub trait Session: Send {
    /// Speed of the serial line, baud.
    fn baud(&self) -> u32;

    /// Sets the next command and replaces one that was not sent yet. The caller has limited it; a command still beyond the
    /// tracks' highest speed is scaled down at constant curvature.
    ///
    /// # Errors
    /// [`BaseError::NotFinite`]; the previous command then stays.
    fn command(&mut self, twist: &Twist) -> Result<(), BaseError>;

    /// Takes received bytes, in pieces of any size.
    fn receive(&mut self, bytes: &[u8], now_s: f64);

    /// Appends the bytes to write now to `line`. Call it after [`Session::command`], after [`Session::receive`], and
    /// periodically while [`Session::is_waiting`].
    fn transmit(&mut self, now_s: f64, line: &mut Vec<u8>);

    /// Whether an answer is outstanding; after it there may be more to write.
    fn is_waiting(&self) -> bool;

    /// The latest complete feedback with its time of arrival.
    fn latest(&self) -> Option<&TimedFeedback>;

    /// Counts of line errors so far.
    fn counters(&self) -> SessionCounters;

    /// Stops the base until [`Session::release`], if the protocol can latch a stop; otherwise commands zero, and the caller must
    /// keep commanding zero.
    fn engage_stop(&mut self);

    /// Ends a latched stop, as an operator's explicit decision, and clears the faults that the session found. The commanded motion
    /// becomes zero. A button that is still pressed keeps the base stopped.
    fn release(&mut self);
}

/// Feedback with its time of arrival.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedFeedback {
    /// Time at which its last byte was received, seconds.
    pub received_s: f64,
    /// The feedback.
    pub feedback: Feedback,
}

/// Line errors since the session began. All zero on a clean line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SessionCounters {
    /// Bytes that belong to no frame or answer.
    pub dropped_bytes: u64,
    /// Requests repeated because no valid answer came in time.
    pub retries: u64,
    /// Requests given up after the last attempt.
    pub unanswered: u64,
    /// Encoder counts and speeds rejected because no track runs that fast.
    pub rejected_readings: u64,
}

/// State that sessions with track speeds and encoders share.
#[derive(Clone, Debug)]
pub(super) struct TrackSession {
    pub(super) settings: BaseSettings,
    pub(super) target: TrackSpeeds,
    /// Whether a command is to be sent.
    pub(super) is_pending: bool,
    pub(super) encoder_speed: EncoderSpeed,
    pub(super) latest: Option<TimedFeedback>,
    pub(super) counters: SessionCounters,
}

impl TrackSession {
    pub(super) fn new(settings: BaseSettings) -> Result<Self, BaseError> {
        settings.validate()?;
        Ok(Self {
            settings,
            target: TrackSpeeds::default(),
            is_pending: false,
            encoder_speed: EncoderSpeed::new(&settings),
            latest: None,
            counters: SessionCounters::default(),
        })
    }

    pub(super) fn command(&mut self, twist: &Twist) -> Result<(), BaseError> {
        let limited = self.settings.limit(twist)?;
        self.target = self.settings.drive().tracks(&limited);
        self.is_pending = true;
        Ok(())
    }

    /// Takes the pending command as ticks per second of the controller's channels.
    pub(super) fn take_rates(&mut self) -> [f64; 2] {
        self.is_pending = false;
        self.settings.channel_rates(&self.target)
    }

    pub(super) fn stop(&mut self) {
        self.target = TrackSpeeds::default();
        self.is_pending = true;
    }

    pub(super) fn release(&mut self) {
        self.stop();
        self.encoder_speed.clear_fault();
    }

    pub(super) fn report(&mut self, feedback: Feedback, received_s: f64) {
        self.latest = Some(TimedFeedback { received_s, feedback });
    }

    pub(super) const fn counters(&self) -> SessionCounters {
        SessionCounters { rejected_readings: self.encoder_speed.rejected(), ..self.counters }
    }
}
