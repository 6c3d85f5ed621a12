//! One mission driven.

use super::ending::{Verdict, verdict};
use super::{Drawn, Ending, MissionRow, MissionSite, MissionsError, Rules, Touch};
use crate::bench::Latencies;
use crate::local::Engine;
use crate::runtime::{Config, MissionResult, Observer};
use crate::sim::SimError;

/// Settings under a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// What they are called in rows.
    pub name: String,
    /// The settings.
    pub config: Config,
}

/// Draws the mission of a seed and drives it before an observer. Without a result where the navigator
/// found no way to begin with.
///
/// # Errors
/// When the map has no room for a mission, or the configuration is not sound.
pub fn drive(
    site: &MissionSite,
    seed: u64,
    rules: &Rules,
    setup: &Setup,
    engine: Box<dyn Engine>,
    observer: &mut Observer<'_>,
) -> Result<(MissionRow, Drawn, Option<MissionResult>), MissionsError> {
    let config = &setup.config;
    let drawn = site.draw(seed, rules, config)?;
    let simulation = &drawn.simulation;
    let mission = &simulation.mission;
    let mut row = MissionRow {
        setup: setup.name.clone(),
        map: site.name.clone(),
        seed,
        people: drawn.people,
        moving: simulation.moving_obstacles.len(),
        unmapped: drawn.unmapped,
        result: Ending::Failed,
        time_s: 0.0,
        path_m: drawn.path_m,
        travelled_m: 0.0,
        min_clearance_m: None,
        contact: Touch::None,
        fault: None,
        reason: None,
        final_error_m: (mission.start.position() - mission.goal.position).norm(),
        final_yaw_error_rad: None,
        plans: 0,
        ticks: 0,
        trace_digest: None,
        engine: engine.name(),
        tick_p50_ms: None,
        tick_p99_ms: None,
    };
    let result = match simulation.run(config, engine, observer) {
        Ok(result) => result,
        Err(SimError::Fault(fault)) => {
            row.fault = Some(word(&fault.to_string()));
            row.reason = Some(fault.to_string());
            return Ok((row, drawn, None));
        }
        Err(error) => {
            let site = site.name.clone();
            return Err(MissionsError::Sim { site, seed, error });
        }
    };
    row.fill(verdict(simulation, config, &result), &result);
    Ok((row, drawn, Some(result)))
}

impl MissionRow {
    fn fill(&mut self, verdict: Verdict, result: &MissionResult) {
        let mut times = Latencies::default();
        for &seconds in &result.decision_s {
            // A clock that ran backwards would give no time.
            let _ = times.record(seconds);
        }
        let times = times.summary();
        let (x_m, y_m) = result.final_error_m;
        self.result = verdict.ending;
        self.contact = verdict.touch;
        self.reason = verdict.reason;
        self.fault = result.fault.as_ref().map(|fault| word(&fault.to_string()));
        self.time_s = result.time_s;
        self.travelled_m = result.travelled_m;
        self.min_clearance_m = Some(result.min_clearance_m).filter(|gap_m| gap_m.is_finite());
        self.final_error_m = libm::hypot(x_m, y_m);
        self.final_yaw_error_rad = result.final_yaw_error;
        self.plans = result.plans.len();
        self.ticks = result.trace.rows.len();
        self.trace_digest = Some(result.trace.digest());
        self.tick_p50_ms = times.map(|times| times.p50_ms);
        self.tick_p99_ms = times.map(|times| times.p99_ms);
    }
}

/// Nav2's word at the beginning of a fault's sentence; `FAULT` where it has none.
fn word(sentence: &str) -> String {
    let word = sentence.split(':').next().unwrap_or_default();
    let is_word = !word.is_empty() && word.chars().all(|c| c.is_ascii_uppercase() || c == '_');
    if is_word { word } else { "FAULT" }.to_owned()
}
