//! Ctrl-C while Rust works. Python's handler only sets a flag, and only the main thread can ask for it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use inbye::experiment::World;
use inbye::external::interruptible;
use pyo3::prelude::*;

use super::controller::Raised;

/// Time between two checks in a drive: each takes Python's lock.
const CHECK_PERIOD: Duration = Duration::from_millis(50);

/// Ends the drives of worlds, and the waits for programs, when Python has a signal to handle.
#[derive(Clone)]
pub struct Interrupt {
    flag: Arc<AtomicBool>,
    checked: Instant,
}

impl Interrupt {
    pub fn new() -> Self {
        Self { flag: Arc::default(), checked: Instant::now() }
    }

    /// Makes the drives of a world end at this interrupt.
    pub fn set_in(&self, world: &mut World) {
        world.interrupt = Some(Arc::clone(&self.flag));
    }

    /// Runs work in this thread. Ends its waits for programs at this interrupt, and keeps an exception of a handler.
    pub fn watch<R>(&self, raised: &Raised, work: impl FnOnce() -> R) -> R {
        let (interrupt, raised) = (self.clone(), raised.clone());
        let is_interrupted = move || {
            interrupt.check().unwrap_or_else(|error| raised.set(error));
            interrupt.flag.load(Ordering::Relaxed)
        };
        interruptible(is_interrupted, work)
    }

    /// Runs the handlers of signals in the main thread; does nothing in other threads. An exception of a handler ends the drives.
    pub fn check(&self) -> PyResult<()> {
        #[expect(
            clippy::redundant_closure_for_method_calls,
            reason = "the method alone is not general enough in its lifetime"
        )]
        let handled = Python::attach(|py| py.check_signals());
        if handled.is_err() {
            self.flag.store(true, Ordering::Relaxed);
        }
        handled
    }

    /// As [`Self::check`], for calls in quick succession.
    pub fn check_now_and_then(&mut self) -> PyResult<()> {
        if self.checked.elapsed() < CHECK_PERIOD {
            return Ok(());
        }
        self.checked = Instant::now();
        self.check()
    }
}
