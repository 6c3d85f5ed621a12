//! Short drives to record, and files to record them in.

use core::ops::ControlFlow;
use std::io::{self, Cursor, Write};
use std::sync::{Arc, Mutex};

use crate::support::room;
use inbye::geometry::{Point, Pose};
use inbye::local::{CpuEngine, Engine};
use inbye::map::OccupancyGrid;
use inbye::navigator::Goal;
use inbye::recording::{
    BackpressurePolicy, DriveMetadata, Reader, Recorder, RecordingError, RecordingReport, Replay,
    replay,
};
use inbye::runtime::{Config, Mission, MissionResult, Observer, TickEvent};
use inbye::sim::{Simulation, crossing};

/// A shared file in memory.
#[derive(Clone, Default)]
pub struct Memory(Arc<Mutex<Vec<u8>>>);

impl Memory {
    pub fn bytes(&self) -> Vec<u8> {
        self.0.lock().expect("no panic").clone()
    }
}

impl Write for Memory {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().expect("no panic").extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Rows of a room of 12 by 5.2 m with a pillar, highest first, in cells of 0.2 m.
pub fn rows() -> Vec<String> {
    room::rows(60, 26, &[(28..31, 11..15)])
}

/// A drive through the room with a waypoint and a crossing pedestrian.
pub fn tour() -> (Simulation, Config) {
    let origin = Pose::new(-1.0 / 3.0, 0.1, 0.0);
    let map = OccupancyGrid::from_rows(&rows(), 0.2, origin).expect("rows of equal length");
    let goal = |x, y, yaw| Goal { position: Point::new(x, y), yaw };
    let mut config = Config::default();
    config.navigator.waypoint_pause_s = 1.0;
    let map = Arc::new(map);
    let known = map.obstacles(config.unknown);
    let way = [Point::new(1.2, 2.5), Point::new(10.0, 2.5)];
    let spawner = config.simulation.pedestrians.spawner(1, 3);
    let moving_obstacles = spawner.spawn(&known, &way, &way, 0.5).expect("enough space");
    let simulation = Simulation {
        moving_obstacles,
        seed: 3,
        ..Simulation::new(Mission {
            via: vec![goal(5.0, 4.0, Some(1.0))],
            time_limit_s: 40.0,
            ..Mission::new(map, Pose::new(1.2, 2.5, 0.0), goal(9.5, 2.5, None))
        })
    };
    (simulation, config)
}

/// The tour with an unmapped obstacle, late decisions and asynchronous plans, as on a real robot: every seventh reading of the
/// clock is late.
pub fn late_tour() -> (Simulation, Config, impl FnMut() -> f64) {
    let (mut simulation, mut config) = tour();
    let mut truth = simulation.mission.map.obstacles(config.unknown);
    truth.fill_disc(&Point::new(3.0, 3.0), 0.4);
    simulation.truth = Some(truth);
    config.navigator.deadline_s = Some(0.05);
    config.navigator.wait_for_plans = false;
    let (mut now_s, mut reading) = (0.0, 0_u64);
    let clock = move || {
        reading += 1;
        // A decision reads the clock twice, so every second late reading is within a decision.
        now_s += if reading.is_multiple_of(7) { 0.2 } else { 0.001 };
        now_s
    };
    (simulation, config, clock)
}

pub fn cpu(threads: usize) -> Box<dyn Engine> {
    Box::new(CpuEngine::with_threads(threads).expect("threads"))
}

/// Records a mission in a file, with a clock.
pub fn record_by<W: Write + Send + 'static>(
    (simulation, config): (&Simulation, &Config),
    clock: &mut dyn FnMut() -> f64,
    file: W,
    policy: BackpressurePolicy,
) -> (MissionResult, RecordingReport) {
    let engine = cpu(1);
    let metadata = DriveMetadata::new(&simulation.mission, config, engine.name());
    let mut recorder = Recorder::new(file, &metadata, policy).expect("space for the metadata");
    let mut on_tick = |moment: &TickEvent<'_>| {
        recorder.record(moment);
    };
    let mut observer = Observer { clock, on_tick: &mut on_tick };
    let result = simulation.run(config, engine, &mut observer).expect("a valid mission");
    let recorded = recorder.finish(result.trace.digest());
    (result, recorded)
}

/// Records a mission in memory.
pub fn record(simulation: &Simulation, config: &Config) -> (MissionResult, Vec<u8>) {
    let file = Memory::default();
    let mut clock = || 0.0;
    let (result, recorded) =
        record_by((simulation, config), &mut clock, file.clone(), BackpressurePolicy::Block);
    assert_eq!(recorded.stopped, None);
    let bytes = file.bytes();
    assert_eq!(recorded.bytes, bytes.len() as u64);
    (result, bytes)
}

/// A crossing with pedestrians, for a few seconds.
pub fn crowded() -> (Simulation, Config) {
    let scene = crossing();
    let config = Config::default();
    let known = scene.map.obstacles(config.unknown);
    let way = [scene.start.position(), scene.goal];
    let spawner = config.simulation.pedestrians.spawner(4, 5);
    let moving_obstacles = spawner.spawn(&known, &way, &way, 0.5).expect("enough space");
    let simulation =
        Simulation { moving_obstacles, seed: 5, ..Simulation::new(scene.mission(12.0)) };
    (simulation, config)
}

pub fn replay_on(file: &[u8], engine: Box<dyn Engine>) -> Replay {
    try_replay_on(file, engine).expect("a whole or truncated file")
}

pub fn try_replay_on(file: &[u8], engine: Box<dyn Engine>) -> Result<Replay, RecordingError> {
    let mut recording = Reader::open(Cursor::new(file)).expect("a recording");
    replay(&mut recording, engine, None, &mut |_| ControlFlow::Continue(()))
}
