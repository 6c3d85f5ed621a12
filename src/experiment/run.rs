//! One run: a world driven with a seed.

use super::barn::score;
use super::localization::LocalizationMonitor;
use super::outcome::outcome;
use super::row_figures::fault_name;
use super::world::WorldSource;
use super::{Cell, CellFile, ExperimentError, RunOutcome, RunRow, World, WorldSimulation};
use crate::local::{Engine, EngineChoice, EngineError, SharedEngines, open_with_fallback};
use crate::navigator::Fault;
use crate::runtime::{Config, Decider, MissionError, MissionResult, Observer, PoseSource};
use crate::sim::SimError;

/// A run: its row, its simulation, and every tick.
#[derive(Clone, Debug)]
pub struct Run {
    /// Its figures.
    pub row: RunRow,
    /// The simulation; none if no route for its moving obstacles was found.
    pub simulation: Option<WorldSimulation>,
    /// Every tick and plan; none if the navigator refused to start.
    pub result: Option<MissionResult>,
}

impl World {
    /// Drives the mission of a seed. A navigator that refuses to start is a result: the outcome is `Failed`.
    ///
    /// # Errors
    /// [`ExperimentError`] when the mission cannot be made, or a setting is out of range.
    pub fn drive(
        &self,
        seed: u64,
        config: &Config,
        decider: impl Into<Decider>,
        observer: &mut Observer<'_>,
    ) -> Result<Run, ExperimentError> {
        let decider = decider.into();
        let mut row = RunRow { outcome: RunOutcome::Failed, ..self.row(config, "cpu", seed) };
        match &decider {
            Decider::Navigator(engine) => {
                row.ran_on = Some(engine.name());
                engine.kind().clone_into(&mut row.engine);
            }
            Decider::Controller(controller) => row.controller = Some(controller.name().to_owned()),
        }
        let refused = |mut row: RunRow, fault: String, simulation| {
            row.fault = Some(fault_name(&fault));
            row.reason = Some(fault);
            Run { row: row.without_success(), simulation, result: None }
        };
        let mut generated = match self.simulation(seed, config) {
            Err(ExperimentError::Simulation(SimError::Mission(MissionError::Fault(fault))))
                if is_result(&fault) =>
            {
                return Ok(refused(row, fault.to_string(), None));
            }
            generated => generated?,
        };
        generated.simulation.mission.interrupt.clone_from(&self.interrupt);
        let simulation = &generated.simulation;
        row.path_m = generated.path_m;
        row.traffic = generated.traffic;
        row.obstacles = simulation.moving_obstacles.len();
        row.unmapped = generated.unmapped;
        row.fill_plant(config, simulation.seed);
        if let WorldSource::Barn(world) = self.source.as_ref() {
            row.optimal_time_s = Some(world.optimal_time_s);
            row.score = Some(0.0);
        }
        row.slip = (config.pose_source == PoseSource::Scans)
            .then_some(config.simulation.dynamics.slip.mean);
        let mut monitor = LocalizationMonitor::new(&simulation.faults);
        let mut observer = Observer {
            clock: &mut *observer.clock,
            on_tick: &mut |event| {
                monitor.on_tick(&mut row, event);
                (observer.on_tick)(event);
            },
        };
        let result = match simulation.run(config, decider, &mut observer) {
            Err(SimError::Mission(MissionError::Fault(fault))) if is_result(&fault) => {
                return Ok(refused(row, fault.to_string(), Some(generated)));
            }
            result => result?,
        };
        (row.outcome, row.contact_cause, row.reason) = outcome(simulation, config, &result);
        let reference = self.reference(&simulation.mission, config, &result);
        row.fill(simulation, config, &result, reference);
        row.fill_times(&result.decision_s);
        match self.source.as_ref() {
            WorldSource::Barn(world) => {
                let reached = row.outcome == RunOutcome::Reached;
                row.score = Some(score(reached, row.time_s, world.optimal_time_s));
            }
            WorldSource::DynaBarn(world) => {
                row.contact_cause = world.contact_cause(&result, config);
            }
            _ => {}
        }
        Ok(Run { row, simulation: Some(generated), result: Some(result) })
    }
}

/// Whether the fault of a navigator that refuses to start is a result. Settings that it cannot use are none.
const fn is_result(fault: &Fault) -> bool {
    !matches!(fault, Fault::Setting(_) | Fault::Choose(_))
}

/// Opens the engine of a cell. Cells on a GPU share it, so the decisions of those that run side by side are evaluated in batches; a
/// cell whose latency is measured has its engine to itself.
///
/// # Errors
/// Fails when this machine does not have the engine. That is no result of the cell: another machine may have it.
pub fn open_engine(cell: &Cell, shared: &SharedEngines) -> Result<Box<dyn Engine>, EngineError> {
    // The plan's check accepts no other names.
    let choice: EngineChoice = cell.row.engine.parse().unwrap_or_default();
    if cell.row.latency {
        let is_gpu = choice != EngineChoice::Cpu;
        return Ok(open_with_fallback(&choice, cell.threads, is_gpu)?.engine);
    }
    shared.open(&choice, cell.threads)
}

/// Drives a cell on its engine. `clock`, in seconds, times the ticks of a timed cell on a machine of this name; other
/// cells see no clock. A run that cannot start is a result too.
///
/// # Errors
/// [`ExperimentError::GpuFailed`] when the CPU took decisions in place of a GPU. That is no result of the cell: its times and its
/// `ran_on` would be wrong. The cell can be driven again.
pub fn run_cell(
    cell: &Cell,
    decider: impl Into<Decider>,
    clock: &mut dyn FnMut() -> f64,
    machine: &str,
) -> Result<CellFile, ExperimentError> {
    let mut no_clock = || 0.0;
    let is_timed = cell.timed || cell.row.latency;
    let mut observer =
        Observer { clock: if is_timed { clock } else { &mut no_clock }, on_tick: &mut |_| {} };
    let driven = cell.world.drive(cell.row.seed, &cell.config, decider, &mut observer);
    let row = match driven {
        Ok(run) => {
            check_gpu(&run)?;
            run.row
        }
        Err(error) => {
            RunRow { reason: Some(error.to_string()), ..cell.row.clone().without_success() }
        }
    };
    let mut row = row.named(&cell.row);
    if !is_timed {
        row = row.without_clock();
    } else if cell.row.latency {
        row.machine = Some(machine.to_owned());
        row.threads = Some(cell.threads);
    }
    Ok(CellFile { inputs: cell.inputs(), row })
}

/// Checks that the GPU of a run took all decisions.
fn check_gpu(run: &Run) -> Result<(), ExperimentError> {
    let incidents = run.result.as_ref().and_then(|result| result.incidents.as_ref());
    match incidents.filter(|incidents| incidents.on_cpu > 0) {
        None => Ok(()),
        Some(incidents) => Err(ExperimentError::GpuFailed {
            on_cpu: incidents.on_cpu,
            decisions: incidents.decisions,
            reason: incidents
                .messages
                .first()
                .map(|first| first.message.clone())
                .unwrap_or_default(),
        }),
    }
}
