//! Engines to drive with: a GPU only with the CPU standing by.

#[cfg(feature = "gpu")]
use std::time::Duration;

use super::open::open_cpu;
#[cfg(feature = "gpu")]
use super::open::{best_gpu, wanted_gpu, why_no_gpu};
#[cfg(feature = "gpu")]
use super::{Beside, CpuEngine, Engine, Failover, gpu::GpuEngine};
use super::{EngineError, Opened, Preference};

/// How long a robot waits for its GPU: half of the default control period, so that the CPU can still answer within it.
#[cfg(feature = "gpu")]
const PATIENCE: Duration = Duration::from_millis(50);

/// Opens the engine that a preference asks for, to drive with: as [`open`](super::open()), but whatever happens to a GPU
/// on the way, the CPU goes on with the same bits and the GPU is tried again, as [`super::Failover`] has it.
/// The GPU has 50 ms for each answer. With [`Preference::Auto`] a GPU that is missing at the start is tried again too,
/// but not where there is a software adapter: that one is no better than the CPU, and no GPU was lost.
///
/// # Errors
/// As [`open`](super::open()); and, where a GPU is required, when the engine to begin with is the CPU.
pub fn open_to_drive(
    preference: &Preference,
    threads: usize,
    gpu_required: bool,
) -> Result<Opened, EngineError> {
    let opened = match preference {
        Preference::Cpu => open_cpu(threads, "asked for"),
        Preference::Gpu(name) => open_gpu(name.clone(), threads),
        Preference::Auto => open_best(threads),
    }?;
    if gpu_required && opened.engine.kind() != "gpu" {
        return Err(EngineError::NoGpu { best: opened.why });
    }
    Ok(opened)
}

#[cfg(feature = "gpu")]
fn open_gpu(name: Option<String>, threads: usize) -> Result<Opened, EngineError> {
    let (gpu, why) = wanted_gpu(name.as_deref())?;
    let again = move || Ok(hurried(wanted_gpu(name.as_deref())?.0));
    with_cpu(hurried(gpu), why, again, threads)
}

#[cfg(feature = "gpu")]
fn open_best(threads: usize) -> Result<Opened, EngineError> {
    let again = || Ok(hurried(best_gpu()?.0));
    match best_gpu() {
        Ok((gpu, why)) => with_cpu(hurried(gpu), why, again, threads),
        Err(error @ EngineError::OnlySoftware { .. }) => open_cpu(threads, &why_no_gpu(&error)),
        Err(error) => {
            let cpu = CpuEngine::with_threads(threads)?;
            Ok(Opened {
                why: format!("{}: {}", cpu.name(), why_no_gpu(&error)),
                engine: Box::new(Failover::new(Err(error), Beside::new(again), cpu)),
            })
        }
    }
}

#[cfg(feature = "gpu")]
fn hurried(mut gpu: GpuEngine) -> Box<dyn Engine> {
    gpu.set_patience(PATIENCE);
    Box::new(gpu)
}

#[cfg(feature = "gpu")]
fn with_cpu(
    gpu: Box<dyn Engine>,
    why: String,
    again: impl Fn() -> Result<Box<dyn Engine>, EngineError> + Send + Sync + 'static,
    threads: usize,
) -> Result<Opened, EngineError> {
    let cpu = CpuEngine::with_threads(threads)?;
    Ok(Opened {
        engine: Box::new(Failover::new(Ok(gpu), Beside::new(again), cpu)),
        why,
    })
}

#[cfg(not(feature = "gpu"))]
fn open_gpu(_name: Option<String>, _threads: usize) -> Result<Opened, EngineError> {
    Err(EngineError::NotBuilt)
}

#[cfg(not(feature = "gpu"))]
fn open_best(threads: usize) -> Result<Opened, EngineError> {
    open_cpu(threads, "this build has no GPU engine")
}
