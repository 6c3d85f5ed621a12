//! The engines of this machine.

use std::thread::available_parallelism;
use std::time::Instant;

use inbye::local::{
    Engine, EngineChoice, SelectedEngine, open_all_engines, open_all_variants, open_engine,
    open_with_fallback,
};

use super::output;

/// Cores that the system lets this program use.
pub fn cores() -> usize {
    available_parallelism().map_or(1, usize::from)
}

/// What this machine is, for records: processor, cores, system.
pub fn machine() -> String {
    use std::env::consts::{ARCH, OS};
    let model = std::fs::read_to_string("/proc/cpuinfo")
        .ok()
        .and_then(|text| {
            let line = text.lines().find(|line| line.starts_with("model name"))?;
            Some(line.split_once(':')?.1.trim().to_owned())
        });
    let model = model.unwrap_or_else(|| "processor unknown".to_owned());
    format!("{model}, {} cores, {ARCH}, {OS}", cores())
}

/// Opens the engine asked for and says on standard error which and why.
pub fn choose(
    preference: &EngineChoice,
    threads: Option<usize>,
) -> anyhow::Result<Box<dyn Engine>> {
    let began = Instant::now();
    let opened = open_engine(preference, threads.unwrap_or_else(cores))?;
    Ok(told(opened, began))
}

/// Opens the engine to drive with, a GPU only with the CPU standing by, and says on standard error which and why.
pub fn choose_to_drive(
    preference: &EngineChoice,
    threads: Option<usize>,
    gpu_required: bool,
) -> anyhow::Result<Box<dyn Engine>> {
    let threads = threads.unwrap_or_else(cores);
    let began = Instant::now();
    let opened = open_with_fallback(preference, threads, gpu_required)?;
    Ok(told(opened, began))
}

/// Says which engine was taken and why, and what opening it took.
fn told(SelectedEngine { engine, reason }: SelectedEngine, began: Instant) -> Box<dyn Engine> {
    output::note(format!("engine: {reason}"));
    let ms = began.elapsed().as_secs_f64() * 1e3;
    output::detail(format!("{} ready after {ms:.0} ms", engine.name()));
    engine
}

/// Every engine. An adapter that cannot be opened is told and left out.
pub fn all() -> anyhow::Result<Vec<Box<dyn Engine>>> {
    let tell = |error| output::note(format!("left out: {error}"));
    Ok(open_all_engines(cores(), tell)?)
}

/// Every way to evaluate here, CPU instruction sets apart.
pub fn to_compare() -> anyhow::Result<Vec<Box<dyn Engine>>> {
    let tell = |error| output::note(format!("left out: {error}"));
    Ok(open_all_variants(cores(), tell)?)
}
