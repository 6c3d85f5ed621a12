//! `inbye doctor`: what this machine offers, and what to change.

use std::fmt;

use clap::Args;
use inbye::bench::{DecisionSize, DensityPlan, DensityRow};
use inbye::local::{AdapterSelection, CpuEngines, EngineError, open_engines};
use serde::Serialize;
use serde_json::json;

use super::engine_selection::{KeptTimes, engine_times, fastest_text, may_recover};
use super::machine::NoAdapter;
use super::{density, machine, output};

/// `inbye doctor`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  inbye doctor\n\n\
    The command takes a few seconds, because it times decisions to find the thread count. `inbye bench density` measures all \
    engines.\n\
    JSON fields: `checks` [{`name`,`ok`,`text`,`hint`}], `threads` (the fastest count for 1,024 samples).\n\
    Exit status 1: a check is not `ok`; its `hint` says what to change.")]
pub struct DoctorArguments {
    /// Seconds of decisions timed for each thread count.
    #[arg(long, default_value_t = 0.3, allow_negative_numbers = true, value_parser = super::arguments::duration)]
    pub seconds: f64,
}

/// Horizon and samples of the timed decisions: those of the default settings, and a dense window.
const STEPS: u32 = 40;
const SAMPLES: [usize; 2] = [1024, 65_536];

/// The result of one check.
#[derive(Debug, Serialize)]
struct Check {
    name: &'static str,
    /// Whether nothing needs to change.
    ok: bool,
    text: String,
    /// What to change.
    #[serde(skip_serializing_if = "Option::is_none")]
    hint: Option<String>,
}

impl Check {
    fn good(name: &'static str, text: impl Into<String>) -> Self {
        Self { name, ok: true, text: text.into(), hint: None }
    }

    fn bad(name: &'static str, text: impl Into<String>, hint: impl Into<String>) -> Self {
        Self { name, ok: false, text: text.into(), hint: Some(hint.into()) }
    }
}

impl fmt::Display for Check {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mark = if self.ok { output::good("ok") } else { output::bad("!!") };
        write!(out, "{mark} {:<9} {}", self.name, self.text)?;
        self.hint.iter().try_for_each(|hint| write!(out, "\n   {:<9} {hint}", ""))
    }
}

/// Looks at this machine. Returns false if something is to change.
pub fn run(arguments: &DoctorArguments) -> anyhow::Result<bool> {
    let (threads, fastest) = thread_counts(arguments.seconds)?;
    let mut checks = vec![processor(), threads, gpu()?, engine()];
    checks.extend(serial_ports());
    checks.push(features());
    let object = json!({ "checks": checks, "threads": fastest });
    output::result(&object, checks.iter().map(ToString::to_string))?;
    Ok(checks.iter().all(|check| check.ok))
}

fn processor() -> Check {
    let features = machine::cpu_features().join(" ");
    Check::good("processor", format!("{}; {features}", machine::description()))
}

/// Times decisions by thread count. Returns the check, and the fastest count for the smaller number of samples.
fn thread_counts(seconds: f64) -> anyhow::Result<(Check, usize)> {
    let cores = machine::cores();
    let mut engines = open_engines(CpuEngines::Doubling, AdapterSelection::None, cores, |_| {})?;
    let plan = DensityPlan {
        samples: SAMPLES.to_vec(),
        ..DensityPlan::powers_of_four(STEPS, SAMPLES[0], SAMPLES[1], seconds)
    };
    let rows = density::measure(&mut engines, &plan)?.rows;
    let of = |samples: usize| rows.iter().filter(move |row| row.samples == samples);
    let least = |one: &&DensityRow, other: &&DensityRow| one.p50_ms.total_cmp(&other.p50_ms);
    let fastest = |samples: usize| of(samples).min_by(least).map_or(1, |row| row.threads);
    let times = SAMPLES.map(|samples| {
        let times: Vec<String> =
            of(samples).map(|row| format!("{:.3} ms with {}", row.p50_ms, row.threads)).collect();
        format!("{samples} samples: {}", times.join(", "))
    });
    let text = format!("median decision of {}", times.join("; "));
    let [few, many] = SAMPLES.map(fastest);
    let check = if few == cores && many == cores {
        Check::good("threads", text)
    } else {
        let advice = format!(
            "fastest with --engine cpu: --threads {few} for few samples, --threads {many} for many; --engine auto measures for itself"
        );
        Check { hint: Some(advice), ..Check::good("threads", text) }
    };
    Ok((check, few))
}

/// Opens every adapter; each takes a first decision.
fn gpu() -> anyhow::Result<Check> {
    let adapters = machine::adapters();
    if adapters.is_empty() {
        let NoAdapter { text, cure } = NoAdapter::new();
        let hint = format!("{cure}; the CPU engine returns the same bits");
        return Ok(Check { hint: Some(hint), ..Check::good("GPU", text) });
    }
    let names: Vec<String> = adapters.iter().map(machine::adapter_text).collect();
    let mut failed = Vec::new();
    let left_out = |error: &EngineError| failed.push(error.to_string());
    open_engines(CpuEngines::OneAndAll, AdapterSelection::All, 1, left_out)?;
    Ok(if failed.is_empty() {
        Check::good("GPU", names.join("; "))
    } else {
        Check::bad("GPU", format!("{}; {}", names.join("; "), failed.join("; ")), GPU_CURE)
    })
}

/// What to do about an adapter that does not work.
const GPU_CURE: &str =
    "update or reinstall the driver, or use --engine cpu, which returns the same bits";

/// The engine that `--engine auto` takes for the default settings, measured again.
fn engine() -> Check {
    let size = DecisionSize::default();
    let mut failed = Vec::new();
    // One that does not open is in the check of the GPU.
    let mut left_out = |error: &EngineError| {
        failed.extend(may_recover(error).then(|| error.to_string()));
    };
    match engine_times(&size, machine::cores(), KeptTimes::None, &mut left_out) {
        Ok(times) => {
            let fastest = times.first().map_or("the CPU", |first| &first.name);
            let reason = fastest_text(&times, &size);
            let text = format!("--engine auto takes {fastest}: {reason}");
            if failed.is_empty() {
                Check::good("auto", text)
            } else {
                Check::bad("auto", format!("{text}; {}", failed.join("; ")), GPU_CURE)
            }
        }
        Err(error) => Check::bad("auto", format!("{error:#}"), "use --engine cpu"),
    }
}

/// Serial ports that this user may not use. Nothing is opened: opening resets some boards.
#[cfg(all(unix, feature = "serial"))]
fn serial_ports() -> Vec<Check> {
    use nix::unistd::{AccessFlags, access};

    let ports = serialport::available_ports().unwrap_or_default();
    let (open, closed): (Vec<String>, Vec<String>) = ports
        .into_iter()
        .map(|port| port.port_name)
        .partition(|port| access(port.as_str(), AccessFlags::R_OK | AccessFlags::W_OK).is_ok());
    let mut checks = Vec::new();
    if !closed.is_empty() {
        let cure = "join the group of the device, usually `sudo usermod -aG dialout $USER`, and log in again";
        checks.push(Check::bad("serial", format!("no permission for {}", closed.join(", ")), cure));
    }
    if !open.is_empty() || closed.is_empty() {
        let text = if open.is_empty() { "no port found".to_owned() } else { open.join(", ") };
        checks.push(Check::good("serial", text));
    }
    checks
}

#[cfg(not(all(unix, feature = "serial")))]
fn serial_ports() -> Vec<Check> {
    Vec::new()
}

/// The optional parts of this build.
fn features() -> Check {
    let features = [
        ("gpu", cfg!(feature = "gpu")),
        ("serial", cfg!(feature = "serial")),
        ("mcap", cfg!(feature = "mcap")),
        ("png", cfg!(feature = "png")),
        ("parquet", cfg!(feature = "parquet")),
        ("playground", cfg!(feature = "playground")),
        ("ros2", cfg!(feature = "ros2")),
    ];
    let names = |is_built: bool| {
        let names = features.iter().filter(|(_, built)| *built == is_built);
        names.map(|(name, _)| *name).collect::<Vec<_>>().join(" ")
    };
    let absent = names(false);
    let absent = if absent.is_empty() { absent } else { format!("; not built: {absent}") };
    Check::good("features", format!("{}{absent}", names(true)))
}
