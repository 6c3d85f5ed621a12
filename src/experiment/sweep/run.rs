//! A cell driven.

use std::sync::Arc;

use super::ground::Ground;
use super::{Cell, CellFile, CellLatency, Outcome};
use crate::bench::Latencies;
use crate::experiment::barn;
use crate::experiment::dynabarn;
use crate::experiment::missions::{self, Ending, MissionSite, Setup, Touch, verdict};
use crate::experiment::worlds::drive_on;
use crate::local::{Engine, EngineChoice, EngineError, open_with_fallback};
use crate::map::OccupancyGrid;
use crate::runtime::{Config, Mission, MissionResult, Observer};
use crate::sim::{SimError, Simulation};

/// Opens the engine of a cell.
///
/// # Errors
/// When this machine does not have it: that is no result of the cell, and another machine may have it.
pub fn open_engine(cell: &Cell) -> Result<Box<dyn Engine>, EngineError> {
    // The plan's check knows the words.
    let preference: EngineChoice = cell.label.engine.parse().unwrap_or_default();
    let is_gpu = matches!(preference, EngineChoice::Gpu(_));
    Ok(open_with_fallback(&preference, cell.threads, is_gpu)?.engine)
}

/// Drives a cell on its engine. `clock`, in seconds, times the ticks of a latency cell on a machine of this name; other cells
/// see no clock. What cannot be driven is a result too.
pub fn run_cell(
    cell: &Cell,
    engine: Box<dyn Engine>,
    clock: &mut dyn FnMut() -> f64,
    machine: &str,
) -> CellFile {
    let ran_on = engine.name();
    let mut no_clock = || 0.0;
    let is_timed = cell.label.latency;
    let clock = if is_timed { clock } else { &mut no_clock };
    let (outcome, result) =
        driven(cell, engine, clock).unwrap_or_else(|reason| (Outcome::error(reason), None));
    let times = result.filter(|_| is_timed).and_then(|result| {
        let mut times = Latencies::default();
        for &seconds in &result.decision_s {
            // A clock that ran backwards would give no time.
            let _ = times.record(seconds);
        }
        times.summary()
    });
    let latency = times.map(|times| CellLatency::new(times, cell.threads, ran_on, machine));
    CellFile {
        key: cell.key.clone(),
        inputs: cell.inputs.clone(),
        outcome,
        latency,
    }
}

type Driven = (Outcome, Option<MissionResult>);

/// What came of it, or in words why it could not be begun.
fn driven(
    cell: &Cell,
    engine: Box<dyn Engine>,
    clock: &mut dyn FnMut() -> f64,
) -> Result<Driven, String> {
    let (config, seed) = (&cell.config, cell.label.seed);
    match cell.ground.as_ref() {
        Ground::Barn(world) => {
            let task = barn::Task::barn(world, seed);
            let driven = drive_on(&task, config, engine, clock);
            let (row, result) = driven.map_err(|error| error.to_string())?;
            Ok((Outcome::barn(row, result.as_ref()), result))
        }
        Ground::DynaBarn(world) => {
            let task = dynabarn::Task { world, seed };
            let driven = drive_on(&task, config, engine, clock);
            let (row, result) = driven.map_err(|error| error.to_string())?;
            Ok((Outcome::dynabarn(row, result.as_ref()), result))
        }
        Ground::Route {
            map,
            start,
            goal,
            people,
            time_limit_s,
        } => {
            let mission = Mission {
                time_limit_s: *time_limit_s,
                ..Mission::new(Arc::clone(map), *start, *goal)
            };
            let driven = on_route(mission, *people, seed, config).and_then(|simulation| {
                let mut observer = Observer {
                    clock,
                    on_tick: &mut |_| {},
                };
                let result = simulation.run(config, engine, &mut observer)?;
                Ok((simulation, result))
            });
            match driven {
                Ok((simulation, result)) => {
                    let verdict = verdict(&simulation, config, &result);
                    let (ending, touch) = (verdict.ending, verdict.touch);
                    let outcome = Outcome::mission(ending, touch, verdict.reason, Some(&result));
                    Ok((outcome, Some(result)))
                }
                Err(SimError::Fault(fault)) => {
                    let reason = Some(fault.to_string());
                    let outcome = Outcome::mission(Ending::Failed, Touch::None, reason, None);
                    Ok((outcome, None))
                }
                Err(error) => Err(error.to_string()),
            }
        }
        Ground::Mission { map, rules } => {
            let site = MissionSite::new(&cell.label.world, OccupancyGrid::clone(map), config);
            let setup = Setup {
                name: String::new(),
                config: config.clone(),
            };
            let mut observer = Observer {
                clock,
                on_tick: &mut |_| {},
            };
            let driven = missions::drive(&site, seed, rules, &setup, engine, &mut observer);
            let (row, _, result) = driven.map_err(|error| error.to_string())?;
            let outcome = Outcome::mission(row.result, row.contact, row.reason, result.as_ref());
            Ok((outcome, result))
        }
    }
}

/// The simulation of a mission, with people spread along the route that the robot will plan.
fn on_route(
    mission: Mission,
    people: usize,
    seed: u64,
    config: &Config,
) -> Result<Simulation, SimError> {
    let ends = (mission.start.position(), mission.goal.position);
    let spawner = config.pedestrians.spawner(people, seed);
    Ok(Simulation {
        moving_obstacles: spawner.spawn_on_route(&mission.map, config, ends)?,
        seed,
        ..Simulation::new(mission)
    })
}
