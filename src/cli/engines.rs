//! The engines of this machine.

use std::thread::available_parallelism;
use std::time::Instant;

use inbye::local::{
    Engine, EngineChoice, EngineError, SelectedEngine, open_all_engines, open_all_variants,
    open_engine, open_with_fallback,
};

use super::output;

/// Number of cores available to this process.
pub fn cores() -> usize {
    available_parallelism().map_or(1, usize::from)
}

/// Describes this machine for records: processor, cores, system.
pub fn machine() -> String {
    use std::env::consts::{ARCH, OS};
    let model = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    let model = model.unwrap_or_else(|| "processor unknown".to_owned());
    format!("{model}, {} cores, {ARCH}, {OS}", cores())
}

/// Opens the chosen engine and prints which one and why to standard error.
pub fn choose(choice: &EngineChoice, threads: Option<usize>) -> anyhow::Result<Box<dyn Engine>> {
    let started = Instant::now();
    let opened = open_engine(choice, threads.unwrap_or_else(cores)).map_err(with_option)?;
    Ok(announce(opened, started))
}

/// Opens the chosen engine for a drive, a GPU only with the CPU as fallback, and prints which one and why to standard error.
pub fn choose_to_drive(
    choice: &EngineChoice,
    threads: Option<usize>,
    gpu_required: bool,
) -> anyhow::Result<Box<dyn Engine>> {
    let threads = threads.unwrap_or_else(cores);
    let started = Instant::now();
    let opened = open_with_fallback(choice, threads, gpu_required).map_err(with_option)?;
    Ok(announce(opened, started))
}

/// Adds the command-line option that avoids an engine error.
pub fn with_option(error: EngineError) -> anyhow::Error {
    let option = match error {
        EngineError::NoAdapter
        | EngineError::AdapterNotFound { .. }
        | EngineError::NoGpuSupport => "--engine cpu",
        EngineError::GpuRequired { .. } => "--engine gpu:NAME",
        _ => return error.into(),
    };
    anyhow::anyhow!("{error} ({option})")
}

/// Prints the engine, the reason and the time it took to open.
fn announce(
    SelectedEngine { engine, reason }: SelectedEngine,
    started: Instant,
) -> Box<dyn Engine> {
    output::note(format!("engine: {reason}"));
    let ms = started.elapsed().as_secs_f64() * 1e3;
    output::detail(format!("{} ready after {ms:.0} ms", engine.name()));
    engine
}

/// Opens every engine. An adapter that cannot be opened is skipped with a note.
pub fn all() -> anyhow::Result<Vec<Box<dyn Engine>>> {
    let skip = |error| output::note(format!("skipped: {error}"));
    Ok(open_all_engines(cores(), skip)?)
}

/// Opens every engine and CPU instruction set.
pub fn to_compare() -> anyhow::Result<Vec<Box<dyn Engine>>> {
    let skip = |error| output::note(format!("skipped: {error}"));
    Ok(open_all_variants(cores(), skip)?)
}
