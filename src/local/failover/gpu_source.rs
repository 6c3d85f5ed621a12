//! Opens a GPU after a failure.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread;

use super::device_closer::WAIT_AT_END;
use crate::local::{Engine, EngineError};

/// Opens GPU engines for a [`Failover`](super::Failover). A closure that opens an engine is a source too; it blocks the
/// decision.
pub trait GpuSource: Send {
    /// Returns the result of the attempt, or `None` while it is pending. [`Failover`](super::Failover) calls it at each
    /// decision from the one at which a new engine is due until there is a result.
    fn poll(&mut self) -> Option<Result<Box<dyn Engine>, EngineError>>;
}

impl<F> GpuSource for F
where
    F: FnMut() -> Result<Box<dyn Engine>, EngineError> + Send,
{
    fn poll(&mut self) -> Option<Result<Box<dyn Engine>, EngineError>> {
        Some(self())
    }
}

type Outcome = Result<Box<dyn Engine>, EngineError>;

/// Opens engines in a background thread. Finding an adapter, compiling the shaders and taking a first decision takes
/// longer than a control tick, and a hung driver must not block the robot. Makes one attempt at a time.
pub struct BackgroundOpener {
    open: Arc<dyn Fn() -> Outcome + Send + Sync>,
    pending: Option<Receiver<Outcome>>,
}

impl BackgroundOpener {
    /// Creates a source that opens engines with this function.
    #[must_use]
    pub fn new(open: impl Fn() -> Outcome + Send + Sync + 'static) -> Self {
        Self { open: Arc::new(open), pending: None }
    }

    fn start(&mut self) -> Result<(), EngineError> {
        let (done, outcome) = channel();
        let open = Arc::clone(&self.open);
        thread::Builder::new()
            .name("inbye-opening".to_owned())
            // The receiver is gone only when the engine is no longer needed.
            .spawn(move || done.send(open()))
            .map_err(|error| EngineError::ThreadSpawn { threads: 1, message: error.to_string() })?;
        self.pending = Some(outcome);
        Ok(())
    }
}

impl GpuSource for BackgroundOpener {
    fn poll(&mut self) -> Option<Outcome> {
        let Some(pending) = &self.pending else {
            return self.start().err().map(Err);
        };
        let outcome = match pending.try_recv() {
            Err(TryRecvError::Empty) => return None,
            Ok(outcome) => outcome,
            Err(TryRecvError::Disconnected) => Err(EngineError::Setup {
                adapter: "unknown".to_owned(),
                message: "the thread that opened it panicked".to_owned(),
            }),
        };
        self.pending = None;
        Some(outcome)
    }
}

impl Drop for BackgroundOpener {
    fn drop(&mut self) {
        if let Some(pending) = &self.pending {
            let _ = pending.recv_timeout(WAIT_AT_END);
        }
    }
}
