//! Many simulated robots, one step at a time, for reinforcement learning.

use std::sync::{Arc, Mutex, PoisonError};

use inbye::experiment::World as ExperimentWorld;
use inbye::geometry::{Pose, Twist};
use inbye::global::Path;
use inbye::local::{Engine, EngineChoice, SharedEngines};
use inbye::navigator::Goal;
use inbye::runtime::{Config, LidarData, MissionRun, Observer, TickEvent};
use inbye::sim::{Episode, EpisodeEnd, SimulatedRobot, Simulation};
use numpy::{PyReadonlyArray2, PyReadwriteArray1, PyReadwriteArray2};
use pyo3::prelude::*;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use super::conversion::raise;
use super::drive::World;
use super::settings::changed;

/// Reward at the goal; contact costs as much.
const REACHED_REWARD: f64 = 10.0;

/// Largest number of robots that wait for a GPU at a time: the size of its batch.
const MOST_WAITING: usize = 256;

/// Who decides the velocities.
enum Driver {
    Caller(Box<Episode>),
    /// The lock lets threads share the whole; nothing waits for it.
    Navigator(Box<Mutex<MissionRun<SimulatedRobot>>>),
}

/// What an agent sees.
#[derive(Clone, Default)]
struct Seen {
    ranges: Vec<f32>,
    /// Goal in the robot's frame, metres.
    goal: [f64; 2],
    velocity: [f64; 2],
}

/// A mission that is going on.
struct Slot {
    driver: Driver,
    job: (usize, u64),
    goal: Goal,
    path: Path,
    progress_m: f64,
    seen: Seen,
    command: [f64; 2],
    time_s: f64,
}

/// How a mission ended.
struct Finished {
    outcome: &'static str,
    job: (usize, u64),
    time_s: f64,
    digest: Option<String>,
    seen: Seen,
}

/// Robots on missions in worlds, stepped together. A robot that has ended its mission begins the next one at once.
#[pyclass(module = "inbye")]
pub struct Environments {
    worlds: Vec<(ExperimentWorld, Arc<Config>)>,
    jobs: Vec<(usize, u64)>,
    next_job: usize,
    beams: usize,
    range_max: f64,
    is_navigator: bool,
    slots: Vec<Slot>,
    finished: Vec<Option<Finished>>,
    engine: EngineChoice,
    engines: SharedEngines,
    pool: ThreadPool,
}

impl Environments {
    fn start(&self, job: (usize, u64)) -> Result<Slot, String> {
        let (world, config) = &self.worlds[job.0];
        let made = world.simulation(job.1, config).map_err(|error| error.to_string())?;
        let engine = if self.is_navigator {
            let engine = self.engines.open(&self.engine, 1);
            Some(engine.map_err(|error| error.to_string())?)
        } else {
            None
        };
        Slot::start(&made.simulation, config, job, engine, self.range_max)
    }

    /// The jobs after the last one that was given out.
    fn take_jobs(&mut self, count: usize) -> Vec<(usize, u64)> {
        let jobs = (0..count).map(|index| self.jobs[(self.next_job + index) % self.jobs.len()]);
        let jobs = jobs.collect();
        self.next_job += count;
        jobs
    }
}

impl Slot {
    fn start(
        simulation: &Simulation,
        config: &Arc<Config>,
        job: (usize, u64),
        engine: Option<Box<dyn Engine>>,
        range_max: f64,
    ) -> Result<Self, String> {
        let text = |error: &dyn core::fmt::Display| error.to_string();
        let mission = &simulation.mission;
        let ends = (mission.start.position(), mission.goal.position);
        let (driver, path) = if let Some(engine) = engine {
            let robot = simulation.robot(config).map_err(|error| text(&error))?;
            let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
            let (mission, config) = (mission.clone(), Arc::clone(config));
            let run = MissionRun::new(mission, config, engine, robot, &mut observer);
            let run = run.map_err(|error| text(&error))?;
            let path = run.navigator().plans().first().map(|plan| plan.smoothed.clone());
            (Driver::Navigator(Box::new(Mutex::new(run))), path)
        } else {
            let obstacles = mission.map.obstacles(config.unknown);
            let mut planner = config.route_planner(mission.map.frame().resolution_m);
            let plan = planner.plan(&obstacles, ends.0, ends.1, &mut || 0.0);
            let episode = Episode::new(simulation, config).map_err(|error| text(&error))?;
            (Driver::Caller(Box::new(episode)), plan.ok().map(|plan| plan.smoothed))
        };
        let path = path.unwrap_or_else(|| Path::new(vec![ends.0, ends.1]));
        let mut slot = Self {
            driver,
            job,
            goal: mission.goal,
            path,
            progress_m: 0.0,
            seen: Seen::default(),
            command: [0.0; 2],
            time_s: 0.0,
        };
        if let Driver::Caller(episode) = &slot.driver {
            let (pose, twist) = (*episode.pose(), *episode.twist());
            let lidar = episode.sensed().lidar.as_ref();
            slot.seen = seen(&pose, &twist, lidar_ranges(lidar), &slot.goal, range_max);
        } else {
            slot.seen =
                seen(&mission.start, &Twist::STOP, [].iter().copied(), &slot.goal, range_max);
        }
        slot.progress_m = slot.path.project(&ends.0).arc_m;
        Ok(slot)
    }

    /// Drives for a control period. Returns the reward, and how the mission ended.
    fn step(
        &mut self,
        action: &Twist,
        range_max: f64,
    ) -> Result<(f64, Option<EpisodeEnd>), String> {
        let (pose, end) = match &mut self.driver {
            Driver::Caller(episode) => {
                let end = episode.step(action).map_err(|error| error.to_string())?;
                let (pose, twist) = (*episode.pose(), *episode.twist());
                let ranges = lidar_ranges(episode.sensed().lidar.as_ref());
                self.seen = seen(&pose, &twist, ranges, &self.goal, range_max);
                self.time_s = episode.time_s();
                self.command = [action.linear, action.angular];
                (pose, end)
            }
            Driver::Navigator(run) => {
                let run = run.get_mut().unwrap_or_else(PoisonError::into_inner);
                let (goal, last) = (&self.goal, &mut self.seen);
                let mut on_tick = |event: &TickEvent<'_>| {
                    let ranges = event.observation.scan.ranges.iter().copied();
                    *last = seen(&event.row.pose, &event.row.twist, ranges, goal, range_max);
                };
                let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut on_tick };
                let is_over = run.step(&mut observer).is_break();
                let last = run.trace().rows.last();
                let (pose, gap_m) =
                    last.map_or((Pose::default(), 1.0), |row| (row.pose, row.gap_m));
                self.time_s = last.map_or(0.0, |row| row.time_s);
                self.command =
                    last.map_or([0.0; 2], |row| [row.command.linear, row.command.angular]);
                let end = is_over.then(|| match run.is_reached() {
                    _ if gap_m <= 0.0 => EpisodeEnd::Contact,
                    true => EpisodeEnd::Reached,
                    false => EpisodeEnd::Timeout,
                });
                (pose, end)
            }
        };
        let progress_m = self.path.project(&pose.position()).arc_m;
        let mut reward = progress_m - self.progress_m;
        self.progress_m = progress_m;
        match end {
            Some(EpisodeEnd::Reached) => reward += REACHED_REWARD,
            Some(EpisodeEnd::Contact) => reward -= REACHED_REWARD,
            _ => {}
        }
        Ok((reward, end))
    }

    fn finish(self, end: EpisodeEnd) -> Finished {
        let digest = match self.driver {
            Driver::Caller(_) => None,
            Driver::Navigator(run) => {
                let run = run.into_inner().unwrap_or_else(PoisonError::into_inner);
                Some(run.result().trace.digest())
            }
        };
        let outcome = match end {
            EpisodeEnd::Reached => "reached",
            EpisodeEnd::Contact => "contact",
            EpisodeEnd::Timeout => "timeout",
        };
        Finished { outcome, job: self.job, time_s: self.time_s, digest, seen: self.seen }
    }
}

/// The ranges of a scan in the order of its beams.
fn lidar_ranges(lidar: Option<&LidarData>) -> Box<dyn Iterator<Item = f64> + '_> {
    match lidar {
        Some(LidarData::Scan(scan)) => Box::new(scan.ranges.iter().copied()),
        Some(LidarData::TimedScan(sweep)) => Box::new(sweep.beams.iter().map(|beam| beam.range)),
        None => Box::new(core::iter::empty()),
    }
}

/// Nothing within range reads as the longest range, and no measurement as zero.
fn seen(
    pose: &Pose,
    twist: &Twist,
    ranges: impl Iterator<Item = f64>,
    goal: &Goal,
    range_max: f64,
) -> Seen {
    let plain = |range: f64| if range.is_nan() { 0.0 } else { range.min(range_max) as f32 };
    let goal = pose.inverse_transform(&goal.position);
    Seen {
        ranges: ranges.map(plain).collect(),
        goal: [goal.x, goal.y],
        velocity: [twist.linear, twist.angular],
    }
}

/// Arrays of the caller that one step fills.
struct Arrays<'py> {
    ranges: PyReadwriteArray2<'py, f32>,
    goals: PyReadwriteArray2<'py, f64>,
    velocities: PyReadwriteArray2<'py, f64>,
}

impl Arrays<'_> {
    fn set(&mut self, index: usize, seen: &Seen) {
        let mut ranges = self.ranges.as_array_mut();
        let mut row = ranges.row_mut(index);
        row.fill(0.0);
        row.iter_mut().zip(&seen.ranges).for_each(|(to, from)| *to = *from);
        for axis in 0..2 {
            self.goals.as_array_mut()[[index, axis]] = seen.goal[axis];
            self.velocities.as_array_mut()[[index, axis]] = seen.velocity[axis];
        }
    }
}

#[pymethods]
impl Environments {
    #[new]
    #[pyo3(signature = (worlds, count, *, seeds, config=None, navigator=false, engine="cpu", threads=None))]
    fn new(
        worlds: Vec<Bound<'_, World>>,
        count: usize,
        seeds: Vec<u64>,
        config: Option<&Bound<'_, PyAny>>,
        navigator: bool,
        engine: &str,
        threads: Option<usize>,
    ) -> PyResult<Self> {
        if worlds.is_empty() || seeds.is_empty() || count == 0 {
            return Err(raise("there must be at least one world, one seed and one environment"));
        }
        let mut prepared = Vec::new();
        for world in &worlds {
            let world = &world.get().inner;
            let config = changed(&world.settings, config)?;
            config.validate().map_err(raise)?;
            prepared.push((world.clone(), Arc::new(config)));
        }
        let lidar = prepared[0].1.simulation.lidar;
        if prepared.iter().any(|(_, config)| config.simulation.lidar.beams != lidar.beams) {
            return Err(raise(
                "all worlds must have the same number of beams: set simulation.lidar.beams",
            ));
        }
        let jobs = seeds.iter().flat_map(|&seed| (0..prepared.len()).map(move |it| (it, seed)));
        let engine: EngineChoice = engine.parse().map_err(raise)?;
        // A robot waits in its thread for the answer of the GPU, which evaluates what all threads ask at that time.
        let usual = if engine == EngineChoice::Cpu { 1 } else { count.min(MOST_WAITING) };
        let threads = threads.unwrap_or(usual).max(1);
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().map_err(raise)?;
        Ok(Self {
            jobs: jobs.collect(),
            worlds: prepared,
            next_job: 0,
            beams: lidar.beams,
            range_max: lidar.range_max_m,
            is_navigator: navigator,
            slots: Vec::with_capacity(count),
            finished: (0..count).map(|_| None).collect(),
            engine,
            engines: SharedEngines::default(),
            pool,
        })
    }

    #[getter]
    const fn beams(&self) -> usize {
        self.beams
    }

    #[getter]
    const fn range_max(&self) -> f64 {
        self.range_max
    }

    /// Least and largest speed, and largest turn rate, of the robot of the first world.
    #[getter]
    fn speed_limits(&self) -> (f64, f64, f64) {
        let limits = &self.worlds[0].1.robot.limits;
        (limits.min_vel_x, limits.max_vel_x, limits.max_vel_theta)
    }

    /// Name of the world, and seed, of each robot's mission.
    #[getter]
    fn missions(&self) -> Vec<(&str, u64)> {
        let mission = |slot: &Slot| (&*self.worlds[slot.job.0].0.name, slot.job.1);
        self.slots.iter().map(mission).collect()
    }

    /// The velocities that the robots were last commanded.
    #[getter]
    fn commands(&self) -> Vec<[f64; 2]> {
        self.slots.iter().map(|slot| slot.command).collect()
    }

    /// Starts missions, the first ones from this job on, in the order of seeds and worlds.
    fn reset<'py>(
        &mut self,
        py: Python<'py>,
        first_job: usize,
        ranges: PyReadwriteArray2<'py, f32>,
        goals: PyReadwriteArray2<'py, f64>,
        velocities: PyReadwriteArray2<'py, f64>,
    ) -> PyResult<()> {
        self.next_job = first_job;
        let jobs = self.take_jobs(self.finished.len());
        let this = &*self;
        let slots: Result<Vec<_>, String> = py.detach(|| {
            this.pool.install(|| jobs.into_par_iter().map(|job| this.start(job)).collect())
        });
        self.slots = slots.map_err(raise)?;
        let mut arrays = Arrays { ranges, goals, velocities };
        self.slots.iter().enumerate().for_each(|(index, slot)| arrays.set(index, &slot.seen));
        Ok(())
    }

    /// Drives every robot for a control period, and starts the next mission of those that have ended theirs. The arrays get what
    /// the robots see then, the rewards, and 1 for a mission that ended or 2 for one whose time was up.
    #[expect(clippy::too_many_arguments, reason = "one array for each quantity")]
    fn step<'py>(
        &mut self,
        py: Python<'py>,
        actions: PyReadonlyArray2<'_, f64>,
        ranges: PyReadwriteArray2<'py, f32>,
        goals: PyReadwriteArray2<'py, f64>,
        velocities: PyReadwriteArray2<'py, f64>,
        mut rewards: PyReadwriteArray1<'_, f64>,
        mut ends: PyReadwriteArray1<'_, u8>,
    ) -> PyResult<()> {
        if self.slots.is_empty() {
            return Err(raise("call reset first"));
        }
        let rows = actions.as_array();
        if rows.dim() != (self.slots.len(), 2) {
            return Err(raise("actions need a row of speed and turn rate for each robot"));
        }
        let actions: Vec<Twist> =
            rows.rows().into_iter().map(|row| Twist::new(row[0], row[1])).collect();
        let range_max = self.range_max;
        let (slots, pool) = (&mut self.slots, &self.pool);
        let stepped: Result<Vec<_>, String> = py.detach(|| {
            let step = |(slot, action): (&mut Slot, &Twist)| slot.step(action, range_max);
            if pool.current_num_threads() == 1 {
                return slots.iter_mut().zip(&actions).map(step).collect();
            }
            pool.install(|| slots.par_iter_mut().zip(&actions).map(step).collect())
        });
        let stepped = stepped.map_err(raise)?;
        let over: Vec<usize> =
            (0..stepped.len()).filter(|&index| stepped[index].1.is_some()).collect();
        let jobs = self.take_jobs(over.len());
        let this = &*self;
        let started: Result<Vec<_>, String> = py.detach(|| {
            this.pool.install(|| jobs.into_par_iter().map(|job| this.start(job)).collect())
        });
        self.finished.iter_mut().for_each(|last| *last = None);
        for (index, new) in over.into_iter().zip(started.map_err(raise)?) {
            let old = std::mem::replace(&mut self.slots[index], new);
            self.finished[index] = stepped[index].1.map(|end| old.finish(end));
        }
        let mut arrays = Arrays { ranges, goals, velocities };
        for (index, ((reward, end), slot)) in stepped.iter().zip(&self.slots).enumerate() {
            arrays.set(index, &slot.seen);
            rewards.as_array_mut()[index] = *reward;
            ends.as_array_mut()[index] = match end {
                None => 0,
                Some(EpisodeEnd::Reached | EpisodeEnd::Contact) => 1,
                Some(EpisodeEnd::Timeout) => 2,
            };
        }
        Ok(())
    }

    /// How a robot's mission ended in the last step: outcome, world, seed, time, and digest of the trace. The arrays get what it
    /// saw last.
    fn finished<'py>(
        &self,
        index: usize,
        ranges: PyReadwriteArray2<'py, f32>,
        goals: PyReadwriteArray2<'py, f64>,
        velocities: PyReadwriteArray2<'py, f64>,
    ) -> Option<(&'static str, &str, u64, f64, Option<&str>)> {
        let finished = self.finished.get(index)?.as_ref()?;
        let mut arrays = Arrays { ranges, goals, velocities };
        arrays.set(0, &finished.seen);
        let (world, seed) = (&*self.worlds[finished.job.0].0.name, finished.job.1);
        Some((finished.outcome, world, seed, finished.time_s, finished.digest.as_deref()))
    }
}
