//! Which engine: decided once, and told.

use core::str::FromStr;

#[cfg(feature = "gpu")]
use super::gpu::{AdapterSummary, GpuEngine, adapters};
use super::{CpuEngine, Engine, EngineError, Instructions};

/// What the user asked for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Preference {
    /// A hardware GPU where there is one, the CPU otherwise: a software adapter runs on the same cores, slower.
    #[default]
    Auto,
    /// The CPU.
    Cpu,
    /// A GPU, hardware before software; with a name, the first adapter whose name contains it, in any case.
    Gpu(Option<String>),
}

impl FromStr for Preference {
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

/// An engine and why it was taken.
pub struct Opened {
    /// The engine.
    pub engine: Box<dyn Engine>,
    /// One sentence for people.
    pub why: String,
}

/// Opens the engine that a preference asks for. CPU engines get this many threads.
///
/// # Errors
/// When a GPU was asked for by name or kind and none of it can be opened. [`Preference::Auto`] falls back to the CPU
/// and says why.
pub fn open(preference: &Preference, threads: usize) -> Result<Opened, EngineError> {
    match preference {
        Preference::Cpu => open_cpu(threads, "asked for"),
        Preference::Gpu(name) => open_gpu(name.as_deref()),
        Preference::Auto => open_best(threads),
    }
}

/// Every engine of this machine: the CPU on one thread and, where there are more, on all of them; then each adapter,
/// hardware first. `left_out` hears why an adapter could not be opened.
///
/// # Errors
/// When the system does not give the threads.
pub fn open_all(
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

/// Every way to evaluate on this machine, to be compared: each set of instructions on one thread, the scalar reference
/// first; the best on all threads; then each adapter.
///
/// # Errors
/// When the system does not give the threads.
pub fn open_to_compare(
    threads: usize,
    left_out: impl FnMut(EngineError),
) -> Result<Vec<Box<dyn Engine>>, EngineError> {
    let mut engines: Vec<Box<dyn Engine>> = Vec::new();
    for instructions in Instructions::ALL {
        if instructions.are_here() {
            engines.push(Box::new(CpuEngine::with_instructions(instructions, 1)?));
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
    left_out(EngineError::NotBuilt);
}

pub(super) fn open_cpu(threads: usize, why: &str) -> Result<Opened, EngineError> {
    let engine = CpuEngine::with_threads(threads)?;
    Ok(Opened {
        why: format!("{}: {why}", engine.name()),
        engine: Box::new(engine),
    })
}

#[cfg(feature = "gpu")]
fn open_gpu(name: Option<&str>) -> Result<Opened, EngineError> {
    let (engine, why) = wanted_gpu(name)?;
    Ok(Opened {
        engine: Box::new(engine),
        why,
    })
}

#[cfg(not(feature = "gpu"))]
fn open_gpu(_name: Option<&str>) -> Result<Opened, EngineError> {
    Err(EngineError::NotBuilt)
}

/// The first adapter, or the first whose name contains this, opened, and why it was taken.
#[cfg(feature = "gpu")]
pub(super) fn wanted_gpu(name: Option<&str>) -> Result<(GpuEngine, String), EngineError> {
    let adapters = adapters();
    let first = adapters.first().ok_or(EngineError::NoAdapter)?;
    let adapter = match name {
        None => first,
        Some(name) => {
            let wanted = name.to_lowercase();
            let named = |summary: &AdapterSummary| summary.name.to_lowercase().contains(&wanted);
            let found = adapters.iter().find(|adapter| named(&adapter.summary));
            found.ok_or_else(|| EngineError::NoSuchAdapter {
                wanted: name.to_owned(),
                found: adapters
                    .iter()
                    .map(|adapter| adapter.summary.name.as_str())
                    .collect::<Vec<_>>()
                    .join(", "),
            })?
        }
    };
    let kind = if adapter.summary.software {
        "software adapter"
    } else {
        "hardware adapter"
    };
    let why = format!("GPU, {}: asked for, {kind}", adapter.summary.name);
    Ok((GpuEngine::new(adapter)?, why))
}

fn open_best(threads: usize) -> Result<Opened, EngineError> {
    match best_gpu() {
        Ok((engine, why)) => Ok(Opened {
            engine: Box::new(engine),
            why,
        }),
        Err(error) => open_cpu(threads, &why_no_gpu(&error)),
    }
}

/// The first hardware adapter, opened, and why it was taken.
#[cfg(feature = "gpu")]
pub(super) fn best_gpu() -> Result<(GpuEngine, String), EngineError> {
    let adapters = adapters();
    let first = adapters.first().ok_or(EngineError::NoAdapter)?;
    let name = &first.summary.name;
    if first.summary.software {
        return Err(EngineError::OnlySoftware {
            adapter: name.clone(),
        });
    }
    let why = format!("GPU, {name}: hardware adapter found");
    Ok((GpuEngine::new(first)?, why))
}

#[cfg(not(feature = "gpu"))]
pub(super) fn best_gpu() -> Result<(CpuEngine, String), EngineError> {
    Err(EngineError::NotBuilt)
}

/// Why the CPU is taken where the best GPU cannot be had.
pub(super) fn why_no_gpu(error: &EngineError) -> String {
    match error {
        EngineError::NotBuilt => "this build has no GPU engine".to_owned(),
        EngineError::NoAdapter => "no GPU adapter found".to_owned(),
        EngineError::OnlySoftware { .. } => error.to_string(),
        _ => format!("the GPU could not be opened ({error})"),
    }
}
