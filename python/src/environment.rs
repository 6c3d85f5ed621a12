//! Many simulated robots, one step at a time, for reinforcement learning.

use std::collections::BTreeSet;
use std::process;
use std::sync::Arc;

use inbye::experiment::{
    RunOutcome, World as ExperimentWorld, run_in_order_checked, wall_clock_setting,
};
use inbye::geometry::Twist;
use inbye::local::{CpuEngine, EngineChoice, SharedEngines};
use inbye::runtime::Config;
use numpy::ndarray::Array2;
use numpy::{Ix2, PyArray1, PyArray2, PyArray3};
use pyo3::prelude::*;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use super::controller::Raised;
use super::conversion::{raise, real_array, table, whole};
use super::drive::World;
use super::interrupt::Interrupt;
use super::mission_slot::{AgentObservation, Commanded, Finished, Job, Slot};
use super::settings::changed;
use super::shared::Shared;

/// Largest number of robots that wait for a GPU at a time: the size of its batch.
const MOST_WAITING: usize = 256;

/// What robots see: ranges, goals and velocities, a row for each robot.
type SeenArrays<'py> =
    (Bound<'py, PyArray2<f32>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);

/// What robots were commanded: a row for each, and whether the protective layer changed it.
type CommandArrays<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<bool>>);

/// A mission that ended: index of its robot; outcome, world, seed, time, digest of the trace and reason; what the robot saw last.
type FinishedTuple<'py> =
    (usize, (&'static str, String, u64, f64, Option<String>, Option<String>), SeenArrays<'py>);

/// A step: what the robots see, rewards, ends, and the missions that ended.
type StepTuple<'py> =
    (SeenArrays<'py>, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<u8>>, Vec<FinishedTuple<'py>>);

/// Robots on missions in worlds, stepped together. A robot that has ended its mission begins the next one at once.
#[pyclass(frozen, module = "inbye")]
pub struct Environments {
    setup: Setup,
    state: Shared<State>,
}

/// What does not change.
struct Setup {
    worlds: Vec<(ExperimentWorld, Arc<Config>)>,
    jobs: Vec<Job>,
    count: usize,
    beams: usize,
    /// Longest range of the lidar, metres.
    farthest_m: f64,
    is_navigator: bool,
    /// Whether a robot whose mission has ended begins the next one.
    is_autoreset: bool,
    /// Steps after which the time of a mission is up.
    max_steps: u64,
    engine: EngineChoice,
    engines: SharedEngines,
    threads: usize,
    /// The threads of a step; none for one thread.
    pool: Option<ThreadPool>,
    /// The process that has them.
    process_id: u32,
}

/// The robots and their missions.
#[derive(Default)]
struct State {
    next_job: usize,
    /// Jobs that could not start the last time.
    refused: BTreeSet<Job>,
    slots: Vec<Slot>,
    /// What each robot was commanded in the last step, also where its mission then ended.
    commands: Vec<Commanded>,
}

impl State {
    /// Raises before the first reset.
    fn check_reset(&self) -> PyResult<()> {
        if self.slots.is_empty() { Err(raise("call reset first")) } else { Ok(()) }
    }
}

/// What a step did.
struct Stepped {
    seen: Vec<AgentObservation>,
    rewards: Vec<f64>,
    ends: Vec<Option<RunOutcome>>,
    /// Missions that ended, with the indices of their robots.
    finished: Vec<(usize, Finished)>,
}

impl Setup {
    /// Checks that the threads of the pool exist: a process that was forked has only the thread that called `fork`.
    fn check_process(&self) -> PyResult<()> {
        if self.pool.is_none() || self.process_id == process::id() {
            return Ok(());
        }
        Err(raise(
            "an environment with several threads was made in another process: make it in this process, or with threads=1",
        ))
    }

    /// Starts this many jobs, the next ones.
    ///
    /// # Errors
    /// When the engine cannot be opened, no job can start, or Python has a signal to handle.
    fn start(&self, state: &mut State, count: usize) -> PyResult<Vec<Slot>> {
        self.check_process()?;
        if count == 0 {
            return Ok(Vec::new());
        }
        let jobs: Vec<Job> =
            (0..count).map(|it| self.jobs[(state.next_job + it) % self.jobs.len()]).collect();
        state.next_job += count;
        let interrupt = Interrupt::new();
        let start = |&job: &Job| {
            let engine = self.is_navigator.then(|| self.engines.open(&self.engine, 1));
            let engine = engine.transpose().map_err(raise)?;
            let start = || Slot::start(&self.worlds[job.0], job, engine, self.farthest_m);
            Ok(interrupt.watch(&Raised::default(), start))
        };
        let check = || interrupt.check();
        let (slots, started) = run_in_order_checked(&jobs, self.threads, start, || {}, check);
        started?;
        for slot in &slots {
            let Some(reason) = slot.refusal() else {
                state.refused.remove(&slot.job);
                continue;
            };
            state.refused.insert(slot.job);
            if self.jobs.iter().all(|job| state.refused.contains(job)) {
                let (world, seed) = (&self.worlds[slot.job.0].0.name, slot.job.1);
                return Err(raise(format!(
                    "no mission can start; the last one, in {world} with seed {seed}: {reason}"
                )));
            }
        }
        Ok(slots)
    }

    /// Starts missions, the first ones from this job on. Returns what the robots see.
    fn reset(&self, state: &mut State, first_job: usize) -> PyResult<Vec<AgentObservation>> {
        state.next_job = first_job;
        state.slots = self.start(state, self.count)?;
        state.commands = vec![Commanded::default(); self.count];
        Ok(clone_seen(state))
    }

    /// Drives every robot for a control period.
    fn step(&self, state: &mut State, actions: &[Twist]) -> PyResult<Stepped> {
        self.check_process()?;
        state.check_reset()?;
        if state.slots.iter().any(Slot::has_ended) {
            return Err(raise("the episode has ended: call reset"));
        }
        let step = |(slot, action): (&mut Slot, &Twist)| slot.step(action, self.max_steps);
        let slots = &mut state.slots;
        let stepped: Vec<_> = match &self.pool {
            None => slots.iter_mut().zip(actions).map(step).collect(),
            Some(pool) => pool.install(|| slots.par_iter_mut().zip(actions).map(step).collect()),
        };
        state.commands = slots.iter().map(|slot| slot.command).collect();
        let finished: Vec<(usize, Finished)> = slots
            .iter_mut()
            .zip(&stepped)
            .enumerate()
            .filter_map(|(index, (slot, (_, end)))| Some((index, slot.finish((*end)?))))
            .collect();
        if self.is_autoreset {
            let started = self.start(state, finished.len())?;
            for ((index, _), new) in finished.iter().zip(started) {
                state.slots[*index] = new;
            }
        }
        let (rewards, ends) = stepped.into_iter().unzip();
        Ok(Stepped { seen: clone_seen(state), rewards, ends, finished })
    }

    /// Velocities of the caller. All of them are checked before a robot is stepped.
    fn actions(&self, actions: &Bound<'_, PyAny>) -> PyResult<Vec<Twist>> {
        let actions = real_array::<Ix2>("actions", actions)?;
        let rows = actions.as_array();
        if rows.dim() != (self.count, 2) {
            return Err(raise("actions need a row of speed and turn rate for each robot"));
        }
        let twists = rows.rows().into_iter().map(|row| Twist::new(row[0], row[1]));
        let twists: Vec<Twist> = twists.collect();
        // The navigator does not use them.
        let bad = twists.iter().position(|twist| !twist.is_finite() && !self.is_navigator);
        match bad {
            Some(row) => {
                Err(raise(format!("actions: row {row} is not finite: no robot was stepped")))
            }
            None => Ok(twists),
        }
    }

    fn tuple<'py>(&self, py: Python<'py>, index: usize, finished: Finished) -> FinishedTuple<'py> {
        let Finished { outcome, job: (world, seed), time_s, digest, reason, seen } = finished;
        let world = self.worlds[world].0.name.clone();
        let seen = self.seen_arrays(py, core::iter::once(&seen));
        (index, (outcome, world, seed, time_s, digest, reason), seen)
    }

    fn seen_arrays<'py, 'a>(
        &self,
        py: Python<'py>,
        seen: impl ExactSizeIterator<Item = &'a AgentObservation>,
    ) -> SeenArrays<'py> {
        let count = seen.len();
        let mut ranges = Array2::zeros((count, self.beams));
        let (mut goals, mut velocities) = (Array2::zeros((count, 2)), Array2::zeros((count, 2)));
        for (index, seen) in seen.enumerate() {
            ranges.row_mut(index).iter_mut().zip(&seen.ranges).for_each(|(to, from)| *to = *from);
            for axis in 0..2 {
                goals[[index, axis]] = seen.goal[axis];
                velocities[[index, axis]] = seen.velocity[axis];
            }
        }
        (
            PyArray2::from_owned_array(py, ranges),
            PyArray2::from_owned_array(py, goals),
            PyArray2::from_owned_array(py, velocities),
        )
    }
}

#[pymethods]
impl Environments {
    #[new]
    #[pyo3(signature = (worlds, count, *, seeds, config=None, navigator=false, autoreset=true, engine="cpu", threads=None, max_steps=None))]
    #[expect(clippy::too_many_arguments, reason = "Python names them")]
    fn new(
        worlds: Vec<Bound<'_, World>>,
        count: i128,
        seeds: Vec<i128>,
        config: Option<&Bound<'_, PyAny>>,
        navigator: bool,
        autoreset: bool,
        engine: &str,
        threads: Option<i128>,
        max_steps: Option<i64>,
    ) -> PyResult<Self> {
        let count: usize = whole("num_envs", count)?;
        let seeds = seeds.into_iter().map(|seed| whole("seed", seed));
        let seeds = seeds.collect::<PyResult<Vec<u64>>>()?;
        if worlds.is_empty() || seeds.is_empty() || count == 0 {
            return Err(raise("there must be at least one world, one seed and one environment"));
        }
        let mut prepared = Vec::new();
        for world in &worlds {
            let world = &world.get().inner;
            let config = changed(&world.settings, config)?;
            check_settings(&config, navigator)?;
            prepared.push((world.clone(), Arc::new(config)));
        }
        check_shared_settings(&prepared)?;
        let lidar = prepared[0].1.simulation.lidar;
        let jobs = seeds.iter().flat_map(|&seed| (0..prepared.len()).map(move |it| (it, seed)));
        let engine: EngineChoice = engine.parse().map_err(raise)?;
        // A robot waits in its thread for the answer of the GPU, which evaluates what all threads ask at that time.
        let usual = if engine == EngineChoice::Cpu { 1 } else { count.min(MOST_WAITING) };
        let threads = threads.map_or(Ok(usual), |threads| whole("threads", threads))?;
        if !(1..=CpuEngine::MAX_THREADS).contains(&threads) {
            let most = CpuEngine::MAX_THREADS;
            return Err(raise(format!("threads is {threads}: it must be 1 to {most}")));
        }
        // Gymnasium writes no limit so.
        let max_steps = max_steps.filter(|steps| *steps != -1);
        if let Some(steps) = max_steps.filter(|steps| *steps < 1) {
            return Err(raise(format!("max_episode_steps is {steps}: it must be at least 1")));
        }
        // A robot has one thread at a time.
        let threads = threads.min(count);
        let pool = (threads > 1).then(|| ThreadPoolBuilder::new().num_threads(threads).build());
        let pool = pool.transpose().map_err(raise)?;
        let setup = Setup {
            jobs: jobs.collect(),
            worlds: prepared,
            count,
            beams: lidar.beams,
            farthest_m: lidar.range_max_m,
            is_navigator: navigator,
            is_autoreset: autoreset,
            max_steps: max_steps.map_or(u64::MAX, i64::cast_unsigned),
            engine,
            engines: SharedEngines::default(),
            threads,
            pool,
            process_id: process::id(),
        };
        Ok(Self { setup, state: Shared::new(State::default()) })
    }

    /// Number of beams of the lidar.
    #[getter]
    const fn beams(&self) -> usize {
        self.setup.beams
    }

    /// Longest range of the lidar.
    #[getter]
    const fn range_max(&self) -> f64 {
        self.setup.farthest_m
    }

    /// Least and largest speed, and largest turn rate, of the robot.
    #[getter]
    fn speed_limits(&self) -> (f64, f64, f64) {
        let limits = &self.setup.worlds[0].1.robot.limits;
        (limits.min_vel_x, limits.max_vel_x, limits.max_vel_theta)
    }

    /// Name of the world, and seed, of each robot's mission.
    #[getter]
    fn missions(&self, py: Python<'_>) -> PyResult<Vec<(&str, u64)>> {
        let worlds = &self.setup.worlds;
        let mission = |slot: &Slot| (&*worlds[slot.job.0].0.name, slot.job.1);
        self.state.with(py, |state| state.slots.iter().map(mission).collect())
    }

    /// The velocities that the robots were commanded in the last step, within the limits of the base, and whether the protective layer
    /// then changed them.
    #[getter]
    fn commands<'py>(&self, py: Python<'py>) -> PyResult<CommandArrays<'py>> {
        let commands = self.state.with(py, |state| state.commands.clone())?;
        let velocities: Vec<_> = commands.iter().map(|command| command.velocity).collect();
        let is_protected = commands.iter().map(|command| command.is_protected);
        Ok((table(py, &velocities)?, PyArray1::from_iter(py, is_protected)))
    }

    /// Control period, seconds.
    #[getter]
    fn period_s(&self) -> f64 {
        self.setup.worlds[0].1.local.control_period_s
    }

    /// Each robot on its mission, seen from above.
    fn pictures<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyArray3<u8>>>> {
        let draw = |state: &mut State| {
            let pictures = || state.slots.iter().map(Slot::picture).collect::<Vec<_>>();
            state.check_reset().map(|()| pictures())
        };
        let pictures = self.state.with(py, draw)??;
        Ok(pictures.into_iter().map(|it| PyArray3::from_owned_array(py, it)).collect())
    }

    /// Starts missions, the first ones from this job on, in the order of seeds and worlds. Returns what the robots see.
    fn reset<'py>(&self, py: Python<'py>, first_job: usize) -> PyResult<SeenArrays<'py>> {
        let seen = self.state.with(py, |state| self.setup.reset(state, first_job))??;
        Ok(self.setup.seen_arrays(py, seen.iter()))
    }

    /// Drives every robot for a control period, and starts the next mission of those that have ended theirs. Returns what the robots
    /// see then, the rewards, 1 for a mission that ended or 2 for one whose time was up, and the missions that ended.
    fn step<'py>(&self, py: Python<'py>, actions: &Bound<'py, PyAny>) -> PyResult<StepTuple<'py>> {
        let actions = self.setup.actions(actions)?;
        let stepped = self.state.with(py, |state| self.setup.step(state, &actions))?;
        let Stepped { seen, rewards, ends, finished } = stepped?;
        let ends = ends.into_iter().map(|end| match end {
            None => 0,
            Some(RunOutcome::Timeout) => 2,
            Some(_) => 1,
        });
        Ok((
            self.setup.seen_arrays(py, seen.iter()),
            PyArray1::from_vec(py, rewards),
            PyArray1::from_vec(py, ends.collect()),
            finished.into_iter().map(|(index, it)| self.setup.tuple(py, index, it)).collect(),
        ))
    }
}

/// Rejects programs of the settings that the environments would not use, and settings that make a step depend on the wall clock.
fn check_settings(config: &Config, is_navigator: bool) -> PyResult<()> {
    if config.simulator.is_set() {
        return Err(raise(
            "simulator.command: environments use inbye's own simulator: leave it out, or use World.drive",
        ));
    }
    if config.global_planner.is_set() && !is_navigator {
        return Err(raise(
            "global_planner.command: without the navigator no program plans paths: leave it out, or set navigator=True",
        ));
    }
    if config.controller.is_set() && !is_navigator {
        return Err(raise(
            "controller.command: without the navigator the caller decides: leave it out, or set navigator=True",
        ));
    }
    if let Some(key) = wall_clock_setting(config).filter(|_| is_navigator) {
        return Err(raise(format!(
            "{key} makes a mission depend on the wall clock, and steps of an environment must not: leave it out"
        )));
    }
    Ok(())
}

/// The settings that define what an agent sees and what its actions do, with their keys.
fn shared_settings(config: &Config) -> [(&'static str, f64); 10] {
    let (lidar, limits) = (&config.simulation.lidar, &config.robot.limits);
    [
        ("simulation.lidar.beams", lidar.beams as f64),
        ("simulation.lidar.field_of_view_rad", lidar.field_of_view_rad),
        ("simulation.lidar.range_max_m", lidar.range_max_m),
        ("simulation.lidar.mount_x_m", lidar.mount_x_m),
        ("simulation.lidar.mount_y_m", lidar.mount_y_m),
        ("simulation.lidar.mount_yaw_rad", lidar.mount_yaw_rad),
        ("local.control_period_s", config.local.control_period_s),
        ("robot.limits.min_vel_x", limits.min_vel_x),
        ("robot.limits.max_vel_x", limits.max_vel_x),
        ("robot.limits.max_vel_theta", limits.max_vel_theta),
    ]
}

/// Rejects worlds of different robots: all missions share one space of observations and one of actions.
fn check_shared_settings(worlds: &[(ExperimentWorld, Arc<Config>)]) -> PyResult<()> {
    let [(first, config), others @ ..] = worlds else { return Ok(()) };
    let expected = shared_settings(config);
    let name = |world: &ExperimentWorld| format!("{} {}", world.kind.name(), world.name);
    for (world, config) in others {
        let pairs = expected.iter().zip(shared_settings(config));
        if let Some((&(key, one), (_, other))) = pairs.into_iter().find(|(one, it)| **one != *it) {
            return Err(raise(format!(
                "worlds: {key} is {one} in {} and {other} in {}, and all worlds of an environment must have the same: set it in config",
                name(first),
                name(world)
            )));
        }
    }
    Ok(())
}

/// What the robots see, for arrays that are filled with Python's lock.
fn clone_seen(state: &State) -> Vec<AgentObservation> {
    state.slots.iter().map(|slot| slot.seen().clone()).collect()
}
