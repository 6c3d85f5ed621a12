//! A GPU engine with a CPU fallback: the same bits at every decision, also after a GPU failure.
//!
//! Every engine returns the same bits, so the result does not depend on the engine. The GPU evaluates first. If it
//! gives no answer, or its winner fails the check, the CPU evaluates the same problem in the same tick. The GPU is then
//! closed and reopened later. The delays grow and count decisions, not seconds, so a run can be replayed.

mod background;
mod incidents;
mod winner_check;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use winner_check::WinnerCheck;

pub(crate) use background::DeviceCloser;
pub use background::{BackgroundOpener, GpuSource};
pub use incidents::{Incident, Incidents};

use super::engine::{Detail, Engine, Evaluation};
use super::{CpuEngine, EngineError, GpuFailureKind, QuantizedProblem};

/// Evaluates on the GPU while it works, otherwise on the CPU.
///
/// The CPU checks every winner of the GPU before it is used: the sample must be admissible, with the same terms and the
/// same score. This costs the evaluation of one sample. The check cannot show that no other sample is better: it
/// accepts a wrong GPU that names an admissible sample with the right score under possible totals.
pub struct Failover {
    gpu: Option<Box<dyn Engine>>,
    source: Box<dyn GpuSource>,
    cpu: CpuEngine,
    back_off: BackOff,
    winner_check: WinnerCheck,
    closer: DeviceCloser,
    incidents: Incidents,
    /// Longest time of the GPU for each problem.
    timeout: Option<Duration>,
}

crate::settings::opaque_debug!(Failover);

impl Failover {
    /// Creates the engine from a GPU, or the error that prevents one; a source of GPUs for later; and the fallback.
    #[must_use]
    pub fn new(
        gpu: Result<Box<dyn Engine>, EngineError>,
        source: impl GpuSource + 'static,
        cpu: CpuEngine,
    ) -> Self {
        let mut failover = Self {
            gpu: None,
            source: Box::new(source),
            cpu,
            back_off: BackOff::default(),
            winner_check: WinnerCheck::default(),
            closer: DeviceCloser::default(),
            incidents: Incidents::default(),
            timeout: None,
        };
        match gpu {
            Ok(gpu) => failover.gpu = Some(gpu),
            Err(error) => failover.record_failure(error.failure_kind(), error.to_string()),
        }
        failover
    }

    /// Limits the time of the GPU for each problem, or does not. A later answer is used, but it counts as a failure of the kind
    /// [`GpuFailureKind::TimedOut`]. The engine's own timeout ends a wait for the device; it does not end a call in which the driver
    /// blocks, and neither does this limit.
    #[must_use]
    pub fn with_timeout(self, timeout: Option<Duration>) -> Self {
        Self { timeout, ..self }
    }

    /// The engine that decides now.
    fn active(&self) -> &dyn Engine {
        match &self.gpu {
            Some(gpu) => gpu.as_ref(),
            None => &self.cpu,
        }
    }

    /// Returns the answer of the GPU to this number of problems if it passes the check.
    fn try_gpu<T>(
        &mut self,
        problems: usize,
        evaluate: impl FnOnce(&mut dyn Engine) -> Result<T, EngineError>,
        check: impl FnOnce(&mut WinnerCheck, &T) -> Result<(), String>,
    ) -> Option<T> {
        self.incidents.decisions += 1;
        self.reopen_when_due();
        let gpu = self.gpu.as_mut()?;
        // wgpu reports most faults and panics at some. After a panic the engine is dropped, so its state is not used
        // again.
        let began = Instant::now();
        let answer = catch_unwind(AssertUnwindSafe(|| evaluate(gpu.as_mut())));
        let (kind, message) = match answer {
            Ok(Ok(answer)) => match check(&mut self.winner_check, &answer) {
                Ok(()) => {
                    self.record_answer(problems, began.elapsed());
                    return Some(answer);
                }
                Err(message) => (GpuFailureKind::WrongAnswer, message),
            },
            Ok(Err(error)) => (error.failure_kind(), error.to_string()),
            Err(_) => (GpuFailureKind::Panicked, "the driver panicked".to_owned()),
        };
        self.record_failure(kind, message);
        None
    }

    /// Records a correct answer; one that came too late is a failure.
    fn record_answer(&mut self, problems: usize, elapsed: Duration) {
        let limit = self.timeout.map(|timeout| timeout.saturating_mul(problems as u32));
        match limit.filter(|limit| elapsed > *limit) {
            None => self.back_off.record_success(),
            Some(limit) => {
                let (ms, limit_ms) = (elapsed.as_millis(), limit.as_millis());
                let message = format!(
                    "the driver blocked: the answer took {ms} ms, longer than {limit_ms} ms"
                );
                self.record_failure(GpuFailureKind::TimedOut, message);
            }
        }
    }

    /// Records a failure and closes the device. A problem that is too large leaves the device usable.
    fn record_failure(&mut self, kind: GpuFailureKind, message: String) {
        *self.incidents.failures.entry(kind).or_default() += 1;
        self.incidents.record(Some(kind), message);
        if kind != GpuFailureKind::TooLarge {
            self.back_off.record_failure();
            if let Some(gpu) = self.gpu.take() {
                self.closer.close(gpu);
            }
        }
    }

    fn reopen_when_due(&mut self) {
        if self.gpu.is_some() || !self.back_off.is_due() {
            return;
        }
        match self.source.poll() {
            None => {}
            Some(Ok(gpu)) => {
                self.incidents.reopened += 1;
                self.incidents.record(None, format!("{} reopened", gpu.name()));
                self.gpu = Some(gpu);
            }
            Some(Err(error)) => {
                self.incidents.reopen_failures += 1;
                self.incidents.record(Some(error.failure_kind()), error.to_string());
                self.back_off.record_failure();
            }
        }
    }
}

impl Engine for Failover {
    fn name(&self) -> String {
        self.active().name()
    }

    fn threads(&self) -> usize {
        self.active().threads()
    }

    fn evaluate(
        &mut self,
        problem: &QuantizedProblem,
        detail: Detail,
    ) -> Result<Evaluation, EngineError> {
        let answer = self.try_gpu(
            1,
            |gpu| gpu.evaluate(problem, detail),
            |winner_check, answer| winner_check.check(problem, answer, detail),
        );
        if let Some(answer) = answer {
            return Ok(answer);
        }
        self.incidents.on_cpu += 1;
        self.cpu.evaluate(problem, detail)
    }

    /// A batch counts as one decision; one wrong answer rejects the whole batch.
    fn evaluate_batch(
        &mut self,
        problems: &[QuantizedProblem],
        detail: Detail,
    ) -> Result<Vec<Evaluation>, EngineError> {
        let answers = self.try_gpu(
            problems.len(),
            |gpu| gpu.evaluate_batch(problems, detail),
            |winner_check, answers| winner_check.check_all(problems, answers, detail),
        );
        if let Some(answers) = answers {
            return Ok(answers);
        }
        self.incidents.on_cpu += 1;
        self.cpu.evaluate_batch(problems, detail)
    }

    fn incidents(&self) -> Option<Incidents> {
        Some(self.incidents.clone())
    }
}

/// Decisions from a failure to the first attempt to reopen the GPU: one second at 10 Hz. Each further failure doubles
/// the delay.
pub const FIRST_RETRY: u32 = 10;

/// Longest delay, decisions: about a minute at 10 Hz.
const LONGEST_RETRY: u32 = 640;

/// Number of correct answers in a row after which the delay is reset.
const TRUSTED_AFTER: u32 = 100;

/// The delay before the next attempt.
#[derive(Clone, Debug)]
struct BackOff {
    next_delay: u32,
    remaining: u32,
    successes: u32,
}

impl Default for BackOff {
    fn default() -> Self {
        Self { next_delay: FIRST_RETRY, remaining: 0, successes: 0 }
    }
}

impl BackOff {
    /// Records a failure of the GPU or of an attempt to reopen it.
    fn record_failure(&mut self) {
        self.successes = 0;
        self.remaining = self.next_delay;
        self.next_delay = (2 * self.next_delay).min(LONGEST_RETRY);
    }

    /// Counts one decision without a GPU. Returns true when the delay has passed, and from then on until the next
    /// failure.
    fn is_due(&mut self) -> bool {
        self.remaining = self.remaining.saturating_sub(1);
        self.remaining == 0
    }

    /// Records a correct answer.
    fn record_success(&mut self) {
        self.successes = self.successes.saturating_add(1);
        if self.successes >= TRUSTED_AFTER {
            self.next_delay = FIRST_RETRY;
        }
    }
}
