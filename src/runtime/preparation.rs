//! What another thread prepares while the robot drives.

use std::thread::{Builder, JoinHandle};

/// The result of a thread, for the newest inputs.
pub(crate) struct Preparation<T> {
    running: Option<JoinHandle<T>>,
    /// Newer inputs arrived since the start of the thread.
    is_outdated: bool,
}

impl<T> Default for Preparation<T> {
    fn default() -> Self {
        Self { running: None, is_outdated: false }
    }
}

impl<T: Send + 'static> Preparation<T> {
    /// Starts a thread of a name with the work that `work` returns. While one runs already, only marks its result as outdated. Returns
    /// false if no thread starts.
    pub fn start<W: FnOnce() -> T + Send + 'static>(
        &mut self,
        name: &str,
        work: impl FnOnce() -> W,
    ) -> bool {
        self.is_outdated = self.is_running();
        if !self.is_running() {
            self.running = Builder::new().name(name.to_owned()).spawn(work()).ok();
        }
        self.is_running()
    }

    /// Whether the thread runs, or its result was not taken.
    pub const fn is_running(&self) -> bool {
        self.running.is_some()
    }

    /// Newer inputs have arrived: the result will be outdated.
    #[cfg(feature = "ros")]
    pub const fn outdate(&mut self) {
        self.is_outdated = true;
    }

    /// The result of a thread that has ended, none if it panicked, and whether it is outdated; once.
    pub fn take(&mut self) -> Option<(Option<T>, bool)> {
        let finished = self.running.take_if(|running| running.is_finished())?;
        Some((finished.join().ok(), self.is_outdated))
    }
}
