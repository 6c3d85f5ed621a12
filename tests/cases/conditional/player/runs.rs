//! Simulated runs with a playback.

use std::sync::Arc;

use inbye::local::{CpuEngine, Engine};
use inbye::navigator::Goal;
use inbye::report::{MissionView, PlaybackRecorder, Report, html};
use inbye::runtime::{Config, Mission, MissionResult, Observer};
use inbye::sim::{MovingObstacles, Simulation, WrongPlanner, crossing};

use super::faulty::{FaultyBase, ObservedFaults, failing_engine};

/// A mission that was driven, and its playback.
pub struct Run {
    simulation: Simulation,
    config: Config,
    pub result: MissionResult,
    playback: PlaybackRecorder,
    /// The faults of each tick.
    pub observed: ObservedFaults,
}

/// A mission through the crossing, with a pedestrian.
pub fn short_run() -> Run {
    run(with_pedestrian(), &Config::default(), engine(), None)
}

/// A mission back and forth, with a number of ticks.
pub fn long_run(ticks: usize) -> Run {
    run(back_and_forth(ticks), &Config::default(), engine(), None)
}

/// A planner that drives at walls under the protective layer, for a while.
pub fn protected_run() -> Run {
    let mut config = Config::default();
    config.simulation.wrong_planner = WrongPlanner::Obstacles;
    run(back_and_forth(150), &config, engine(), None)
}

/// The mission back and forth, with many faults.
pub fn faulty_run(ticks: usize) -> Run {
    let simulation = back_and_forth(ticks);
    let mut config = Config::default();
    // Odometry is the only source of the pose.
    config.simulation.fixes.rate_hz = 0.0;
    let mut base = FaultyBase::new(&simulation, &config);
    run(simulation, &config, failing_engine(), Some(&mut base))
}

fn engine() -> Box<dyn Engine> {
    Box::new(CpuEngine::single_threaded())
}

fn with_pedestrian() -> Simulation {
    let scene = crossing();
    let goal = Goal::at(scene.goal);
    let map = Arc::new(scene.map);
    // It stands in the second crossing of the path.
    let obstacles = r#"[{"x": 8.0, "y": 6.8, "radius": 0.3, "speed": 0.4, "route": [[8.0, 9.4]]}]"#;
    let ground = map.obstacles(Config::default().unknown);
    let moving_obstacles = MovingObstacles::parse(obstacles, "obstacles.json", &ground, scene.seed);
    Simulation {
        moving_obstacles: moving_obstacles.expect("the obstacle is on the map"),
        ..Simulation::new(Mission::new(map, scene.start, goal))
    }
}

fn back_and_forth(ticks: usize) -> Simulation {
    let mut simulation = with_pedestrian();
    let [there, back] = [simulation.mission.goal.position, simulation.mission.start.position()];
    simulation.mission.via = (0..100).flat_map(|_| [Goal::at(there), Goal::at(back)]).collect();
    simulation.mission.time_limit_s = ticks as f64 * 0.1;
    simulation.moving_obstacles = MovingObstacles::default();
    simulation
}

fn run(
    simulation: Simulation,
    config: &Config,
    engine: Box<dyn Engine>,
    base: Option<&mut FaultyBase>,
) -> Run {
    let (mut playback, mut observed) = (PlaybackRecorder::default(), ObservedFaults::default());
    let mut observer = Observer {
        clock: &mut || 0.0,
        on_tick: &mut |event| {
            playback.record(event);
            observed.record(event);
        },
    };
    let result = match base {
        Some(base) => simulation.run_with(base, config, engine, &mut observer),
        None => simulation.run(config, engine, &mut observer),
    };
    let mut result = result.expect("a mission that can start");
    // Pages without decision times are the same for the same run.
    result.decision_s.clear();
    Run { result, simulation, config: config.clone(), playback, observed }
}

impl Run {
    /// Its report.
    pub fn page(&self) -> String {
        page_of(core::slice::from_ref(self))
    }

    fn view(&self) -> MissionView<'_> {
        MissionView {
            title: "A run",
            command: "inbye",
            mission: &self.simulation.mission,
            config: &self.config,
            result: &self.result,
            playback: Some(&self.playback),
            facts: &[],
        }
    }
}

/// A report of several.
pub fn page_of(runs: &[Run]) -> String {
    html(&Report {
        title: "Runs",
        missions: runs.iter().map(Run::view).collect(),
        ..Report::default()
    })
}
