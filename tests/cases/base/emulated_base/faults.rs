//! Faults of a base while it drives: what stops it, in what time, and what must not stop it.

use std::fs;
use std::os::unix::fs::symlink;
use std::thread;
use std::time::Duration;

use serde_json::{Value, json};

use super::processes::{Emulated, Process, number};

/// Start of a fault by the base's clock, seconds.
const FROM_S: f64 = 2.0;

/// Time by which a busy machine may delay a process, seconds.
const MARGIN_S: f64 = 1.5;

/// Drives with a fault. Returns the results of the host and of the base.
fn drive_with(protocol: &'static str, fault: &str, time_s: f64) -> (Value, Value) {
    let base = Emulated::start(protocol, &format!("--fault {fault}"));
    let ended = base.host(&format!("base send --linear 0.3 --for {time_s}")).wait();
    let sent = ended.object();
    let (stopped, done) = (!sent["stop_cause"].is_null(), ended.status.code() == Some(0));
    assert_ne!(stopped, done, "{ended:?}");
    // A base that has stopped itself needs a moment more than its host.
    thread::sleep(Duration::from_millis(300));
    (sent, base.end())
}

#[test]
fn each_fault_stops_the_base_with_its_cause_in_time() {
    let cases = [
        ("native", "ignored-commands", 1.0, "it ignores its commands"),
        ("native", "bumper", 0.1, "the left bumper is pressed"),
        ("native", "cliff", 0.1, "a cliff sensor sees no ground"),
        ("wheeltec", "tilt", 1.0, "the base is tilted"),
        ("native", "stuck-left", 1.3, "the left track stands"),
        ("wheeltec", "stuck-right", 1.3, "the right track stands"),
        ("wheeltec", "runaway", 1.0, "the left track runs at"),
    ];
    thread::scope(|scope| {
        for (protocol, fault, within_s, words) in cases {
            scope.spawn(move || {
                // The host ignores no stop: a base that ignores commands gets its stop at 3 s.
                let is_ignored = fault == "ignored-commands";
                let time_s = if is_ignored { 3.0 } else { 30.0 };
                let (sent, summary) = drive_with(protocol, &format!("{fault}@{FROM_S}"), time_s);
                let cause = sent["stop_cause"].as_str().unwrap_or_default();
                assert!(cause.contains(words), "{protocol} {fault}: {sent}");
                let limit_s = FROM_S + within_s + MARGIN_S;
                assert!(number(&sent, "time_s") < limit_s, "{protocol} {fault}: {sent}");
                if !is_ignored && fault != "runaway" {
                    assert_eq!(summary["linear"], json!(0.0), "{protocol} {fault}: {summary}");
                }
            });
        }
    });
}

/// Without a valid report the base is braked after 0.2 s, and the connection is opened again after 0.5 s, with zeros.
#[test]
fn base_stands_while_its_reports_are_corrupt() {
    thread::scope(|scope| {
        for protocol in ["native", "wheeltec"] {
            scope.spawn(move || {
                let (sent, summary) = drive_with(protocol, "corrupt-reports@2", 6.0);
                let failure = sent["last_failure"].as_str().unwrap_or_default();
                assert!(failure.contains("timed out"), "{protocol}: {sent}");
                assert_eq!(summary["linear"], json!(0.0), "{protocol}: {summary}");
                // At most 2 s at 0.3 m/s, 0.22 s until it brakes, and 0.2 s of braking; 6 s at this speed are 1.8 m.
                assert!(number(&summary, "travelled_m") < 0.3 * 2.5, "{protocol}: {summary}");
            });
        }
    });
}

/// Faults that end: the base stands or slows meanwhile, and drives on.
#[test]
fn passing_fault_latches_no_stop() {
    let cases = [
        ("wheeltec", "stop-glitch@2..2.5"),
        ("native", "wedge@2..2.35"),
        ("wheeltec", "wedge@2..2.35"),
        ("native", "bogged@2..3"),
    ];
    thread::scope(|scope| {
        for (protocol, fault) in cases {
            scope.spawn(move || {
                let (sent, summary) = drive_with(protocol, fault, 6.0);
                assert_eq!(sent["stop_cause"], Value::Null, "{protocol} {fault}: {sent}");
                assert!(number(&summary, "travelled_m") > 0.6, "{protocol} {fault}: {summary}");
            });
        }
    });
}

/// A base that loses its power for a moment counts from zero again. That is no motion, and the user is told.
#[test]
fn counters_reset_by_a_restart_are_no_motion() {
    let cases = [
        ("roboclaw", "reboot@4..4.3", 6.0),
        ("arduino", "reboot@4..4.3", 6.0),
        ("native", "reboot@4..4.3", 6.0),
        ("native", "reboot@5..7", 9.0),
    ];
    thread::scope(|scope| {
        for (protocol, fault, time_s) in cases {
            scope.spawn(move || {
                let (sent, summary) = drive_with(protocol, fault, time_s);
                let text = format!("{protocol} {fault}: {sent} {summary}");
                let cause = sent["stop_cause"].as_str();
                assert!(cause.is_none_or(|cause| cause.contains("encoder")), "{text}");
                assert_eq!(sent["odometry_uncertain"], json!(true), "{text}");
                let (x_m, truth_m) = (&sent["pose"][0], number(&summary, "travelled_m"));
                // The motion until the base has stopped is unknown: at 0.3 m/s for 0.5 s, and that of braking.
                let missing_m = truth_m - x_m.as_f64().expect("a number");
                assert!((-0.02..0.35).contains(&missing_m), "{text}");
                assert!(number(&sent, "travelled_m") < truth_m + 0.02, "{text}");
            });
        }
    });
}

/// The process is stopped for 2 s. Without this rule the first command after the pause was the last one before it.
#[test]
fn paused_host_sends_zeros_before_it_drives_again() {
    let base = Emulated::start("native", "--motor-lag 0.15");
    let mut host = base.host("base send --linear 0.4 --for 7");
    host.await_note("the base answers");
    thread::sleep(Duration::from_millis(1500));
    host.signal("STOP");
    thread::sleep(Duration::from_secs(2));
    host.signal("CONT");
    let ended = host.wait();
    assert_eq!(ended.status.code(), Some(0), "{ended:?}");
    let summary = base.end();
    assert!(number(&summary, "watchdog_stops") >= 1.0, "{summary}");
    // 0.1 s of zeros at 50 Hz; a busy machine may skip some.
    assert!(number(&summary, "zero_commands_after_watchdog") >= 2.0, "{summary}");
    assert!(number(&summary, "travelled_m") > 0.8, "it drives again: {summary}");
}

/// The name of the port leads to another terminal after the base was unplugged. That terminal gets no byte.
#[test]
fn replaced_port_is_not_opened() {
    let base = Emulated::start("native", "--fault port-replaced@2");
    let host = base.host("base send --linear 0.3 --for 5");
    let ended = host.wait();
    assert_eq!(ended.status.code(), Some(1), "{ended:?}");
    let sent = ended.object();
    let failure = sent["last_failure"].as_str().expect("text");
    let is_refused = failure.contains("another device has this name: it was the pseudo-terminal");
    assert!(is_refused || failure.contains("cannot be opened"), "{failure}");
    let summary = base.end();
    assert_eq!(summary["bytes_after_replacement"], json!(0), "{summary}");
}

#[test]
fn link_to_another_terminal_is_not_opened_again() {
    let folder = tempfile::tempdir().expect("a place for temporary files");
    let link = folder.path().join("base");
    let (one, other) = (Emulated::start("native", ""), Emulated::start("native", ""));
    symlink(&one.port, &link).expect("a link");
    let name = link.display();
    let mut host = Process::start(&format!("base send --port {name} --linear 0.3 --for 5 --json"));
    host.await_note("the base answers");
    thread::sleep(Duration::from_millis(500));
    fs::remove_file(&link).expect("the link");
    symlink(&other.port, &link).expect("a link");
    one.end();
    let ended = host.wait();
    assert_eq!(ended.status.code(), Some(1), "{ended:?}");
    let sent = ended.object();
    let failure = sent["last_failure"].as_str().expect("text");
    assert!(failure.contains("another device has this name"), "{failure}");
    let summary = other.end();
    assert_eq!(summary["commands"], json!(0), "{summary}");
}

#[test]
fn base_without_watchdog_is_capped_and_warned_of_unless_confirmed() {
    let folder = tempfile::tempdir().expect("a place for temporary files");
    let confirmed = folder.path().join("base.toml");
    fs::write(&confirmed, "[base]\nhas_watchdog = true\n").expect("written");
    let fast = |more: &str| {
        let base = Emulated::start("wheeltec", "");
        let ended = base.host(&format!("base send --linear 0.8 --for 2 {more}")).wait();
        (ended.stderr.contains("has no watchdog"), number(&base.end(), "travelled_m"))
    };
    let (is_warned, travelled_m) = fast("");
    assert!(is_warned && travelled_m < 0.7, "{travelled_m}");
    let (is_warned, travelled_m) = fast(&format!("--base-config {}", confirmed.display()));
    assert!(!is_warned && travelled_m > 0.7, "{travelled_m}");
}
