//! The operator's switch: armed, not armed, or stopped.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

const NOT_ARMED: u8 = 0;
const ARMED: u8 = 1;
const STOPPED: u8 = 2;

/// State of the operator's switch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OperatorState {
    /// The robot was not armed yet, or it was disarmed.
    NotArmed,
    /// The robot may move.
    Armed,
    /// The operator stopped the robot. Only arming ends this.
    Stopped,
}

impl OperatorState {
    /// Name of the state, as in JSON.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::NotArmed => "not_armed",
            Self::Armed => "armed",
            Self::Stopped => "stopped",
        }
    }
}

/// The operator's switch. Clones share its state, so that a key, a signal handler or a server can use it on any thread.
#[derive(Clone, Debug, Default)]
pub struct OperatorSwitch(Arc<AtomicU8>);

impl OperatorSwitch {
    /// Permits motion. Ends a stop.
    pub fn arm(&self) {
        self.0.store(ARMED, Ordering::SeqCst);
    }

    /// Forbids motion until the next [`Self::arm`]. A stop stays one.
    pub fn disarm(&self) {
        // A stop that comes in between is the newer decision.
        let _ = self.0.compare_exchange(ARMED, NOT_ARMED, Ordering::SeqCst, Ordering::SeqCst);
    }

    /// Latches a stop until the next [`Self::arm`].
    pub fn stop(&self) {
        self.0.store(STOPPED, Ordering::SeqCst);
    }

    /// The present state.
    #[must_use]
    pub fn state(&self) -> OperatorState {
        match self.0.load(Ordering::SeqCst) {
            ARMED => OperatorState::Armed,
            STOPPED => OperatorState::Stopped,
            _ => OperatorState::NotArmed,
        }
    }
}
