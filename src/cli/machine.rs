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

use inbye::suggest::counted;

use super::output;
#[cfg(unix)]
use super::stop_signals;

/// Exit status after a second Ctrl-C, as shells define it.
const INTERRUPTED: i32 = 130;

/// Longest time for a base to come to a standstill after a second signal.
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
    format!("{model}, {}, {ARCH}, {OS}", counted(cores(), "core"))
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

/// Engines of this machine.
pub struct Engines {
    /// Those that opened.
    pub open: Vec<Box<dyn Engine>>,
    /// Why each of the other adapters did not open.
    pub skipped: Vec<String>,
}

/// Opens these CPU engines and all adapters. Warns of an adapter that does not open.
pub fn engines(cpu: CpuEngines) -> anyhow::Result<Engines> {
    let mut skipped = Vec::new();
    let open = open_engines(cpu, AdapterSelection::All, cores(), |error| {
        if *error == EngineError::NoGpuSupport {
            return output::note(format!("skipped: {error}"));
        }
        output::warn(format!("skipped: {error}"));
        skipped.push(error.to_string());
    })?;
    Ok(Engines { open, skipped })
}

/// Environment variables that name driver files to the Vulkan loader in place of the installed ones.
const DRIVER_VARIABLES: [&str; 2] = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"];

/// Why this machine has no adapter, and what to do.
pub struct NoAdapter {
    /// What the graphics drivers report.
    pub text: String,
    /// What to do.
    pub cure: String,
}

impl NoAdapter {
    /// Looks for adapters again, and collects the messages of the drivers.
    pub fn new() -> Self {
        if !cfg!(feature = "gpu") {
            let text = EngineError::NoGpuSupport.to_string();
            return Self { text, cure: "build it with the feature `gpu`".to_owned() };
        }
        let messages = output::library_messages(|| drop(adapters()));
        let failed = messages.iter().filter_map(|message| message.split_once("failed to create "));
        let reasons: Vec<&str> = failed.map(|(_, reason)| reason).collect();
        let reasons =
            if reasons.is_empty() { String::new() } else { format!(": {}", reasons.join("; ")) };
        let text = format!("no adapter found{reasons}");
        let is_set = |name: &&str| std::env::var_os(name).is_some();
        let variables: Vec<&str> = DRIVER_VARIABLES.into_iter().filter(is_set).collect();
        let cure = if variables.is_empty() {
            "install or reinstall a driver: Debian's mesa-vulkan-drivers and libvulkan1 have a software one".to_owned()
        } else {
            format!("check the driver files that {} names, or unset it", variables.join(", "))
        };
        Self { text, cure }
    }
}

/// `inbye devices`: lists GPU adapters and CPU features.
pub fn devices() -> anyhow::Result<bool> {
    let (adapters, features) = (adapters(), cpu_features());
    let (cores, architecture) = (cores(), std::env::consts::ARCH);
    let listed =
        if features.is_empty() { "no vector features".to_owned() } else { features.join(" ") };
    let mut lines = vec![format!("CPU: {}, {architecture}, {listed}", counted(cores, "core"))];
    let missing = adapters.is_empty().then(NoAdapter::new);
    if let Some(NoAdapter { text, cure }) = &missing {
        lines.push(format!("GPU: {text} ({cure})"));
    }
    for adapter in &adapters {
        lines.push(format!("GPU: {}", adapter_text(adapter)));
    }
    let cpu = json!({ "cores": cores, "architecture": architecture, "features": features });
    let reason = missing.map(|missing| missing.text);
    output::result(&json!({ "adapters": adapters, "cpu": cpu, "no_adapter": reason }), lines)?;
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
