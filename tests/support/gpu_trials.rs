//! Parity tests on each adapter.

use inbye::bench::compare;
use inbye::geometry::Pose;
use inbye::local::{Adapter, GpuEngine};
use inbye::local::{
    Axis, CpuEngine, Detail, Engine, EngineError, GpuFailureKind, Outside, Problem,
    QuantizedProblem, Window,
};
use inbye::map::MovingDisc;
use libtest_mimic::Failed;

use super::adapters::GpuTest;
use super::batch_trials;
use super::cpu_trials::{agree, golden};
use super::extremes::{extremes, field, footprint, plain};
use super::kernel::{Kernel, every_difference};
use super::loss_trials;

pub const TRIALS: [(&str, GpuTest); 17] = [
    ("operations_return_the_bits_of_rust", operations),
    ("random_problems_return_the_bits_of_the_cpu", random_problems),
    ("digest_equals_the_pinned_one", the_digest),
    ("problems_of_any_size_in_sequence_return_the_bits_of_the_cpu", sizes),
    ("changed_field_is_uploaded", fields),
    ("problems_at_the_limits_return_the_bits_of_the_cpu", limits),
    ("lost_device_is_an_error", lost_device),
    ("batches_return_the_bits_of_single_problems", batch_trials::growth),
    ("batches_share_and_change_fields", batch_trials::fields),
    ("batches_replace_large_fields", batch_trials::large_fields),
    ("batches_of_many_submissions_keep_their_order", batch_trials::many_submissions),
    ("batch_rejects_a_problem_that_is_rejected_alone", batch_trials::refusals),
    ("falsified_answer_of_a_batch_is_reported", batch_trials::falsified),
    ("late_answer_is_never_used_for_another_problem", loss_trials::late_answers),
    ("device_lost_during_a_decision_gives_an_error_or_the_answer", loss_trials::lost_in_the_middle),
    ("rejected_call_is_an_error_of_its_kind", loss_trials::refused_calls),
    ("ten_gpu_failures_do_not_change_the_trace", loss_trials::ten_losses),
];

fn operations(adapter: &Adapter) -> Result<(), Failed> {
    let kernel = Kernel::new(adapter)?;
    let differences = every_difference(|operation, cases| kernel.run(operation, cases))?;
    if differences.is_empty() { Ok(()) } else { Err(differences.join("\n").into()) }
}

fn random_problems(adapter: &Adapter) -> Result<(), Failed> {
    let mut engines: [Box<dyn Engine>; 2] =
        [Box::new(CpuEngine::single_threaded()), Box::new(GpuEngine::new(adapter)?)];
    agree(&mut engines, 300, 42)
}

fn the_digest(adapter: &Adapter) -> Result<(), Failed> {
    golden(Box::new(GpuEngine::new(adapter)?))
}

/// Evaluates a problem with and without samples, on an engine with earlier answers.
fn same(engine: &mut GpuEngine, name: &str, problem: &Problem) -> Result<(), Failed> {
    let problem = QuantizedProblem::new(problem)?;
    for detail in [Detail::Samples, Detail::Answer] {
        let expected = CpuEngine::single_threaded().evaluate(&problem, detail)?;
        let found = engine.evaluate(&problem, detail)?;
        let mut first = None;
        let mut count = 0;
        compare(&expected, &found, |what, expected, found| {
            count += 1;
            first.get_or_insert(format!("{what}: {found}, not {expected}"));
        });
        // Checks the comparison against equality.
        if let Some(first) = first {
            return Err(format!("{name}, {detail:?}: {count} differences, first: {first}").into());
        }
        if expected != found {
            return Err(
                format!("{name}, {detail:?}: unequal, yet no difference is reported").into()
            );
        }
    }
    Ok(())
}

pub fn window(speeds: u32, turns: u32) -> Window {
    let axis = |low, high, count| Axis::new(low, high, count);
    Window { vx: axis(-0.2, 0.8, speeds), vtheta: axis(-1.0, 1.0, turns) }
}

fn sizes(adapter: &Adapter) -> Result<(), Failed> {
    const DISCS: [[f64; 3]; 3] = [[0.2, 0.0, 0.2], [-0.2, 0.0, 0.2], [0.0, 0.1, 0.1]];
    let body = |index: usize| MovingDisc {
        x: 3.0 + index as f64 * 0.2,
        y: 1.0 + index as f64 * 0.3,
        radius: 0.2,
        vx: -0.3,
        vy: 0.1,
    };
    let engine = &mut GpuEngine::new(adapter)?;
    for (speeds, turns, steps, discs, moving, side) in [
        (1, 1, 1, 1, 0, 40),
        (3, 85, 30, 1, 0, 41),
        (256, 1, 10, 2, 3, 7),
        (257, 1, 10, 2, 3, 1),
        (1, 257, 10, 1, 1, 3),
        (256, 256, 5, 3, 0, 301),
        (2, 2, 200, 3, 5, 5),
        (1, 1, 1, 1, 0, 1),
        (128, 128, 20, 2, 2, 100),
        (20, 40, 40, 1, 0, 40),
        (65_536, 1, 2, 1, 0, 33),
        (1, 65_536, 2, 1, 0, 40),
        (7, 5, 3, 1, 0, 9),
    ] {
        let what = format!(
            "{speeds} x {turns} samples, {steps} steps, {discs} discs, {moving} moving, side {side}"
        );
        let field = field(side, 0.1, &[[0, side - 1], [side / 2, 0]]);
        let middle = f64::from(side) * 0.05;
        let problem = Problem {
            window: window(speeds, turns),
            steps,
            footprint: footprint(&DISCS[..discs]),
            obstacles: (0..moving).map(body).collect(),
            pose: Pose::new(middle, middle, 0.4),
            outside: if side < 10 { Outside::Free } else { Outside::Obstacle },
            field,
            ..plain()
        };
        same(engine, &what, &problem)?;
    }
    Ok(())
}

fn fields(adapter: &Adapter) -> Result<(), Failed> {
    let with = |blocked: &[[i32; 2]]| Problem {
        window: window(20, 20),
        field: field(41, 0.1, blocked),
        ..plain()
    };
    let (near, far) = (with(&[[30, 25]]), with(&[[40, 40]]));
    let answer = |problem: &Problem| -> Result<_, Failed> {
        Ok(CpuEngine::single_threaded()
            .evaluate(&QuantizedProblem::new(problem)?, Detail::Answer)?)
    };
    if answer(&near)? == answer(&far)? {
        return Err("two fields with one answer: a stale field could not show".into());
    }
    let engine = &mut GpuEngine::new(adapter)?;
    let moved = Problem { pose: Pose::new(2.0, 2.2, 1.0), ..near.clone() };
    for (what, problem) in [
        ("the first field", &near),
        ("the same field", &near),
        ("the same field, elsewhere", &moved),
        ("another field of that size", &far),
        ("the first field again", &near),
    ] {
        same(engine, what, problem)?;
    }
    Ok(())
}

fn limits(adapter: &Adapter) -> Result<(), Failed> {
    let engine = &mut GpuEngine::new(adapter)?;
    for (what, problem) in extremes() {
        match engine.evaluate(&QuantizedProblem::new(&problem)?, Detail::Answer) {
            // llvmpipe abandons invocations with this many loop iterations: an error is correct then, a wrong answer is
            // not.
            Err(EngineError::TooLarge { message, .. }) if message.contains("loop iterations") => {}
            _ => same(engine, what, &problem)?,
        }
    }
    // 4.8 GB of tables: more than an adapter can bind.
    let too_large = Problem {
        window: window(1, 65_536),
        steps: 1023,
        step_s: 0.01,
        footprint: footprint(&[[0.0, 0.0, 0.2]; 8]),
        ..plain()
    };
    match engine.evaluate(&QuantizedProblem::new(&too_large)?, Detail::Answer) {
        Err(EngineError::TooLarge { message, .. }) if message.contains("sample less densely") => {}
        other => return Err(format!("too large, yet {other:?}").into()),
    }
    same(engine, "after one that was too large", &plain())?;
    // The largest number of samples; a CPU would take minutes.
    let side = if adapter.summary.software { 1 << 8 } else { 1 << 11 };
    for (speeds, turns) in [(side, side), (side * side, 1), (1, side * side)] {
        let most = Problem { window: window(speeds, turns), steps: 1, ..plain() };
        same(engine, &format!("{speeds} x {turns} samples"), &most)?;
    }
    Ok(())
}

fn lost_device(adapter: &Adapter) -> Result<(), Failed> {
    let problem = QuantizedProblem::new(&plain())?;
    for answers_before in [0, 2] {
        let mut engine = GpuEngine::new(adapter)?;
        for _ in 0..answers_before {
            engine.evaluate(&problem, Detail::Samples)?;
        }
        engine.destroyer()();
        for detail in [Detail::Answer, Detail::Samples, Detail::Answer] {
            match engine.evaluate(&problem, detail) {
                Err(EngineError::Lost {
                    adapter: name,
                    kind: GpuFailureKind::DeviceLost,
                    message: what,
                }) if name == adapter.summary.name && !what.is_empty() => {}
                other => return Err(format!("after {answers_before} answers: {other:?}").into()),
            }
        }
    }
    same(&mut GpuEngine::new(adapter)?, "a new device", &plain())
}
