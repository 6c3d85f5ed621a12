//! Answers and drives when a real device is lost.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

use inbye::geometry::Pose;
use inbye::local::internals::gpu::MAX_TABULATION_ROUNDS;
use inbye::local::{Adapter, GpuEngine, adapters};
use inbye::local::{
    CpuEngine, Detail, Engine, EngineError, Evaluation, Failover, GpuFailureKind, Incidents,
    Problem, QuantizedProblem,
};
use inbye::navigator::Goal;
use inbye::runtime::{Config, Mission, MissionResult, Observer};
use inbye::sim::{PedestrianSpawner, Simulation, crossing};
use libtest_mimic::Failed;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::extremes::plain;
use super::gpu_trials::window;

/// A problem that keeps an adapter busy for much more than a millisecond.
fn heavy(adapter: &Adapter) -> Result<QuantizedProblem, Failed> {
    let (side, steps) = if adapter.summary.software { (256, 20) } else { (2048, 1000) };
    let problem = Problem { window: window(side, side), steps, step_s: 0.01, ..plain() };
    Ok(QuantizedProblem::new(&problem)?)
}

/// More turn rates than one dispatch allows and no forward speed, so that no buffer is too large: no checked problem is
/// like this.
fn refused() -> Result<QuantizedProblem, Failed> {
    let mut problem =
        QuantizedProblem::new(&Problem { window: window(1, 1), steps: 1, ..plain() })?;
    problem.vx_samples.clear();
    problem.profiles = vec![problem.profiles[0]; MAX_TABULATION_ROUNDS as usize * 65_536];
    problem.header.steps = 0;
    Ok(problem)
}

fn kind_of(outcome: Result<Evaluation, EngineError>) -> Option<GpuFailureKind> {
    outcome.err().map(|error| error.failure_kind())
}

/// Neither the abandoned answer nor its buffers may appear later.
pub fn late_answers(adapter: &Adapter) -> Result<(), Failed> {
    let mut engine = GpuEngine::new(adapter)?;
    let late = heavy(adapter)?;
    let patience = Duration::from_secs(60);
    for attempt in 0..2 {
        engine.set_timeout(Duration::from_millis(1));
        let kind = kind_of(engine.evaluate(&late, Detail::Answer));
        if kind != Some(GpuFailureKind::TimedOut) {
            return Err(format!("attempt {attempt}: {kind:?}").into());
        }
        engine.set_timeout(patience);
        let next = QuantizedProblem::new(&Problem {
            pose: Pose::new(2.5, 2.5, f64::from(attempt)),
            ..plain()
        })?;
        let expected = CpuEngine::single_threaded().evaluate(&next, Detail::Samples)?;
        if engine.evaluate(&next, Detail::Samples)? != expected {
            return Err(format!("attempt {attempt}: not the answer to the next problem").into());
        }
    }
    Ok(())
}

/// Destroys the device at several moments of a decision: before, during and perhaps after it. The driver may still
/// finish, and then the answer is right. It is never half an answer, a panic or an endless wait.
pub fn lost_in_the_middle(adapter: &Adapter) -> Result<(), Failed> {
    let problem = heavy(adapter)?;
    let expected = CpuEngine::single_threaded().evaluate(&problem, Detail::Answer)?;
    for delay_ms in [0, 1, 5, 30] {
        let mut engine = GpuEngine::new(adapter)?;
        let destroy = engine.destroyer();
        let outcome = thread::scope(|scope| {
            scope.spawn(move || {
                thread::sleep(Duration::from_millis(delay_ms));
                destroy();
            });
            engine.evaluate(&problem, Detail::Answer)
        });
        let found = match outcome {
            Ok(answer) if answer == expected => None,
            Ok(_) => return Err(format!("a wrong answer after {delay_ms} ms").into()),
            Err(error) => Some(error.failure_kind()),
        };
        if found.is_some_and(|kind| kind != GpuFailureKind::DeviceLost) {
            return Err(format!("after {delay_ms} ms: {found:?}").into());
        }
        let next = kind_of(engine.evaluate(&QuantizedProblem::new(&plain())?, Detail::Answer));
        if next != Some(GpuFailureKind::DeviceLost) {
            return Err(format!("the next one after {delay_ms} ms: {next:?}").into());
        }
    }
    Ok(())
}

/// wgpu panics at a rejected call by default.
pub fn refused_calls(adapter: &Adapter) -> Result<(), Failed> {
    let mut engine = GpuEngine::new(adapter)?;
    match kind_of(engine.evaluate(&refused()?, Detail::Answer)) {
        Some(GpuFailureKind::Validation) => Ok(()),
        other => Err(format!("{other:?}").into()),
    }
}

/// A failure of a device at a decision.
#[derive(Clone, Copy, Debug)]
enum Blow {
    Destroyed,
    Slow,
    Refused,
    /// Simulated: other programs need the memory.
    OutOfMemory,
    Corrupted,
    /// The answer to the previous problem.
    Stale,
}

const BLOWS: [Blow; 10] = [
    Blow::Destroyed,
    Blow::Slow,
    Blow::Corrupted,
    Blow::Refused,
    Blow::Stale,
    Blow::Destroyed,
    Blow::OutOfMemory,
    Blow::Corrupted,
    Blow::Slow,
    Blow::Destroyed,
];

/// Scheduled failures, each after a number of answers.
type Plan = Arc<Mutex<VecDeque<(u32, Blow)>>>;

/// A real device with scheduled failures.
struct Battered {
    gpu: GpuEngine,
    plan: Plan,
    heavy: QuantizedProblem,
    last: Option<Evaluation>,
}

impl Battered {
    fn boxed(adapter: &Adapter, plan: &Plan) -> Result<Box<dyn Engine>, Failed> {
        Ok(Box::new(Self {
            gpu: GpuEngine::new(adapter)?,
            plan: Arc::clone(plan),
            heavy: heavy(adapter)?,
            last: None,
        }))
    }

    /// The failure that is due.
    fn blow(&self) -> Option<Blow> {
        let mut plan = self.plan.lock().expect("no thread panics");
        let (left, _) = plan.front_mut()?;
        if *left > 0 {
            *left -= 1;
            return None;
        }
        plan.pop_front().map(|(_, blow)| blow)
    }
}

impl Engine for Battered {
    fn name(&self) -> String {
        self.gpu.name()
    }

    fn evaluate(
        &mut self,
        problem: &QuantizedProblem,
        detail: Detail,
    ) -> Result<Evaluation, EngineError> {
        match self.blow() {
            None => {}
            Some(Blow::Destroyed) => self.gpu.destroyer()(),
            Some(Blow::Slow) => {
                self.gpu.set_timeout(Duration::from_millis(1));
                return self.gpu.evaluate(&self.heavy, detail);
            }
            Some(Blow::Refused) => {
                let refused = refused().expect("a problem to be refused");
                return self.gpu.evaluate(&refused, detail);
            }
            Some(Blow::OutOfMemory) => {
                return Err(EngineError::Lost {
                    adapter: self.name(),
                    kind: GpuFailureKind::OutOfMemory,
                    message: "as planned".to_owned(),
                });
            }
            Some(Blow::Corrupted) => {
                let mut answer = self.gpu.evaluate(problem, detail)?;
                match &mut answer.winner {
                    Some(winner) => winner.index ^= 1,
                    None => answer.counts.admissible += 1,
                }
                return Ok(answer);
            }
            Some(Blow::Stale) => return Ok(self.last.take().unwrap_or_default()),
        }
        let answer = self.gpu.evaluate(problem, detail)?;
        self.last = Some(answer.clone());
        Ok(answer)
    }
}

/// Around the pillars among people, back and forth: long enough for ten failures and the delays after them.
fn mission(config: &Config) -> Result<Simulation, Failed> {
    let scene = crossing();
    let goal = Goal::at;
    let ground = scene.map.obstacles(config.unknown);
    let (start, end) = (scene.start.position(), scene.goal);
    let spawner = PedestrianSpawner::new(3, scene.seed);
    let moving_obstacles = spawner.spawn(&ground, &[start, end], &[start, end], 0.5)?;
    Ok(Simulation {
        moving_obstacles,
        seed: 5,
        ..Simulation::new(Mission {
            via: [end, start].map(goal).to_vec(),
            time_limit_s: 400.0,
            ..Mission::new(Arc::new(scene.map), scene.start, goal(end))
        })
    })
}

fn drive(engine: Box<dyn Engine>) -> Result<MissionResult, Failed> {
    let mut config = Config::default();
    // Small enough for software adapters, which use the cores of the tests.
    config.local.vx_samples = 8;
    config.local.vtheta_samples = 16;
    config.local.sim_time_s = 2.0;
    let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
    let result = mission(&config)?.run(&config, engine, &mut observer)?;
    if result.reached && !result.collided {
        Ok(result)
    } else {
        Err(format!("{}, {:?}", result.time_s, result.fault).into())
    }
}

/// Ten failures at random decisions and two failed attempts to reopen the device: the trace is unchanged.
pub fn ten_losses(adapter: &Adapter) -> Result<(), Failed> {
    let rng = &mut Pcg64Mcg::seed_from_u64(10);
    // A hundred correct answers reset the delay.
    let mut later = || rng.random_range(100..=110);
    let plan: VecDeque<(u32, Blow)> = BLOWS.map(|blow| (later(), blow)).into();
    let plan: Plan = Arc::new(Mutex::new(plan));
    let expected = drive(Box::new(CpuEngine::single_threaded()))?.trace.digest();
    let first = Battered::boxed(adapter, &plan)?;
    let mut attempts = 0;
    let (wanted, its_plan) = (adapter.summary.clone(), Arc::clone(&plan));
    let source = move || {
        attempts += 1;
        if matches!(attempts, 2 | 5) {
            return Err(EngineError::NoAdapter);
        }
        let adapters = adapters();
        let found = adapters.iter().find(|one| one.summary == wanted);
        let again = found.ok_or(EngineError::NoAdapter)?;
        Ok(Battered::boxed(again, &its_plan).expect("the adapter opens again"))
    };
    let cpu = CpuEngine::single_threaded();
    let result = drive(Box::new(Failover::new(Ok(first), source, cpu)))?;
    if result.trace.digest() != expected {
        return Err("the trace is another one".into());
    }
    let met = result.incidents.ok_or("a failover keeps count")?;
    check_counts(&met)
}

fn check_counts(met: &Incidents) -> Result<(), Failed> {
    let expected = BTreeMap::from([
        (GpuFailureKind::DeviceLost, 3),
        (GpuFailureKind::TimedOut, 2),
        (GpuFailureKind::Validation, 1),
        (GpuFailureKind::OutOfMemory, 1),
        (GpuFailureKind::WrongAnswer, 3),
    ]);
    // Ten delays of 10 decisions, and one more of 20 after each failed attempt.
    if met.failures != expected || (met.reopened, met.reopen_failures, met.on_cpu) != (10, 2, 140) {
        return Err(format!("{met:#?}").into());
    }
    Ok(())
}
