//! Single decisions.

use core::ffi::c_char;
use core::panic::AssertUnwindSafe;
use core::str::FromStr;
use std::thread;
use std::time::Instant;

use inbye::bench::{DecisionSize, EngineRequest, EvaluationDigest, open_requested};
use inbye::local::{DecisionInput, Detail, Engine, Explainer, QuantizedProblem};

use crate::error::{array, boxed, free, guarded, object, object_mut, place, text};
use crate::map::{InbyeConfig, InbyeMap};
use crate::values::{InbyeMovingDisc, InbyePoint, InbyePose, InbyeTwist};

/// Evaluates samples on the CPU or on a GPU, with the same bits.
pub struct InbyeEngine(Box<dyn Engine>);

/// The inputs of one decision.
#[repr(C)]
pub struct InbyeProblem {
    pub pose: InbyePose,
    /// Measured velocity.
    pub velocity: InbyeTwist,
    /// The command of the last tick.
    pub last_command: InbyeTwist,
    /// The robot faces it at the end of the horizon. Its distance to the robot is limited, to 32 to 64 m
    /// depending on the resolution of the map: 51 m at 0.05 m.
    pub target: InbyePoint,
    /// The key node: the trajectory ends near it. Its distance to the robot has the same limit.
    pub key_node: InbyePoint,
    /// Moving obstacles, and their number.
    pub obstacles: *const InbyeMovingDisc,
    pub obstacle_count: usize,
}

/// The answer to one problem.
#[repr(C)]
pub struct InbyeDecision {
    /// Whether a sample is admissible. If not, the robot must stop.
    pub has_command: bool,
    /// Velocity of the best sample, and its index.
    pub command: InbyeTwist,
    pub index: u32,
    /// Numbers of samples.
    pub admissible: u32,
    pub collision: u32,
    pub cannot_stop: u32,
    pub outside: u32,
    /// SHA-256 of the exact bits of all samples, 64 hexadecimal digits and a zero, as `inbye evaluate` prints it. Only
    /// inbye_decide_with_digest computes it; from inbye_decide it is empty.
    pub digest: [c_char; 65],
}

/// Opens an engine: "auto", the fastest for decisions of the default size, "cpu", "gpu" or "gpu:NAME", with up to 1024 threads of the
/// CPU; 0 counts as 1. Returns null on failure.
///
/// # Safety
/// `name` points to a text that ends with zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn inbye_engine_open(
    name: *const c_char,
    threads: usize,
) -> *mut InbyeEngine {
    boxed(AssertUnwindSafe(|| {
        // SAFETY: the caller vouches for the text.
        let name = unsafe { text(name, "name") }?;
        let request = EngineRequest::from_str(name)?;
        let size = DecisionSize::default();
        let started = Instant::now();
        let clock = &mut || started.elapsed().as_secs_f64();
        let engine = open_requested(&request, &size, threads, clock, &mut thread::sleep);
        Ok(InbyeEngine(engine.map_err(|error| error.to_string())?))
    }))
}

/// Frees an engine.
///
/// # Safety
/// `engine` is null or an engine that was not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn inbye_engine_free(engine: *mut InbyeEngine) {
    // SAFETY: the caller vouches for the engine.
    unsafe { free(engine) };
}

/// Takes one decision. Limits, footprint and samples are those of the configuration. Where zones of the map limit the speed, the
/// limits are lower, as a navigator has them there; a robot that is faster brakes.
///
/// # Safety
/// `engine`, `map` and `config` are alive; `problem` can be read, and so can its obstacles; `decision` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn inbye_decide(
    engine: *mut InbyeEngine,
    map: *const InbyeMap,
    config: *const InbyeConfig,
    problem: *const InbyeProblem,
    decision: *mut InbyeDecision,
) -> bool {
    // SAFETY: the caller vouches for all of them.
    unsafe { decide(engine, map, config, problem, decision, Detail::Answer) }
}

/// As inbye_decide, with the digest of all samples, which takes longer.
///
/// # Safety
/// As for inbye_decide.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn inbye_decide_with_digest(
    engine: *mut InbyeEngine,
    map: *const InbyeMap,
    config: *const InbyeConfig,
    problem: *const InbyeProblem,
    decision: *mut InbyeDecision,
) -> bool {
    // SAFETY: the caller vouches for all of them.
    unsafe { decide(engine, map, config, problem, decision, Detail::Samples) }
}

/// Takes one decision, with the digest where the engine gives the samples.
///
/// # Safety
/// As for [`inbye_decide`].
unsafe fn decide(
    engine: *mut InbyeEngine,
    map: *const InbyeMap,
    config: *const InbyeConfig,
    problem: *const InbyeProblem,
    decision: *mut InbyeDecision,
    detail: Detail,
) -> bool {
    let decided = guarded(AssertUnwindSafe(|| {
        // SAFETY: the caller vouches for all of them.
        let (engine, map) = unsafe { (object_mut(engine, "engine")?, object(map, "map")?) };
        // SAFETY: likewise.
        let (config, problem) = unsafe { (object(config, "config")?, object(problem, "problem")?) };
        // SAFETY: likewise.
        let answer = unsafe { place(decision, "decision") }?;
        // SAFETY: likewise.
        let discs = unsafe { array(problem.obstacles, problem.obstacle_count, "obstacles") }?;
        let discs: Vec<_> = discs.iter().map(Into::into).collect();
        let config = &config.0;
        let (pose, twist) = (problem.pose.checked("pose")?, problem.velocity.checked("velocity")?);
        let input = config.decision_input(map, pose, twist, problem.target.checked("target")?);
        let input = DecisionInput {
            last_command: problem.last_command.checked("last_command")?,
            obstacles: &discs,
            key_node: problem.key_node.checked("key_node")?,
            ..input.map_err(|error| error.to_string())?
        };
        let problem = input.problem(&config.local);
        let quantized = QuantizedProblem::new(&problem).map_err(|error| error.to_string())?;
        let evaluation = engine.0.evaluate(&quantized, detail);
        let evaluation = evaluation.map_err(|error| error.to_string())?;
        let winner = Explainer::new(&problem, &quantized, &evaluation).winner(&evaluation);
        let mut letters = [0; 65];
        if detail == Detail::Samples {
            let mut digest = EvaluationDigest::default();
            digest.add(&evaluation);
            for (to, from) in letters.iter_mut().zip(digest.hex().bytes()) {
                *to = from.cast_signed() as c_char;
            }
        }
        let (linear, angular, index) =
            winner.map_or((0.0, 0.0, 0), |winner| (winner.vx, winner.vtheta, winner.index));
        answer.write(InbyeDecision {
            has_command: winner.is_some(),
            command: InbyeTwist { linear, angular },
            index,
            admissible: evaluation.counts.admissible,
            collision: evaluation.counts.collision,
            cannot_stop: evaluation.counts.cannot_stop,
            outside: evaluation.counts.outside,
            digest: letters,
        });
        Ok(())
    }));
    decided.is_some()
}
