//! However a host ends the base stops: by the host's zeros where the host can still send, else by the base's watchdog.

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

use super::processes::{Emulated, Process};

/// Time in which a base gets going.
const UNDER_WAY: Duration = Duration::from_secs(1);

const PROTOCOLS: [&str; 4] = ["native", "wheeltec", "roboclaw", "arduino"];

/// A host that drives.
fn driving(base: &Emulated) -> Process {
    let mut host = base.host("base send --linear 0.4 --angular 0.2 --for 600");
    host.await_note("the base answers");
    thread::sleep(UNDER_WAY);
    host
}

/// Checks that it was the host's zeros that stopped the base.
#[track_caller]
fn assert_left_with_zeros(base: Emulated, case: &str) {
    // Bytes on their way, and a ramp of the motors.
    thread::sleep(Duration::from_millis(700));
    let summary = base.end();
    let zeros = summary["final_zero_commands"].as_u64().expect("a count");
    assert!(zeros >= 3, "{case}: {summary}");
    assert_eq!(summary["watchdog_stops"], json!(0), "{case}: {summary}");
    assert_eq!(summary["linear"], json!(0.0), "{case}: {summary}");
    assert!(
        summary["distance_m"].as_f64().expect("a number") > 0.05,
        "{case}: it had driven: {summary}"
    );
}

#[test]
fn signals_end_with_zeros() {
    for protocol in PROTOCOLS {
        for signal in ["INT", "TERM"] {
            let base = Emulated::start(protocol, "");
            let host = driving(&base);
            host.signal(signal);
            let ended = host.wait();
            assert_eq!(ended.status.code(), Some(1), "{protocol}: {ended:?}");
            assert_eq!(ended.object()["interrupted"], json!(true), "{ended:?}");
            assert_left_with_zeros(base, &format!("{protocol}, {signal}"));
        }
    }
}

/// Ctrl-C by somebody impatient.
#[test]
fn a_second_signal_right_after_the_first_ends_with_zeros_too() {
    for protocol in PROTOCOLS {
        let base = Emulated::start(protocol, "");
        let host = driving(&base);
        host.signal("INT");
        host.signal("INT");
        let ended = host.wait();
        // By the first or by the second, whichever was quicker.
        assert!(
            matches!(ended.status.code(), Some(1 | 130)),
            "{protocol}: {ended:?}"
        );
        assert_left_with_zeros(base, &format!("{protocol}, INT twice"));
    }
}

/// A process that panics while it drives: this test program again, with one test that does so.
#[test]
fn a_panic_ends_with_zeros() {
    for protocol in PROTOCOLS {
        let base = Emulated::start(protocol, "");
        let mut command = Command::new(env::current_exe().expect("this program"));
        command
            .args(["--exact", "endings::panics_under_way", "--ignored"])
            .env("INBYE_TEST_BASE", format!("{protocol} {}", base.port));
        let ended = Process::of(command).wait();
        assert!(!ended.status.success(), "{ended:?}");
        assert!(ended.stdout.contains("the planner has a bug"), "{ended:?}");
        assert_left_with_zeros(base, protocol);
    }
}

#[test]
#[ignore = "it panics: a_panic_ends_with_zeros runs it in a process of its own"]
fn panics_under_way() {
    let base = env::var("INBYE_TEST_BASE").expect("set by the other test");
    let (protocol, port) = base.split_once(' ').expect("two words");
    let (protocol, port): (Protocol, String) = (protocol.parse().unwrap(), port.to_owned());
    let settings = BaseSettings::default();
    let open: OpenBase = Box::new(move || {
        let session = protocol.session(settings)?;
        let within = SerialSettings::default();
        Ok(Box::new(SerialBase::open(&port, session, within)?))
    });
    let supervisor = BaseSupervisor::start(
        open,
        &settings,
        SupervisorSettings::default(),
        Arc::default(),
    )
    .expect("an open line");
    while supervisor.status().travelled_m < 0.1 {
        let _ = supervisor.set_target(&Twist::new(0.4, 0.0), supervisor.now_s());
        thread::sleep(Duration::from_millis(20));
    }
    panic!("the planner has a bug");
}

/// The end of a base whose host was killed.
fn kill_and_wait(protocol: &'static str) -> serde_json::Value {
    let base = Emulated::start(protocol, "");
    let host = driving(&base);
    host.signal("KILL");
    host.wait();
    // The slowest watchdog takes 2 s.
    thread::sleep(Duration::from_millis(3500));
    base.end()
}

/// What no program can do anything about. A base whose firmware has no watchdog drives on: this is why it must have one.
#[test]
fn after_a_kill_the_bases_watchdog_acts_where_it_has_one() {
    for (protocol, stops) in [
        ("native", 1),
        ("roboclaw", 1),
        ("arduino", 1),
        ("wheeltec", 0),
    ] {
        // On a machine that is held up, the sender stops on the age of its plan; the kill then meets one that stands.
        let summary = (0..3)
            .map(|_| kill_and_wait(protocol))
            .find(|summary| summary["final_zero_commands"] == json!(0))
            .expect("a host that is killed sends no zeros");
        assert_eq!(
            summary["watchdog_stops"],
            json!(stops),
            "{protocol}: {summary}"
        );
        let stands = summary["linear"] == json!(0.0);
        assert_eq!(stands, stops == 1, "{protocol}: {summary}");
    }
}
