//! The base stops however the host ends: by the host's zero commands if it can still send, else by the base's watchdog.

use std::env;
use std::process::Command;
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use inbye::base::{
    BaseSettings, BaseSupervisor, OpenBase, Protocol, SerialBase, SerialSettings,
    SupervisorSettings,
};
use inbye::geometry::Twist;
use serde_json::json;

use super::processes::{Emulated, PROGRAM, Process, number};

/// Time for a base to reach its speed.
const START_TIME: Duration = Duration::from_secs(1);

/// Time for a base to read the last commands and to brake.
const BRAKE_TIME: Duration = Duration::from_millis(1500);

/// Time for a watchdog to stop a base: the slowest one takes 2 s. No poll can replace it, because a host's bytes reset watchdogs.
const WATCHDOG_TIME: Duration = Duration::from_secs(6);

/// Runs a test with every protocol at once: most of its time is waiting.
fn with_every_protocol(test: impl Fn(&'static str) + Sync) {
    thread::scope(|scope| {
        for protocol in ["native", "wheeltec", "roboclaw", "arduino"] {
            let test = &test;
            scope.spawn(move || test(protocol));
        }
    });
}

/// Starts a host that drives.
fn driving(base: &Emulated) -> Process {
    let mut host = base.host("base send --linear 0.4 --angular 0.2 --for 600");
    host.await_note("the base answers");
    thread::sleep(START_TIME);
    host
}

/// Checks that zero commands of the host stopped the base.
#[track_caller]
fn assert_stopped_by_zeros(base: Emulated, case: &str) {
    thread::sleep(BRAKE_TIME);
    let summary = base.end();
    let zeros = summary["final_zero_commands"].as_u64().expect("a count");
    assert!(zeros >= 3, "{case}: {summary}");
    assert_eq!(summary["watchdog_stops"], json!(0), "{case}: {summary}");
    assert_eq!(summary["linear"], json!(0.0), "{case}: {summary}");
    assert!(
        summary["travelled_m"].as_f64().expect("a number") > 0.05,
        "{case}: it had driven: {summary}"
    );
}

#[test]
fn signals_stop_base_with_zeros() {
    with_every_protocol(|protocol| {
        for signal in ["INT", "TERM"] {
            let base = Emulated::start(protocol, "");
            let host = driving(&base);
            host.signal(signal);
            let ended = host.wait();
            assert_eq!(ended.status.code(), Some(1), "{protocol}: {ended:?}");
            assert_eq!(ended.object()["interrupted"], json!(true), "{ended:?}");
            assert_stopped_by_zeros(base, &format!("{protocol}, {signal}"));
        }
    });
}

/// The emulated firmware keeps its last speed.
#[test]
fn base_that_drives_on_after_a_signal_is_a_fault() {
    let base = Emulated::start("wheeltec", "--fault ignored-commands@3");
    let mut host = base.host("base send --linear 0.3 --for 600");
    host.await_note("the base answers");
    thread::sleep(4 * START_TIME);
    host.signal("INT");
    let ended = host.wait();
    assert_eq!(ended.status.code(), Some(1), "{ended:?}");
    let object = ended.object();
    assert_eq!(object["interrupted"], json!(true), "{ended:?}");
    let cause = object["stop_cause"].as_str().expect("a cause");
    assert!(cause.contains("cut the motors' power"), "{cause}");
}

/// The motors are 0.3 s late: they have hardly followed when the signal comes, and the base has reported that it stands.
#[test]
fn program_does_not_end_before_late_motors_have_stopped() {
    let base = Emulated::start("native", "--fault late-motors@0");
    let mut host = base.host("base send --linear 0.6 --for 600");
    host.await_note("the base answers");
    thread::sleep(Duration::from_millis(350));
    host.signal("TERM");
    let ended = host.wait();
    assert_eq!(ended.object()["stop_cause"], json!(null), "{ended:?}");
    thread::sleep(START_TIME);
    let summary = base.end();
    let stood_s = number(&summary, "time_s") - number(&summary, "last_motion_s");
    assert!(number(&summary, "travelled_m") > 0.005, "{summary}");
    assert!(stood_s > START_TIME.as_secs_f64(), "it moved after the end: {summary}");
}

/// Checks that a signal stops a base without a watchdog, and ends the program.
fn check_signal(signal: &str, command: &str, (note, after): (&str, Duration)) {
    let base = Emulated::start("wheeltec", "");
    let mut host = base.host(command);
    host.await_note(note);
    thread::sleep(after);
    host.signal(signal);
    let ended = host.wait();
    let case = format!("{command}, {signal}");
    assert_eq!(ended.status.code(), Some(1), "{case}: {ended:?}");
    assert_eq!(ended.object()["interrupted"], json!(true), "{ended:?}");
    assert_stopped_by_zeros(base, &case);
}

/// Signals of a terminal, of timers and limits, and the stop signal.
#[test]
fn every_signal_stops_base_with_zeros() {
    const SIGNALS: [&str; 9] =
        ["QUIT", "TSTP", "USR1", "USR2", "ALRM", "VTALRM", "PROF", "XCPU", "ABRT"];
    for signals in SIGNALS.chunks(4) {
        thread::scope(|scope| {
            for signal in signals {
                let send = "base send --linear 0.3 --for 600";
                scope.spawn(move || {
                    check_signal(signal, send, ("the base answers", 2 * START_TIME));
                });
            }
        });
    }
    let calibrate = "base calibrate --yes --turns 0 --distance 5";
    // It stands for three seconds before it drives.
    check_signal("USR1", calibrate, ("has no watchdog", 6 * START_TIME));
}

/// Reading from the terminal and writing to it in the background, a file at its largest size, and a terminal that is closed under
/// `nohup`.
#[test]
fn ignored_signals_neither_suspend_nor_end_the_program() {
    let base = Emulated::start("wheeltec", "");
    let send = base.on_line("base send --linear 0.3 --for 600");
    let mut command = Command::new("sh");
    command.args(["-c", "trap '' HUP; exec $0", &format!("{PROGRAM} {send}")]);
    let mut host = Process::of(command);
    host.await_note("the base answers");
    thread::sleep(START_TIME);
    for signal in ["TTIN", "TTOU", "XFSZ", "HUP"] {
        host.signal(signal);
    }
    thread::sleep(2 * START_TIME);
    host.signal("INT");
    let ended = host.wait();
    assert_eq!(ended.status.code(), Some(1), "{ended:?}");
    let object = ended.object();
    assert!(object["time_s"].as_f64().is_some_and(|time_s| time_s > 2.5), "{object}");
    assert_stopped_by_zeros(base, "TTIN, TTOU, XFSZ, HUP");
}

/// A monitor without `--for` ends by a signal only.
#[test]
fn signal_is_the_normal_end_of_a_monitor() {
    for signal in ["INT", "TERM", "TSTP"] {
        let base = Emulated::start("native", "");
        let mut host = base.host("base monitor");
        host.line();
        host.signal(signal);
        let ended = host.wait();
        assert_eq!(ended.status.code(), Some(0), "{signal}: {ended:?}");
        base.end();
    }
}

#[test]
fn signal_before_the_base_answers_ends_the_program() {
    for (base, command) in [
        (Emulated::start("native", "--fault silence@0"), "base send"),
        (Emulated::start("native", "--fault silence@0"), "base monitor"),
    ] {
        let host = base.host(command);
        thread::sleep(START_TIME);
        host.signal("INT");
        let ended = host.wait();
        assert_eq!(ended.status.code(), Some(1), "{command}: {ended:?}");
        assert!(
            ended.stderr.contains("stopped by a signal before the device answered"),
            "{ended:?}"
        );
        assert!(!ended.stderr.contains("the base answers"), "{ended:?}");
    }
}

#[test]
fn second_signal_stops_base_with_zeros() {
    with_every_protocol(|protocol| {
        let base = Emulated::start(protocol, "");
        let host = driving(&base);
        host.signal("INT");
        host.signal("INT");
        let ended = host.wait();
        // Ended by the first or the second signal.
        assert!(matches!(ended.status.code(), Some(1 | 130)), "{protocol}: {ended:?}");
        assert_stopped_by_zeros(base, &format!("{protocol}, INT twice"));
    });
}

/// Runs this test program again, with the test that panics while it drives.
#[test]
fn panic_stops_base_with_zeros() {
    with_every_protocol(|protocol| {
        let base = Emulated::start(protocol, "");
        let mut command = Command::new(env::current_exe().expect("this program"));
        command
            .args(["panics_while_driving", "--ignored"])
            .env("INBYE_TEST_BASE", format!("{protocol} {}", base.port));
        let ended = Process::of(command).wait();
        assert!(!ended.status.success(), "{ended:?}");
        assert!(ended.stdout.contains("the planner has a bug"), "{ended:?}");
        assert_stopped_by_zeros(base, protocol);
    });
}

#[test]
#[ignore = "it panics: panic_stops_base_with_zeros runs it in another process"]
fn panics_while_driving() {
    let base = env::var("INBYE_TEST_BASE").expect("set by the other test");
    let (protocol, port) = base.split_once(' ').expect("two words");
    let (protocol, port): (Protocol, String) = (protocol.parse().unwrap(), port.to_owned());
    let settings = BaseSettings::default();
    let open: OpenBase = Box::new(move || {
        let session = protocol.session(settings)?;
        let timeouts = SerialSettings::default();
        Ok(Box::new(SerialBase::open(&port, session, timeouts)?))
    });
    let supervisor =
        BaseSupervisor::start(open, &settings, SupervisorSettings::default(), Arc::default())
            .expect("an open line");
    while supervisor.status().travelled_m < 0.1 {
        let _ = supervisor.set_target(&Twist::new(0.4, 0.0), supervisor.now_s());
        thread::sleep(Duration::from_millis(20));
    }
    panic!("the planner has a bug");
}

/// The summary of a base whose host was killed.
fn kill_and_wait(protocol: &'static str) -> serde_json::Value {
    let base = Emulated::start(protocol, "");
    let host = driving(&base);
    host.signal("KILL");
    host.wait();
    thread::sleep(WATCHDOG_TIME);
    base.end()
}

/// A killed host sends nothing: a base without a watchdog keeps driving.
#[test]
fn watchdog_stops_base_of_killed_host() {
    with_every_protocol(|protocol| {
        // On a busy machine the target may expire before the kill, and the base then stands already.
        let summary = (0..3)
            .map(|_| kill_and_wait(protocol))
            .find(|summary| summary["final_zero_commands"] == json!(0))
            .expect("a killed host sends no zeros");
        let has_watchdog = protocol != "wheeltec";
        let stops = u64::from(has_watchdog);
        assert_eq!(summary["watchdog_stops"], json!(stops), "{protocol}: {summary}");
        let stands = summary["linear"] == json!(0.0);
        assert_eq!(stands, has_watchdog, "{protocol}: {summary}");
    });
}
