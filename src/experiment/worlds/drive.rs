//! One run: a world's mission, driven on one thread.

use super::{RunKey, Verdict, WorldError};
use crate::bench::Latencies;
use crate::experiment::campaign::Row;
use crate::local::{CpuEngine, Engine};
use crate::runtime::{Config, MissionResult, Observer};
use crate::sim::{SimError, Simulation};

/// A world to be driven with a seed.
pub trait WorldTask: Sync {
    /// What a run leaves behind.
    type Row: Row<Key = RunKey> + Clone;

    /// Which run it is.
    fn key(&self) -> RunKey;

    /// The simulation: an empty map, and what is there in truth.
    ///
    /// # Errors
    /// When the world is too large for a grid, or something cannot move as told.
    fn simulation(&self) -> Result<Simulation, WorldError>;

    /// The row of a run with these figures; without a result where the navigator found no way to begin with.
    fn row(
        &self,
        config: &Config,
        figures: RunFigures,
        result: Option<&MissionResult>,
    ) -> Self::Row;
}

/// What is told of every run.
#[derive(Clone, Debug, PartialEq)]
pub struct RunFigures {
    /// How it ended.
    pub verdict: Verdict,
    /// Simulated time, seconds.
    pub time_s: f64,
    /// Way driven, metres.
    pub travelled_m: f64,
    /// Smallest true gap on the way, metres; none where no tick was driven.
    pub min_clearance_m: Option<f64>,
    /// Why the navigator gave up, where it did.
    pub fault: Option<String>,
    /// Wall-clock time of a decision, the median, milliseconds.
    pub decision_p50_ms: Option<f64>,
    /// The same, the 99th percentile.
    pub decision_p99_ms: Option<f64>,
}

/// Drives, on one thread; times each decision by `clock`, in seconds. Without a result where the navigator found no way
/// to begin with.
///
/// # Errors
/// When the world cannot be driven, or the configuration is not sound.
pub fn drive<T: WorldTask>(
    task: &T,
    config: &Config,
    clock: &mut dyn FnMut() -> f64,
) -> Result<(T::Row, Option<MissionResult>), WorldError> {
    drive_on(task, config, Box::new(CpuEngine::single_threaded()), clock)
}

/// The same on an engine of any kind.
///
/// # Errors
/// As [`drive`].
pub fn drive_on<T: WorldTask>(
    task: &T,
    config: &Config,
    engine: Box<dyn Engine>,
    clock: &mut dyn FnMut() -> f64,
) -> Result<(T::Row, Option<MissionResult>), WorldError> {
    let simulation = task.simulation()?;
    let mut observer = Observer {
        clock,
        on_tick: &mut |_| {},
    };
    let (figures, result) = match simulation.run(config, engine, &mut observer) {
        Ok(result) => (RunFigures::of(&result), Some(result)),
        Err(SimError::Fault(fault)) => (RunFigures::refused(fault.to_string()), None),
        Err(error) => {
            let world = task.key().world;
            return Err(WorldError::Sim { world, error });
        }
    };
    Ok((task.row(config, figures, result.as_ref()), result))
}

impl RunFigures {
    fn of(result: &MissionResult) -> Self {
        let mut times = Latencies::default();
        for &seconds in &result.decision_s {
            // A clock that ran backwards would give no time.
            let _ = times.record(seconds);
        }
        let times = times.summary();
        Self {
            verdict: Verdict::of(result),
            time_s: result.time_s,
            travelled_m: result.travelled_m,
            min_clearance_m: Some(result.min_clearance_m).filter(|gap_m| gap_m.is_finite()),
            fault: result.fault.as_ref().map(ToString::to_string),
            decision_p50_ms: times.map(|times| times.p50_ms),
            decision_p99_ms: times.map(|times| times.p99_ms),
        }
    }

    const fn refused(fault: String) -> Self {
        Self {
            verdict: Verdict::Failed,
            time_s: 0.0,
            travelled_m: 0.0,
            min_clearance_m: None,
            fault: Some(fault),
            decision_p50_ms: None,
            decision_p99_ms: None,
        }
    }
}
