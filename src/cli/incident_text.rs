//! GPU failures, missed deadlines and faulty observations of a drive.

use inbye::local::{GpuFailureKind, Incidents, Sampling};
use inbye::navigator::DeadlineStats;
use inbye::runtime::MissionResult;
use serde_json::{Value, json};

/// The JSON fields: always the same names, null without a GPU or without a deadline.
pub fn fields(result: &MissionResult) -> [(&'static str, Value); 6] {
    let incidents = result.incidents.as_ref();
    [
        ("gpu_losses", json!(incidents.map(|incidents| &incidents.failures))),
        ("gpu_reopened", json!(incidents.map(|incidents| incidents.reopened))),
        ("gpu_incidents", json!(incidents.map(|incidents| &incidents.messages))),
        ("cpu_ticks", json!(incidents.map(|incidents| incidents.on_cpu))),
        ("deadline", json!(result.deadline_stats)),
        ("observation_faults", json!(result.observation_faults)),
    ]
}

/// The text: a name and a sentence for each kind of incident that occurred.
pub fn facts(result: &MissionResult) -> Vec<(&'static str, String)> {
    let mut facts = Vec::new();
    // An absent GPU is reported with the engine's name.
    let lost = |kind: &GpuFailureKind| *kind != GpuFailureKind::Absent;
    if let Some(incidents) = &result.incidents
        && (incidents.failures.keys().any(lost) || incidents.reopened > 0)
    {
        facts.push(("GPU", losses(incidents)));
        let first = incidents.messages.first().map(|first| first.message.clone());
        facts.extend(first.map(|message| ("GPU, first", message)));
    }
    facts.extend(result.deadline_stats.iter().map(|stats| ("deadline", misses(stats))));
    facts.extend(
        result
            .observation_faults
            .iter()
            .map(|(fault, count)| ("sensors", format!("{count} faulty observations: {fault}"))),
    );
    facts
}

fn losses(incidents: &Incidents) -> String {
    let kinds: Vec<String> =
        incidents.failures.iter().map(|(kind, count)| format!("{count} {kind}")).collect();
    format!(
        "lost: {}; reopened: {}; decided by the CPU meanwhile: {} of {}",
        kinds.join(", "),
        incidents.reopened,
        incidents.on_cpu,
        incidents.decisions,
    )
}

fn misses(stats: &DeadlineStats) -> String {
    let Sampling { vx_samples, vtheta_samples } = stats.lowest;
    format!(
        "{} of {} decisions took longer than {} ms; fewest samples {vx_samples} x {vtheta_samples}",
        stats.misses,
        stats.decisions,
        stats.deadline_s * 1e3,
    )
}
