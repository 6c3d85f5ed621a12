//! Drives one case of the fault matrix.

use core::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::FaultRow;
use super::faulty_engine::{EngineFault, faulty_engine};
use super::sites::{AT_S, appear_around, roadway_mission};
use crate::experiment::outcome::outcome;
use crate::experiment::{ContactCause, ExperimentError, RunOutcome};
use crate::local::{CpuEngine, Engine};
use crate::runtime::{Config, MissionResult, Observer, TickEvent, TraceRow};
use crate::sim::{FaultInjection, Simulation};

/// A fault of the matrix.
#[derive(Clone, Copy, Debug)]
pub(super) struct FaultCase {
    pub name: &'static str,
    /// Time within which the robot must stand for good, seconds; none where it may drive on.
    pub limit_s: Option<f64>,
    pub end: End,
    /// Changes an undisturbed drive through the roadways.
    pub prepare: fn(&mut Drive) -> Result<(), ExperimentError>,
}

/// How a drive must end. In any case the robot has caused no contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum End {
    /// The robot may still move: the commands of a wrong planner do not end with the mission.
    WithoutContact,
    /// Standing at the goal, or with a reason.
    Any,
    /// Standing at the goal.
    AtGoal,
    /// Standing, with a reason that has this text.
    Reason(&'static str),
}

/// A drive with a fault.
pub(super) struct Drive {
    pub config: Config,
    pub simulation: Simulation,
    /// Duration of each decision from the fault on, seconds.
    pub decision_s: f64,
    /// The fault of the engine, and whether it has a CPU fallback.
    pub engine: Option<(EngineFault, bool)>,
    /// Gap, metres, and direction, radians, of each obstacle that appears around the robot.
    pub appearing: Vec<(f64, f64)>,
    /// Whether the robot stands where its commands do: the belts of a bogged robot may turn.
    pub stands_by_command: bool,
}

impl Drive {
    fn new(seed: u64) -> Self {
        Self {
            config: Config::default(),
            simulation: roadway_mission(seed),
            decision_s: 0.0,
            engine: None,
            appearing: Vec::new(),
            stands_by_command: false,
        }
    }

    pub fn inject(&mut self, fault: FaultInjection) {
        self.simulation.faults.push(fault);
    }

    fn run(&self) -> Result<MissionResult, ExperimentError> {
        let is_faulty = Arc::new(AtomicBool::new(false));
        let engine: Box<dyn Engine> = match self.engine {
            Some((fault, has_fallback)) => {
                faulty_engine(fault, has_fallback, Arc::clone(&is_faulty))
            }
            None => Box::new(CpuEngine::single_threaded()),
        };
        let (time_s, mut now_s, mut is_end) = (Cell::new(0.0), 0.0, true);
        // It is read at the begin and at the end of each decision.
        let mut clock = || {
            is_end = !is_end;
            now_s += if is_end && time_s.get() >= AT_S { self.decision_s } else { 0.0 };
            now_s
        };
        let mut on_tick = |event: &TickEvent<'_>| {
            time_s.set(event.row.time_s);
            is_faulty.store(event.row.time_s >= AT_S, Ordering::Relaxed);
        };
        let mut observer = Observer { clock: &mut clock, on_tick: &mut on_tick };
        Ok(self.simulation.run(&self.config, engine, &mut observer)?)
    }

    fn moves(&self, row: &TraceRow) -> bool {
        let twist = if self.stands_by_command { &row.command } else { &row.twist };
        !twist.stands()
    }
}

impl FaultCase {
    /// Drives with a seed, and adds the drive to the row.
    pub fn drive(&self, seed: u64, row: &mut FaultRow) -> Result<(), ExperimentError> {
        let mut drive = Drive::new(seed);
        (self.prepare)(&mut drive)?;
        if !drive.appearing.is_empty() {
            appear_around(&mut drive.simulation, &drive.config, &drive.appearing)?;
        }
        let result = drive.run()?;
        let (ended, cause, reason) = outcome(&drive.simulation, &drive.config, &result);
        let rows = &result.trace.rows;
        let is_robot = ended == RunOutcome::Contact && cause == Some(ContactCause::Robot);
        let last_moving_s =
            rows.iter().rev().find(|row| drive.moves(row)).map_or(0.0, |row| row.time_s);
        let stood_s = (last_moving_s + drive.config.local.control_period_s - AT_S).max(0.0);
        let after = rows.iter().filter(|row| row.time_s >= AT_S);
        let gap_m = after.map(|row| row.gap_m).fold(f64::INFINITY, f64::min);
        let stands_at_end =
            self.end == End::WithoutContact || rows.last().is_none_or(|row| !drive.moves(row));
        let has_met_engine_fault = match drive.engine {
            Some((_, true)) => {
                result.incidents.as_ref().is_some_and(|incidents| incidents.total_failures() > 0)
            }
            _ => true,
        };
        let ends_as_required = match self.end {
            End::WithoutContact => true,
            End::Any => matches!(ended, RunOutcome::Reached | RunOutcome::Failed),
            End::AtGoal => ended == RunOutcome::Reached,
            End::Reason(text) => reason.as_ref().is_some_and(|reason| reason.contains(text)),
        };
        let is_in_time = self.limit_s.is_none_or(|limit_s| stood_s <= limit_s);
        let failure = if is_robot || !ends_as_required {
            let reason = reason.as_ref().map_or_else(String::new, |reason| format!(": {reason}"));
            Some(format!("{}{reason}", ended.text()))
        } else if !stands_at_end {
            Some("it moves at the end".to_owned())
        } else if !has_met_engine_fault {
            Some("the engine met no fault".to_owned())
        } else {
            (!is_in_time).then(|| format!("it stood {stood_s:.2} s after the fault"))
        };
        row.runs += 1;
        row.contacts_robot += usize::from(is_robot);
        if self.limit_s.is_some() {
            row.stood_s = Some(row.stood_s.map_or(stood_s, |longest_s| longest_s.max(stood_s)));
        }
        row.min_gap_m = Some(row.min_gap_m.map_or(gap_m, |least_m| least_m.min(gap_m)));
        // A later drive that meets the requirement must not hide the failure.
        if failure.is_some() {
            (row.passed, row.reason) = (false, failure);
        } else if row.passed {
            row.reason = reason.or(row.reason.take());
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn row_has_the_reason_of_the_last_drive_that_failed() {
        let case = |limit_s| FaultCase {
            name: "silent lidar",
            limit_s: Some(limit_s),
            end: End::WithoutContact,
            prepare: |drive| {
                drive.simulation.mission.time_limit_s = AT_S + 4.0;
                drive.inject(FaultInjection::LidarSilent { from_s: AT_S, to_s: f64::INFINITY });
                Ok(())
            },
        };
        let mut row = FaultRow { passed: true, ..FaultRow::default() };
        case(4.0).drive(1, &mut row).expect("a drive");
        assert!(row.passed && !row.reason.as_ref().is_some_and(|reason| reason.contains("stood")));
        for limit_s in [0.0, 4.0] {
            case(limit_s).drive(1, &mut row).expect("a drive");
            let reason = row.reason.as_deref().unwrap_or_default();
            assert!(!row.passed && reason.contains("s after the fault"), "{row:?}");
        }
        assert_eq!(row.runs, 3);
    }
}
