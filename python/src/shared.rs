//! State that the threads of a Python program share.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::{self, ThreadId};

use pyo3::prelude::*;

use super::conversion::raise;

/// A value that one thread uses at a time. The others wait without Python's lock, which that thread may need.
pub struct Shared<T> {
    inner: Mutex<T>,
    user: Mutex<Option<ThreadId>>,
}

/// Removes the user when its work is done, or panics.
struct User<'a>(&'a Mutex<Option<ThreadId>>);

impl Drop for User<'_> {
    fn drop(&mut self) {
        *lock(self.0) = None;
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<T: Send> Shared<T> {
    pub const fn new(inner: T) -> Self {
        Self { inner: Mutex::new(inner), user: Mutex::new(None) }
    }

    /// Works with the value. Raises in a thread that works with it already, as a controller that calls its navigator does.
    pub fn with<R: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut T) -> R + Send,
    ) -> PyResult<R> {
        let this_thread = thread::current().id();
        if *lock(&self.user) == Some(this_thread) {
            return Err(raise("a controller cannot use the object that calls it"));
        }
        Ok(py.detach(|| {
            let mut inner = lock(&self.inner);
            *lock(&self.user) = Some(this_thread);
            let _user = User(&self.user);
            work(&mut inner)
        }))
    }
}
