//! What a drive reports: JSON, text, the log of `--verbose`, and its page.

use inbye::bench::Latencies;
use inbye::local::{GpuFailureKind, Incidents, Sampling};
use inbye::localization::ChangedArea;
use inbye::map::GridFrame;
use inbye::navigator::{DeadlineStats, Mode};
use inbye::report::{MissionView, Report, html};
use inbye::runtime::{
    EarlyEnd, FaultEvents, MissionEnd, MissionResult, StopError, TickEvent, ZoneCompliance,
};
use inbye::suggest::counted;
use serde_json::{Value, json};

use super::output;

/// Introduction of a simulated drive's page.
pub const SIMULATED: &str = "One mission, simulated in a closed loop.";

/// Measured over commanded turn rate: outside, the base is not calibrated.
const MIN_TURN_RATIO: f64 = 0.9;
const MAX_TURN_RATIO: f64 = 1.1;

/// Distance by scans over that of the tracks: outside, slip alone hardly explains it.
const USUAL_SCALE: core::ops::RangeInclusive<f64> = 0.7..=1.1;

/// Collects the decision times.
fn latencies(result: &MissionResult) -> Latencies {
    let mut latencies = Latencies::default();
    for &seconds in &result.decision_s {
        // The wall clock never runs backwards, so every time is valid.
        let _ = latencies.record(seconds);
    }
    latencies
}

/// The result as a JSON object. Figures of GPU failures and deadlines are null without a GPU or without a deadline.
pub fn object(result: &MissionResult) -> Value {
    let error = |x_m: f64, y_m: f64, yaw_rad: Option<f64>| json!({ "x_m": x_m, "y_m": y_m, "yaw_rad": yaw_rad });
    let (x_m, y_m) = result.final_error_m;
    let stops = result.stop_errors.iter().map(|stop| error(stop.x_m, stop.y_m, stop.yaw_rad));
    let incidents = result.incidents.as_ref();
    json!({
        "reached": result.reached,
        "collided": result.collided,
        "time_s": result.time_s,
        "travelled_m": result.travelled_m,
        "min_clearance_m": result.min_clearance_m,
        "omega_sign_changes_per_m": result.omega_sign_changes_per_m(),
        "people_met": result.encounters.people_met,
        "people_time_lost_s": result.encounters.time_lost_s,
        "final_error": error(x_m, y_m, result.final_yaw_error),
        "stop_errors": stops.collect::<Vec<_>>(),
        "engine": result.engine,
        "latency_ms": latencies(result).summary(),
        "ticks": result.trace.rows.len(),
        "plans": result.plans.len(),
        "fault": result.fault.as_ref().map(ToString::to_string),
        "why": result.why(),
        "interrupted": result.early_end == Some(EarlyEnd::Interrupted),
        "trace_digest": result.trace.digest(),
        "gpu_losses": incidents.map(|incidents| &incidents.failures),
        "gpu_reopened": incidents.map(|incidents| incidents.reopened),
        "gpu_incidents": incidents.map(|incidents| &incidents.messages),
        "cpu_ticks": incidents.map(|incidents| incidents.on_cpu),
        "deadline": result.deadline_stats,
        "observation_faults": result.observation_faults,
        "motion": result.motion,
        "odometry_scale": result.odometry_scale.map(|(distance, turn)| json!({ "distance": distance, "turn": turn })),
        "protective_actions": result.protective_actions,
        "zones": result.zones,
    })
}

/// The result in one line.
pub fn one_line(result: &MissionResult) -> String {
    with_outcome(outcome(result), result)
}

/// The result in one line, in colour on a terminal.
pub fn coloured_line(result: &MissionResult) -> String {
    let mark = if result.end() == MissionEnd::Reached { output::good } else { output::bad };
    with_outcome(&mark(outcome(result)), result)
}

fn outcome(result: &MissionResult) -> &'static str {
    match result.end() {
        MissionEnd::Contact => match &result.contact {
            Some(contact) if !contact.is_by_robot() => {
                let last = result.trace.rows.last();
                if last.is_some_and(|row| row.twist.stands()) {
                    "a moving obstacle ran into the standing robot"
                } else {
                    "a moving obstacle ran into the robot"
                }
            }
            _ => "hit an obstacle",
        },
        MissionEnd::Reached => "reached the goal",
        MissionEnd::Timeout | MissionEnd::Failed => "did not reach the goal",
    }
}

fn with_outcome(outcome: &str, result: &MissionResult) -> String {
    let gap_m = result.min_clearance_m;
    // That of a robot that stayed lost is not known.
    let gap =
        if gap_m.is_finite() { format!(", smallest gap {gap_m:.3} m") } else { String::new() };
    format!(
        "{outcome}: {:.1} m in {:.1} s, {}, {}{gap}",
        result.travelled_m,
        result.time_s,
        counted(result.trace.rows.len(), "tick"),
        counted(result.plans.len(), "plan"),
    )
}

/// The result as lines of text.
pub fn lines(result: &MissionResult) -> Vec<String> {
    let mut lines = vec![coloured_line(result)];
    lines.extend(result.why().map(|why| format!("why          {why}")));
    let error = |name: &str, (x_m, y_m): (f64, f64), yaw_rad: Option<f64>| {
        let yaw = yaw_rad.map_or_else(String::new, |yaw_rad| format!(", yaw {yaw_rad:+.4} rad"));
        format!("{name:<12} x {x_m:+.3} m, y {y_m:+.3} m{yaw}")
    };
    for (number, StopError { x_m, y_m, yaw_rad, .. }) in (1..).zip(&result.stop_errors) {
        lines.push(error(&format!("stop {number}"), (*x_m, *y_m), *yaw_rad));
    }
    lines.push(error("final error", result.final_error_m, result.final_yaw_error));
    if let Some(summary) = latencies(result).summary() {
        lines.push(format!(
            "decision     p50 {:.2} ms, p99 {:.2} ms, slowest {:.2} ms on {}",
            summary.p50_ms, summary.p99_ms, summary.max_ms, result.engine,
        ));
    }
    lines.push(format!("{:<12} {}", "motion", motion(result)));
    lines.push(format!("{:<12} {}", "response", response(result)));
    lines.extend(odometry(result).map(|scale| format!("{:<12} {scale}", "odometry")));
    lines.extend(
        result.zones.as_ref().map(|zones| format!("{:<12} {}", "zones", zones_text(zones))),
    );
    lines.extend(incidents(result).iter().map(|(name, fact)| format!("{name:<12} {fact}")));
    lines.push(format!("trace        {}", result.trace.digest()));
    lines
}

/// What the scans contradicted in the map, a line; none without a pose from scans.
pub fn map_changes(result: &MissionResult, frame: &GridFrame) -> Option<String> {
    let changes = result.map_changes.as_ref()?;
    let largest = |areas: &[ChangedArea]| match areas {
        [] => "nothing".to_owned(),
        [area, rest @ ..] => {
            let &ChangedArea { x, y, width_m, height_m, .. } = area;
            let more =
                if rest.is_empty() { String::new() } else { format!(" and {} more", rest.len()) };
            format!("{width_m:.2} x {height_m:.2} m at ({x:.2}, {y:.2}){more}")
        }
    };
    let [appeared, vanished] = changes.areas(frame);
    Some(format!(
        "{:<12} appeared: {}; vanished: {}",
        "map changes",
        largest(&appeared),
        largest(&vanished)
    ))
}

/// How the robot kept the zones.
fn zones_text(zones: &ZoneCompliance) -> String {
    let closed = match zones.intrusions {
        _ if zones.min_gap_m.is_infinite() => "none closed".to_owned(),
        0 => format!("{:.3} m from closed ones at least", zones.min_gap_m),
        ticks => format!("{ticks} ticks in closed ones"),
    };
    let limited = match zones.limited_ticks {
        0 => "no speed limit met".to_owned(),
        ticks => {
            format!("{ticks} ticks with a speed limit, at most {:.3} m/s above", zones.max_excess)
        }
    };
    format!("{closed}; {limited}")
}

/// How smoothly the robot drove, and what people cost it.
fn motion(result: &MissionResult) -> String {
    let per_m = result.omega_sign_changes_per_m();
    let changes = per_m.map_or_else(|| "no".to_owned(), |per_m| format!("{per_m:.2}"));
    let met = result.encounters.people_met;
    let people = if met == 1 { "person" } else { "people" };
    let lost_s = result.encounters.time_lost_s;
    let lost = lost_s.map_or_else(String::new, |lost_s| format!(", {lost_s:+.1} s with them"));
    format!("{changes} sign changes of omega per metre; {met} {people} met{lost}")
}

/// An unusual scale of the odometry.
fn odometry(result: &MissionResult) -> Option<String> {
    let (distance, _) = result.odometry_scale?;
    (!USUAL_SCALE.contains(&distance)).then(|| {
        format!(
            "the robot moves {distance:.2} times as far as its tracks report: slip, or a wrong scale (see `inbye base calibrate`)"
        )
    })
}

/// What the drive showed of the base's response to commands.
fn response(result: &MissionResult) -> String {
    let motion = &result.motion;
    let delay = motion.delay_s.map_or_else(
        || format!("latency not identified, {:.2} s assumed", motion.safe_delay_s),
        |delay_s| {
            format!("latency {:.2} s ({:.2} to {:.2})", delay_s.value, delay_s.low, delay_s.high)
        },
    );
    let mut parts = vec![
        delay,
        format!("acceleration {:.2} m/s^2", motion.acceleration_m_s2),
        format!("braking {:.2} m/s^2", motion.braking_m_s2),
    ];
    if let Some(ratio) = motion.turn_ratio {
        parts.push(format!("turns at {:.0} % of the command", 100.0 * ratio.value));
        // Within a few percent, the calibration of one floor is as good as on another.
        if ratio.low > MAX_TURN_RATIO || ratio.high < MIN_TURN_RATIO {
            parts.push(format!(
                "multiply effective_width_ratio by {:.2}, or run `inbye base calibrate`",
                ratio.value.recip()
            ));
        }
    }
    parts.join(", ")
}

/// The text: a name and a sentence for each kind of incident that occurred.
fn incidents(result: &MissionResult) -> Vec<(&'static str, String)> {
    let mut facts = Vec::new();
    // An absent GPU is reported with the engine's name.
    let lost = |kind: &GpuFailureKind| *kind != GpuFailureKind::Absent;
    if let Some(incidents) = &result.incidents
        && (incidents.failures.keys().any(lost) || incidents.reopened > 0)
    {
        facts.extend(gpu_facts(incidents));
    }
    facts.extend(result.deadline_stats.iter().map(|stats| ("deadline", misses(stats))));
    facts.extend(
        result
            .observation_faults
            .iter()
            .map(|(fault, count)| ("sensors", format!("{count} faulty observations: {fault}"))),
    );
    let actions = result.protective_actions.iter();
    let actions: Vec<String> =
        actions.map(|(action, ticks)| format!("{} {ticks}", action.replace('_', " "))).collect();
    if !actions.is_empty() {
        facts.push(("protection", format!("acted on commands, by ticks: {}", actions.join(", "))));
    }
    facts
}

/// The GPU failures, and the first message.
pub fn gpu_facts(incidents: &Incidents) -> Vec<(&'static str, String)> {
    let first = incidents.messages.first().map(|first| ("GPU, first", first.message.clone()));
    core::iter::once(("GPU", losses(incidents))).chain(first).collect()
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

/// The log of a drive for `--verbose`: a line for each change of mode, new plan and fault.
#[derive(Default)]
pub struct DriveLog {
    mode: Option<Mode>,
    plans: usize,
    fault_events: FaultEvents,
    faults: Vec<String>,
}

impl DriveLog {
    /// Prints what changed in a tick.
    pub fn update(&mut self, tick: &TickEvent<'_>) {
        let row = tick.row;
        let at = || {
            let position = row.belief.position();
            format!("{:7.1} s at {:.2}, {:.2}", row.time_s, position.x, position.y)
        };
        let plans = tick.navigator.plans();
        for plan in plans.iter().skip(self.plans) {
            output::detail(format!(
                "{}: a plan of {:.1} m, {} cells expanded",
                at(),
                plan.smoothed.length_m(),
                plan.expanded,
            ));
        }
        let faults = self.fault_events.update(tick);
        for fault in faults.iter().filter(|fault| !self.faults.contains(fault)) {
            output::detail(format!("{}: {fault}", at()));
        }
        self.faults = faults;
        if self.mode != Some(row.mode) {
            output::detail(format!("{}: {}", at(), row.mode.name().replace('_', " ")));
        }
        self.mode = Some(row.mode);
        self.plans = plans.len();
    }
}

/// Further facts on a run for its page.
pub fn facts(result: &MissionResult, seed: u64) -> Vec<(String, String)> {
    let mut facts = vec![
        ("Version", format!("inbye {}", env!("CARGO_PKG_VERSION"))),
        ("Seed of the simulation", seed.to_string()),
        ("Global plans", result.plans.len().to_string()),
        ("Trace digest", result.trace.digest()),
    ];
    facts.extend(result.why().map(|why| ("Why not reached", why)));
    facts.push(("Response of the base", response(result)));
    facts.extend(incidents(result));
    facts.into_iter().map(|(name, fact)| (name.to_owned(), fact)).collect()
}

/// Returns the page of one drive.
pub fn page(intro: &str, drive: MissionView<'_>) -> String {
    let title = &format!("inbye drive: {}", drive.title);
    html(&Report { title, intro, missions: vec![drive], ..Report::default() })
}
