//! A CPU engine whose answers a test changes.

use inbye::local::{CpuEngine, Detail, Engine, EngineError, Evaluation, QuantizedProblem};

pub struct ChangedEngine<F> {
    cpu: CpuEngine,
    change: F,
}

impl<F: FnMut(&QuantizedProblem, &mut Evaluation) + Send> ChangedEngine<F> {
    pub fn new(change: F) -> Self {
        Self { cpu: CpuEngine::single_threaded(), change }
    }
}

impl<F: FnMut(&QuantizedProblem, &mut Evaluation) + Send> Engine for ChangedEngine<F> {
    fn name(&self) -> String {
        "changed".to_owned()
    }

    fn threads(&self) -> usize {
        1
    }

    fn evaluate(
        &mut self,
        problem: &QuantizedProblem,
        detail: Detail,
    ) -> Result<Evaluation, EngineError> {
        let mut answer = self.cpu.evaluate(problem, detail)?;
        (self.change)(problem, &mut answer);
        Ok(answer)
    }
}
