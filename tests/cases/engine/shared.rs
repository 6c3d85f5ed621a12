//! One engine for many threads, tested with CPU engines in the place of a GPU.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Barrier};
use std::thread;
use std::time::Duration;

use inbye::bench::random_problem;
use inbye::local::{
    CpuEngine, Detail, Engine, EngineError, Evaluation, Failover, GpuFailureKind, QuantizedProblem,
    SharedEngine,
};

const THREADS: usize = 8;
const DECISIONS: u64 = 40;

/// What an engine does with a batch before it answers.
type Before = Box<dyn FnMut(&[QuantizedProblem]) -> Result<(), EngineError> + Send>;

/// A CPU engine that refuses, panics or waits.
struct Odd {
    cpu: CpuEngine,
    before: Before,
}

impl Odd {
    fn shared(
        before: impl FnMut(&[QuantizedProblem]) -> Result<(), EngineError> + Send + 'static,
    ) -> SharedEngine {
        let cpu = CpuEngine::single_threaded();
        SharedEngine::new(Box::new(Self { cpu, before: Box::new(before) }))
    }
}

impl Engine for Odd {
    fn name(&self) -> String {
        "odd".to_owned()
    }

    fn evaluate(
        &mut self,
        problem: &QuantizedProblem,
        detail: Detail,
    ) -> Result<Evaluation, EngineError> {
        let mut answers = self.evaluate_batch(core::slice::from_ref(problem), detail)?;
        Ok(answers.swap_remove(0))
    }

    fn evaluate_batch(
        &mut self,
        problems: &[QuantizedProblem],
        detail: Detail,
    ) -> Result<Vec<Evaluation>, EngineError> {
        (self.before)(problems)?;
        self.cpu.evaluate_batch(problems, detail)
    }
}

fn problem(seed: u64, case: u64) -> QuantizedProblem {
    QuantizedProblem::new(&random_problem(seed, case)).expect("within the ranges")
}

/// The answers of all threads to their problems, and those of an engine alone.
fn answers(
    shared: &SharedEngine,
) -> Vec<(Result<Evaluation, EngineError>, Result<Evaluation, EngineError>)> {
    let start = Barrier::new(THREADS);
    thread::scope(|scope| {
        let threads: Vec<_> = (0..THREADS as u64)
            .map(|seed| {
                let (mut shared, start) = (shared.clone(), &start);
                scope.spawn(move || {
                    let mut alone = CpuEngine::single_threaded();
                    start.wait();
                    let pair = |case| {
                        let problem = problem(seed, case);
                        // Some ask for samples: not every batch is uniform.
                        let is_whole = (seed + case).is_multiple_of(5);
                        let detail = if is_whole { Detail::Samples } else { Detail::Answer };
                        (shared.evaluate(&problem, detail), alone.evaluate(&problem, detail))
                    };
                    (0..DECISIONS).map(pair).collect::<Vec<_>>()
                })
            })
            .collect();
        threads.into_iter().flat_map(|thread| thread.join().expect("it does not panic")).collect()
    })
}

fn lost() -> EngineError {
    EngineError::Lost {
        adapter: "odd".to_owned(),
        kind: GpuFailureKind::DeviceLost,
        message: "gone".to_owned(),
    }
}

#[test]
fn each_thread_gets_the_answers_to_its_own_problems_from_few_batches() {
    let largest = Arc::new(AtomicUsize::new(0));
    let seen = Arc::clone(&largest);
    let shared = Odd::shared(move |problems| {
        seen.fetch_max(problems.len(), Ordering::Relaxed);
        // The other threads come meanwhile.
        thread::sleep(Duration::from_millis(1));
        Ok(())
    });
    for (found, expected) in answers(&shared) {
        assert_eq!(found, expected);
    }
    let (batches, problems) = shared.counts();
    assert_eq!(problems, THREADS as u64 * DECISIONS);
    assert!(batches < problems / 2, "{batches} batches of {problems} problems");
    assert!((2..=THREADS).contains(&largest.load(Ordering::Relaxed)));
    assert!(!shared.has_failed());
}

#[test]
fn batch_of_a_handle_is_one_batch() {
    let mut shared = Odd::shared(|_| Ok(()));
    let problems: Vec<_> = (0..5).map(|case| problem(1, case)).collect();
    let expected = CpuEngine::single_threaded().evaluate_batch(&problems, Detail::Answer);
    assert_eq!(shared.evaluate_batch(&problems, Detail::Answer), expected);
    assert_eq!(shared.counts(), (1, 5));
    assert_eq!(shared.evaluate_batch(&[], Detail::Answer), Ok(Vec::new()));
}

#[test]
fn handle_reports_the_incidents_of_its_engine() {
    let failover = Failover::new(Err(lost()), || Err(lost()), CpuEngine::single_threaded());
    let mut shared = SharedEngine::new(Box::new(failover));
    assert!(shared.evaluate(&problem(1, 1), Detail::Answer).is_ok());
    let incidents = shared.incidents().expect("a failover has incidents");
    assert_eq!((incidents.total_failures(), incidents.on_cpu), (1, 1));
}

/// The comparison above would see an answer that goes to another thread.
#[test]
fn answers_of_different_problems_differ() {
    let mut engine = CpuEngine::single_threaded();
    let answer = |seed, engine: &mut CpuEngine| engine.evaluate(&problem(seed, 0), Detail::Answer);
    assert_ne!(answer(0, &mut engine), answer(1, &mut engine));
}

#[test]
fn refused_problem_fails_alone() {
    let refused = problem(3, 7);
    let refusal =
        || EngineError::TooLarge { adapter: "odd".to_owned(), message: "large".to_owned() };
    let held = refused.clone();
    let shared = Odd::shared(move |problems| {
        let is_it = |problem: &QuantizedProblem| {
            problem.vx_samples == held.vx_samples && problem.profiles == held.profiles
        };
        if problems.iter().any(is_it) { Err(refusal()) } else { Ok(()) }
    });
    let answers = answers(&shared);
    let failed = answers.iter().filter(|(found, _)| found.is_err()).count();
    assert_eq!(failed, 1, "the one that is refused");
    assert!(answers.iter().all(|(found, alone)| found.is_err() || found == alone));
    assert!(!shared.has_failed(), "the engine stays usable");
}

#[test]
fn lost_engine_fails_for_all_and_says_so() {
    let mut left = 20;
    let shared = Odd::shared(move |_| {
        left -= 1;
        if left > 0 { Ok(()) } else { Err(lost()) }
    });
    let answers = answers(&shared);
    assert!(answers.iter().all(|(found, alone)| *found == Err(lost()) || found == alone));
    assert_eq!(answers.last().map(|(found, _)| found.clone()), Some(Err(lost())));
    assert!(shared.has_failed());
}

#[test]
fn panic_in_one_thread_leaves_no_other_waiting() {
    let mut left = 3;
    let mut shared = Odd::shared(move |_| {
        thread::sleep(Duration::from_millis(20));
        left -= 1;
        assert!(left != 0, "the panic of this test");
        Ok(())
    });
    let panics = thread::scope(|scope| {
        let threads: Vec<_> = (0..THREADS as u64)
            .map(|seed| {
                let mut shared = shared.clone();
                scope.spawn(move || {
                    for case in 0..3 {
                        // Those of the batch that panicked get an error.
                        drop(shared.evaluate(&problem(seed, case), Detail::Answer));
                    }
                })
            })
            .collect();
        threads.into_iter().filter_map(|thread| thread.join().err()).count()
    });
    assert_eq!(panics, 1, "the thread that evaluated");
    assert!(shared.evaluate(&problem(0, 0), Detail::Answer).is_ok());
}
