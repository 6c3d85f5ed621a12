//! One trace, bit for bit, whatever computes it.

use inbye::local::{CpuEngine, Engine};
use inbye::sim::{Config, Mission, MissionResult};

use crate::Test;
use crate::driving::{mission, people, story, try_drive};
use crate::ground::hall;

pub const TESTS: &[Test] = &[
    ("a drive is the same to the bit on every machine", golden),
    ("one thread and several leave the same trace", threads),
    ("other noise leaves another trace", noise),
];

#[cfg(feature = "gpu")]
pub const GPU_TESTS: [(&str, crate::adapters::GpuTest); 1] =
    [("a drive on the GPU leaves the CPU's trace", gpu)];

/// Of the short drive below. A change to planning, navigation or simulation that is meant to change decisions changes
/// it too; anything else must not.
const GOLDEN: &str = "7ffc877a7a0e93300b59ca5015a2cdcfb2bbaef38b7a6a796d3b5390f977f5df";

/// A short drive with a turn, a wall that the map does not show, somebody who crosses, and a yaw to park with.
fn short_drive() -> Mission {
    let ground = hall(10.0, 6.0).wall([4.0, 0.0, 4.4, 2.5]);
    let mut task = mission(&ground, [1.5, 1.5, 3.0], [9.5, 5.0]);
    task.goal.yaw = Some(-1.0);
    task.truth = Some(ground.wall([6.5, 3.0, 7.0, 3.6]).obstacles());
    task.walkers = people(
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
    assert_ne!(
        other.trace.digest(),
        on(CpuEngine::single_threaded()).trace.digest()
    );
}

#[cfg(feature = "gpu")]
fn gpu(adapter: &inbye::local::gpu::Adapter) -> Result<(), libtest_mimic::Failed> {
    let on_gpu = on(inbye::local::gpu::GpuEngine::new(adapter)?);
    assert_eq!(
        on_gpu.trace.digest(),
        on(CpuEngine::single_threaded()).trace.digest()
    );
    Ok(())
}
