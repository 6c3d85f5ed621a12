//! One engine for one navigator after the other.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::local::{Detail, Engine, EngineError, Evaluation, QuantizedProblem};

/// Opening an engine can take seconds, and a navigator that finds no path takes its own with it: each gets a handle.
#[derive(Clone)]
pub struct SharedEngine(Arc<Mutex<Box<dyn Engine>>>);

impl SharedEngine {
    pub fn new(engine: Box<dyn Engine>) -> Self {
        Self(Arc::new(Mutex::new(engine)))
    }

    fn engine(&self) -> MutexGuard<'_, Box<dyn Engine>> {
        // An engine that has failed may be asked again.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Engine for SharedEngine {
    fn name(&self) -> String {
        self.engine().name()
    }

    fn kind(&self) -> &'static str {
        self.engine().kind()
    }

    fn threads(&self) -> usize {
        self.engine().threads()
    }

    fn evaluate(
        &mut self,
        problem: &QuantizedProblem,
        detail: Detail,
    ) -> Result<Evaluation, EngineError> {
        self.engine().evaluate(problem, detail)
    }
}
