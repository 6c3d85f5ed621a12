//! What a drive survived: a lost GPU, late decisions, faulty observations.

use inbye::local::{GpuFailureKind, Incidents, Sampling};
use inbye::navigator::DeadlineStats;
use inbye::runtime::MissionResult;
use serde_json::{Value, json};

/// As scripts read it: always the same names, null where no GPU was wanted, or no deadline.
pub fn fields(result: &MissionResult) -> [(&'static str, Value); 6] {
    let incidents = result.incidents.as_ref();
    [
        ("gpu_losses", json!(incidents.map(|one| &one.failures))),
        ("gpu_reopened", json!(incidents.map(|one| one.reopened))),
        ("gpu_incidents", json!(incidents.map(|one| &one.messages))),
        ("cpu_ticks", json!(incidents.map(|one| one.on_cpu))),
        ("deadline", json!(result.deadline_stats)),
        ("observation_faults", json!(result.observation_faults)),
    ]
}

/// As people read it: a name and a sentence for each thing, nothing of what did not happen.
pub fn facts(result: &MissionResult) -> Vec<(&'static str, String)> {
    let mut facts = Vec::new();
    // That there is none is said where the engine is named.
    let lost = |kind: &GpuFailureKind| *kind != GpuFailureKind::Absent;
    if let Some(incidents) = &result.incidents
        && (incidents.failures.keys().any(lost) || incidents.reopened > 0)
    {
        facts.push(("GPU", losses(incidents)));
        let first = incidents
            .messages
            .first()
            .map(|first| first.message.clone());
        facts.extend(first.map(|what| ("GPU, first", what)));
    }
    facts.extend(
        result
            .deadline_stats
            .iter()
            .map(|one| ("deadline", misses(one))),
    );
    facts.extend(
        result
            .observation_faults
            .iter()
            .map(|(fault, count)| ("sensors", format!("{count} faulty observations: {fault}"))),
    );
    facts
}

fn losses(incidents: &Incidents) -> String {
    let kinds: Vec<String> = incidents
        .failures
        .iter()
        .map(|(kind, count)| format!("{count} {}", kind.as_str()))
        .collect();
    format!(
        "lost: {}; opened anew: {}; decided by the CPU meanwhile: {} of {}",
        kinds.join(", "),
        incidents.reopened,
        incidents.on_cpu,
        incidents.decisions,
    )
}

fn misses(stats: &DeadlineStats) -> String {
    let Sampling {
        vx_samples,
        vtheta_samples,
    } = stats.lowest;
    format!(
        "{} of {} decisions took longer than {} ms; fewest samples {vx_samples} x {vtheta_samples}",
        stats.misses,
        stats.decisions,
        stats.deadline_s * 1e3,
    )
}
