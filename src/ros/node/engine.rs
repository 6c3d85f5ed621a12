//! The engine of a node, which its successive navigators use.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::local::{Detail, Engine, EngineError, Evaluation, Incidents, QuantizedProblem};
use crate::ros::convert::key_value;
use crate::ros::msg::DiagnosticStatus;

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

    /// The status of a GPU with a CPU fallback for `diagnostics`; none for another engine.
    pub fn status(&self) -> Option<DiagnosticStatus> {
        let engine = self.lock();
        let incidents = engine.incidents()?;
        let decides = engine.kind();
        let (level, message) = match incidents.messages.last() {
            Some(newest) if decides == "cpu" => (DiagnosticStatus::WARN, newest.message.clone()),
            _ => (DiagnosticStatus::OK, format!("the {} decides", decides.to_uppercase())),
        };
        Some(DiagnosticStatus {
            level,
            name: "inbye: engine".to_owned(),
            message,
            hardware_id: engine.name(),
            values: vec![
                key_value("gpu_failures", incidents.total_failures()),
                key_value("gpu_reopened", incidents.reopened),
                key_value("cpu_ticks", incidents.on_cpu),
            ],
        })
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

    fn evaluate_batch(
        &mut self,
        problems: &[QuantizedProblem],
        detail: Detail,
    ) -> Result<Vec<Evaluation>, EngineError> {
        self.lock().evaluate_batch(problems, detail)
    }

    fn incidents(&self) -> Option<Incidents> {
        self.lock().incidents()
    }
}
