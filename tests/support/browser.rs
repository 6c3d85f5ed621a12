//! The same shaders in Chromium: neither its WGSL compiler nor its WebGPU is the engine's.

use inbye::bench::verify;
use inbye::local::internals::gpu::Batch;
use inbye::local::internals::gpu::source;
use inbye::local::{
    CpuEngine, Detail, Engine, EngineError, Evaluation, GpuFailureKind, QuantizedProblem,
};
use libtest_mimic::{Failed, Trial};

use super::batch_trials::random_batches;
use super::cpu_trials::{agree, golden};
use super::kernel::{every_difference, source as kernel_source};
use super::operations::{OPERATIONS, Outcome};

mod chromium;
pub mod devtools;
mod plan;
pub mod program;

use chromium::Browser;
use plan::Plan;
use program::{BrowserTest, Program};

const TRIALS: [(&str, BrowserTest); 7] = [
    ("operations_return_the_bits_of_rust", operations),
    ("a_slip_in_an_operation_is_reported", slip_in_an_operation),
    ("random_problems_return_the_bits_of_the_cpu", random_problems),
    ("batches_return_the_bits_of_one_at_a_time", batches),
    ("a_slip_in_a_shader_is_reported", slip_in_a_shader),
    ("the_digest_is_the_pinned_one", the_digest),
    ("what_goes_wrong_is_an_error", what_goes_wrong),
];

pub fn trials() -> Vec<Trial> {
    program::trials(&TRIALS)
}

/// Evaluates in a page of Chromium.
struct ChromiumEngine {
    browser: Browser,
    wgsl: String,
    stamp: u32,
}

impl ChromiumEngine {
    /// An engine in a browser of its own. The page asks for no limits above WebGPU's default ones: shaders that need
    /// more are refused.
    fn new(program: &Program, wgsl: String) -> Result<Self, Failed> {
        Ok(Self { browser: Browser::start(program)?, wgsl, stamp: 0 })
    }

    fn lost(&self, what: impl Into<String>) -> EngineError {
        EngineError::Lost {
            adapter: self.name(),
            kind: GpuFailureKind::Internal,
            message: what.into(),
        }
    }
}

impl Engine for ChromiumEngine {
    fn name(&self) -> String {
        "Chromium".to_owned()
    }

    fn evaluate(
        &mut self,
        problem: &QuantizedProblem,
        detail: Detail,
    ) -> Result<Evaluation, EngineError> {
        let mut evaluations = self.evaluate_batch(core::slice::from_ref(problem), detail)?;
        Ok(evaluations.swap_remove(0))
    }

    fn evaluate_batch(
        &mut self,
        problems: &[QuantizedProblem],
        detail: Detail,
    ) -> Result<Vec<Evaluation>, EngineError> {
        let mut evaluations = Vec::new();
        for batch in Batch::split(problems) {
            let first_stamp = self.stamp;
            self.stamp += batch.problems.len() as u32;
            let plan = Plan::evaluation(&self.wgsl, &batch, first_stamp, detail);
            let outcome = self.browser.run(&plan);
            let bytes =
                outcome.map_err(|failed| self.lost(failed.message().unwrap_or_default()))?;
            let answers = batch.read(&bytes, first_stamp, detail);
            evaluations.extend(answers.ok_or_else(|| self.lost("a stale answer came back"))?);
        }
        Ok(evaluations)
    }
}

/// The text with the lowest bit of one constant flipped, that of the sine's largest coefficient.
fn with_a_slip(wgsl: &str) -> Result<String, Failed> {
    let (constant, slip) = ("+ 843314837;", "+ 843314836;");
    match wgsl.matches(constant).count() {
        1 => Ok(wgsl.replace(constant, slip)),
        count => Err(format!("`{constant}` stands {count} times in the shaders").into()),
    }
}

/// What the operations of a kernel differ in from Rust.
fn differences(program: &Program, wgsl: &str) -> Result<Vec<String>, Failed> {
    let mut browser = Browser::start(program)?;
    every_difference(|operation, cases| {
        let bytes = browser.run(&Plan::operation(wgsl, operation, cases)?)?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    })
}

fn operations(program: &Program) -> Result<(), Failed> {
    let differences = differences(program, &kernel_source())?;
    if differences.is_empty() { Ok(()) } else { Err(differences.join("\n").into()) }
}

fn slip_in_an_operation(program: &Program) -> Result<(), Failed> {
    let differences = differences(program, &with_a_slip(&kernel_source())?)?;
    match differences.as_slice() {
        [sine, cosine] if sine.starts_with("sin_q20: ") && cosine.starts_with("cos_q20: ") => {
            Ok(())
        }
        other => Err(format!("a slip in the sine was reported as {other:#?}").into()),
    }
}

fn random_problems(program: &Program) -> Result<(), Failed> {
    let mut engines: [Box<dyn Engine>; 2] =
        [Box::new(CpuEngine::single_threaded()), Box::new(ChromiumEngine::new(program, source())?)];
    agree(&mut engines, 100, 43)
}

fn batches(program: &Program) -> Result<(), Failed> {
    let engine = &mut ChromiumEngine::new(program, source())?;
    random_batches(engine, 47, &[(0, 7), (7, 1), (8, 2), (0, 30)])
}

fn slip_in_a_shader(program: &Program) -> Result<(), Failed> {
    let mut engines: [Box<dyn Engine>; 2] = [
        Box::new(CpuEngine::single_threaded()),
        Box::new(ChromiumEngine::new(program, with_a_slip(&source())?)?),
    ];
    let verification = verify(&mut engines, 20, 43, |_| {})?;
    if verification.agree() || verification.digests[0] == verification.digests[1] {
        return Err("a slip in the sine changed nothing that is compared".into());
    }
    Ok(())
}

fn the_digest(program: &Program) -> Result<(), Failed> {
    golden(Box::new(ChromiumEngine::new(program, source())?))
}

fn what_goes_wrong(program: &Program) -> Result<(), Failed> {
    let (browser, wgsl) = (&mut Browser::start(program)?, kernel_source());
    let operation = &OPERATIONS[0];
    let cases = [[7, 6, 0, 0, 0, 0]; 3];
    let run =
        |browser: &mut Browser, wgsl: &str| browser.run(&Plan::operation(wgsl, operation, &cases)?);
    let altered = |from, to| -> Result<String, Failed> {
        if wgsl.contains(from) {
            Ok(wgsl.replace(from, to))
        } else {
            Err(format!("the kernel has no `{from}`").into())
        }
    };
    let refused = |outcome: Result<Vec<u8>, Failed>, what: &str| match outcome {
        Err(failed) if failed.message().unwrap_or_default().contains(what) => Ok(()),
        other => Err(Failed::from(format!("not an error with `{what}`: {other:?}"))),
    };
    let misspelt = altered("header.steps", "header.step")?;
    refused(run(browser, &misspelt), "member step not found")?;
    // More than a device allows that was asked for no more than the default limits.
    let too_large = altered("@workgroup_size(64)", "@workgroup_size(512)")?;
    refused(run(browser, &too_large), "exceeds the maximum allowed")?;
    let expected = [[42, 0, 0, 0]; 3];
    let found: Vec<Outcome> = bytemuck::pod_collect_to_vec(&run(browser, &wgsl)?);
    if found != expected {
        return Err(format!("after two refusals: {found:?}, not {expected:?}").into());
    }
    browser.crash()?;
    refused(run(browser, &wgsl), "Chromium is gone")
}
