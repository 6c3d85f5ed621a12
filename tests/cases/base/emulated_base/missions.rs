//! `inbye drive --port`: a mission in a simulated world with a base in another process.

use std::fs;
use std::thread;
use std::time::{Duration, SystemTime};

use crate::support::room;
use serde_json::{Value, json};
use tempfile::TempDir;

use super::processes::{Emulated, Process, number};

/// A room of 7.2 by 4.4 m with 0.2 m cells and an obstacle between start and goal.
fn room() -> TempDir {
    let folder = tempfile::tempdir().expect("a place for temporary files");
    let rows = room::rows(36, 22, &[(16..19, 10..14)]);
    fs::write(folder.path().join("room.txt"), rows.join("\n")).expect("written");
    folder
}

fn drive(room: &TempDir, more: &str) -> String {
    format!(
        "drive --map {} --resolution 0.2 --start 1.2,2,0 --goal 4.8,2 --engine cpu --threads 1 --simulated-senses --arm {more}",
        room.path().join("room.txt").display()
    )
}

#[track_caller]
fn completes(protocol: &'static str) {
    let room = room();
    let base = Emulated::start(protocol, "");
    let ended = base.host(&drive(&room, "--time-limit 120")).wait();
    assert_eq!(ended.status.code(), Some(0), "{protocol}: {ended:?}");
    let (driven, summary) = (ended.object(), base.end());
    assert_eq!(driven["reached"], json!(true), "{driven}");
    assert_eq!(driven["collided"], json!(false), "{driven}");
    assert_eq!(driven["base"]["stop_cause"], Value::Null, "{driven}");
    assert_eq!(driven["base"]["interrupted"], json!(false), "{driven}");
    // The mission's distance equals that of the machine in the other process.
    let (believed_m, true_m) = (number(&driven, "travelled_m"), number(&summary, "travelled_m"));
    assert!(true_m > 3.4, "{summary}");
    assert_eq!(summary["linear"], json!(0.0), "{summary}");
    // A real base has a deadline of one control period without any setting.
    assert_eq!(driven["deadline"]["deadline_s"], json!(0.1), "{driven}");
    assert_eq!(summary["watchdog_stops"], json!(0), "{summary}");
    assert!((believed_m - true_m).abs() < 0.03 * true_m + 0.05, "{driven} {summary}");
    // So does the final position, relative to the start.
    let pose = summary["pose"].as_array().expect("a pose");
    let x_m = 1.2 + pose[0].as_f64().expect("a number");
    let y_m = 2.0 + pose[1].as_f64().expect("a number");
    assert!(libm::hypot(x_m - 4.8, y_m - 2.0) < 0.5, "{driven} {summary}");
}

/// The drive of five seconds stands for eight after the signal, and goes on to wait for its operator.
#[test]
fn signal_stops_a_drive_until_it_is_armed_again() {
    let room = room();
    let base = Emulated::start("native", "");
    let mut host = base.host(&drive(&room, "--time-limit 120"));
    host.await_note("engine");
    thread::sleep(Duration::from_secs(2));
    host.signal("USR1");
    host.await_note("stopped by the operator");
    thread::sleep(Duration::from_secs(8));
    host.signal("INT");
    let ended = host.wait();
    assert_eq!(ended.status.code(), Some(1), "{ended:?}");
    let (driven, summary) = (ended.object(), base.end());
    assert_eq!(driven["reached"], json!(false), "{driven}");
    assert_eq!(summary["linear"], json!(0.0), "{summary}");
    assert!(number(&summary, "travelled_m") < 3.0, "{summary}");
}

#[test]
fn real_time_mission_is_recorded_and_replayed() {
    let room = room();
    let path = |name: &str| format!("{}", room.path().join(name).display());
    let settings = "[navigator]\nwait_for_plans = false\ndeadline_s = 0.05\n";
    fs::write(path("robot.toml"), settings).expect("written");
    let (settings, file) = (path("robot.toml"), path("run.mcap"));
    let base = Emulated::start("native", "");
    let more = format!("--time-limit 4 --config {settings} --record {file}");
    let driven = base.host(&drive(&room, &more)).wait().object();
    base.end();
    assert_eq!(driven["recording"]["stopped"], Value::Null, "{driven}");
    let replayed = Process::start(&format!("replay {file} --engine cpu --threads 1 --json")).wait();
    assert_eq!(replayed.status.code(), Some(0), "{replayed:?}");
    let replay = replayed.object();
    assert_eq!(replay["ticks"], driven["ticks"], "{replay}");
    assert_eq!(replay["complete"], json!(true), "{replay}");
    let recording = fs::read(&file).expect("a recording");
    let key = b"unix_s";
    let at = recording.windows(key.len()).position(|bytes| bytes == key).expect("a date");
    // The text follows its length, four bytes.
    let digits = recording[at + key.len() + 4..].iter().take_while(|byte| byte.is_ascii_digit());
    let text = String::from_utf8(digits.copied().collect()).expect("digits");
    let now_s = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).expect("a date").as_secs();
    let age_s = now_s - text.parse::<u64>().expect("seconds");
    assert!((3..120).contains(&age_s), "{age_s}");
}

#[test]
fn mission_completes_with_native_base() {
    completes("native");
}

#[test]
fn mission_completes_with_wheeltec_base() {
    completes("wheeltec");
}

#[test]
fn mission_completes_with_roboclaw_base() {
    completes("roboclaw");
}

#[test]
fn mission_completes_with_arduino_base() {
    completes("arduino");
}

#[test]
fn stuck_base_ends_mission_with_cause() {
    let room = room();
    let base = Emulated::start("native", "--fault stuck-left@2.5");
    let folder = room.path().join("out");
    let report = format!("--report {}", folder.display());
    let ended = base.host(&drive(&room, &report)).wait();
    assert_eq!(ended.status.code(), Some(1), "{ended:?}");
    let driven = ended.object();
    assert_eq!(driven["reached"], json!(false), "{driven}");
    let cause = driven["base"]["stop_cause"].as_str().expect("text");
    assert!(cause.contains("left track"), "{cause}");
    assert_eq!(driven["fault"], driven["base"]["stop_cause"], "{driven}");
    // The report shows it at the last tick.
    let page = fs::read_to_string(folder.join("index.html")).expect("a page");
    assert!(page.contains("driven by a base on a serial line in real time"));
    let last = driven["ticks"].as_u64().expect("ticks") - 1;
    let listed = format!("<button type=\"button\" data-frame=\"{last}\"><b>");
    let (_, listed) = page.split_once(&listed).expect("a fault is listed");
    assert!(listed.contains(&format!("</b> base: {cause}</button>")), "{cause}");
    assert!(number(&base.end(), "final_zero_commands") >= 3.0);
}

#[test]
fn signal_ends_mission_and_stops_base() {
    let room = room();
    // The base or the mission may notice the signal first.
    for signal in ["INT", "TERM", "TSTP"] {
        let base = Emulated::start("native", "");
        let mut host = base.host(&drive(&room, ""));
        host.await_note("engine: ");
        thread::sleep(Duration::from_secs(1));
        host.signal(signal);
        let ended = host.wait();
        assert_eq!(ended.status.code(), Some(1), "{ended:?}");
        let driven = ended.object();
        assert_eq!(driven["base"]["interrupted"], json!(true), "{driven}");
        assert_eq!(driven["interrupted"], json!(true), "{driven}");
        let why = driven["why"].as_str().expect("a reason");
        assert!(why.starts_with("the drive was interrupted"), "{why}");
        let summary = base.end();
        assert!(number(&summary, "final_zero_commands") >= 3.0, "{summary}");
        assert_eq!(summary["watchdog_stops"], json!(0), "{summary}");
    }
}
