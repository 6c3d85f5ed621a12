//! Opens the engine that the user chose, or all engines of the machine.

use core::str::FromStr;
use std::time::Duration;

#[cfg(feature = "gpu")]
use super::gpu::{AdapterSummary, GpuEngine, adapters};
use super::{BackgroundOpener, CpuEngine, Engine, EngineError, Failover, InstructionSet};

/// Longest wait for an answer of the GPU while driving: half of the default control period, so that the CPU can still
/// answer within it.
const DRIVING_TIMEOUT: Duration = Duration::from_millis(50);

/// The engine that the user chooses. [`measure_engines`](crate::bench::measure_engines) finds the fastest one.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum EngineChoice {
    /// The CPU.
    #[default]
    Cpu,
    /// A GPU, hardware before software. With a name: the adapter of that name, or else the first one whose name contains it,
    /// ignoring case.
    Gpu(Option<String>),
}

impl FromStr for EngineChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text.split_once(':') {
            None if text == "cpu" => Ok(Self::Cpu),
            None if text == "gpu" => Ok(Self::Gpu(None)),
            Some(("gpu", name)) if !name.is_empty() => Ok(Self::Gpu(Some(name.to_owned()))),
            _ => Err(format!(
                "`{}` is not an engine: use cpu, gpu or gpu:ADAPTER-NAME",
                text.escape_debug()
            )),
        }
    }
}

/// An open engine.
#[non_exhaustive]
pub struct SelectedEngine {
    /// The engine.
    pub engine: Box<dyn Engine>,
    /// Its name and the kind of an adapter. If a GPU was requested and this is the CPU, also the reason.
    pub description: String,
}

crate::settings::opaque_debug!(SelectedEngine);

/// Opens the chosen engine. A CPU engine gets `threads` threads.
///
/// # Errors
/// When the choice is a GPU and no matching adapter opens, or the system refuses a thread.
pub fn open_engine(choice: &EngineChoice, threads: usize) -> Result<SelectedEngine, EngineError> {
    match choice {
        EngineChoice::Cpu => open_cpu(threads),
        EngineChoice::Gpu(name) => open_gpu(name.as_deref(), None),
    }
}

/// Opens the chosen engine for driving. As [`open_engine`], but a GPU gets a CPU fallback: after any GPU failure the
/// CPU continues with the same bits and the GPU is reopened later, see [`Failover`](super::Failover). Unless `gpu_required`
/// is set, the same is true of a GPU that does not open at the start.
///
/// The GPU has 50 ms for each answer. A call in which its driver blocks for longer is not ended; it counts as a failure afterwards.
///
/// # Errors
/// With `gpu_required`, when the choice is the CPU or the GPU does not open. When the system refuses a thread.
pub fn open_with_fallback(
    choice: &EngineChoice,
    threads: usize,
    gpu_required: bool,
) -> Result<SelectedEngine, EngineError> {
    match choice {
        EngineChoice::Gpu(name) => {
            open_failover(name.as_deref(), threads, gpu_required, Some(DRIVING_TIMEOUT))
        }
        EngineChoice::Cpu if gpu_required => {
            let selected = CpuEngine::with_threads(threads)?.name();
            Err(EngineError::GpuRequired { selected })
        }
        EngineChoice::Cpu => open_cpu(threads),
    }
}

/// Opens the chosen engine for a replay. As [`open_with_fallback`], but a GPU must open, and it has as long for each answer as an
/// engine of [`open_engine`]: no robot waits.
///
/// # Errors
/// When the choice is a GPU and no matching adapter opens, or the system refuses a thread.
pub fn open_to_replay(
    choice: &EngineChoice,
    threads: usize,
) -> Result<SelectedEngine, EngineError> {
    match choice {
        EngineChoice::Gpu(name) => open_failover(name.as_deref(), threads, true, None),
        EngineChoice::Cpu => open_cpu(threads),
    }
}

/// Opens a GPU with the CPU as fallback, with another timeout than the default if one is given.
fn open_failover(
    name: Option<&str>,
    threads: usize,
    gpu_required: bool,
    timeout: Option<Duration>,
) -> Result<SelectedEngine, EngineError> {
    let cpu = CpuEngine::with_threads(threads)?;
    let (gpu, description) = match open_gpu(name, timeout) {
        Ok(opened) => (Ok(opened.engine), opened.description),
        Err(error) if gpu_required || matches!(error, EngineError::NoGpuSupport) => {
            return Err(error);
        }
        Err(error) => {
            let description = format!("{} until the GPU opens ({error})", cpu.name());
            (Err(error), description)
        }
    };
    let name = name.map(str::to_owned);
    let reopen = move || Ok(open_gpu(name.as_deref(), timeout)?.engine);
    let engine = Failover::new(gpu, BackgroundOpener::new(reopen), cpu).with_timeout(timeout);
    Ok(SelectedEngine { engine: Box::new(engine), description })
}

/// The CPU engines of [`open_engines`], in their order; each list ends with the CPU on all threads, if there are several.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CpuEngines {
    /// One thread.
    OneAndAll,
    /// 1, 2, 4, 8... threads.
    Doubling,
    /// One thread with each instruction set, the scalar reference first.
    InstructionSets,
}

/// The adapters of [`open_engines`], hardware first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AdapterSelection {
    /// None.
    None,
    /// No software adapters, which run on the same cores as the CPU engines.
    Hardware,
    /// All.
    All,
}

/// Opens several engines of this machine, to compare or to time them: the CPU, then the adapters. `left_out` receives the error of
/// each adapter that does not open.
///
/// # Errors
/// When the system refuses a thread.
pub fn open_engines(
    cpu: CpuEngines,
    adapters: AdapterSelection,
    threads: usize,
    left_out: impl FnMut(&EngineError),
) -> Result<Vec<Box<dyn Engine>>, EngineError> {
    let mut engines: Vec<Box<dyn Engine>> = Vec::new();
    if cpu == CpuEngines::InstructionSets {
        for instructions in InstructionSet::ALL.into_iter().filter(|one| one.is_available()) {
            engines.push(Box::new(CpuEngine::with_instruction_set(instructions, 1)?));
        }
    } else {
        engines.push(Box::new(CpuEngine::single_threaded()));
    }
    let fewer = core::iter::successors(Some(2_usize), |threads| threads.checked_mul(2))
        .take_while(|&fewer| fewer < threads && cpu == CpuEngines::Doubling);
    for threads in fewer.chain((threads > 1).then_some(threads)) {
        engines.push(Box::new(CpuEngine::with_threads(threads)?));
    }
    if adapters != AdapterSelection::None {
        engines.extend(open_adapters(adapters == AdapterSelection::All, left_out));
    }
    Ok(engines)
}

/// Opens the adapters, hardware first.
#[cfg(feature = "gpu")]
fn open_adapters(software: bool, mut left_out: impl FnMut(&EngineError)) -> Vec<Box<dyn Engine>> {
    let mut engines: Vec<Box<dyn Engine>> = Vec::new();
    for adapter in adapters().iter().filter(|adapter| software || !adapter.summary.software) {
        match GpuEngine::new(adapter) {
            Ok(engine) => engines.push(Box::new(engine)),
            Err(error) => left_out(&error),
        }
    }
    engines
}

#[cfg(not(feature = "gpu"))]
fn open_adapters(_: bool, mut left_out: impl FnMut(&EngineError)) -> Vec<Box<dyn Engine>> {
    left_out(&EngineError::NoGpuSupport);
    Vec::new()
}

fn open_cpu(threads: usize) -> Result<SelectedEngine, EngineError> {
    let engine = CpuEngine::with_threads(threads)?;
    Ok(SelectedEngine { description: engine.name(), engine: Box::new(engine) })
}

/// The index of the requested name, or else of the first name that contains it, ignoring case: one card's name may begin with
/// that of another.
#[cfg(feature = "gpu")]
fn index_of_name(names: &[&str], requested: &str) -> Option<usize> {
    let requested = requested.to_lowercase();
    let names: Vec<String> = names.iter().map(|name| name.to_lowercase()).collect();
    let exact = names.iter().position(|name| *name == requested);
    exact.or_else(|| names.iter().position(|name| name.contains(&requested)))
}

/// Opens the first adapter, or the one of the requested name; with another timeout than the default if one is given.
#[cfg(feature = "gpu")]
fn open_gpu(
    requested: Option<&str>,
    timeout: Option<Duration>,
) -> Result<SelectedEngine, EngineError> {
    let adapters = adapters();
    let mut adapter = adapters.first().ok_or(EngineError::NoAdapter)?;
    if let Some(requested) = requested {
        let names: Vec<&str> = adapters.iter().map(|one| one.summary.name.as_str()).collect();
        let index =
            index_of_name(&names, requested).ok_or_else(|| EngineError::AdapterNotFound {
                requested: requested.to_owned(),
                available: names.join(", "),
            })?;
        adapter = &adapters[index];
    }
    let AdapterSummary { name, software, .. } = &adapter.summary;
    let kind = if *software { "software adapter" } else { "hardware adapter" };
    let mut engine = GpuEngine::new(adapter)?;
    if let Some(timeout) = timeout {
        engine.set_timeout(timeout);
    }
    Ok(SelectedEngine { engine: Box::new(engine), description: format!("GPU, {name}, {kind}") })
}

#[cfg(not(feature = "gpu"))]
fn open_gpu(_: Option<&str>, _: Option<Duration>) -> Result<SelectedEngine, EngineError> {
    Err(EngineError::NoGpuSupport)
}

#[cfg(all(test, feature = "gpu"))]
mod tests {
    use super::index_of_name;

    #[test]
    fn adapter_of_the_exact_name_comes_before_names_that_contain_it() {
        let names = ["NVIDIA A100", "NVIDIA A10", "llvmpipe"];
        assert_eq!(index_of_name(&names, "NVIDIA A10"), Some(1));
        assert_eq!(index_of_name(&names, "nvidia a10"), Some(1));
        assert_eq!(index_of_name(&names, "A10"), Some(0));
        assert_eq!(index_of_name(&names, "pipe"), Some(2));
        assert_eq!(index_of_name(&names, "H200"), None);
    }
}
