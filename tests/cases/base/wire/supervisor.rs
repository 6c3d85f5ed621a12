//! The sender's thread on a line in memory: it stops the base however its owner ends, and opens lost lines anew.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use inbye::base::{
    Base, BaseError, BaseSettings, BaseSupervisor, DriveStatus, Feedback, OpenBase,
    SupervisorSettings, SupervisorStatus,
};
use inbye::geometry::Twist;

/// A bound so generous that a busy machine does not trip it.
const PATIENCE: Duration = Duration::from_secs(20);
const AHEAD: Twist = Twist::new(0.5, 0.0);

/// What a base was told, line by line.
type Told = Arc<Mutex<Vec<Vec<Twist>>>>;

/// A base that does at once what it is told, on a line that can be cut.
struct Obedient {
    told: Told,
    cut: Arc<AtomicBool>,
    now: Twist,
}

impl Obedient {
    fn unplugged(&self) -> Result<(), BaseError> {
        if self.cut.load(Ordering::Relaxed) {
            Err(unplugged())
        } else {
            Ok(())
        }
    }
}

fn unplugged() -> BaseError {
    BaseError::Disconnected {
        port: "memory".to_owned(),
    }
}

impl Base for Obedient {
    fn send(&mut self, command: &Twist) -> Result<(), BaseError> {
        self.unplugged()?;
        assert!(command.is_finite());
        self.now = *command;
        let mut told = self.told.lock().expect("no test fails with it");
        told.last_mut().expect("a line").push(*command);
        Ok(())
    }

    fn feedback(&mut self) -> Result<Feedback, BaseError> {
        self.unplugged()?;
        Ok(Feedback {
            twist: self.now,
            ..Feedback::default()
        })
    }
}

struct Place {
    told: Told,
    cut: Arc<AtomicBool>,
    end: Arc<AtomicBool>,
}

impl Place {
    fn new() -> Self {
        Self {
            told: Arc::default(),
            cut: Arc::default(),
            end: Arc::default(),
        }
    }

    fn supervisor(&self) -> BaseSupervisor {
        let (told, cut) = (Arc::clone(&self.told), Arc::clone(&self.cut));
        let open: OpenBase = Box::new(move || {
            if cut.load(Ordering::Relaxed) {
                return Err(unplugged());
            }
            told.lock().expect("no test fails with it").push(Vec::new());
            Ok(Box::new(Obedient {
                told: Arc::clone(&told),
                cut: Arc::clone(&cut),
                now: Twist::STOP,
            }))
        });
        let settings = SupervisorSettings {
            rate_hz: 200.0,
            reconnect_min_s: 0.01,
            reconnect_max_s: 0.04,
            // A busy machine is not to be taken for a hung planner.
            target_timeout_s: 2.0,
            ..SupervisorSettings::default()
        };
        let end = Arc::clone(&self.end);
        BaseSupervisor::start(open, &BaseSettings::default(), settings, end).expect("an open line")
    }

    /// The last commands on the newest line.
    fn last(&self, count: usize) -> Vec<Twist> {
        let told = self.told.lock().expect("no test fails with it");
        let line = told.last().expect("a line");
        line[line.len().saturating_sub(count)..].to_vec()
    }
}

/// Plans until something holds.
fn drive_until(
    supervisor: &BaseSupervisor,
    holds: impl Fn(&SupervisorStatus) -> bool,
) -> SupervisorStatus {
    let began = Instant::now();
    loop {
        let _ = supervisor.set_target(&AHEAD, supervisor.now_s());
        let status = supervisor.status();
        if holds(&status) {
            return status;
        }
        assert!(began.elapsed() < PATIENCE, "{status:?}");
        thread::sleep(Duration::from_millis(5));
    }
}

fn is_fast(status: &SupervisorStatus) -> bool {
    status.sent == AHEAD
}

#[test]
fn it_ends_with_three_zeros_when_it_is_dropped() {
    let place = Place::new();
    let supervisor = place.supervisor();
    drive_until(&supervisor, is_fast);
    assert_ne!(place.last(1), [Twist::STOP]);
    drop(supervisor);
    assert_eq!(place.last(3), [Twist::STOP; 3]);
    assert_ne!(place.last(6)[0], Twist::STOP, "it drove to the last");
}

#[test]
fn it_ends_with_three_zeros_when_its_owner_panics() {
    let place = Place::new();
    let supervisor = place.supervisor();
    let outcome = catch_unwind(AssertUnwindSafe(move || {
        drive_until(&supervisor, is_fast);
        panic!("a planner's error");
    }));
    assert!(outcome.is_err());
    assert_eq!(place.last(3), [Twist::STOP; 3]);
}

#[test]
fn it_ends_with_three_zeros_when_its_end_is_asked_for() {
    let place = Place::new();
    let supervisor = place.supervisor();
    drive_until(&supervisor, is_fast);
    place.end.store(true, Ordering::Relaxed);
    // The owner goes on to plan, in vain.
    drive_until(&supervisor, |status| !status.is_running);
    drop(supervisor);
    assert_eq!(place.last(3), [Twist::STOP; 3]);
}

#[test]
fn a_hung_planner_whose_threads_live_is_stopped_by_the_age_of_its_plan() {
    let place = Place::new();
    let supervisor = place.supervisor();
    drive_until(&supervisor, is_fast);
    let planned_s = supervisor.now_s();
    supervisor
        .set_target(&AHEAD, planned_s)
        .expect("a good plan");
    let began = Instant::now();
    // It lives and speaks, and repeats what it planned.
    loop {
        let _ = supervisor.set_target(&AHEAD, planned_s);
        let status = supervisor.status();
        if matches!(status.drive_status, DriveStatus::TargetExpired { .. })
            && status.sent == Twist::STOP
        {
            break;
        }
        assert!(began.elapsed() < PATIENCE, "{status:?}");
        thread::sleep(Duration::from_millis(5));
    }
    assert_eq!(place.last(1), [Twist::STOP]);
}

#[test]
fn a_lost_line_is_opened_anew_and_begins_with_zero() {
    let place = Place::new();
    let supervisor = place.supervisor();
    drive_until(&supervisor, is_fast);
    place.cut.store(true, Ordering::Relaxed);
    let status = drive_until(&supervisor, |status| {
        status.counters.connection_failures >= 3
    });
    assert!(matches!(status.drive_status, DriveStatus::Disconnected(_)));
    assert_eq!(status.sent, Twist::STOP);
    place.cut.store(false, Ordering::Relaxed);
    drive_until(&supervisor, is_fast);
    let told = place.told.lock().expect("no test fails with it");
    assert_eq!(told.len(), 2);
    assert_eq!(told[1][0], Twist::STOP);
    drop(told);
    assert_eq!(supervisor.status().counters.connections, 2);
}

#[test]
fn a_line_that_cannot_be_opened_at_first_is_told_at_once() {
    let open: OpenBase = Box::new(|| Err(unplugged()));
    let settings = SupervisorSettings::default();
    let kept = BaseSupervisor::start(open, &BaseSettings::default(), settings, Arc::default());
    assert_eq!(kept.err(), Some(unplugged()));
}

/// A base whose driver has a bug: it panics in the sender's own thread.
#[test]
fn a_panic_of_the_sender_itself_leaves_zeros() {
    struct Buggy(Obedient, u32);
    impl Base for Buggy {
        fn send(&mut self, command: &Twist) -> Result<(), BaseError> {
            self.0.send(command)
        }
        fn feedback(&mut self) -> Result<Feedback, BaseError> {
            self.1 += 1;
            assert_ne!(self.1, 200, "a bug");
            self.0.feedback()
        }
    }
    let place = Place::new();
    let told = Arc::clone(&place.told);
    let open: OpenBase = Box::new(move || {
        told.lock().expect("no test fails with it").push(Vec::new());
        let base = Obedient {
            told: Arc::clone(&told),
            cut: Arc::default(),
            now: Twist::STOP,
        };
        Ok(Box::new(Buggy(base, 0)))
    });
    let settings = SupervisorSettings {
        rate_hz: 200.0,
        target_timeout_s: 2.0,
        ..SupervisorSettings::default()
    };
    let supervisor =
        BaseSupervisor::start(open, &BaseSettings::default(), settings, Arc::default());
    let supervisor = supervisor.expect("an open line");
    drive_until(&supervisor, |status| !status.is_running);
    drop(supervisor);
    assert_eq!(place.last(3), [Twist::STOP; 3]);
}
