//! This machine: its engines, clock and signals; `inbye devices` lists them.

use std::path::PathBuf;
use std::process::exit;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread::{self, available_parallelism};
use std::time::{Duration, Instant};

use anyhow::Context;
use inbye::base::BaseSupervisor;
use inbye::external::{LineProcess, interrupt_by};
use inbye::local::{AdapterSelection, CpuEngines, Engine, EngineError, open_engines};
use serde_json::{Value, json};

use super::output;
#[cfg(unix)]
use super::stop_signals;

/// Exit status after a second Ctrl-C, as shells define it.
const INTERRUPTED: i32 = 130;

/// Longest time for a base to get its zero commands after a second signal. Its sender takes at most 0.25 s, and longer only on a
/// busy machine.
const STOP_TIME: Duration = Duration::from_secs(3);

/// Time between two checks whether every base has got them.
const STOP_POLL: Duration = Duration::from_millis(5);

/// Returns a clock in seconds since this call. Library code gets it as a parameter.
pub fn wall_clock() -> impl FnMut() -> f64 {
    let started = Instant::now();
    move || started.elapsed().as_secs_f64()
}

/// Set by the handler of Ctrl-C.
static INTERRUPT: OnceLock<Arc<AtomicBool>> = OnceLock::new();

/// Whether Ctrl-C, SIGTERM or SIGHUP came since [`interrupt_flag`].
pub fn is_interrupted() -> bool {
    INTERRUPT.get().is_some_and(|flag| flag.load(Ordering::Relaxed))
}

/// Returns the flag that Ctrl-C, SIGTERM and SIGHUP set. A second signal ends the process once a base has been stopped.
pub fn interrupt_flag() -> anyhow::Result<Arc<AtomicBool>> {
    if let Some(flag) = INTERRUPT.get() {
        return Ok(Arc::clone(flag));
    }
    let flag = Arc::clone(INTERRUPT.get_or_init(Arc::default));
    interrupt_by(Arc::clone(&flag));
    let is_set = Arc::clone(&flag);
    let handler = move || {
        if is_set.swap(true, Ordering::Relaxed) {
            let latest = Instant::now() + STOP_TIME;
            while BaseSupervisor::running() > 0 && Instant::now() < latest {
                thread::sleep(STOP_POLL);
            }
            // They have process groups of their own: the terminal does not end them.
            LineProcess::kill_all();
            exit(INTERRUPTED);
        }
    };
    let install = || ctrlc::set_handler(handler);
    #[cfg(unix)]
    let installed = stop_signals::install_but_keep_nohup(install)?;
    #[cfg(not(unix))]
    let installed = install();
    installed.context("cannot install the handler of Ctrl-C")?;
    Ok(flag)
}

/// Number of cores available to this process.
pub fn cores() -> usize {
    available_parallelism().map_or(1, usize::from)
}

/// The user's folder for what can be made again.
pub fn cache_folder() -> Option<PathBuf> {
    let variable = |name: &str| std::env::var_os(name).map(PathBuf::from);
    let cache = variable("XDG_CACHE_HOME").filter(|folder| folder.is_absolute());
    let folder = cache.or_else(|| Some(variable("HOME")?.join(".cache")))?;
    Some(folder.join("inbye"))
}

/// Describes this machine for records: processor, cores, system.
pub fn description() -> String {
    use std::env::consts::{ARCH, OS};
    let model = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    let model = model.unwrap_or_else(|| "processor unknown".to_owned());
    format!("{model}, {} cores, {ARCH}, {OS}", cores())
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

/// Opens these CPU engines and all adapters. An adapter that cannot be opened is skipped with a note.
pub fn engines(cpu: CpuEngines) -> anyhow::Result<Vec<Box<dyn Engine>>> {
    Ok(open_engines(cpu, AdapterSelection::All, cores(), note_skipped)?)
}

/// Notes an adapter that cannot be opened.
pub fn note_skipped(error: &EngineError) {
    output::note(format!("skipped: {error}"));
}

/// `inbye devices`: lists GPU adapters and CPU features.
pub fn devices() -> anyhow::Result<bool> {
    let (adapters, features) = (adapters(), cpu_features());
    let (cores, architecture) = (cores(), std::env::consts::ARCH);
    let listed =
        if features.is_empty() { "no vector features".to_owned() } else { features.join(" ") };
    let mut lines = vec![format!("CPU: {cores} cores, {architecture}, {listed}")];
    if adapters.is_empty() {
        let none = "GPU: no adapter found (Debian's mesa-vulkan-drivers has a software one)";
        lines.push(none.to_owned());
    }
    for adapter in &adapters {
        lines.push(format!("GPU: {}", adapter_text(adapter)));
    }
    let cpu = json!({ "cores": cores, "architecture": architecture, "features": features });
    output::result(&json!({ "adapters": adapters, "cpu": cpu }), lines)?;
    Ok(true)
}

/// Name, kind, backend and driver of an adapter.
pub fn adapter_text(adapter: &Value) -> String {
    let text = |key: &str| adapter[key].as_str().unwrap_or_default().to_owned();
    let kind = if adapter["software"] == true { "software" } else { "hardware" };
    format!("{} ({kind}, {}, {})", text("name"), text("backend"), text("driver"))
}

#[cfg(feature = "gpu")]
pub fn adapters() -> Vec<Value> {
    inbye::local::adapters().iter().map(|adapter| json!(adapter.summary)).collect()
}

#[cfg(not(feature = "gpu"))]
pub fn adapters() -> Vec<Value> {
    Vec::new()
}

pub fn cpu_features() -> Vec<&'static str> {
    #[cfg(target_arch = "x86_64")]
    let found = [
        ("sse4.1", is_x86_feature_detected!("sse4.1")),
        ("avx2", is_x86_feature_detected!("avx2")),
        ("fma", is_x86_feature_detected!("fma")),
        ("avx512f", is_x86_feature_detected!("avx512f")),
        ("avx512bw", is_x86_feature_detected!("avx512bw")),
    ];
    #[cfg(not(target_arch = "x86_64"))]
    let found: [(&str, bool); 0] = [];
    found.into_iter().filter(|(_, present)| *present).map(|(name, _)| name).collect()
}
