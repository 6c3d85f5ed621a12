//! The GPUs that robots simulated side by side have in common.

use std::sync::{Mutex, PoisonError};

use super::{
    BackgroundOpener, CpuEngine, Engine, EngineChoice, EngineError, Failover, SharedEngine,
    open_engine,
};

/// Opens engines for robots that are simulated side by side, each in its own thread. All of them share a GPU, which evaluates
/// their decisions in batches; on the CPU each has its own engine.
#[derive(Default)]
pub struct SharedEngines {
    gpus: Mutex<Vec<(EngineChoice, SharedEngine)>>,
}

crate::settings::opaque_debug!(SharedEngines);

impl SharedEngines {
    /// Opens the engine of a robot. A GPU has the CPU as fallback, with `threads` threads as a CPU engine has.
    ///
    /// # Errors
    /// When the choice is a GPU and no matching adapter opens, or the system refuses a thread.
    pub fn open(
        &self,
        choice: &EngineChoice,
        threads: usize,
    ) -> Result<Box<dyn Engine>, EngineError> {
        if *choice == EngineChoice::Cpu {
            return Ok(open_engine(choice, threads)?.engine);
        }
        let gpu: Box<dyn Engine> = Box::new(self.gpu(choice)?);
        let cpu = CpuEngine::with_threads(threads)?;
        let choice = choice.clone();
        let reopen = move || Ok(open_engine(&choice, 1)?.engine);
        Ok(Box::new(Failover::new(Ok(gpu), BackgroundOpener::new(reopen), cpu)))
    }

    /// The GPU of a choice, opened again after it has failed.
    fn gpu(&self, choice: &EngineChoice) -> Result<SharedEngine, EngineError> {
        let mut gpus = self.gpus.lock().unwrap_or_else(PoisonError::into_inner);
        gpus.retain(|(_, engine)| !engine.has_failed());
        if let Some((_, engine)) = gpus.iter().find(|(other, _)| other == choice) {
            return Ok(engine.clone());
        }
        let engine = SharedEngine::new(open_engine(choice, 1)?.engine);
        gpus.push((choice.clone(), engine.clone()));
        Ok(engine)
    }
}
