//! The engines of this machine.

use std::thread::available_parallelism;

use inbye::local::{CpuEngine, Engine, Opened, Preference, open};

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
pub fn choose(preference: &Preference, threads: Option<usize>) -> anyhow::Result<Box<dyn Engine>> {
    let Opened { engine, why } = open(preference, threads.unwrap_or_else(cores))?;
    output::note(format!("engine: {why}"));
    Ok(engine)
}

/// Every engine: the CPU on one thread and on all cores, then each adapter. An adapter that cannot be opened is told
/// and left out.
pub fn all() -> anyhow::Result<Vec<Box<dyn Engine>>> {
    let mut engines: Vec<Box<dyn Engine>> = vec![Box::new(CpuEngine::single_threaded())];
    if cores() > 1 {
        engines.push(Box::new(CpuEngine::with_threads(cores())?));
    }
    add_adapters(&mut engines);
    Ok(engines)
}

#[cfg(feature = "gpu")]
fn add_adapters(engines: &mut Vec<Box<dyn Engine>>) {
    use inbye::local::gpu::{GpuEngine, adapters};
    for adapter in adapters() {
        match GpuEngine::new(&adapter) {
            Ok(engine) => engines.push(Box::new(engine)),
            Err(error) => output::note(format!("left out: {error}")),
        }
    }
}

#[cfg(not(feature = "gpu"))]
fn add_adapters(_engines: &mut Vec<Box<dyn Engine>>) {
    output::note("this build has no GPU engine");
}
