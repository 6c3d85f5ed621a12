//! Selects an engine by the user's choice and the machine's adapters, and gives the reason.

use core::str::FromStr;
use std::time::Duration;

#[cfg(feature = "gpu")]
use super::gpu::{Adapter, AdapterSummary, GpuEngine, adapters};
use super::{BackgroundOpener, CpuEngine, Engine, EngineError, Failover, InstructionSet};

/// Longest wait for an answer of the GPU while driving: half of the default control period, so that the CPU can still
/// answer within it.
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
                "`{}` is not an engine: use auto, cpu, gpu or gpu:ADAPTER-NAME",
                text.escape_debug()
            )),
        }
    }
}

/// An engine and the reason for its selection.
#[non_exhaustive]
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
    if *choice == EngineChoice::Cpu {
        return open_cpu(threads, "requested");
    }
    match open_gpu(choice, None) {
        Err(error) if *choice == EngineChoice::Auto => open_cpu(threads, &no_gpu_reason(&error)),
        opened => opened,
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
        _ => open_gpu_with_fallback(choice, threads),
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
    left_out: impl FnMut(&EngineError),
) -> Result<Vec<Box<dyn Engine>>, EngineError> {
    with_others(vec![Box::new(CpuEngine::single_threaded())], threads, left_out)
}

/// Opens every engine variant for a comparison: each instruction set on one thread, the scalar reference first; the
/// best one on all threads; then each adapter.
///
/// # Errors
/// When the system refuses a thread.
pub fn open_all_variants(
    threads: usize,
    left_out: impl FnMut(&EngineError),
) -> Result<Vec<Box<dyn Engine>>, EngineError> {
    let mut engines: Vec<Box<dyn Engine>> = Vec::new();
    for instructions in InstructionSet::ALL.into_iter().filter(|one| one.is_available()) {
        engines.push(Box::new(CpuEngine::with_instruction_set(instructions, 1)?));
    }
    with_others(engines, threads, left_out)
}

/// Adds the CPU on all threads if there are several, and all adapters.
fn with_others(
    mut engines: Vec<Box<dyn Engine>>,
    threads: usize,
    mut left_out: impl FnMut(&EngineError),
) -> Result<Vec<Box<dyn Engine>>, EngineError> {
    if threads > 1 {
        engines.push(Box::new(CpuEngine::with_threads(threads)?));
    }
    #[cfg(feature = "gpu")]
    for adapter in adapters() {
        match GpuEngine::new(&adapter) {
            Ok(engine) => engines.push(Box::new(engine)),
            Err(error) => left_out(&error),
        }
    }
    #[cfg(not(feature = "gpu"))]
    left_out(&EngineError::NoGpuSupport);
    Ok(engines)
}

fn open_cpu(threads: usize, reason: &str) -> Result<SelectedEngine, EngineError> {
    let engine = CpuEngine::with_threads(threads)?;
    Ok(SelectedEngine { reason: format!("{}: {reason}", engine.name()), engine: Box::new(engine) })
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

/// Opens the GPU of a choice other than the CPU, with another timeout than the default if one is given.
#[cfg(feature = "gpu")]
fn open_gpu(
    choice: &EngineChoice,
    timeout: Option<Duration>,
) -> Result<SelectedEngine, EngineError> {
    let adapters = adapters();
    let mut adapter = adapters.first().ok_or(EngineError::NoAdapter)?;
    if let EngineChoice::Gpu(Some(requested)) = choice {
        let pattern = requested.to_lowercase();
        let matches = |one: &&Adapter| one.summary.name.to_lowercase().contains(&pattern);
        adapter = adapters.iter().find(matches).ok_or_else(|| {
            let names: Vec<&str> = adapters.iter().map(|one| one.summary.name.as_str()).collect();
            EngineError::AdapterNotFound {
                requested: requested.clone(),
                available: names.join(", "),
            }
        })?;
    }
    let AdapterSummary { name, software, .. } = &adapter.summary;
    let cause = match (choice, software) {
        (EngineChoice::Auto, true) => {
            return Err(EngineError::SoftwareAdapterOnly { adapter: name.clone() });
        }
        (EngineChoice::Auto, false) => "hardware adapter found",
        (_, true) => "requested, software adapter",
        (_, false) => "requested, hardware adapter",
    };
    let mut engine = GpuEngine::new(adapter)?;
    if let Some(timeout) = timeout {
        engine.set_timeout(timeout);
    }
    Ok(SelectedEngine { engine: Box::new(engine), reason: format!("GPU, {name}: {cause}") })
}

#[cfg(not(feature = "gpu"))]
fn open_gpu(_: &EngineChoice, _: Option<Duration>) -> Result<SelectedEngine, EngineError> {
    Err(EngineError::NoGpuSupport)
}

fn open_gpu_with_fallback(
    choice: &EngineChoice,
    threads: usize,
) -> Result<SelectedEngine, EngineError> {
    let cpu = CpuEngine::with_threads(threads)?;
    let (gpu, reason) = match open_gpu(choice, Some(DRIVING_TIMEOUT)) {
        Ok(opened) => (Ok(opened.engine), opened.reason),
        Err(error) if *choice != EngineChoice::Auto => return Err(error),
        Err(error) => {
            let reason = format!("{}: {}", cpu.name(), no_gpu_reason(&error));
            if matches!(error, EngineError::SoftwareAdapterOnly { .. } | EngineError::NoGpuSupport)
            {
                return Ok(SelectedEngine { engine: Box::new(cpu), reason });
            }
            (Err(error), reason)
        }
    };
    let choice = choice.clone();
    let reopen = move || Ok(open_gpu(&choice, Some(DRIVING_TIMEOUT))?.engine);
    let engine = Failover::new(gpu, BackgroundOpener::new(reopen), cpu);
    Ok(SelectedEngine { engine: Box::new(engine), reason })
}
