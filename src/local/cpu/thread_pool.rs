//! A pool of threads that run one task together with the caller.
//!
//! A decision takes 0.1 ms, so starting the task must cost microseconds and no allocation. A worker spins for a short
//! time before it sleeps. The caller works too, so a worker that wakes late delays nothing.
#![expect(
    unsafe_code,
    reason = "a pool that takes borrowed task without allocating; the usual one allocates for each decision"
)]

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use crate::local::EngineError;

type Task<'a> = &'a (dyn Fn() + Sync);

/// Iterations of the spin loop before a worker or the waiting caller sleeps: about ten microseconds.
const SPIN_ITERATIONS: u32 = 4000;

/// Worker threads in addition to the caller's thread.
pub struct ThreadPool {
    shared: Arc<Shared>,
    workers: Vec<JoinHandle<()>>,
}

struct Shared {
    state: Mutex<TaskState>,
    /// Number of the last task, for spinning without the lock.
    task_number: AtomicU64,
    /// Workers that have not finished the task.
    busy: AtomicU64,
    wake: Condvar,
    done: Condvar,
}

struct TaskState {
    number: u64,
    task: Option<Task<'static>>,
    panicked: bool,
    shutdown: bool,
}

impl ThreadPool {
    /// Starts the workers.
    ///
    /// # Errors
    /// When the system refuses a thread.
    pub fn new(workers: usize) -> Result<Self, EngineError> {
        let shared = Arc::new(Shared {
            state: Mutex::new(TaskState {
                number: 0,
                task: None,
                panicked: false,
                shutdown: false,
            }),
            task_number: AtomicU64::new(0),
            busy: AtomicU64::new(0),
            wake: Condvar::new(),
            done: Condvar::new(),
        });
        let mut pool = Self { shared, workers: Vec::with_capacity(workers) };
        for _ in 0..workers {
            let shared = Arc::clone(&pool.shared);
            let builder = std::thread::Builder::new().name("inbye".to_owned());
            let worker = builder.spawn(move || shared.run_worker());
            pool.workers.push(worker.map_err(|error| EngineError::ThreadSpawn {
                threads: workers + 1,
                message: error.to_string(),
            })?);
        }
        Ok(pool)
    }

    /// Calls `task` once in the caller's thread and once in each worker. Returns when all calls have returned.
    ///
    /// # Panics
    /// When `task` panics in any thread, after all calls have returned.
    pub fn run(&mut self, task: Task<'_>) {
        // SAFETY: only the lifetime changes. Workers use the reference between the start and their report of
        // completion, and this function waits for all reports below, also when `task` panics in this thread.
        let unbounded = unsafe { core::mem::transmute::<Task<'_>, Task<'static>>(task) };
        self.shared.start(unbounded, self.workers.len() as u64);
        let own = catch_unwind(AssertUnwindSafe(task));
        let panicked = self.shared.wait();
        if let Err(cause) = own {
            resume_unwind(cause);
        }
        assert!(!panicked, "a worker of the CPU engine panicked");
    }
}

impl Drop for ThreadPool {
    fn drop(&mut self) {
        self.shared.lock().shutdown = true;
        self.shared.task_number.store(u64::MAX, Ordering::Release);
        self.shared.wake.notify_all();
        for worker in self.workers.drain(..) {
            // Workers catch panics, so the result carries no information.
            let _ = worker.join();
        }
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, TaskState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn start(&self, task: Task<'static>, workers: u64) {
        let mut state = self.lock();
        state.number += 1;
        state.task = Some(task);
        state.panicked = false;
        self.busy.store(workers, Ordering::Release);
        self.task_number.store(state.number, Ordering::Release);
        drop(state);
        self.wake.notify_all();
    }

    /// Waits until no worker is busy. Returns whether one panicked.
    fn wait(&self) -> bool {
        spin_until(|| self.busy.load(Ordering::Acquire) == 0);
        let mut state = self.lock();
        while self.busy.load(Ordering::Acquire) > 0 {
            state = self.done.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        state.task = None;
        state.panicked
    }

    /// The loop of a worker.
    fn run_worker(&self) {
        let mut last = 0;
        while let Some((number, task)) = self.next_task(last) {
            last = number;
            let outcome = catch_unwind(AssertUnwindSafe(task));
            let mut state = self.lock();
            state.panicked |= outcome.is_err();
            if self.busy.fetch_sub(1, Ordering::AcqRel) == 1 {
                drop(state);
                self.done.notify_one();
            }
        }
    }

    /// The next task after `last`; `None` when the pool shuts down.
    fn next_task(&self, last: u64) -> Option<(u64, Task<'static>)> {
        spin_until(|| self.task_number.load(Ordering::Acquire) != last);
        let mut state = self.lock();
        loop {
            if state.shutdown {
                return None;
            }
            match state.task {
                Some(task) if state.number != last => return Some((state.number, task)),
                _ => {
                    state = self.wake.wait(state).unwrap_or_else(PoisonError::into_inner);
                }
            }
        }
    }
}

/// Spins for a limited time until `condition` holds.
fn spin_until(condition: impl Fn() -> bool) {
    for _ in 0..SPIN_ITERATIONS {
        if condition() {
            return;
        }
        core::hint::spin_loop();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicUsize;

    #[test]
    fn thread_pool_runs_each_task_once_per_thread() {
        let mut pool = ThreadPool::new(3).expect("three threads");
        let calls = AtomicUsize::new(0);
        for task in 1..=1000 {
            pool.run(&|| {
                calls.fetch_add(1, Ordering::Relaxed);
            });
            assert_eq!(calls.load(Ordering::Relaxed), 4 * task);
        }
    }

    #[test]
    fn thread_pool_passes_on_a_panic_and_stays_usable() {
        let mut pool = ThreadPool::new(2).expect("two threads");
        let caller = std::thread::current().id();
        for in_caller in [true, false] {
            let outcome = catch_unwind(AssertUnwindSafe(|| {
                pool.run(&|| {
                    let here = std::thread::current().id() == caller;
                    assert_ne!(here, in_caller, "the panic of this test");
                });
            }));
            assert!(outcome.is_err());
        }
        let calls = AtomicUsize::new(0);
        pool.run(&|| {
            calls.fetch_add(1, Ordering::Relaxed);
        });
        assert_eq!(calls.load(Ordering::Relaxed), 3);
    }
}
