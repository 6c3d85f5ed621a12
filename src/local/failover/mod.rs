//! A GPU with a CPU standing by: the same bits at every decision, whatever happens to the GPU.
//!
//! Every engine returns the same bits, so a decision does not depend on who took it. The GPU is asked first. Where it
//! gives no answer, or one that does not hold when its winner is judged again, the CPU answers the same problem in the
//! same tick; the GPU is dropped and opened anew later, after longer and longer waits that are counted in decisions, not
//! seconds: so a run can be replayed.

mod back_off;
mod device_closer;
mod gpu_source;
mod incidents;
mod winner_check;

use std::panic::{AssertUnwindSafe, catch_unwind};

use back_off::BackOff;
use device_closer::DeviceCloser;
use winner_check::WinnerCheck;

pub use back_off::{FIRST_RETRY, LONGEST_RETRY};
pub use gpu_source::{BackgroundOpener, GpuSource};
pub use incidents::{Incident, Incidents};

use super::engine::{Detail, Engine, Evaluation};
use super::{CpuEngine, EngineError, GpuFailureKind, QuantizedProblem};

/// Evaluates on a GPU while there is one, and on the CPU otherwise.
///
/// A winner from the GPU is used only after the CPU has judged that sample again: admissible, with the same terms and
/// the same score. That costs one sample of thousands. What it cannot show is that no other sample is better: a GPU that
/// computes wrongly and yet names a safe sample, rightly scored within totals that are possible, is believed.
pub struct Failover {
    gpu: Option<Box<dyn Engine>>,
    source: Box<dyn GpuSource>,
    cpu: CpuEngine,
    back_off: BackOff,
    winner_check: WinnerCheck,
    closer: DeviceCloser,
    incidents: Incidents,
}

impl Failover {
    /// A GPU, or why there is none to begin with, a source of others for later, and the CPU that stands by.
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
        };
        match gpu {
            Ok(gpu) => failover.gpu = Some(gpu),
            Err(error) => failover.lose(error.failure_kind(), error.to_string()),
        }
        failover
    }

    /// Whose answer counts now.
    fn active(&self) -> &dyn Engine {
        match &self.gpu {
            Some(gpu) => gpu.as_ref(),
            None => &self.cpu,
        }
    }

    /// The GPU's answer, if it gives one that holds.
    fn ask_gpu<T>(
        &mut self,
        ask: impl FnOnce(&mut dyn Engine) -> Result<T, EngineError>,
        check: impl FnOnce(&mut WinnerCheck, &T) -> Result<(), String>,
    ) -> Option<T> {
        self.incidents.decisions += 1;
        self.reopen_when_due();
        let gpu = self.gpu.as_mut()?;
        // wgpu reports most faults and panics at some. The engine is used no more after one, so nothing half done shows.
        let answer = catch_unwind(AssertUnwindSafe(|| ask(gpu.as_mut())));
        let (kind, message) = match answer {
            Ok(Ok(answer)) => match check(&mut self.winner_check, &answer) {
                Ok(()) => {
                    self.back_off.worked();
                    return Some(answer);
                }
                Err(message) => (GpuFailureKind::WrongAnswer, message),
            },
            Ok(Err(error)) => (error.failure_kind(), error.to_string()),
            Err(_) => (
                GpuFailureKind::Panicked,
                "its driver's code panicked".to_owned(),
            ),
        };
        self.lose(kind, message);
        None
    }

    /// Notes a failure. But for a problem that is only too large, the device has answered for the last time.
    fn lose(&mut self, kind: GpuFailureKind, message: String) {
        self.incidents.lost(kind, message);
        if kind != GpuFailureKind::TooLarge {
            self.back_off.failed();
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
                self.incidents.reopened(&gpu.name());
                self.gpu = Some(gpu);
            }
            Some(Err(error)) => {
                self.incidents
                    .reopen_failures(error.failure_kind(), error.to_string());
                self.back_off.failed();
            }
        }
    }
}

impl Engine for Failover {
    fn name(&self) -> String {
        self.active().name()
    }

    fn kind(&self) -> &'static str {
        self.active().kind()
    }

    fn threads(&self) -> usize {
        self.active().threads()
    }

    fn evaluate(
        &mut self,
        problem: &QuantizedProblem,
        detail: Detail,
    ) -> Result<Evaluation, EngineError> {
        let answer = self.ask_gpu(
            |gpu| gpu.evaluate(problem, detail),
            |winner_check, answer| winner_check.check(problem, answer, detail),
        );
        if let Some(answer) = answer {
            return Ok(answer);
        }
        self.incidents.on_cpu += 1;
        self.cpu.evaluate(problem, detail)
    }

    /// A batch counts as one decision, and one wrong answer in it as all wrong.
    fn evaluate_batch(
        &mut self,
        problems: &[QuantizedProblem],
        detail: Detail,
    ) -> Result<Vec<Evaluation>, EngineError> {
        let answers = self.ask_gpu(
            |gpu| gpu.evaluate_batch(problems, detail),
            |winner_check, answers| winner_check.check_all(problems, answers, detail),
        );
        if let Some(answers) = answers {
            return Ok(answers);
        }
        self.incidents.on_cpu += 1;
        self.cpu.evaluate_batch(problems, detail)
    }

    fn incidents(&self) -> Option<&Incidents> {
        Some(&self.incidents)
    }
}
