//! A GPU that fails, for the tests of measurements, and what measurements make of it.

use std::ops::ControlFlow;

use super::{DensityPlan, DensityRow, SkippedCell, measure_batches, measure_density};
use crate::local::{
    CpuEngine, Detail, Engine, EngineError, Evaluation, GpuFailureKind, QuantizedProblem,
};

/// A GPU that takes this many decisions.
struct LostGpu {
    engine: CpuEngine,
    remaining: usize,
}

impl Engine for LostGpu {
    fn name(&self) -> String {
        "a GPU".to_owned()
    }

    fn evaluate(
        &mut self,
        problem: &QuantizedProblem,
        detail: Detail,
    ) -> Result<Evaluation, EngineError> {
        let lost = || EngineError::Lost {
            adapter: self.name(),
            kind: GpuFailureKind::DeviceLost,
            message: "simulated".to_owned(),
        };
        self.remaining = self.remaining.checked_sub(1).ok_or_else(lost)?;
        self.engine.evaluate(problem, detail)
    }
}

/// The CPU, and a GPU that takes this many decisions.
pub(super) fn with_gpu(remaining: usize) -> [Box<dyn Engine>; 2] {
    let engine = CpuEngine::single_threaded;
    [Box::new(engine()), Box::new(LostGpu { engine: engine(), remaining })]
}

/// A clock that shows a later time by each call.
pub(super) fn clock(step_s: f64) -> impl FnMut() -> f64 {
    let mut now_s = 0.0;
    move || {
        now_s += step_s;
        now_s
    }
}

#[test]
fn gpu_that_is_lost_is_listed_and_the_other_rows_are_kept() {
    let plan = DensityPlan::powers_of_four(2, 4, 64, 0.5);
    // It is lost at the second density.
    let mut engines = with_gpu(100);
    let done = |_: Result<&DensityRow, &SkippedCell>| ControlFlow::Continue(());
    let mut density =
        measure_density(&mut engines, &plan, &mut clock(0.01), done).expect("the CPU answers");
    let rows: Vec<_> = density.rows.iter().map(|row| (&*row.engine, row.samples)).collect();
    assert_eq!(rows, [("cpu", 4), ("gpu", 4), ("cpu", 16), ("cpu", 64)]);
    let [lost] = &density.lost[..] else { panic!("{:?}", density.lost) };
    assert_eq!((&*lost.name, &*lost.reason), ("a GPU", "GPU a GPU gave no answer: simulated"));
    let skipped: Vec<_> = density.skipped.iter().map(|one| (one.samples, &*one.reason)).collect();
    let again = "it failed before: GPU a GPU gave no answer: simulated";
    assert_eq!(skipped, [(16, &*lost.reason), (64, again)]);
    let next = || ControlFlow::Continue(());
    let batches = measure_batches(&mut engines, &plan, &mut density.lost, &mut clock(0.01), next);
    let batches = batches.expect("the CPU answers");
    assert!(!batches.is_empty() && batches.iter().all(|row| row.engine == "cpu"), "{batches:?}");
    // Lost within the batches.
    let (mut engines, mut lost) = (with_gpu(3), Vec::new());
    let batches = measure_batches(&mut engines, &plan, &mut lost, &mut clock(0.01), next);
    assert_eq!(
        batches.expect("the CPU answers").iter().filter(|row| row.engine == "gpu").count(),
        0
    );
    assert_eq!(lost.len(), 1);
}

#[test]
fn measurement_that_is_ended_returns_its_rows() {
    let plan = DensityPlan::powers_of_four(2, 4, 64, 0.5);
    let mut cells = 0;
    let done = |_: Result<&DensityRow, &SkippedCell>| {
        cells += 1;
        if cells == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let density = measure_density(&mut with_gpu(usize::MAX), &plan, &mut clock(0.01), done);
    let rows = density.expect("the engines answer").rows;
    let rows: Vec<_> = rows.iter().map(|row| (&*row.engine, row.samples)).collect();
    assert_eq!(rows, [("cpu", 4), ("gpu", 4), ("cpu", 16)]);
    let (mut engines, mut lost) = (with_gpu(usize::MAX), Vec::new());
    let next = || ControlFlow::Break(());
    let batches = measure_batches(&mut engines, &plan, &mut lost, &mut clock(0.01), next);
    assert_eq!(batches.expect("the engines answer").len(), 1);
}
