//! `inbye base emulate`, `send` and `monitor`.

use std::fs;

use serde_json::{Value, json};

use super::processes::{Emulated, Process, number};

const PROTOCOLS: [&str; 4] = ["native", "wheeltec", "roboclaw", "arduino"];

#[test]
fn send_drives_in_every_protocol() {
    for protocol in PROTOCOLS {
        let base = Emulated::start(protocol, "");
        let ended = base.host("base send --linear 0.4 --for 1.5").wait();
        assert_eq!(ended.status.code(), Some(0), "{protocol}: {ended:?}");
        let sent = ended.object();
        assert_eq!(sent["stop_cause"], Value::Null, "{sent}");
        assert_eq!(sent["interrupted"], json!(false), "{sent}");
        let summary = base.end();
        // 0.4 m/s for 1.5 s. Wide bounds: a busy machine delays the first and the last command.
        let travelled_m = number(&summary, "travelled_m");
        assert!((0.3..1.2).contains(&travelled_m), "{protocol}: {summary}");
        let difference_m = (number(&sent, "travelled_m") - travelled_m).abs();
        assert!(difference_m < 0.1, "{protocol}: {sent} {summary}");
        assert_eq!(summary["linear"], json!(0.0), "{protocol}: {summary}");
        assert_eq!(summary["watchdog_stops"], json!(0), "{protocol}: {summary}");
        assert!(number(&summary, "final_zero_commands") >= 3.0, "{summary}");
    }
}

#[test]
fn speed_above_that_of_the_tracks_is_announced_in_every_protocol() {
    for protocol in PROTOCOLS {
        let base = Emulated::start(protocol, "");
        let limited = "the base drives";
        let ended = base.host("base send --linear 5 --for 0.3").wait();
        let messages = format!("{ended:?}");
        assert!(messages.contains(limited) && messages.contains("not 5.00 m/s"), "{messages}");
        let ended = base.host("base send --linear 0.2 --for 0.3").wait();
        let messages = format!("{ended:?}");
        assert!(!messages.contains("max_track_speed"), "{messages}");
        base.end();
    }
}

/// A base gets zeros below the deadband of its settings, 0.02 m/s.
#[test]
fn speed_within_the_deadband_is_announced() {
    let base = Emulated::start("native", "");
    for (speed, is_announced) in [("0.01", true), ("0.02", false), ("0", false)] {
        let ended = base.host(&format!("base send --linear {speed} --for 0.3")).wait();
        let text = "a track slower than 0.02 m/s stands (deadband in [base.tracks]): the base drives 0.00 m/s";
        assert_eq!(ended.stderr.contains(text), is_announced, "{speed}: {ended:?}");
    }
    assert_eq!(number(&base.end(), "linear"), 0.0);
}

#[test]
fn stuck_track_stops_base_with_cause() {
    for protocol in PROTOCOLS {
        let base = Emulated::start(protocol, "--fault stuck-right");
        let ended = base.host("base send --linear 0.4 --for 60").wait();
        assert_eq!(ended.status.code(), Some(1), "{protocol}: {ended:?}");
        let sent = ended.object();
        let cause = sent["stop_cause"].as_str().expect("text");
        assert!(cause.starts_with("the right track stands"), "{cause}");
        assert!(number(&base.end(), "final_zero_commands") >= 3.0);
    }
}

#[test]
fn latched_stop_needs_explicit_release() {
    let base = Emulated::start("native", "--fault button@0..1.5");
    let ended = base.host("base send --linear 0.3 --for 60").wait();
    let sent = ended.object();
    let cause = sent["stop_cause"].as_str().expect("text");
    assert!(cause.contains("emergency stop"), "{cause}");
    // The button is released by then; the base keeps its stop.
    std::thread::sleep(std::time::Duration::from_millis(1600));
    let ended = base.host("base send --linear 0.3 --for 0.5").wait();
    assert_eq!(ended.status.code(), Some(1), "{ended:?}");
    let ended = base.host("base send --linear 0.3 --for 0.5 --release").wait();
    assert_eq!(ended.status.code(), Some(0), "{ended:?}");
    assert!(number(&base.end(), "travelled_m") > 0.02);
}

#[test]
fn silent_base_is_reported_and_stopped() {
    let base = Emulated::start("native", "--fault silence@2.5");
    let ended = base.host("base send --linear 0.3 --for 5").wait();
    assert_eq!(ended.status.code(), Some(1), "{ended:?}");
    let sent = ended.object();
    assert!(number(&sent["counters"], "connection_failures") >= 1.0, "{sent}");
    let summary = base.end();
    assert_eq!(summary["linear"], json!(0.0), "{summary}");
    assert!(number(&summary, "final_zero_commands") >= 3.0, "{summary}");
}

#[test]
fn base_drives_again_after_silence() {
    let base = Emulated::start("native", "--fault silence@2.5..4");
    let ended = base.host("base send --linear 0.3 --for 8").wait();
    assert_eq!(ended.status.code(), Some(0), "{ended:?}");
    let sent = ended.object();
    assert!(number(&sent["counters"], "connections") >= 2.0, "{sent}");
    base.end();
}

#[test]
fn monitor_prints_reports_and_does_not_move_base() {
    for protocol in PROTOCOLS {
        let base = Emulated::start(protocol, "");
        let ended = base.host("base monitor --for 0.5").wait();
        assert_eq!(ended.status.code(), Some(0), "{protocol}: {ended:?}");
        let mut lines = 0;
        for line in ended.stdout.lines() {
            let row: Value = serde_json::from_str(line).expect("each line is JSON");
            assert_eq!(row["feedback"]["linear"], json!(0.0), "{row}");
            // The first report may precede the first command.
            let faults = row["feedback"]["faults"].as_str().expect("text");
            let idle = ["none", "stopped by its watchdog"];
            assert!(idle.contains(&faults), "{row}");
            lines += 1;
        }
        assert!(lines >= 1, "{ended:?}");
        assert_eq!(number(&base.end(), "travelled_m"), 0.0);
    }
}

#[test]
fn unusable_arguments_fail_with_one_line() {
    let folder = tempfile::tempdir().expect("a place for temporary files");
    let file = folder.path().join("base.toml");
    fs::write(&file, "[base]\ntrack_width_m = -1.0\n").expect("written");
    let file = file.display().to_string();
    for (arguments, words) in [
        ("base send --port no-such-port".to_owned(), "no-such-port: cannot be opened"),
        ("base send".to_owned(), "--port"),
        ("base send --port x --linear nan".to_owned(), "-100 to 100"),
        (
            "base send --port x --protocol can".to_owned(),
            "`can` is not a protocol: use one of native, ",
        ),
        ("base emulate --fault stuck".to_owned(), "`stuck` is not a fault"),
        ("base emulate --for 0".to_owned(), "above zero"),
        (
            "drive --scene mine --port x --lidar x --arm".to_owned(),
            "--lidar x: it is the port of the base too",
        ),
        (
            "drive --scene mine --port x --lidar y --operator-port 0".to_owned(),
            "it must be a whole number, 1 to 65535",
        ),
        (format!("base emulate --base-config {file}"), "track_width_m is -1"),
        (
            "base emulate --base-config gone.toml".to_owned(),
            "--base-config gone.toml: cannot be read",
        ),
    ] {
        let ended = Process::start(&arguments).wait();
        assert_eq!(ended.status.code(), Some(2), "{arguments}: {ended:?}");
        assert_eq!(ended.stderr.lines().count(), 1, "{arguments}: {ended:?}");
        assert!(ended.stderr.contains(words), "{arguments}: {ended:?}");
    }
}

#[test]
fn wrong_protocol_is_reported() {
    let base = Emulated::start("wheeltec", "");
    let mut other = base.on_line("base send");
    other = other.replace("wheeltec", "roboclaw");
    let ended = Process::start(&other).wait();
    assert_eq!(ended.status.code(), Some(2), "{ended:?}");
    assert!(ended.stderr.contains("no answer within 3 s"), "{ended:?}");
    assert!(ended.stderr.contains("status_bytes = 2 in [base.roboclaw]"), "{ended:?}");
}

#[test]
fn port_in_use_is_named() {
    let base = Emulated::start("native", "");
    let mut first = base.host("base monitor");
    first.line();
    let ended = base.host("base monitor").wait();
    assert_eq!(ended.status.code(), Some(2), "{ended:?}");
    assert!(ended.stderr.contains("another program uses this port"), "{ended:?}");
}

/// The line is cut while the base drives ahead, after its turn.
#[test]
fn calibration_with_a_lost_line_prints_no_settings() {
    let base = Emulated::start("native", "--fault line-cut@6");
    let calibrate = "base calibrate --yes --turns 0.25 --distance 1 --driven 0.98";
    let ended = base.host(calibrate).wait();
    assert_eq!(ended.status.code(), Some(1), "{ended:?}");
    let object = ended.object();
    assert!(number(&object, "turned_rad") > 1.5, "{object}");
    assert_eq!(object["effective_width_ratio"], Value::Null, "{object}");
    assert_eq!(object["ticks_per_m"], Value::Null, "{object}");
    assert!(object["why"].is_string(), "{object}");
}

/// The signal comes while the base turns.
#[test]
fn interrupted_calibration_reports_the_turn_so_far() {
    for given in ["", "--turned 300"] {
        let base = Emulated::start("native", "");
        let host = base.host(&format!("base calibrate --yes --distance 0 {given}"));
        std::thread::sleep(std::time::Duration::from_secs(6));
        host.signal("INT");
        let ended = host.wait();
        assert_eq!(ended.status.code(), Some(1), "{ended:?}");
        let object = ended.object();
        assert!(number(&object, "turned_rad") > 0.3, "{object}");
        assert!(object["turned_by_gyro_rad"].is_number(), "{object}");
        assert_eq!(object["effective_width_ratio"], Value::Null, "{object}");
        base.end();
    }
}

/// Its firmware measures the distance, so that no setting of the host corrects it.
#[test]
fn calibration_without_encoder_counts_ignores_the_distance() {
    let base = Emulated::start("wheeltec", "");
    let calibrate = "base calibrate --yes --turns 0.5 --distance 0.3";
    let ended = base.host(&format!("{calibrate} --driven 0.4 --turned 180")).wait();
    assert_eq!(ended.status.code(), Some(0), "{ended:?}");
    let object = ended.object();
    let ratio = number(&object, "effective_width_ratio");
    let expected = number(&object, "turned_rad") / core::f64::consts::PI;
    assert!((ratio - expected).abs() < 1e-9, "{object}");
    assert_eq!(object["ticks_per_m"], Value::Null, "{object}");
}

/// The emulated base has tracks that turn as if they were farther apart than the host's settings say.
#[test]
fn calibration_prints_the_effective_width_of_a_base_with_a_gyro() {
    let place = tempfile::tempdir().expect("a folder");
    let file = place.path().join("base.toml");
    fs::write(&file, "[base]\neffective_width_ratio = 1.35\n").expect("a file");
    let base = Emulated::start("native", &format!("--base-config {}", file.display()));
    let refused = base.host("base calibrate --turns 0.5 --distance 0.3").wait();
    assert_eq!(refused.status.code(), Some(2), "{refused:?}");
    assert!(refused.stderr.contains("--yes"), "{refused:?}");
    let ended = base.host("base calibrate --yes --turns 0.5 --distance 0.3 --driven 0.3").wait();
    assert_eq!(ended.status.code(), Some(0), "{ended:?}");
    let object = ended.object();
    let ratio = number(&object, "effective_width_ratio");
    // A measured distance rescales the turn by the tracks too.
    let expected = 1.35 * 0.3 / number(&object, "driven_m");
    assert!((ratio - expected).abs() < 0.05, "{object}");
    let left = number(&object["ticks_per_m"], "left");
    assert!((left / 10_000.0 - number(&object, "driven_m") / 0.3).abs() < 1e-9, "{object}");
    assert!(number(&base.end(), "final_zero_commands") >= 3.0);
}
