//! One trace, bit for bit, on every engine.

use inbye::local::{CpuEngine, Engine, FanArc, SampleStatus, Sampling};
use inbye::runtime::{Config, MissionResult, Observer, TickEvent};
use inbye::sim::Simulation;

use super::Test;
use super::driving::{mission, people, story, try_drive};
use super::ground::hall;

pub const TESTS: &[Test] = &[
    ("trace of a drive equals the golden digest", golden),
    ("trace is independent of the number of threads", threads),
    ("trace changes with the noise", noise),
    ("fan shows the evaluated window", fans),
];

pub const GPU_TESTS: [(&str, crate::support::adapters::GpuTest); 2] = [
    ("trace on the GPU equals that on the CPU", gpu),
    ("traces on a shared GPU equal that on the CPU", shared_gpu),
];

/// Digest of the short drive below. It changes only with a change to planning, navigation or simulation that is meant to
/// change decisions.
const GOLDEN: &str = "113ba0bdd1f43c766de2be7a2554a2a80944014ded72d17741615339b11fc873";

/// A short drive with a rotation, an unmapped wall, a crossing pedestrian, and a goal with a yaw.
fn short_drive() -> Simulation {
    let ground = hall(10.0, 6.0).wall([4.0, 0.0, 4.4, 2.5]);
    let mut task = mission(&ground, [1.5, 1.5, 3.0], [9.5, 5.0]);
    task.mission.goal.yaw = Some(-1.0);
    task.truth = Some(ground.wall([6.5, 3.0, 7.0, 3.6]).obstacles());
    task.moving_obstacles = people(
        &task,
        r#"[{"x": 5.2, "y": 6.0, "radius": 0.3, "speed": 0.6, "route": [[5.6, 1.0]]}]"#,
    );
    task
}

fn on(engine: impl Engine + 'static) -> MissionResult {
    let result = try_drive(&short_drive(), &Config::default(), Box::new(engine));
    let result = result.expect("a mission that can start");
    assert!(result.reached && !result.collided, "{}", story(&result));
    result
}

fn golden() {
    let result = on(CpuEngine::single_threaded());
    assert_eq!(result.trace.digest(), GOLDEN, "{}", story(&result));
}

fn threads() {
    let one = on(CpuEngine::single_threaded());
    for threads in [2, 3] {
        let several = on(CpuEngine::with_threads(threads).expect("threads"));
        assert_eq!(several.trace, one.trace);
        assert_eq!(several.trace.digest(), one.trace.digest());
    }
}

fn noise() {
    let mut task = short_drive();
    task.seed += 1;
    let engine = Box::new(CpuEngine::single_threaded());
    let other = try_drive(&task, &Config::default(), engine).expect("a mission that can start");
    assert_ne!(other.trace.digest(), on(CpuEngine::single_threaded()).trace.digest());
}

fn fans() {
    let (mut seen, mut unseen) = (0, 0);
    let mut on_tick = |moment: &TickEvent<'_>| {
        let Some(counts) = moment.decision.counts else {
            unseen += 1;
            assert_eq!(moment.fan(Sampling { vx_samples: 9, vtheta_samples: 9 }), None);
            return;
        };
        seen += 1;
        let all = Sampling { vx_samples: u32::MAX, vtheta_samples: u32::MAX };
        let whole = moment.fan(all).expect("samples were evaluated");
        let judged_by = |wanted: SampleStatus| {
            let is_so = |arc: &&FanArc| arc.status == wanted;
            whole.arcs.iter().filter(is_so).count() as u32
        };
        let by_engine = counts.to_array();
        let reasons = [
            SampleStatus::Ok,
            SampleStatus::Collision,
            SampleStatus::CannotStop,
            SampleStatus::Outside,
        ];
        assert_eq!(reasons.map(judged_by), by_engine);
        assert_eq!(whole.winner.is_some(), counts.admissible > 0);
        if let Some(winner) = &whole.winner {
            let chosen = &whole.arcs[winner.index as usize];
            assert_eq!(chosen.score, Some(winner.score));
            // The engine compares integers, so the winner of a near tie may differ here.
            let best = whole.arcs.iter().filter_map(|arc| arc.score).fold(f64::MIN, f64::max);
            assert!(best - winner.score < 1e-7, "{best} {}", winner.score);
        }
        let thin = moment.fan(Sampling { vx_samples: 4, vtheta_samples: 9 });
        let thin = thin.expect("as before").arcs;
        assert!(thin.len() <= 36 && thin.iter().all(|arc| whole.arcs.contains(arc)));
        assert_eq!((thin.first(), thin.last()), (whole.arcs.first(), whole.arcs.last()));
    };
    let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut on_tick };
    let engine = Box::new(CpuEngine::single_threaded());
    let driven = short_drive().run(&Config::default(), engine, &mut observer);
    // An observer that asks for fans changes nothing.
    assert_eq!(driven.expect("a mission that can start").trace.digest(), GOLDEN);
    assert!(seen > 50 && unseen > 0, "{seen} and {unseen}");
}

/// Robots that share an adapter, each in its own thread, drive as the one that has it alone.
fn shared_gpu(adapter: &inbye::local::Adapter) -> Result<(), libtest_mimic::Failed> {
    let shared = inbye::local::SharedEngine::new(Box::new(inbye::local::GpuEngine::new(adapter)?));
    let expected = on(CpuEngine::single_threaded()).trace.digest();
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..3).map(|_| scope.spawn(|| on(shared.clone()))).collect();
        for thread in threads {
            let driven = thread.join().expect("the mission can start");
            assert_eq!(driven.trace.digest(), expected);
        }
    });
    let (batches, decisions) = shared.counts();
    assert!(batches < decisions, "{batches} batches of {decisions} decisions");
    Ok(())
}

fn gpu(adapter: &inbye::local::Adapter) -> Result<(), libtest_mimic::Failed> {
    let on_gpu = on(inbye::local::GpuEngine::new(adapter)?);
    assert_eq!(on_gpu.trace.digest(), on(CpuEngine::single_threaded()).trace.digest());
    Ok(())
}
