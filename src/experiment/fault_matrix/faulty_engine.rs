//! An engine that fails on demand, in the place of a GPU.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::local::{
    CpuEngine, Detail, Engine, EngineError, Evaluation, Failover, GpuFailureKind, QuantizedProblem,
};

/// What is wrong with the engine.
#[derive(Clone, Copy, Debug)]
pub(super) enum EngineFault {
    /// It gives no answer.
    NoAnswer(GpuFailureKind),
    /// It names another sample than the best one.
    WrongAnswer,
}

/// A CPU engine that fails while a switch is on.
struct FaultyEngine {
    cpu: CpuEngine,
    fault: EngineFault,
    is_faulty: Arc<AtomicBool>,
}

impl Engine for FaultyEngine {
    fn name(&self) -> String {
        "faulty".to_owned()
    }

    fn evaluate(
        &mut self,
        problem: &QuantizedProblem,
        detail: Detail,
    ) -> Result<Evaluation, EngineError> {
        let mut answer = self.cpu.evaluate(problem, detail)?;
        if !self.is_faulty.load(Ordering::Relaxed) {
            return Ok(answer);
        }
        match self.fault {
            EngineFault::NoAnswer(kind) => Err(EngineError::Lost {
                adapter: self.name(),
                kind,
                message: "injected fault".to_owned(),
            }),
            EngineFault::WrongAnswer => {
                // The last sample has the highest speed.
                if let Some(winner) = &mut answer.winner {
                    winner.index = problem.len().saturating_sub(1) as u32;
                }
                Ok(answer)
            }
        }
    }
}

/// Creates an engine that fails while the switch is on, with a CPU fallback or without one. It is not reopened.
pub(super) fn faulty_engine(
    fault: EngineFault,
    has_fallback: bool,
    is_faulty: Arc<AtomicBool>,
) -> Box<dyn Engine> {
    let engine = FaultyEngine { cpu: CpuEngine::single_threaded(), fault, is_faulty };
    if has_fallback {
        let reopen = || Err(EngineError::NoAdapter);
        Box::new(Failover::new(Ok(Box::new(engine)), reopen, CpuEngine::single_threaded()))
    } else {
        Box::new(engine)
    }
}
