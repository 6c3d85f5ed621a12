//! One robot of the environments on its mission.

use std::sync::Arc;

use inbye::base::ProtectiveAction;
use inbye::experiment::{ExperimentError, RunOutcome, World};
use inbye::geometry::{Pose, Twist};
use inbye::global::Path;
use inbye::local::Engine;
use inbye::map::{OccupancyGrid, Scan};
use inbye::navigator::Goal;
use inbye::robot::Footprint;
use inbye::runtime::{Config, Mission, MissionEnd, MissionError, MissionRun, Observer, TickEvent};
use inbye::sim::{Episode, Lidar, SimError, SimulatedRobot, Simulation, first_path};
use numpy::ndarray::Array3;

use super::picture::Scene;

/// Reward at the goal; contact costs as much.
const REACHED_REWARD: f64 = 10.0;

/// A world of the list, and a seed.
pub type Job = (usize, u64);

/// Who decides the velocities.
enum Driver {
    Caller(Box<Episode>),
    Navigator(Box<MissionRun<SimulatedRobot>>),
    /// The mission could not start: its only step ends it, for this reason.
    Refused(RunOutcome, String),
    /// The mission has ended, and no other one follows.
    Ended,
}

/// What an agent sees.
#[derive(Clone, Default)]
pub struct AgentObservation {
    pub ranges: Vec<f32>,
    /// Goal in the robot's frame, metres.
    pub goal: [f64; 2],
    pub velocity: [f64; 2],
}

/// What an agent is shown: the goal, and the ranges of a lidar.
struct View {
    goal: Goal,
    lidar: Lidar,
    /// Longest range that is shown, metres.
    farthest_m: f64,
    footprint: Footprint,
    /// None where there is no mission.
    map: Option<Arc<OccupancyGrid>>,
}

/// What is seen at a tick: by the agent, and in a picture.
#[derive(Default)]
struct Seen {
    agent: AgentObservation,
    pose: Pose,
    scan: Scan,
}

impl View {
    /// Nothing within range reads as the longest range, and no measurement as zero.
    fn seen(&self, pose: &Pose, twist: &Twist, scan: &Scan) -> Seen {
        let plain =
            |range: f64| if range.is_nan() { 0.0 } else { range.min(self.farthest_m) as f32 };
        let goal = pose.inverse_transform(&self.goal.position);
        let agent = AgentObservation {
            ranges: self.lidar.ranges_in_fixed_directions(scan).into_iter().map(plain).collect(),
            goal: [goal.x, goal.y],
            velocity: [twist.linear, twist.angular],
        };
        Seen { agent, pose: *pose, scan: scan.clone() }
    }

    fn seen_in(&self, episode: &Episode) -> Seen {
        self.seen(episode.pose(), episode.twist(), episode.scan())
    }
}

/// What a robot was commanded for a control period.
#[derive(Clone, Copy, Default)]
pub struct Commanded {
    /// Within the limits of the base, m/s and rad/s.
    pub velocity: [f64; 2],
    /// Whether the protective layer then changed it.
    pub is_protected: bool,
}

impl Commanded {
    const fn new(command: &Twist, action: &ProtectiveAction) -> Self {
        let Twist { linear, angular } = *command;
        Self { velocity: [linear, angular], is_protected: !action.passes() }
    }
}

/// A mission that is going on.
pub struct Slot {
    driver: Driver,
    pub job: Job,
    view: View,
    path: Path,
    progress_m: f64,
    seen: Seen,
    /// The command of the last step.
    pub command: Commanded,
    /// What the navigator has decided from what is seen now.
    decided: Commanded,
    time_s: f64,
    steps: u64,
}

/// How a mission ended.
pub struct Finished {
    pub outcome: &'static str,
    pub job: Job,
    pub time_s: f64,
    pub digest: Option<String>,
    /// Why the goal was not reached, where the navigator drove or the mission did not start.
    pub reason: Option<String>,
    pub seen: AgentObservation,
}

impl Slot {
    /// Puts a robot at the start of a mission; inbye drives it with the engine, or the caller without one. A mission that cannot
    /// start has an outcome like any other: that of a single run.
    pub fn start(
        (world, config): &(World, Arc<Config>),
        job: Job,
        engine: Option<Box<dyn Engine>>,
        farthest_m: f64,
    ) -> Self {
        let view = |goal, map| View {
            goal,
            lidar: config.simulation.lidar,
            farthest_m,
            footprint: config.robot.footprint.clone(),
            map,
        };
        let outcome = |error: &SimError| match error {
            SimError::Mission(MissionError::Fault(_)) => RunOutcome::Failed,
            _ => RunOutcome::Error,
        };
        let simulation = match world.simulation(job.1, config) {
            Ok(made) => made.simulation,
            Err(error) => {
                let outcome = match &error {
                    ExperimentError::Simulation(error) => outcome(error),
                    _ => RunOutcome::Error,
                };
                let view = view(Goal::at(Pose::default().position()), None);
                let refused = Driver::Refused(outcome, error.to_string());
                return Self::new(refused, job, &Pose::default(), view, None);
            }
        };
        let (driver, path) = driver(&simulation, config, engine)
            .unwrap_or_else(|error| (Driver::Refused(outcome(&error), error.to_string()), None));
        let Mission { start, goal, map, .. } = &simulation.mission;
        Self::new(driver, job, start, view(*goal, Some(Arc::clone(map))), path)
    }

    fn new(driver: Driver, job: Job, start: &Pose, view: View, path: Option<Path>) -> Self {
        let path = path.unwrap_or_else(|| Path::new(vec![start.position(), view.goal.position]));
        let seen = match &driver {
            Driver::Caller(episode) => view.seen_in(episode),
            _ => view.seen(start, &Twist::STOP, &Scan::default()),
        };
        let progress_m = path.project(&start.position()).arc_m;
        let (command, decided) = Default::default();
        let (time_s, steps) = (0.0, 0);
        let mut slot =
            Self { driver, job, view, path, progress_m, seen, command, decided, time_s, steps };
        // The first tick has the first scan; the caller sees what the navigator decides from.
        if let Driver::Navigator(run) = &mut slot.driver {
            (slot.seen, slot.decided) = tick(run, &slot.view).unwrap_or_default();
        }
        slot
    }

    /// What the agent sees now.
    pub const fn seen(&self) -> &AgentObservation {
        &self.seen.agent
    }

    /// The robot now, seen from above; two by two black pixels where there is no mission.
    pub fn picture(&self) -> Array3<u8> {
        let Some(map) = &self.view.map else { return Array3::zeros((2, 2, 3)) };
        let View { goal, footprint, .. } = &self.view;
        let Seen { pose, scan, .. } = &self.seen;
        let goal = goal.position;
        Scene { map, path: &self.path, goal, footprint, pose: *pose, scan }.picture()
    }

    /// Why the mission could not start, if it could not.
    pub const fn refusal(&self) -> Option<&String> {
        match &self.driver {
            Driver::Refused(_, reason) => Some(reason),
            _ => None,
        }
    }

    /// Whether the mission has ended and no other one follows.
    pub const fn has_ended(&self) -> bool {
        matches!(self.driver, Driver::Ended)
    }

    /// Drives for a control period. Returns the reward, and how the mission ended: its time is up after this many steps.
    pub fn step(&mut self, action: &Twist, max_steps: u64) -> (f64, Option<RunOutcome>) {
        self.steps += 1;
        let (pose, end) = match &mut self.driver {
            Driver::Caller(episode) => {
                // The actions are finite: all were checked before the first robot was stepped.
                let end = episode.step(action).unwrap_or(None);
                self.seen = self.view.seen_in(episode);
                self.time_s = episode.time_s();
                self.command = Commanded::new(episode.command(), &episode.protective_action());
                (*episode.pose(), end)
            }
            Driver::Navigator(run) => {
                self.command = self.decided;
                // A mission may have ended at its first tick.
                if let Some((seen, decided)) = tick(run, &self.view) {
                    (self.seen, self.decided) = (seen, decided);
                }
                let last = run.trace().rows.last();
                self.time_s = last.map_or(0.0, |row| row.time_s);
                (last.map_or_else(Pose::default, |row| row.pose), run.end())
            }
            Driver::Refused(outcome, _) => return (0.0, Some(*outcome)),
            Driver::Ended => return (0.0, None),
        };
        let progress_m = self.path.project(&pose.position()).arc_m;
        let mut reward = progress_m - self.progress_m;
        self.progress_m = progress_m;
        match end {
            Some(MissionEnd::Reached) => reward += REACHED_REWARD,
            Some(MissionEnd::Contact) => reward -= REACHED_REWARD,
            _ => {}
        }
        let is_late = self.steps >= max_steps;
        (reward, end.map(RunOutcome::from).or(is_late.then_some(RunOutcome::Timeout)))
    }

    /// Ends the mission with this outcome.
    pub fn finish(&mut self, outcome: RunOutcome) -> Finished {
        let (digest, reason) = match core::mem::replace(&mut self.driver, Driver::Ended) {
            Driver::Caller(_) | Driver::Ended => (None, None),
            Driver::Navigator(run) => {
                let result = run.result();
                (Some(result.trace.digest()), result.why())
            }
            Driver::Refused(_, reason) => (None, Some(reason)),
        };
        let (job, time_s, seen) = (self.job, self.time_s, self.seen.agent.clone());
        Finished { outcome: outcome.name(), job, time_s, digest, reason, seen }
    }
}

/// Runs the next tick of a mission. Returns what is seen at it, and what the navigator decides; none where the mission is over.
fn tick(run: &mut MissionRun<SimulatedRobot>, view: &View) -> Option<(Seen, Commanded)> {
    let mut last = None;
    let mut on_tick = |event: &TickEvent<'_>| {
        let seen = view.seen(&event.row.pose, &event.row.twist, &event.observation.scan);
        last = Some((seen, Commanded::new(&event.row.command, event.protective_action)));
    };
    let _ = run.step(&mut Observer { clock: &mut || 0.0, on_tick: &mut on_tick });
    last
}

/// What drives the robot, and the path along which progress counts; none where no path was found.
fn driver(
    simulation: &Simulation,
    config: &Arc<Config>,
    engine: Option<Box<dyn Engine>>,
) -> Result<(Driver, Option<Path>), SimError> {
    let mission = &simulation.mission;
    let Some(engine) = engine else {
        let episode = Episode::new(simulation, config)?;
        return Ok((Driver::Caller(Box::new(episode)), first_path(mission, config).ok()));
    };
    let robot = simulation.robot(config)?;
    let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
    let run = MissionRun::new(mission.clone(), Arc::clone(config), engine, robot, &mut observer)?;
    let path = run.navigator().plans().first().map(|plan| plan.smoothed.clone());
    Ok((Driver::Navigator(Box::new(run)), path))
}
