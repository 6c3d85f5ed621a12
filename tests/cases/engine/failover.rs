//! The CPU fallback, tested without a GPU: engines that fail on demand, and answers falsified in every part.
//!
//! `support/loss_trials.rs` tests real devices.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use inbye::bench::random_problem;
use inbye::local::internals::FIRST_RETRY;
use inbye::local::{
    BackgroundOpener, CpuEngine, Detail, Engine, EngineError, Evaluation, Failover, GpuFailureKind,
    GpuSource, Incidents, QuantizedProblem, SampleStatus,
};

type OpenResult = Result<Box<dyn Engine>, EngineError>;

/// Replaces the answer of an engine at a decision.
type Falsify =
    Box<dyn FnMut(u32, &QuantizedProblem, Evaluation) -> Result<Evaluation, EngineError> + Send>;

/// A CPU engine in the place of a GPU, with falsified answers.
struct FaultyGpu {
    cpu: CpuEngine,
    decisions: u32,
    falsify: Falsify,
}

impl FaultyGpu {
    fn boxed(
        falsify: impl FnMut(u32, &QuantizedProblem, Evaluation) -> Result<Evaluation, EngineError>
        + Send
        + 'static,
    ) -> Box<dyn Engine> {
        Box::new(Self {
            cpu: CpuEngine::single_threaded(),
            decisions: 0,
            falsify: Box::new(falsify),
        })
    }

    fn correct() -> Box<dyn Engine> {
        Self::boxed(|_, _, answer| Ok(answer))
    }
}

impl Engine for FaultyGpu {
    fn name(&self) -> String {
        "faulty".to_owned()
    }

    fn evaluate(
        &mut self,
        problem: &QuantizedProblem,
        detail: Detail,
    ) -> Result<Evaluation, EngineError> {
        let answer = self.cpu.evaluate(problem, detail)?;
        self.decisions += 1;
        (self.falsify)(self.decisions, problem, answer)
    }
}

fn lost(kind: GpuFailureKind) -> EngineError {
    EngineError::Lost { adapter: "faulty".to_owned(), kind, message: "simulated".to_owned() }
}

fn problem(case: u64) -> QuantizedProblem {
    QuantizedProblem::new(&random_problem(8, case)).expect("a problem within the ranges")
}

fn expected_answer(problem: &QuantizedProblem, detail: Detail) -> Evaluation {
    let answer = CpuEngine::single_threaded().evaluate(problem, detail);
    answer.expect("the CPU does not fail")
}

fn with_fallback(gpu: OpenResult, source: impl FnMut() -> OpenResult + Send + 'static) -> Failover {
    Failover::new(gpu, source, CpuEngine::single_threaded())
}

fn incidents_of(failover: &Failover) -> Incidents {
    failover.incidents().expect("a failover has incidents")
}

/// Evaluates problems one after the other and compares each answer with the CPU's.
#[track_caller]
fn check_answers(failover: &mut Failover, cases: core::ops::Range<u64>) {
    for case in cases {
        let problem = problem(case);
        let detail = if case % 3 == 0 { Detail::Samples } else { Detail::Answer };
        let answer = failover.evaluate(&problem, detail);
        assert_eq!(answer, Ok(expected_answer(&problem, detail)), "case {case}");
    }
}

#[test]
fn every_gpu_failure_gets_the_same_bits_from_the_cpu_in_the_same_tick() {
    for kind in [
        GpuFailureKind::DeviceLost,
        GpuFailureKind::TimedOut,
        GpuFailureKind::Validation,
        GpuFailureKind::OutOfMemory,
        GpuFailureKind::Internal,
        GpuFailureKind::Stale,
        GpuFailureKind::Panicked,
    ] {
        let gpu = FaultyGpu::boxed(move |decision, _, answer| match decision {
            4 if kind == GpuFailureKind::Panicked => panic!("simulated"),
            4 => Err(lost(kind)),
            _ => Ok(answer),
        });
        let mut failover = with_fallback(Ok(gpu), || Ok(FaultyGpu::correct()));
        check_answers(&mut failover, 0..30);
        let incidents = incidents_of(&failover);
        assert_eq!(incidents.failures.iter().collect::<Vec<_>>(), [(&kind, &1)]);
        let on_cpu = u64::from(FIRST_RETRY);
        assert_eq!((incidents.decisions, incidents.on_cpu, incidents.reopened), (30, on_cpu, 1));
        let reported: Vec<_> =
            incidents.messages.iter().map(|one| (one.decision, one.kind)).collect();
        assert_eq!(reported, [(4, Some(kind)), (4 + on_cpu, None)]);
        assert_eq!(failover.kind(), "gpu");
    }
}

/// A driver that blocks within a call cannot be interrupted.
#[test]
fn late_answer_of_a_blocked_driver_counts_as_a_failure() {
    let limit = Duration::from_secs(2);
    let gpu = FaultyGpu::boxed(move |decision, _, answer| {
        if decision == 4 {
            std::thread::sleep(limit + Duration::from_millis(1));
        }
        Ok(answer)
    });
    let mut failover =
        with_fallback(Ok(gpu), || Ok(FaultyGpu::correct())).with_timeout(Some(limit));
    check_answers(&mut failover, 0..30);
    let incidents = incidents_of(&failover);
    assert_eq!(incidents.failures.get(&GpuFailureKind::TimedOut), Some(&1));
    assert!(incidents.messages[0].message.contains("longer than 2000 ms"), "{incidents:?}");
    // The late answer is used; the CPU decides until the GPU is reopened.
    assert_eq!((incidents.on_cpu, incidents.reopened), (u64::from(FIRST_RETRY) - 1, 1));
    assert_eq!(incidents.messages[0].decision, 4);
}

#[test]
fn missing_gpu_is_retried_after_growing_delays() {
    let attempts = Arc::new(Mutex::new(0_u32));
    let count = Arc::clone(&attempts);
    let mut failover = with_fallback(Err(EngineError::NoAdapter), move || {
        *count.lock().expect("no thread panics") += 1;
        Err(EngineError::NoAdapter)
    });
    assert_eq!(failover.kind(), "cpu");
    let mut at = Vec::new();
    for case in 0..160 {
        let before = *attempts.lock().expect("no thread panics");
        check_answers(&mut failover, case..case + 1);
        if *attempts.lock().expect("no thread panics") > before {
            at.push(case + 1);
        }
    }
    assert_eq!(at, [10, 30, 70, 150]);
    let incidents = incidents_of(&failover);
    assert_eq!(incidents.failures.get(&GpuFailureKind::Absent), Some(&1));
    assert_eq!((incidents.on_cpu, incidents.reopen_failures, incidents.reopened), (160, 4, 0));
    let words = serde_json::to_value(incidents).expect("counts are JSON");
    assert_eq!(words["failures"], serde_json::json!({ "absent": 1 }));
}

/// Answers some problems, then fails.
fn lost_after(answers: u32) -> Box<dyn Engine> {
    FaultyGpu::boxed(move |decision, _, answer| {
        if decision > answers { Err(lost(GpuFailureKind::DeviceLost)) } else { Ok(answer) }
    })
}

/// Decisions of the CPU after each loss, when each GPU answers a number of problems before it is lost.
fn delays(answers: &[u32]) -> Vec<u64> {
    let smallest = (0..50).map(problem).min_by_key(QuantizedProblem::len).expect("50 problems");
    let mut later: Vec<u32> = answers[1..].iter().rev().copied().collect();
    let mut failover =
        with_fallback(Ok(lost_after(answers[0])), move || Ok(lost_after(later.pop().unwrap_or(1))));
    let mut delay = || {
        let Incidents { on_cpu, reopened, .. } = incidents_of(&failover);
        while incidents_of(&failover).reopened == reopened {
            failover.evaluate(&smallest, Detail::Answer).expect("the CPU does not fail");
        }
        incidents_of(&failover).on_cpu - on_cpu
    };
    answers.iter().map(|_| delay()).collect()
}

#[test]
fn delays_double_up_to_the_longest_and_reset_after_100_successes() {
    assert_eq!(delays(&[99; 9]), [10, 20, 40, 80, 160, 320, 640, 640, 640]);
    assert_eq!(delays(&[99, 99, 100, 1]), [10, 20, 10, 20]);
}

/// Fails at every third poll.
struct SlowSource(Arc<AtomicU32>);

impl GpuSource for SlowSource {
    fn poll(&mut self) -> Option<OpenResult> {
        let before = self.0.fetch_add(1, Ordering::SeqCst);
        (before % 3 == 2).then_some(Err(EngineError::NoAdapter))
    }
}

#[test]
fn pending_source_is_polled_at_every_decision_until_it_fails() {
    let polls = Arc::new(AtomicU32::new(0));
    let source = SlowSource(Arc::clone(&polls));
    let cpu = CpuEngine::single_threaded();
    let mut failover = Failover::new(Err(EngineError::NoAdapter), source, cpu);
    for (decisions, expected) in [(0..9, 0), (9..10, 1), (10..12, 3), (12..31, 3), (31..32, 4)] {
        check_answers(&mut failover, decisions);
        assert_eq!(polls.load(Ordering::SeqCst), expected);
    }
}

#[test]
fn problem_too_large_for_the_adapter_keeps_the_device() {
    let gpu = FaultyGpu::boxed(|decision, _, answer| match decision {
        2 | 3 => Err(EngineError::TooLarge {
            adapter: "faulty".to_owned(),
            message: "simulated".to_owned(),
        }),
        _ => Ok(answer),
    });
    let mut failover = with_fallback(Ok(gpu), || panic!("no device was lost"));
    check_answers(&mut failover, 0..9);
    let incidents = incidents_of(&failover);
    assert_eq!((incidents.on_cpu, incidents.reopened), (2, 0));
    assert_eq!(incidents.failures.get(&GpuFailureKind::TooLarge), Some(&2));
}

/// Name and falsification of an answer; it returns false if it changes nothing.
type Falsification = (&'static str, fn(&QuantizedProblem, &mut Evaluation) -> bool);

const FALSIFICATIONS: [Falsification; 13] = [
    ("the next sample", |_, answer| edit(answer, |winner| winner.index ^= 1)),
    ("an index out of range", |_, answer| edit(answer, |winner| winner.index = u32::MAX)),
    ("a colliding sample", |problem, answer| {
        let all = expected_answer(problem, Detail::Samples).samples.unwrap_or_default();
        let bad = all.iter().position(|one| one.status == SampleStatus::Collision);
        bad.is_some_and(|bad| edit(answer, |winner| winner.index = bad as u32))
    }),
    ("a clearance", |_, answer| edit(answer, |winner| winner.terms.clearance += 1)),
    ("a heading", |_, answer| edit(answer, |winner| winner.terms.heading ^= 1 << 9)),
    ("a score", |_, answer| edit(answer, |winner| winner.score ^= 1)),
    ("all zeros", |_, answer| {
        *answer = Evaluation::default();
        true
    }),
    ("all ones", |_, answer| {
        answer.counts.admissible = u32::MAX;
        answer.totals.sums = [u64::MAX; 4];
        answer.totals.max = [u32::MAX; 4];
        edit(answer, |winner| winner.score = -1)
    }),
    ("no winner", |_, answer| answer.winner.take().is_some()),
    ("one sample too many", |_, answer| {
        answer.counts.collision += 1;
        true
    }),
    ("smaller totals", |_, answer| {
        answer.totals.sums[1] >>= 9;
        answer.totals.sums[1] > 0
    }),
    ("a maximum below the winner", |_, answer| {
        answer.totals.max[0] = 0;
        answer.winner.is_some_and(|winner| winner.terms.heading > 0)
    }),
    ("a truncated list", |_, answer| {
        let list = answer.samples.as_mut();
        list.is_some_and(|list| list.pop().is_some())
    }),
];

fn edit(answer: &mut Evaluation, change: impl FnOnce(&mut inbye::local::Winner)) -> bool {
    answer.winner.as_mut().map(change).is_some()
}

#[test]
fn falsified_winner_is_never_used() {
    for (what, falsify) in FALSIFICATIONS {
        let mut falsified = 0;
        for case in 0..200 {
            let problem = problem(case);
            let expected = expected_answer(&problem, Detail::Samples);
            let mut changed = expected.clone();
            if !falsify(&problem, &mut changed) || changed == expected {
                continue;
            }
            falsified += 1;
            let gpu = FaultyGpu::boxed(move |_, _, _| Ok(changed.clone()));
            let mut failover = with_fallback(Ok(gpu), || Ok(FaultyGpu::correct()));
            let answer = failover.evaluate(&problem, Detail::Samples);
            assert_eq!(answer, Ok(expected), "{what}, case {case}");
            let incidents = incidents_of(&failover);
            assert_eq!(incidents.failures.get(&GpuFailureKind::WrongAnswer), Some(&1), "{what}");
            assert_eq!((incidents.on_cpu, failover.kind()), (1, "cpu"), "{what}");
        }
        assert!(falsified > 8, "{what}: only {falsified} problems show it");
    }
}

/// The answer to the previous problem, as from a buffer that was not written again.
#[test]
fn answer_to_another_problem_is_not_used() {
    let mut last = None;
    let gpu = FaultyGpu::boxed(move |_, _, answer| {
        let stale = last.replace(answer.clone());
        Ok(stale.unwrap_or(answer))
    });
    let mut failover = with_fallback(Ok(gpu), || panic!("too early for a retry"));
    check_answers(&mut failover, 0..8);
    let incidents = incidents_of(&failover);
    assert_eq!(incidents.failures.get(&GpuFailureKind::WrongAnswer), Some(&1));
    assert_eq!((incidents.messages[0].decision, incidents.on_cpu), (2, 7));
}

/// A limit that the documentation of [`Failover`] states: another admissible sample with the right score passes. If
/// this fails, the documentation promises too little.
#[test]
fn admissible_sample_that_is_not_the_best_passes_the_check() {
    let mut answers = (0..).map(problem).map(|problem| {
        let answer = expected_answer(&problem, Detail::Samples);
        (problem, answer)
    });
    let several = |(_, answer): &(QuantizedProblem, Evaluation)| answer.counts.admissible > 1;
    let (problem, mut answer) = answers.find(several).expect("one of many problems");
    let all = answer.samples.take().expect("requested");
    let winner = answer.winner.as_mut().expect("an admissible sample");
    let other = (0..)
        .zip(&all)
        .find(|(index, one)| one.status == SampleStatus::Ok && *index != winner.index);
    let (index, other) = other.expect("two admissible samples");
    let normalizers = inbye::local::internals::score::normalizers(&problem.header, &answer.totals);
    winner.index = index;
    winner.terms = other.terms;
    winner.score = inbye::local::internals::score::score(&other.terms, &normalizers);
    let reported = answer.clone();
    let gpu = FaultyGpu::boxed(move |_, _, _| Ok(reported.clone()));
    let mut failover = with_fallback(Ok(gpu), || panic!("no device was lost"));
    assert_eq!(failover.evaluate(&problem, Detail::Answer), Ok(answer));
}

#[test]
fn batch_with_a_wrong_answer_runs_on_the_cpu_as_a_whole() {
    let gpu = FaultyGpu::boxed(|decision, _, mut answer| {
        if decision == 3 {
            answer.counts.outside += 1;
        }
        Ok(answer)
    });
    let mut failover = with_fallback(Ok(gpu), || panic!("too early for a retry"));
    let problems: Vec<QuantizedProblem> = (0..5).map(problem).collect();
    let expected: Vec<_> =
        problems.iter().map(|one| expected_answer(one, Detail::Answer)).collect();
    let answers = failover.evaluate_batch(&problems, Detail::Answer);
    assert_eq!(answers, Ok(expected));
    let incidents = incidents_of(&failover);
    assert_eq!((incidents.decisions, incidents.on_cpu, incidents.total_failures()), (1, 1, 1));
}

/// An engine whose destructor blocks until it is released, then reports.
struct SlowToClose {
    engine: Box<dyn Engine>,
    release: Receiver<()>,
    closed: Arc<AtomicBool>,
}

impl Engine for SlowToClose {
    fn name(&self) -> String {
        self.engine.name()
    }

    fn evaluate(
        &mut self,
        problem: &QuantizedProblem,
        detail: Detail,
    ) -> Result<Evaluation, EngineError> {
        self.engine.evaluate(problem, detail)
    }
}

impl Drop for SlowToClose {
    fn drop(&mut self) {
        // With a timeout, so that a decision that waits for this fails below instead of hanging.
        let _ = self.release.recv_timeout(Duration::from_secs(60));
        self.closed.store(true, Ordering::SeqCst);
    }
}

#[test]
fn decisions_do_not_wait_for_a_device_to_close_or_open() {
    let (release, released) = channel();
    let closed = Arc::new(AtomicBool::new(false));
    let gpu = SlowToClose {
        engine: FaultyGpu::boxed(|_, _, _| Err(lost(GpuFailureKind::TimedOut))),
        release: released,
        closed: Arc::clone(&closed),
    };
    let (opens, when_open) = channel();
    let when_open = Mutex::new(when_open);
    let source = BackgroundOpener::new(move || {
        let reported = when_open.lock().expect("no thread panics").recv();
        reported.map_err(|_| EngineError::NoAdapter)?;
        Ok(FaultyGpu::correct())
    });
    let cpu = CpuEngine::single_threaded();
    let mut failover = Failover::new(Ok(Box::new(gpu)), source, cpu);
    check_answers(&mut failover, 0..30);
    assert!(!closed.load(Ordering::SeqCst));
    let still = incidents_of(&failover);
    assert_eq!((still.on_cpu, still.reopened, still.reopen_failures), (30, 0, 0));
    release.send(()).expect("it is being closed");
    opens.send(()).expect("it is being opened");
    let mut case = 30;
    while failover.kind() == "cpu" {
        check_answers(&mut failover, case..case + 1);
        case += 1;
    }
    assert_eq!(incidents_of(&failover).reopened, 1);
    drop(failover);
    assert!(closed.load(Ordering::SeqCst));
}

#[test]
fn panic_while_opening_a_device_is_a_failed_attempt() {
    let source = BackgroundOpener::new(|| panic!("simulated"));
    let cpu = CpuEngine::single_threaded();
    let mut failover = Failover::new(Err(EngineError::NoAdapter), source, cpu);
    let mut case = 0;
    while incidents_of(&failover).reopen_failures == 0 {
        check_answers(&mut failover, case..case + 1);
        case += 1;
    }
    assert_eq!(incidents_of(&failover).messages[1].kind, Some(GpuFailureKind::OpenFailed));
}
