//! A pool of threads that run one task together with the caller.
//!
//! A decision takes 0.1 ms, so starting the task must cost microseconds and no allocation. A worker spins for a short
//! time before it sleeps. The caller works too, and does not wait for a worker that wakes after the work is done.
#![expect(
    unsafe_code,
    reason = "a pool that takes borrowed task without allocating; the usual one allocates for each decision"
)]

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
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

#[derive(Default)]
struct Shared {
    state: Mutex<TaskState>,
    /// [`TaskState::open`], for spinning without the lock.
    open: AtomicUsize,
    /// [`TaskState::running`], for spinning without the lock.
    running: AtomicUsize,
    wake: Condvar,
    done: Condvar,
}

#[derive(Default)]
struct TaskState {
    /// Workers that have begun to wait for tasks.
    started: usize,
    task: Option<Task<'static>>,
    /// Calls of the task that a worker may still begin.
    open: usize,
    /// Calls of the task that workers have begun and not ended.
    running: usize,
    panicked: bool,
    shutdown: bool,
}

impl ThreadPool {
    /// Starts the workers.
    ///
    /// # Errors
    /// When the system refuses a thread.
    pub fn new(workers: usize) -> Result<Self, EngineError> {
        let shared = Arc::new(Shared::default());
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
        // The system allocates memory for a thread when it begins to run, which no decision may cost.
        let mut state = pool.shared.lock();
        while state.started < workers {
            state = pool.shared.done.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        drop(state);
        Ok(pool)
    }

    /// Calls `task` in the caller's thread, and up to `helpers` times in workers that are ready before the caller's call
    /// returns. Returns when all calls have returned. Each call must therefore work until nothing is left to do.
    ///
    /// # Panics
    /// When `task` panics in any thread, after all calls have returned.
    pub fn run(&mut self, helpers: usize, task: Task<'_>) {
        // SAFETY: only the lifetime changes. A worker uses the reference between `next_task`, which counts it as running, and
        // its report. `finish` closes the task and then waits until none is running, also when `task` panics in this thread.
        let unbounded = unsafe { core::mem::transmute::<Task<'_>, Task<'static>>(task) };
        self.shared.start(unbounded, helpers.min(self.workers.len()));
        let own = catch_unwind(AssertUnwindSafe(task));
        let panicked = self.shared.finish();
        if let Err(cause) = own {
            resume_unwind(cause);
        }
        assert!(!panicked, "a worker of the CPU engine panicked");
    }
}

impl Drop for ThreadPool {
    fn drop(&mut self) {
        self.shared.lock().shutdown = true;
        // Ends the spinning.
        self.shared.open.store(1, Ordering::Release);
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

    fn start(&self, task: Task<'static>, helpers: usize) {
        let mut state = self.lock();
        state.task = Some(task);
        state.open = helpers;
        state.panicked = false;
        self.open.store(helpers, Ordering::Release);
        drop(state);
        for _ in 0..helpers {
            self.wake.notify_one();
        }
    }

    /// Lets no further worker begin, and waits for those that have begun. Returns whether one panicked.
    fn finish(&self) -> bool {
        {
            let mut state = self.lock();
            state.task = None;
            state.open = 0;
            self.open.store(0, Ordering::Release);
        }
        spin_until(|| self.running.load(Ordering::Acquire) == 0);
        let mut state = self.lock();
        while state.running > 0 {
            state = self.done.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        state.panicked
    }

    /// The loop of a worker.
    fn run_worker(&self) {
        self.lock().started += 1;
        self.done.notify_one();
        while let Some(task) = self.next_task() {
            let outcome = catch_unwind(AssertUnwindSafe(task));
            let mut state = self.lock();
            state.panicked |= outcome.is_err();
            state.running -= 1;
            self.running.store(state.running, Ordering::Release);
            if state.running == 0 {
                drop(state);
                self.done.notify_one();
            }
        }
    }

    /// Begins the next call; `None` when the pool shuts down.
    fn next_task(&self) -> Option<Task<'static>> {
        spin_until(|| self.open.load(Ordering::Acquire) > 0);
        let mut state = self.lock();
        loop {
            if state.shutdown {
                return None;
            }
            match state.task {
                Some(task) if state.open > 0 => {
                    state.open -= 1;
                    state.running += 1;
                    self.open.store(state.open, Ordering::Release);
                    self.running.store(state.running, Ordering::Release);
                    return Some(task);
                }
                _ => {
                    state = self.wake.wait(state).unwrap_or_else(PoisonError::into_inner);
                }
            }
        }
    }
}

/// Hands out the numbers from zero, each once, to all threads.
#[derive(Default)]
pub struct Counter(AtomicUsize);

impl Counter {
    /// The next number.
    pub fn take(&self) -> usize {
        self.0.fetch_add(1, Ordering::Relaxed)
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
    use std::sync::Barrier;
    use std::sync::atomic::AtomicUsize;

    /// All threads meet in each task, so a thread that does not come would stop the test.
    #[test]
    fn thread_pool_runs_the_task_in_as_many_threads_as_asked() {
        let mut pool = ThreadPool::new(3).expect("three threads");
        for task in 0..1000 {
            let helpers = task % 4;
            let (barrier, calls) = (Barrier::new(helpers + 1), AtomicUsize::new(0));
            pool.run(helpers, &|| {
                barrier.wait();
                calls.fetch_add(1, Ordering::Relaxed);
            });
            assert_eq!(calls.load(Ordering::Relaxed), helpers + 1, "task {task}");
        }
    }

    /// The caller ends at once. A worker that comes later must not call the task: its data is gone.
    #[test]
    fn thread_pool_has_no_call_after_run_returns() {
        let mut pool = ThreadPool::new(3).expect("three threads");
        let late = AtomicUsize::new(0);
        for _ in 0..1000 {
            let over = AtomicUsize::new(0);
            pool.run(3, &|| {
                late.fetch_add(over.load(Ordering::SeqCst), Ordering::Relaxed);
            });
            over.store(1, Ordering::SeqCst);
        }
        assert_eq!(late.load(Ordering::Relaxed), 0);
        assert_eq!(pool.shared.lock().running, 0);
    }

    #[test]
    fn thread_pool_passes_on_a_panic_and_stays_usable() {
        let mut pool = ThreadPool::new(2).expect("two threads");
        let caller = std::thread::current().id();
        for in_caller in [true, false] {
            let barrier = Barrier::new(3);
            let outcome = catch_unwind(AssertUnwindSafe(|| {
                pool.run(2, &|| {
                    barrier.wait();
                    let here = std::thread::current().id() == caller;
                    assert_ne!(here, in_caller, "the panic of this test");
                });
            }));
            assert!(outcome.is_err());
        }
        let (barrier, calls) = (Barrier::new(3), AtomicUsize::new(0));
        pool.run(2, &|| {
            barrier.wait();
            calls.fetch_add(1, Ordering::Relaxed);
        });
        assert_eq!(calls.load(Ordering::Relaxed), 3);
    }
}
