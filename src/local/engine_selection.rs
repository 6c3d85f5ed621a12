//! Selects an engine by the user's choice and the machine's adapters, and gives the reason.

use core::str::FromStr;
#[cfg(feature = "gpu")]
use std::time::Duration;

#[cfg(feature = "gpu")]
use super::gpu::{AdapterSummary, GpuEngine, adapters};
#[cfg(feature = "gpu")]
use super::{BackgroundOpener, Failover};
use super::{CpuEngine, Engine, EngineError, InstructionSet};

/// Longest wait for an answer of the GPU while driving: half of the default control period, so that the CPU can still
/// answer within it.
#[cfg(feature = "gpu")]
const DRIVING_TIMEOUT: Duration = Duration::from_millis(50);

/// The engine that the user chooses.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum EngineChoice {
    /// A hardware GPU if there is one, otherwise the CPU. A software adapter is never taken: it runs on the same cores,
    /// slower.
    #[default]
    Auto,
    /// The CPU.
    Cpu,
    /// A GPU, hardware before software. With a name: the first adapter whose name contains it, ignoring case.
    Gpu(Option<String>),
}

impl FromStr for EngineChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text.split_once(':') {
            None if text == "auto" => Ok(Self::Auto),
            None if text == "cpu" => Ok(Self::Cpu),
            None if text == "gpu" => Ok(Self::Gpu(None)),
            Some(("gpu", name)) if !name.is_empty() => Ok(Self::Gpu(Some(name.to_owned()))),
            _ => Err(format!(
                "`{}` is no engine: use auto, cpu, gpu or gpu:ADAPTER-NAME",
                text.escape_debug()
            )),
        }
    }
}

/// An engine and the reason for its selection.
pub struct SelectedEngine {
    /// The engine.
    pub engine: Box<dyn Engine>,
    /// Name of the engine and reason, one sentence.
    pub reason: String,
}

/// Opens the chosen engine. A CPU engine gets `threads` threads.
///
/// # Errors
/// When the choice is a GPU and no matching adapter opens. [`EngineChoice::Auto`] falls back to the CPU and gives the
/// cause as the reason.
pub fn open_engine(choice: &EngineChoice, threads: usize) -> Result<SelectedEngine, EngineError> {
    match choice {
        EngineChoice::Cpu => open_cpu(threads, "requested"),
        EngineChoice::Gpu(name) => {
            let (engine, reason) = requested_gpu(name.as_deref())?;
            Ok(SelectedEngine { engine: Box::new(engine), reason })
        }
        EngineChoice::Auto => match best_gpu() {
            Ok((engine, reason)) => Ok(SelectedEngine { engine: Box::new(engine), reason }),
            Err(error) => open_cpu(threads, &no_gpu_reason(&error)),
        },
    }
}

/// Opens the chosen engine for driving. As [`open_engine`], but a GPU gets a CPU fallback: after any GPU failure the
/// CPU continues with the same bits and the GPU is reopened later, see [`Failover`](super::Failover).
///
/// The GPU has 50 ms for each answer. [`EngineChoice::Auto`] also retries a GPU that is missing at the start, unless
/// there is a software adapter: no GPU was lost then, and the software adapter is no better than the CPU.
///
/// # Errors
/// As [`open_engine`]; also when `gpu_required` is set and the selected engine is the CPU.
pub fn open_with_fallback(
    choice: &EngineChoice,
    threads: usize,
    gpu_required: bool,
) -> Result<SelectedEngine, EngineError> {
    let selected = match choice {
        EngineChoice::Cpu => open_cpu(threads, "requested"),
        EngineChoice::Gpu(name) => open_requested_with_fallback(name.clone(), threads),
        EngineChoice::Auto => open_best_with_fallback(threads),
    }?;
    if gpu_required && selected.engine.kind() != "gpu" {
        return Err(EngineError::GpuRequired { selected: selected.reason });
    }
    Ok(selected)
}

/// Opens every engine of this machine: the CPU on one thread, the CPU on all `threads` if there are more, then each
/// adapter, hardware first. `left_out` receives the error of each adapter that does not open.
///
/// # Errors
/// When the system refuses a thread.
pub fn open_all_engines(
    threads: usize,
    left_out: impl FnMut(EngineError),
) -> Result<Vec<Box<dyn Engine>>, EngineError> {
    let mut engines: Vec<Box<dyn Engine>> = vec![Box::new(CpuEngine::single_threaded())];
    if threads > 1 {
        engines.push(Box::new(CpuEngine::with_threads(threads)?));
    }
    add_adapters(&mut engines, left_out);
    Ok(engines)
}

/// Opens every engine variant for a comparison: each instruction set on one thread, the scalar reference first; the
/// best one on all threads; then each adapter.
///
/// # Errors
/// When the system refuses a thread.
pub fn open_all_variants(
    threads: usize,
    left_out: impl FnMut(EngineError),
) -> Result<Vec<Box<dyn Engine>>, EngineError> {
    let mut engines: Vec<Box<dyn Engine>> = Vec::new();
    for instructions in InstructionSet::ALL {
        if instructions.is_available() {
            engines.push(Box::new(CpuEngine::with_instruction_set(instructions, 1)?));
        }
    }
    if threads > 1 {
        engines.push(Box::new(CpuEngine::with_threads(threads)?));
    }
    add_adapters(&mut engines, left_out);
    Ok(engines)
}

#[cfg(feature = "gpu")]
fn add_adapters(engines: &mut Vec<Box<dyn Engine>>, mut left_out: impl FnMut(EngineError)) {
    for adapter in adapters() {
        match GpuEngine::new(&adapter) {
            Ok(engine) => engines.push(Box::new(engine)),
            Err(error) => left_out(error),
        }
    }
}

#[cfg(not(feature = "gpu"))]
fn add_adapters(_engines: &mut Vec<Box<dyn Engine>>, mut left_out: impl FnMut(EngineError)) {
    left_out(EngineError::NoGpuSupport);
}

fn open_cpu(threads: usize, reason: &str) -> Result<SelectedEngine, EngineError> {
    let engine = CpuEngine::with_threads(threads)?;
    Ok(SelectedEngine { reason: format!("{}: {reason}", engine.name()), engine: Box::new(engine) })
}

/// Opens the first adapter, or the first whose name contains `name`, and gives the reason.
#[cfg(feature = "gpu")]
fn requested_gpu(name: Option<&str>) -> Result<(GpuEngine, String), EngineError> {
    let adapters = adapters();
    let first = adapters.first().ok_or(EngineError::NoAdapter)?;
    let adapter = match name {
        None => first,
        Some(name) => {
            let requested = name.to_lowercase();
            let matches =
                |summary: &AdapterSummary| summary.name.to_lowercase().contains(&requested);
            let found = adapters.iter().find(|adapter| matches(&adapter.summary));
            found.ok_or_else(|| EngineError::AdapterNotFound {
                requested: name.to_owned(),
                available: adapters
                    .iter()
                    .map(|adapter| adapter.summary.name.as_str())
                    .collect::<Vec<_>>()
                    .join(", "),
            })?
        }
    };
    let kind = if adapter.summary.software { "software adapter" } else { "hardware adapter" };
    let reason = format!("GPU, {}: requested, {kind}", adapter.summary.name);
    Ok((GpuEngine::new(adapter)?, reason))
}

#[cfg(not(feature = "gpu"))]
fn requested_gpu(_name: Option<&str>) -> Result<(CpuEngine, String), EngineError> {
    Err(EngineError::NoGpuSupport)
}

/// Opens the first hardware adapter and gives the reason.
#[cfg(feature = "gpu")]
fn best_gpu() -> Result<(GpuEngine, String), EngineError> {
    let adapters = adapters();
    let first = adapters.first().ok_or(EngineError::NoAdapter)?;
    let name = &first.summary.name;
    if first.summary.software {
        return Err(EngineError::SoftwareAdapterOnly { adapter: name.clone() });
    }
    let reason = format!("GPU, {name}: hardware adapter found");
    Ok((GpuEngine::new(first)?, reason))
}

#[cfg(not(feature = "gpu"))]
fn best_gpu() -> Result<(CpuEngine, String), EngineError> {
    Err(EngineError::NoGpuSupport)
}

/// The reason for the CPU when the best GPU does not open.
fn no_gpu_reason(error: &EngineError) -> String {
    match error {
        EngineError::NoGpuSupport => "this build has no GPU engine".to_owned(),
        EngineError::NoAdapter => "no GPU adapter found".to_owned(),
        EngineError::SoftwareAdapterOnly { .. } => error.to_string(),
        _ => format!("the GPU could not be opened ({error})"),
    }
}

#[cfg(feature = "gpu")]
fn open_requested_with_fallback(
    name: Option<String>,
    threads: usize,
) -> Result<SelectedEngine, EngineError> {
    let (gpu, reason) = requested_gpu(name.as_deref())?;
    let reopen = move || Ok(with_timeout(requested_gpu(name.as_deref())?.0));
    with_fallback(with_timeout(gpu), reason, reopen, threads)
}

#[cfg(feature = "gpu")]
fn open_best_with_fallback(threads: usize) -> Result<SelectedEngine, EngineError> {
    let reopen = || Ok(with_timeout(best_gpu()?.0));
    match best_gpu() {
        Ok((gpu, reason)) => with_fallback(with_timeout(gpu), reason, reopen, threads),
        Err(error @ EngineError::SoftwareAdapterOnly { .. }) => {
            open_cpu(threads, &no_gpu_reason(&error))
        }
        Err(error) => {
            let cpu = CpuEngine::with_threads(threads)?;
            Ok(SelectedEngine {
                reason: format!("{}: {}", cpu.name(), no_gpu_reason(&error)),
                engine: Box::new(Failover::new(Err(error), BackgroundOpener::new(reopen), cpu)),
            })
        }
    }
}

#[cfg(feature = "gpu")]
fn with_timeout(mut gpu: GpuEngine) -> Box<dyn Engine> {
    gpu.set_timeout(DRIVING_TIMEOUT);
    Box::new(gpu)
}

#[cfg(feature = "gpu")]
fn with_fallback(
    gpu: Box<dyn Engine>,
    reason: String,
    reopen: impl Fn() -> Result<Box<dyn Engine>, EngineError> + Send + Sync + 'static,
    threads: usize,
) -> Result<SelectedEngine, EngineError> {
    let cpu = CpuEngine::with_threads(threads)?;
    Ok(SelectedEngine {
        engine: Box::new(Failover::new(Ok(gpu), BackgroundOpener::new(reopen), cpu)),
        reason,
    })
}

#[cfg(not(feature = "gpu"))]
fn open_requested_with_fallback(
    _name: Option<String>,
    _threads: usize,
) -> Result<SelectedEngine, EngineError> {
    Err(EngineError::NoGpuSupport)
}

#[cfg(not(feature = "gpu"))]
fn open_best_with_fallback(threads: usize) -> Result<SelectedEngine, EngineError> {
    open_cpu(threads, &no_gpu_reason(&EngineError::NoGpuSupport))
}
