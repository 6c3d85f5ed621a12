//! The CPU that stands by for a GPU, without a GPU: engines that fail to order, and answers falsified in every part.
//!
//! What happens to real devices is in `support/loss_trials.rs`.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use inbye::bench::random_problem;
use inbye::local::internals::FIRST_RETRY;
use inbye::local::{
    BackgroundOpener, CpuEngine, Detail, Engine, EngineError, Evaluation, Failover, GpuFailureKind,
    Incidents, QuantizedProblem, SampleStatus,
};

type Opened = Result<Box<dyn Engine>, EngineError>;

/// What an engine does at a decision in place of its work.
type Trick =
    Box<dyn FnMut(u32, &QuantizedProblem, Evaluation) -> Result<Evaluation, EngineError> + Send>;

/// The CPU in a GPU's place, with a trick.
struct Tricky {
    cpu: CpuEngine,
    decisions: u32,
    trick: Trick,
}

impl Tricky {
    fn boxed(
        trick: impl FnMut(u32, &QuantizedProblem, Evaluation) -> Result<Evaluation, EngineError>
        + Send
        + 'static,
    ) -> Box<dyn Engine> {
        Box::new(Self {
            cpu: CpuEngine::single_threaded(),
            decisions: 0,
            trick: Box::new(trick),
        })
    }

    fn honest() -> Box<dyn Engine> {
        Self::boxed(|_, _, answer| Ok(answer))
    }
}

impl Engine for Tricky {
    fn name(&self) -> String {
        "tricky".to_owned()
    }

    fn kind(&self) -> &'static str {
        "gpu"
    }

    fn threads(&self) -> usize {
        0
    }

    fn evaluate(
        &mut self,
        problem: &QuantizedProblem,
        detail: Detail,
    ) -> Result<Evaluation, EngineError> {
        let answer = self.cpu.evaluate(problem, detail)?;
        self.decisions += 1;
        (self.trick)(self.decisions, problem, answer)
    }
}

fn lost(kind: GpuFailureKind) -> EngineError {
    EngineError::Lost {
        adapter: "tricky".to_owned(),
        kind,
        message: "as told".to_owned(),
    }
}

fn problem(case: u64) -> QuantizedProblem {
    QuantizedProblem::new(&random_problem(8, case)).expect("a problem within the ranges")
}

fn truth(problem: &QuantizedProblem, detail: Detail) -> Evaluation {
    let answer = CpuEngine::single_threaded().evaluate(problem, detail);
    answer.expect("the CPU does not fail")
}

fn with_cpu(gpu: Opened, source: impl FnMut() -> Opened + Send + 'static) -> Failover {
    Failover::new(gpu, source, CpuEngine::single_threaded())
}

fn met(failover: &Failover) -> &Incidents {
    failover.incidents().expect("a failover keeps count")
}

/// Puts problems to it, one after the other, and holds each answer against the CPU's.
#[track_caller]
fn ask(failover: &mut Failover, cases: core::ops::Range<u64>) {
    for case in cases {
        let problem = problem(case);
        let detail = if case % 3 == 0 {
            Detail::Samples
        } else {
            Detail::Answer
        };
        let answer = failover.evaluate(&problem, detail);
        assert_eq!(answer, Ok(truth(&problem, detail)), "case {case}");
    }
}

#[test]
fn whatever_fails_the_cpu_answers_in_the_same_tick_with_the_same_bits() {
    for kind in [
        GpuFailureKind::DeviceLost,
        GpuFailureKind::TimedOut,
        GpuFailureKind::Validation,
        GpuFailureKind::OutOfMemory,
        GpuFailureKind::Internal,
        GpuFailureKind::Stale,
        GpuFailureKind::Panicked,
    ] {
        let gpu = Tricky::boxed(move |decision, _, answer| match decision {
            4 if kind == GpuFailureKind::Panicked => panic!("as told"),
            4 => Err(lost(kind)),
            _ => Ok(answer),
        });
        let mut failover = with_cpu(Ok(gpu), || Ok(Tricky::honest()));
        ask(&mut failover, 0..30);
        let met = met(&failover);
        assert_eq!(met.failures.iter().collect::<Vec<_>>(), [(&kind, &1)]);
        let on_cpu = u64::from(FIRST_RETRY);
        assert_eq!((met.decisions, met.on_cpu, met.reopened), (30, on_cpu, 1));
        let told: Vec<_> = met
            .messages
            .iter()
            .map(|one| (one.decision, one.kind))
            .collect();
        assert_eq!(told, [(4, Some(kind)), (4 + on_cpu, None)]);
        assert_eq!(failover.kind(), "gpu");
    }
}

#[test]
fn a_gpu_that_is_not_there_is_looked_for_after_longer_and_longer_waits() {
    let asked = Arc::new(Mutex::new(0_u32));
    let count = Arc::clone(&asked);
    let mut failover = with_cpu(Err(EngineError::NoAdapter), move || {
        *count.lock().expect("nobody panics") += 1;
        Err(EngineError::NoAdapter)
    });
    assert_eq!(failover.kind(), "cpu");
    let mut at = Vec::new();
    for case in 0..160 {
        let before = *asked.lock().expect("nobody panics");
        ask(&mut failover, case..case + 1);
        if *asked.lock().expect("nobody panics") > before {
            at.push(case + 1);
        }
    }
    assert_eq!(at, [10, 30, 70, 150]);
    let met = met(&failover);
    assert_eq!(met.failures.get(&GpuFailureKind::Absent), Some(&1));
    assert_eq!((met.on_cpu, met.reopen_failures, met.reopened), (160, 4, 0));
    let words = serde_json::to_value(met).expect("counts are JSON");
    assert_eq!(words["losses"], serde_json::json!({ "absent": 1 }));
}

#[test]
fn a_problem_too_large_for_the_adapter_costs_one_decision_and_not_the_device() {
    let gpu = Tricky::boxed(|decision, _, answer| match decision {
        2 | 3 => Err(EngineError::TooLarge {
            adapter: "tricky".to_owned(),
            message: "as told".to_owned(),
        }),
        _ => Ok(answer),
    });
    let mut failover = with_cpu(Ok(gpu), || panic!("nothing was lost"));
    ask(&mut failover, 0..9);
    let met = met(&failover);
    assert_eq!((met.on_cpu, met.reopened), (2, 0));
    assert_eq!(met.failures.get(&GpuFailureKind::TooLarge), Some(&2));
}

/// What was done to an answer; false where it changes nothing.
type Falsification = (&'static str, fn(&QuantizedProblem, &mut Evaluation) -> bool);

const FALSIFICATIONS: [Falsification; 13] = [
    ("the next sample", |_, answer| {
        edit(answer, |winner| winner.index ^= 1)
    }),
    ("no such sample", |_, answer| {
        edit(answer, |winner| winner.index = u32::MAX)
    }),
    ("a sample that collides", |problem, answer| {
        let all = truth(problem, Detail::Samples).samples.unwrap_or_default();
        let bad = all
            .iter()
            .position(|one| one.status == SampleStatus::Collision);
        bad.is_some_and(|bad| edit(answer, |winner| winner.index = bad as u32))
    }),
    ("a clearance", |_, answer| {
        edit(answer, |winner| winner.terms.clearance += 1)
    }),
    ("a heading", |_, answer| {
        edit(answer, |winner| winner.terms.heading ^= 1 << 9)
    }),
    ("a score", |_, answer| {
        edit(answer, |winner| winner.score ^= 1)
    }),
    ("nothing but zeros", |_, answer| {
        *answer = Evaluation::default();
        true
    }),
    ("nothing but ones", |_, answer| {
        answer.counts.admissible = u32::MAX;
        answer.totals.sums = [u64::MAX; 4];
        answer.totals.max = [u32::MAX; 4];
        edit(answer, |winner| winner.score = -1)
    }),
    ("a winner kept back", |_, answer| {
        answer.winner.take().is_some()
    }),
    ("a sample counted twice", |_, answer| {
        answer.counts.collision += 1;
        true
    }),
    ("totals of less", |_, answer| {
        answer.totals.sums[1] >>= 9;
        answer.totals.sums[1] > 0
    }),
    ("a greatest below the winner", |_, answer| {
        answer.totals.max[0] = 0;
        answer.winner.is_some_and(|winner| winner.terms.heading > 0)
    }),
    ("a list cut short", |_, answer| {
        let list = answer.samples.as_mut();
        list.is_some_and(|list| list.pop().is_some())
    }),
];

fn edit(answer: &mut Evaluation, change: impl FnOnce(&mut inbye::local::Winner)) -> bool {
    answer.winner.as_mut().map(change).is_some()
}

#[test]
fn no_falsified_winner_is_used() {
    for (what, falsify) in FALSIFICATIONS {
        let mut falsified = 0;
        for case in 0..200 {
            let problem = problem(case);
            let truth = truth(&problem, Detail::Samples);
            let mut changed = truth.clone();
            if !falsify(&problem, &mut changed) || changed == truth {
                continue;
            }
            falsified += 1;
            let gpu = Tricky::boxed(move |_, _, _| Ok(changed.clone()));
            let mut failover = with_cpu(Ok(gpu), || Ok(Tricky::honest()));
            let answer = failover.evaluate(&problem, Detail::Samples);
            assert_eq!(answer, Ok(truth), "{what}, case {case}");
            let met = met(&failover);
            assert_eq!(
                met.failures.get(&GpuFailureKind::WrongAnswer),
                Some(&1),
                "{what}"
            );
            assert_eq!((met.on_cpu, failover.kind()), (1, "cpu"), "{what}");
        }
        assert!(falsified > 8, "{what}: only {falsified} problems show it");
    }
}

/// The answer to the problem before, as a buffer that was not written again would have it.
#[test]
fn the_answer_to_another_problem_is_not_used() {
    let mut last = None;
    let gpu = Tricky::boxed(move |_, _, answer| {
        let stale = last.replace(answer.clone());
        Ok(stale.unwrap_or(answer))
    });
    let mut failover = with_cpu(Ok(gpu), || panic!("not so soon"));
    ask(&mut failover, 0..8);
    let met = met(&failover);
    assert_eq!(met.failures.get(&GpuFailureKind::WrongAnswer), Some(&1));
    assert_eq!((met.messages[0].decision, met.on_cpu), (2, 7));
}

/// What the doc of [`Failover`] admits: another safe sample, rightly scored, passes. Should this begin to fail, the doc
/// promises too little.
#[test]
fn a_safe_sample_that_is_not_the_best_is_believed() {
    let mut answers = (0..).map(problem).map(|problem| {
        let answer = truth(&problem, Detail::Samples);
        (problem, answer)
    });
    let several = |(_, answer): &(QuantizedProblem, Evaluation)| answer.counts.admissible > 1;
    let (problem, mut answer) = answers.find(several).expect("a problem of many");
    let all = answer.samples.take().expect("asked for");
    let winner = answer.winner.as_mut().expect("an admissible sample");
    let other = (0..)
        .zip(&all)
        .find(|(index, one)| one.status == SampleStatus::Ok && *index != winner.index);
    let (index, other) = other.expect("two admissible samples");
    let normalizers = inbye::local::internals::score::normalizers(&problem.header, &answer.totals);
    winner.index = index;
    winner.terms = other.terms;
    winner.score = inbye::local::internals::score::score(&other.terms, &normalizers);
    let told = answer.clone();
    let gpu = Tricky::boxed(move |_, _, _| Ok(told.clone()));
    let mut failover = with_cpu(Ok(gpu), || panic!("nothing was lost"));
    assert_eq!(failover.evaluate(&problem, Detail::Answer), Ok(answer));
}

#[test]
fn a_batch_falls_to_the_cpu_as_a_whole() {
    let gpu = Tricky::boxed(|decision, _, mut answer| {
        if decision == 3 {
            answer.counts.outside += 1;
        }
        Ok(answer)
    });
    let mut failover = with_cpu(Ok(gpu), || panic!("not so soon"));
    let problems: Vec<QuantizedProblem> = (0..5).map(problem).collect();
    let expected: Vec<_> = problems
        .iter()
        .map(|one| truth(one, Detail::Answer))
        .collect();
    let answers = failover.evaluate_batch(&problems, Detail::Answer);
    assert_eq!(answers, Ok(expected));
    let met = met(&failover);
    assert_eq!((met.decisions, met.on_cpu, met.total_failures()), (1, 1, 1));
}

/// An engine that takes its time to go: it waits to be let go of, and says when it is gone.
struct Lingering {
    engine: Box<dyn Engine>,
    let_go: Receiver<()>,
    gone: Arc<AtomicBool>,
}

impl Engine for Lingering {
    fn name(&self) -> String {
        self.engine.name()
    }

    fn kind(&self) -> &'static str {
        "gpu"
    }

    fn threads(&self) -> usize {
        0
    }

    fn evaluate(
        &mut self,
        problem: &QuantizedProblem,
        detail: Detail,
    ) -> Result<Evaluation, EngineError> {
        self.engine.evaluate(problem, detail)
    }
}

impl Drop for Lingering {
    fn drop(&mut self) {
        // Bounded, so that a decision that waits for this fails below and does not hang.
        let _ = self.let_go.recv_timeout(Duration::from_secs(60));
        self.gone.store(true, Ordering::SeqCst);
    }
}

#[test]
fn no_decision_waits_for_a_device_to_close_or_to_open() {
    let (let_go, when_let_go) = channel();
    let gone = Arc::new(AtomicBool::new(false));
    let gpu = Lingering {
        engine: Tricky::boxed(|_, _, _| Err(lost(GpuFailureKind::TimedOut))),
        let_go: when_let_go,
        gone: Arc::clone(&gone),
    };
    let (opens, when_open) = channel();
    let when_open = Mutex::new(when_open);
    let source = BackgroundOpener::new(move || {
        let told = when_open.lock().expect("nobody panics").recv();
        told.map_err(|_| EngineError::NoAdapter)?;
        Ok(Tricky::honest())
    });
    let cpu = CpuEngine::single_threaded();
    let mut failover = Failover::new(Ok(Box::new(gpu)), source, cpu);
    ask(&mut failover, 0..30);
    assert!(!gone.load(Ordering::SeqCst));
    let still = met(&failover);
    assert_eq!(
        (still.on_cpu, still.reopened, still.reopen_failures),
        (30, 0, 0)
    );
    let_go.send(()).expect("it is being closed");
    opens.send(()).expect("it is being opened");
    let mut case = 30;
    while failover.kind() == "cpu" {
        ask(&mut failover, case..case + 1);
        case += 1;
    }
    assert_eq!(met(&failover).reopened, 1);
    drop(failover);
    assert!(gone.load(Ordering::SeqCst));
}

#[test]
fn a_thread_that_panics_while_it_opens_a_device_is_an_attempt_in_vain() {
    let source = BackgroundOpener::new(|| panic!("as told"));
    let cpu = CpuEngine::single_threaded();
    let mut failover = Failover::new(Err(EngineError::NoAdapter), source, cpu);
    let mut case = 0;
    while met(&failover).reopen_failures == 0 {
        ask(&mut failover, case..case + 1);
        case += 1;
    }
    assert_eq!(
        met(&failover).messages[1].kind,
        Some(GpuFailureKind::OpenFailed)
    );
}
