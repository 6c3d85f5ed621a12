//! `diagnostic_msgs/DiagnosticArray`: latency, mode and counters.

use crate::navigator::{Decision, Mode, Navigator};
use crate::recording::cdr::Encoder;
use crate::recording::parts;

/// Numbers of `diagnostic_msgs/DiagnosticStatus`.
const OK: u8 = 0;
const WARN: u8 = 1;
const ERROR: u8 = 2;

/// What diagnostics tell of a tick.
pub struct Status<'a> {
    /// The time of the tick, seconds.
    pub time_s: f64,
    /// What was decided.
    pub decision: &'a Decision,
    /// How long that took, seconds.
    pub took_s: f64,
    /// What decided.
    pub navigator: &'a Navigator,
    /// What it decided on.
    pub engine: &'a str,
}

/// How the navigator is, as one status.
pub fn diagnostics(status: &Status<'_>) -> Vec<u8> {
    let (level, said) = judged(status);
    let mut message = Encoder::new();
    parts::header(&mut message, status.time_s, "");
    message.count(1);
    message.u8(level);
    message.text("inbye: decision");
    message.text(&said);
    message.text(status.engine);
    let values = values(status);
    message.count(values.len());
    for (key, value) in &values {
        message.text(key);
        message.text(value);
    }
    message.finish()
}

/// How bad it is, and in words.
fn judged(status: &Status<'_>) -> (u8, String) {
    let mode = status.decision.mode;
    let level = match mode {
        Mode::Failed => ERROR,
        Mode::Blocked | Mode::SensorFault => WARN,
        _ => OK,
    };
    match status.navigator.fault() {
        Some(fault) => (ERROR, fault.to_string()),
        None => (level, mode.as_str().to_owned()),
    }
}

fn values(status: &Status<'_>) -> Vec<(&'static str, String)> {
    let Status {
        decision,
        took_s,
        navigator,
        ..
    } = status;
    let counts = decision.counts.unwrap_or_default();
    let observation_faults: u64 = navigator.observation_faults().values().sum();
    let mut values = vec![
        ("mode", decision.mode.as_str().to_owned()),
        ("latency_ms", (took_s * 1e3).to_string()),
        ("admissible", counts.admissible.to_string()),
        ("collision", counts.collision.to_string()),
        ("cannot_stop", counts.cannot_stop.to_string()),
        ("outside", counts.outside.to_string()),
        ("plans", navigator.plans().len().to_string()),
        ("observation_faults", observation_faults.to_string()),
    ];
    if let Some(stats) = navigator.deadline_stats() {
        let deadline_ms = stats.deadline_s * 1e3;
        values.push(("deadline_ms", deadline_ms.to_string()));
        values.push(("deadline_misses", stats.misses.to_string()));
    }
    if let Some(incidents) = navigator.planner().incidents() {
        let failures: u64 = incidents.failures.values().sum();
        values.push(("gpu_losses", failures.to_string()));
        values.push(("cpu_ticks", incidents.on_cpu.to_string()));
    }
    values
}
