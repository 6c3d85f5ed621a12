//! Runs to look at.

use std::sync::Arc;

use inbye::geometry::{Point, Pose};
use inbye::local::CpuEngine;
use inbye::navigator::Goal;
use inbye::report::{MissionView, Outcome, Reel, Report, html};
use inbye::sim::{Config, Mission, MissionResult, Observer, Walkers, crossing, run_mission};

/// A mission that was driven, and its reel.
pub struct Run {
    mission: Mission,
    config: Config,
    pub result: MissionResult,
    reel: Reel,
}

/// Through the crossing, among people.
pub fn short_run() -> Run {
    run(|_| ())
}

/// To and fro for so many ticks.
pub fn long_run(ticks: usize) -> Run {
    run(|mission| {
        let [there, back] = [mission.goal.position, mission.start.position()];
        let stop = |position: Point| Goal {
            position,
            yaw: None,
        };
        mission.via = (0..100).flat_map(|_| [stop(there), stop(back)]).collect();
        mission.time_limit_s = ticks as f64 * 0.1;
        mission.walkers = Walkers::default();
    })
}

fn run(change: impl FnOnce(&mut Mission)) -> Run {
    let scene = crossing();
    let goal = Goal {
        position: scene.goal,
        yaw: None,
    };
    let map = Arc::new(scene.map);
    // In the second crossing on the way.
    let people = r#"[{"x": 8.0, "y": 6.8, "radius": 0.3, "speed": 0.4, "route": [[8.0, 9.4]]}]"#;
    let ground = map.obstacles(Config::default().unknown);
    let walkers = Walkers::parse(people, "people.json", &ground, scene.seed);
    let mut mission = Mission {
        walkers: walkers.expect("people on the map"),
        ..Mission::new(map, scene.start, goal)
    };
    change(&mut mission);
    let config = Config::default();
    let mut reel = Reel::default();
    let mut observer = Observer {
        clock: &mut || 0.0,
        witness: &mut |moment| reel.take(moment),
    };
    let engine = Box::new(CpuEngine::single_threaded());
    let result = run_mission(&mission, &config, engine, &mut observer);
    Run {
        result: result.expect("a mission that can start"),
        mission,
        config,
        reel,
    }
}

impl Run {
    /// Its report.
    pub fn page(&self) -> String {
        page_of(core::slice::from_ref(self))
    }

    fn view(&self) -> MissionView<'_> {
        let result = &self.result;
        let plan = &result.plans[0];
        MissionView {
            title: "A run",
            command: "inbye",
            map: &self.mission.map,
            start: self.mission.start,
            goal: self.mission.goal.position,
            searched: plan.raw.points(),
            pruned: plan.pruned.points(),
            smoothed: plan.smoothed.points(),
            trace: &result.trace,
            footprint: &self.config.robot.footprint,
            latency_ms: &[],
            engine: &result.engine,
            outcome: Outcome {
                reached: result.reached,
                collided: result.collided,
                time_s: result.time_s,
                travelled_m: result.travelled_m,
                min_clearance_m: result.min_clearance_m,
                final_error: Pose::default(),
            },
            control_period_s: self.config.local.control_period_s,
            reel: Some(&self.reel),
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
