//! The engine of a node, which its successive navigators use.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::local::{Detail, Engine, EngineError, Evaluation, QuantizedProblem};

/// An engine for successive navigators: opening one can take seconds, and a navigator owns its engine.
#[derive(Clone)]
pub struct NodeEngine(Arc<Mutex<Box<dyn Engine>>>);

impl NodeEngine {
    pub fn new(engine: Box<dyn Engine>) -> Self {
        Self(Arc::new(Mutex::new(engine)))
    }

    fn lock(&self) -> MutexGuard<'_, Box<dyn Engine>> {
        // An engine is usable after a panic.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Engine for NodeEngine {
    fn name(&self) -> String {
        self.lock().name()
    }

    fn threads(&self) -> usize {
        self.lock().threads()
    }

    fn evaluate(
        &mut self,
        problem: &QuantizedProblem,
        detail: Detail,
    ) -> Result<Evaluation, EngineError> {
        self.lock().evaluate(problem, detail)
    }
}
