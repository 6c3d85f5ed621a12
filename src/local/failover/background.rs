//! Opens and closes devices in separate threads, because a driver may hang.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread;
use std::time::Duration;

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

crate::settings::opaque_debug!(BackgroundOpener);

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

/// Longest wait at process exit for each thread that holds a device. A healthy driver needs less, so no driver is
/// unloaded while it works; a hung one never answers.
const WAIT_AT_END: Duration = Duration::from_secs(2);

/// Devices that are being closed, each in its own thread.
///
/// When wgpu drops a queue, it waits without limit until the queue is idle, and it panics at unexpected driver errors.
/// Neither may happen in the control thread.
#[derive(Default)]
pub struct DeviceCloser(Vec<Receiver<()>>);

impl DeviceCloser {
    /// Closes an engine without waiting.
    pub fn close(&mut self, engine: Box<dyn Engine>) {
        self.0.retain(|closed| closed.try_recv() == Err(TryRecvError::Empty));
        let (done, closed) = channel();
        let close = move || {
            drop(engine);
            // The receiver is gone after the wait at exit has timed out.
            let _ = done.send(());
        };
        // If the system refuses the thread, the closure and the engine are dropped here.
        if thread::Builder::new().name("inbye-closer".to_owned()).spawn(close).is_ok() {
            self.0.push(closed);
        }
    }
}

impl Drop for DeviceCloser {
    fn drop(&mut self) {
        for closed in &self.0 {
            // The thread isolates a panic or a hang of the driver, so the result does not matter.
            let _ = closed.recv_timeout(WAIT_AT_END);
        }
    }
}
