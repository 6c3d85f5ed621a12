//! A pool of threads that run one task together with the caller.
//!
//! A decision takes 0.1 ms, so starting the task must cost microseconds and no allocation. A worker spins for a short
//! time before it sleeps. The caller works too, so a worker that wakes late delays nothing.
#![expect(
    unsafe_code,
    reason = "a pool that takes borrowed work without allocating; the usual one allocates for each decision"
)]

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use crate::local::EngineError;

type LaneTask<'a> = &'a (dyn Fn() + Sync);

/// Iterations of the spin loop before a worker or the waiting caller sleeps: about ten microseconds.
const TIMEOUT: u32 = 4000;

/// Worker threads in addition to the caller's thread.
pub struct ThreadPool {
    shared: Arc<Shared>,
    workers: Vec<JoinHandle<()>>,
}

struct Shared {
    order: Mutex<Order>,
    /// Number of the last task, for spinning without the lock.
    given: AtomicU64,
    /// Workers that have not finished the task.
    busy: AtomicU64,
    wake: Condvar,
    done: Condvar,
}

struct Order {
    number: u64,
    work: Option<LaneTask<'static>>,
    panicked: bool,
    dismissed: bool,
}

impl ThreadPool {
    /// Starts the workers.
    ///
    /// # Errors
    /// When the system refuses a thread.
    pub fn new(workers: usize) -> Result<Self, EngineError> {
        let shared = Arc::new(Shared {
            order: Mutex::new(Order {
                number: 0,
                work: None,
                panicked: false,
                dismissed: false,
            }),
            given: AtomicU64::new(0),
            busy: AtomicU64::new(0),
            wake: Condvar::new(),
            done: Condvar::new(),
        });
        let mut pool = Self {
            shared,
            workers: Vec::with_capacity(workers),
        };
        for _ in 0..workers {
            let shared = Arc::clone(&pool.shared);
            let builder = std::thread::Builder::new().name("inbye".to_owned());
            let worker = builder.spawn(move || shared.serve());
            pool.workers
                .push(worker.map_err(|error| EngineError::ThreadSpawn {
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
    pub fn run(&mut self, work: LaneTask<'_>) {
        // SAFETY: only the lifetime changes. Workers use the reference between the start and their report of
        // completion, and this function waits for all reports below, also when `task` panics in this thread.
        let unbounded = unsafe { core::mem::transmute::<LaneTask<'_>, LaneTask<'static>>(work) };
        self.shared.give(unbounded, self.workers.len() as u64);
        let own = catch_unwind(AssertUnwindSafe(work));
        let panicked = self.shared.wait();
        if let Err(cause) = own {
            resume_unwind(cause);
        }
        assert!(!panicked, "a worker of the CPU engine panicked");
    }
}

impl Drop for ThreadPool {
    fn drop(&mut self) {
        self.shared.lock().dismissed = true;
        self.shared.given.store(u64::MAX, Ordering::Release);
        self.shared.wake.notify_all();
        for worker in self.workers.drain(..) {
            // Workers catch panics, so the result carries no information.
            let _ = worker.join();
        }
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Order> {
        self.order.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn give(&self, work: LaneTask<'static>, workers: u64) {
        let mut order = self.lock();
        order.number += 1;
        order.work = Some(work);
        order.panicked = false;
        self.busy.store(workers, Ordering::Release);
        self.given.store(order.number, Ordering::Release);
        drop(order);
        self.wake.notify_all();
    }

    /// Waits until no worker is busy. Returns whether one panicked.
    fn wait(&self) -> bool {
        look_out(|| self.busy.load(Ordering::Acquire) == 0);
        let mut order = self.lock();
        while self.busy.load(Ordering::Acquire) > 0 {
            order = self
                .done
                .wait(order)
                .unwrap_or_else(PoisonError::into_inner);
        }
        order.work = None;
        order.panicked
    }

    /// The loop of a worker.
    fn serve(&self) {
        let mut last = 0;
        while let Some((number, work)) = self.next(last) {
            last = number;
            let outcome = catch_unwind(AssertUnwindSafe(work));
            let mut order = self.lock();
            order.panicked |= outcome.is_err();
            if self.busy.fetch_sub(1, Ordering::AcqRel) == 1 {
                drop(order);
                self.done.notify_one();
            }
        }
    }

    /// The next task after `last`; `None` when the pool shuts down.
    fn next(&self, last: u64) -> Option<(u64, LaneTask<'static>)> {
        look_out(|| self.given.load(Ordering::Acquire) != last);
        let mut order = self.lock();
        loop {
            if order.dismissed {
                return None;
            }
            match order.work {
                Some(work) if order.number != last => return Some((order.number, work)),
                _ => {
                    order = self
                        .wake
                        .wait(order)
                        .unwrap_or_else(PoisonError::into_inner);
                }
            }
        }
    }
}

/// Spins for a limited time until `condition` holds.
fn look_out(come_true: impl Fn() -> bool) {
    for _ in 0..TIMEOUT {
        if come_true() {
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
    fn every_order_is_done_once_by_each_thread() {
        let mut pool = ThreadPool::new(3).expect("three threads");
        let calls = AtomicUsize::new(0);
        for order in 1..=1000 {
            pool.run(&|| {
                calls.fetch_add(1, Ordering::Relaxed);
            });
            assert_eq!(calls.load(Ordering::Relaxed), 4 * order);
        }
    }

    #[test]
    fn a_panic_reaches_the_caller_and_the_crew_works_on() {
        let mut pool = ThreadPool::new(2).expect("two threads");
        let caller = std::thread::current().id();
        for in_caller in [true, false] {
            let outcome = catch_unwind(AssertUnwindSafe(|| {
                pool.run(&|| {
                    let here = std::thread::current().id() == caller;
                    assert_ne!(here, in_caller, "as the test wants");
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
