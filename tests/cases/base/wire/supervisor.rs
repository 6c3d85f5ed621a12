//! The supervisor on a connection in memory: it stops the base however its owner ends, and reconnects.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use inbye::base::{
    Base, BaseError, BaseSettings, BaseSupervisor, CollisionMonitorSettings, DriveStatus, Feedback,
    OpenBase, ProtectiveAction, ProtectiveLayer, ScanSource, SupervisorSettings, SupervisorStatus,
};
use inbye::geometry::Twist;
use inbye::map::{Beam, TimedScan};
use inbye::robot::{Footprint, Limits};

/// Generous enough for a busy machine.
const TIMEOUT: Duration = Duration::from_secs(20);
const AHEAD: Twist = Twist::new(0.5, 0.0);

/// Commands received, by connection.
type Commands = Arc<Mutex<Vec<Vec<Twist>>>>;

/// A base that follows every command at once, on a connection that can be cut.
struct IdealBase {
    commands: Commands,
    cut: Arc<AtomicBool>,
    now: Twist,
}

impl IdealBase {
    fn check(&self) -> Result<(), BaseError> {
        if self.cut.load(Ordering::Relaxed) { Err(disconnected()) } else { Ok(()) }
    }
}

fn disconnected() -> BaseError {
    BaseError::Disconnected { port: "memory".to_owned() }
}

impl Base for IdealBase {
    fn send(&mut self, command: &Twist) -> Result<(), BaseError> {
        self.check()?;
        assert!(command.is_finite());
        self.now = *command;
        let mut commands = self.commands.lock().expect("not poisoned");
        commands.last_mut().expect("a connection").push(*command);
        Ok(())
    }

    fn feedback(&mut self) -> Result<Feedback, BaseError> {
        self.check()?;
        Ok(Feedback { twist: self.now, ..Feedback::default() })
    }
}

struct TestBase {
    commands: Commands,
    cut: Arc<AtomicBool>,
    shutdown: Arc<AtomicBool>,
}

impl TestBase {
    fn new() -> Self {
        Self { commands: Arc::default(), cut: Arc::default(), shutdown: Arc::default() }
    }

    fn supervisor(&self) -> BaseSupervisor {
        let (commands, cut) = (Arc::clone(&self.commands), Arc::clone(&self.cut));
        let open: OpenBase = Box::new(move || {
            if cut.load(Ordering::Relaxed) {
                return Err(disconnected());
            }
            commands.lock().expect("not poisoned").push(Vec::new());
            Ok(Box::new(IdealBase {
                commands: Arc::clone(&commands),
                cut: Arc::clone(&cut),
                now: Twist::STOP,
            }))
        });
        let settings = SupervisorSettings::default()
            .rate_hz(200.0)
            .reconnect_min_s(0.01)
            .reconnect_max_s(0.04)
            // A busy machine must not look like a hung planner or a stopped process.
            .target_timeout_s(2.0)
            .max_gap_s(2.0);
        let shutdown = Arc::clone(&self.shutdown);
        BaseSupervisor::start(open, &BaseSettings::default(), settings, shutdown)
            .expect("a connection")
    }

    /// The last commands on the latest connection.
    fn last(&self, count: usize) -> Vec<Twist> {
        let commands = self.commands.lock().expect("not poisoned");
        let line = commands.last().expect("a connection");
        line[line.len().saturating_sub(count)..].to_vec()
    }
}

/// Sets the target until a condition holds.
fn drive_until(
    supervisor: &BaseSupervisor,
    holds: impl Fn(&SupervisorStatus) -> bool,
) -> SupervisorStatus {
    let started = Instant::now();
    loop {
        let _ = supervisor.set_target(&AHEAD, supervisor.now_s());
        let status = supervisor.status();
        if holds(&status) {
            return status;
        }
        assert!(started.elapsed() < TIMEOUT, "{status:?}");
        thread::sleep(Duration::from_millis(5));
    }
}

fn is_fast(status: &SupervisorStatus) -> bool {
    status.sent == AHEAD
}

#[test]
fn dropped_supervisor_sends_three_zeros() {
    let base = TestBase::new();
    let supervisor = base.supervisor();
    drive_until(&supervisor, is_fast);
    assert_ne!(base.last(1), [Twist::STOP]);
    drop(supervisor);
    assert_eq!(base.last(3), [Twist::STOP; 3]);
    // Zeros for a standstill of 0.3 s, and the last ones.
    assert!(base.last(100).iter().any(|sent| *sent != Twist::STOP), "it drove until the end");
    // The flag of the caller may be that of a handler of signals.
    assert!(!base.shutdown.load(Ordering::Relaxed));
}

/// A base that follows zero only after a number of reports, if ever.
struct SlowToStop {
    now: Twist,
    reports_at_speed: Option<u32>,
}

impl Base for SlowToStop {
    fn send(&mut self, command: &Twist) -> Result<(), BaseError> {
        match &mut self.reports_at_speed {
            _ if *command != Twist::STOP => self.now = *command,
            Some(0) => self.now = Twist::STOP,
            Some(left) => *left -= 1,
            None => {}
        }
        Ok(())
    }

    fn feedback(&mut self) -> Result<Feedback, BaseError> {
        Ok(Feedback { twist: self.now, ..Feedback::default() })
    }
}

#[test]
fn end_waits_for_the_standstill_and_reports_a_base_that_drives_on() {
    for (reports_at_speed, stops) in [(Some(100), true), (None, false)] {
        let open: OpenBase =
            Box::new(move || Ok(Box::new(SlowToStop { now: Twist::STOP, reports_at_speed })));
        let settings =
            SupervisorSettings::default().rate_hz(200.0).target_timeout_s(2.0).max_gap_s(2.0);
        let supervisor =
            BaseSupervisor::start(open, &BaseSettings::default(), settings, Arc::default());
        let supervisor = supervisor.expect("a connection");
        drive_until(&supervisor, is_fast);
        let began = Instant::now();
        let status = supervisor.end();
        assert!(status.is_running, "it ran until the call");
        assert!(began.elapsed() > Duration::from_millis(500), "{:?}", began.elapsed());
        let why = status.stop_cause.map(|cause| cause.to_string());
        if stops {
            assert_eq!(why, None);
            assert_eq!(status.feedback.expect("reports").twist, Twist::STOP);
        } else {
            let why = why.expect("a cause");
            assert!(
                why.contains("keeps 0.50 m/s") && why.contains("cut the motors' power"),
                "{why}"
            );
        }
    }
}

#[test]
fn panicking_owner_leaves_three_zeros() {
    let base = TestBase::new();
    let supervisor = base.supervisor();
    let outcome = catch_unwind(AssertUnwindSafe(move || {
        drive_until(&supervisor, is_fast);
        panic!("a planner's error");
    }));
    assert!(outcome.is_err());
    assert_eq!(base.last(3), [Twist::STOP; 3]);
}

#[test]
fn shutdown_flag_leaves_three_zeros() {
    let base = TestBase::new();
    let supervisor = base.supervisor();
    drive_until(&supervisor, is_fast);
    base.shutdown.store(true, Ordering::Relaxed);
    // Further targets have no effect.
    drive_until(&supervisor, |status| !status.is_running);
    drop(supervisor);
    assert_eq!(base.last(3), [Twist::STOP; 3]);
}

#[test]
fn repeated_old_target_expires() {
    let base = TestBase::new();
    let supervisor = base.supervisor();
    drive_until(&supervisor, is_fast);
    let stamp_s = supervisor.now_s();
    supervisor.set_target(&AHEAD, stamp_s).expect("a valid target");
    let started = Instant::now();
    // The planner's thread runs, but repeats an old target.
    loop {
        let _ = supervisor.set_target(&AHEAD, stamp_s);
        let status = supervisor.status();
        if matches!(status.drive_status, DriveStatus::TargetExpired { .. })
            && status.sent == Twist::STOP
        {
            break;
        }
        assert!(started.elapsed() < TIMEOUT, "{status:?}");
        thread::sleep(Duration::from_millis(5));
    }
    assert_eq!(base.last(1), [Twist::STOP]);
}

#[test]
fn lost_connection_is_reopened_and_starts_with_zero() {
    let base = TestBase::new();
    let supervisor = base.supervisor();
    drive_until(&supervisor, is_fast);
    base.cut.store(true, Ordering::Relaxed);
    let status = drive_until(&supervisor, |status| status.counters.connection_failures >= 3);
    assert!(matches!(status.drive_status, DriveStatus::Disconnected(_)));
    assert_eq!(status.sent, Twist::STOP);
    base.cut.store(false, Ordering::Relaxed);
    drive_until(&supervisor, is_fast);
    let commands = base.commands.lock().expect("not poisoned");
    assert_eq!(commands.len(), 2);
    assert_eq!(commands[1][0], Twist::STOP);
    drop(commands);
    assert_eq!(supervisor.status().counters.connections, 2);
}

#[test]
fn start_fails_if_first_open_fails() {
    let open: OpenBase = Box::new(|| Err(disconnected()));
    let settings = SupervisorSettings::default();
    let supervisor =
        BaseSupervisor::start(open, &BaseSettings::default(), settings, Arc::default());
    assert_eq!(supervisor.err(), Some(disconnected()));
}

/// The driver panics in the supervisor's thread.
#[test]
fn panicking_supervisor_thread_leaves_zeros() {
    struct Buggy(IdealBase, u32);
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
    let base = TestBase::new();
    let commands = Arc::clone(&base.commands);
    let open: OpenBase = Box::new(move || {
        commands.lock().expect("not poisoned").push(Vec::new());
        let base =
            IdealBase { commands: Arc::clone(&commands), cut: Arc::default(), now: Twist::STOP };
        Ok(Box::new(Buggy(base, 0)))
    });
    let settings =
        SupervisorSettings::default().rate_hz(200.0).target_timeout_s(2.0).max_gap_s(2.0);
    let supervisor =
        BaseSupervisor::start(open, &BaseSettings::default(), settings, Arc::default());
    let supervisor = supervisor.expect("a connection");
    drive_until(&supervisor, |status| !status.is_running);
    drop(supervisor);
    assert_eq!(base.last(3), [Twist::STOP; 3]);
}

/// Raw scans reach the protective layer by the supervisor's own thread.
#[test]
fn base_drives_only_with_scans_of_its_lidar() {
    for has_scans in [true, false] {
        let base = TestBase::new();
        let supervisor = base.supervisor();
        let body = Footprint::round(0.3).expect("a radius");
        let monitor = CollisionMonitorSettings::default().source_timeout(10.0);
        let layer = ProtectiveLayer::new(monitor, &body, Limits::default(), 0.02);
        let mut layer = layer.expect("valid settings");
        layer.arm();
        let scans: ScanSource = Box::new(move |now_s| {
            let beam = |index: i32| {
                // Every scan differs from the one before.
                let range = 8.0 + 0.1 * now_s.fract();
                Beam { angle: f64::from(index).to_radians(), range, time_s: now_s }
            };
            let beams = (0..360).map(beam).collect();
            has_scans.then_some(TimedScan { beams, range_max: 12.0, ..TimedScan::default() })
        });
        supervisor.protect(layer, Some(scans));
        if has_scans {
            drive_until(&supervisor, is_fast);
        } else {
            let no_scan = DriveStatus::Protected(ProtectiveAction::NoScan);
            drive_until(&supervisor, |status| status.drive_status == no_scan);
            assert_eq!(base.last(1), [Twist::STOP]);
        }
    }
}
