//! One engine for many threads: decisions that arrive while it works are evaluated together afterwards.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use super::engine::{Detail, Engine, Evaluation};
use super::{EngineError, GpuFailureKind, Incidents, QuantizedProblem};

/// A handle to an engine that other handles use as well, each in its own thread, such as robots that are simulated side by side.
///
/// The engine evaluates one batch at a time. A thread that finds it idle evaluates all problems that wait by then; the others
/// wait for their answers. On a GPU a batch of 64 takes little longer than one problem. The answers are those of the engine alone,
/// bit for bit.
#[derive(Clone)]
pub struct SharedEngine {
    shared: Arc<Shared>,
}

crate::settings::opaque_debug!(SharedEngine);

struct Shared {
    name: String,
    threads: usize,
    engine: Mutex<Box<dyn Engine>>,
    queue: Mutex<Queue>,
    answered: Condvar,
    failed: AtomicBool,
}

#[derive(Default)]
struct Queue {
    next_ticket: u64,
    waiting: Vec<Request>,
    answers: Vec<(u64, Result<Evaluation, EngineError>)>,
    /// Whether a thread evaluates.
    is_busy: bool,
    /// Batches evaluated, and the problems in them.
    batches: u64,
    problems: u64,
}

struct Request {
    ticket: u64,
    problem: QuantizedProblem,
    detail: Detail,
}

impl SharedEngine {
    /// Shares an engine. Further handles are clones.
    #[must_use]
    pub fn new(engine: Box<dyn Engine>) -> Self {
        let shared = Shared {
            name: engine.name(),
            threads: engine.threads(),
            engine: Mutex::new(engine),
            queue: Mutex::default(),
            answered: Condvar::new(),
            failed: AtomicBool::new(false),
        };
        Self { shared: Arc::new(shared) }
    }

    /// Whether the engine has failed on its own account, not because of a problem that it cannot hold.
    #[must_use]
    pub fn has_failed(&self) -> bool {
        self.shared.failed.load(Ordering::Relaxed)
    }

    /// Number of batches so far, and of the problems in them.
    #[must_use]
    pub fn counts(&self) -> (u64, u64) {
        let queue = self.shared.lock();
        (queue.batches, queue.problems)
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn engine(&self) -> MutexGuard<'_, Box<dyn Engine>> {
        self.engine.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The answers in the order of the problems. One batch holds them all.
    fn evaluate(
        &self,
        problems: &[QuantizedProblem],
        detail: Detail,
    ) -> Vec<Result<Evaluation, EngineError>> {
        if problems.is_empty() {
            return Vec::new();
        }
        let mut queue = self.lock();
        let first = queue.next_ticket;
        queue.next_ticket += problems.len() as u64;
        let tickets = first..queue.next_ticket;
        let own = tickets.clone().zip(problems);
        let own = own.map(|(ticket, problem)| Request { ticket, problem: problem.clone(), detail });
        queue.waiting.extend(own);
        loop {
            // The answers to a batch are consecutive, in the order of the tickets.
            if let Some(place) = queue.answers.iter().position(|(ticket, _)| *ticket == first) {
                let own = queue.answers.drain(place..place + problems.len());
                return own.map(|(_, answer)| answer).collect();
            }
            if queue.is_busy {
                queue = self.answered.wait(queue).unwrap_or_else(PoisonError::into_inner);
                continue;
            }
            queue.is_busy = true;
            let requests = std::mem::take(&mut queue.waiting);
            queue.batches += 1;
            queue.problems += requests.len() as u64;
            drop(queue);
            let tickets: Vec<u64> = requests.iter().map(|request| request.ticket).collect();
            // The other threads get an answer also when the engine panics.
            let evaluated = catch_unwind(AssertUnwindSafe(|| self.evaluate_all(requests)));
            queue = self.lock();
            queue.is_busy = false;
            self.answered.notify_all();
            match evaluated {
                Ok(answers) => queue.answers.extend(tickets.into_iter().zip(answers)),
                Err(panic) => {
                    let lost = tickets.into_iter().map(|ticket| (ticket, Err(self.panicked())));
                    queue.answers.extend(lost);
                    drop(queue);
                    resume_unwind(panic);
                }
            }
        }
    }

    fn panicked(&self) -> EngineError {
        EngineError::Lost {
            adapter: self.name.clone(),
            kind: GpuFailureKind::Internal,
            message: "the thread that evaluated the batch panicked".to_owned(),
        }
    }

    /// The answers in the order of the requests.
    fn evaluate_all(&self, requests: Vec<Request>) -> Vec<Result<Evaluation, EngineError>> {
        let details: Vec<Detail> = requests.iter().map(|request| request.detail).collect();
        let problems: Vec<QuantizedProblem> =
            requests.into_iter().map(|request| request.problem).collect();
        let mut engine = self.engine();
        let is_uniform = details.windows(2).all(|pair| pair[0] == pair[1]);
        if let Some(&detail) = details.first().filter(|_| is_uniform)
            && let Ok(answers) = engine.evaluate_batch(&problems, detail)
        {
            return answers.into_iter().map(Ok).collect();
        }
        // One after the other: an error belongs to one problem alone.
        let answers = problems.iter().zip(details).map(|(problem, detail)| {
            let answer = engine.evaluate(problem, detail);
            if answer.as_ref().is_err_and(|error| !matches!(error, EngineError::TooLarge { .. })) {
                self.failed.store(true, Ordering::Relaxed);
            }
            answer
        });
        answers.collect()
    }
}

impl Engine for SharedEngine {
    fn name(&self) -> String {
        self.shared.name.clone()
    }

    fn threads(&self) -> usize {
        self.shared.threads
    }

    fn evaluate(
        &mut self,
        problem: &QuantizedProblem,
        detail: Detail,
    ) -> Result<Evaluation, EngineError> {
        self.shared.evaluate(std::slice::from_ref(problem), detail).remove(0)
    }

    fn evaluate_batch(
        &mut self,
        problems: &[QuantizedProblem],
        detail: Detail,
    ) -> Result<Vec<Evaluation>, EngineError> {
        self.shared.evaluate(problems, detail).into_iter().collect()
    }

    /// Waits for the end of a batch.
    fn incidents(&self) -> Option<Incidents> {
        self.shared.engine().incidents()
    }
}
