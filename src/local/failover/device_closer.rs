//! Closes a device that may hang.
//!
//! When wgpu drops a queue, it waits without limit until the queue is idle, and it panics at unexpected driver errors.
//! Neither may happen in the control thread.

use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread;
use std::time::Duration;

use crate::local::Engine;

/// Longest wait at process exit for each thread that holds a device. A healthy driver needs less, so no driver is
/// unloaded while it works; a hung one never answers.
pub const WAIT_AT_END: Duration = Duration::from_secs(2);

/// Devices that are being closed, each in its own thread.
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
