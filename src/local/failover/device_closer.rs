//! DeviceCloser a device that may hang.
//!
//! wgpu waits without limit for a queue to be idle when it drops it, and panics where the driver says something
//! unexpected. Neither may happen to the thread that drives a robot.

use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread;
use std::time::Duration;

use crate::local::Engine;

/// The process waits so long at its end for each thread that holds a device: longer than a healthy driver needs, so
/// that none is unloaded while it works; a hung one never answers.
pub const WAIT_AT_END: Duration = Duration::from_secs(2);

/// Devices that are being closed, each in a thread of its own.
#[derive(Default)]
pub struct DeviceCloser(Vec<Receiver<()>>);

impl DeviceCloser {
    /// Closes an engine without waiting for it.
    pub fn close(&mut self, engine: Box<dyn Engine>) {
        self.0
            .retain(|closed| closed.try_recv() == Err(TryRecvError::Empty));
        let (done, closed) = channel();
        let close = move || {
            drop(engine);
            // Nobody listens any more where the wait at the end is over.
            let _ = done.send(());
        };
        // Where the system gives no thread, the closure is dropped here, and the engine with it.
        if thread::Builder::new()
            .name("inbye-closer".to_owned())
            .spawn(close)
            .is_ok()
        {
            self.0.push(closed);
        }
    }
}

impl Drop for DeviceCloser {
    fn drop(&mut self) {
        for closed in &self.0 {
            // A panic while closer, or no end of it, is what the thread was for.
            let _ = closed.recv_timeout(WAIT_AT_END);
        }
    }
}
