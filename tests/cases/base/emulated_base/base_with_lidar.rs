//! `inbye drive --lidar`: base and lidar are emulated by another process, in one world.

use std::io::BufReader;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};
use std::{env, fs, thread};

use inbye::recording::Reader;
use serde_json::{Value, json};
use tempfile::TempDir;

use super::processes::{Emulated, Ended, Process};
use crate::support::room;

/// A hall of 14 by 8 m with 0.1 m cells, a pillar between start and goal, a block and two niches; and settings of a base whose
/// encoders count 5 % too much.
fn hall() -> TempDir {
    let folder = tempfile::tempdir().expect("a place for temporary files");
    let open = [(8..132, 10..60), (40..58, 60..72), (90..104, 4..10)];
    let solid = [(62..72, 28..40), (20..26, 10..16)];
    let cell = |column: i32, row: i32| {
        let is_in = |boxes: &[(core::ops::Range<i32>, core::ops::Range<i32>)]| {
            let mut boxes = boxes.iter();
            boxes.any(|(columns, rows)| columns.contains(&column) && rows.contains(&row))
        };
        if is_in(&open) && !is_in(&solid) { '.' } else { '#' }
    };
    let row = |row: i32| (0..140).map(|column| cell(column, row)).collect::<String>() + "\n";
    let rows: String = (0..80).rev().map(row).collect();
    fs::write(folder.path().join("hall.txt"), rows).expect("written");
    let settings = "[base]\nticks_per_m = { left = 10500.0, right = 10500.0 }\n";
    fs::write(folder.path().join("slips.toml"), settings).expect("written");
    folder
}

fn file(folder: &TempDir, name: &str) -> String {
    format!("{}", folder.path().join(name).display())
}

/// A robot that starts slightly off its assumed pose.
fn robot(hall: &TempDir, more: &str) -> Emulated {
    let (map, slips) = (file(hall, "hall.txt"), file(hall, "slips.toml"));
    let world = format!("--lidar-map {map} --resolution 0.1 --start 1.65,2.46,0.04");
    Emulated::start("native", &format!("{world} --base-config {slips} {more}"))
}

fn drive(hall: &TempDir, robot: &Emulated, more: &str) -> Ended {
    drive_from(hall, robot, &format!("--start 1.6,2.5,0 --goal 11.5,4.5 {more}"))
}

fn drive_from(hall: &TempDir, robot: &Emulated, route: &str) -> Ended {
    let map = file(hall, "hall.txt");
    let lidar = robot.lidar.as_deref().expect("it has one");
    let base = format!("--engine cpu --threads 1 --arm --lidar {lidar}");
    robot.host(&format!("drive --map {map} --resolution 0.1 {base} {route}")).wait()
}

fn map_pose(summary: &Value) -> [f64; 3] {
    serde_json::from_value(summary["map_pose"].clone()).expect("a pose")
}

#[test]
fn base_with_lidar_reaches_goal() {
    let hall = hall();
    let robot = robot(&hall, "");
    let ended = drive(&hall, &robot, "--time-limit 120");
    assert_eq!(ended.status.code(), Some(0), "{ended:?}");
    let (driven, summary) = (ended.object(), robot.end());
    assert_eq!(driven["reached"], json!(true), "{driven}");
    let lidar = &driven["base"]["lidar"];
    assert_eq!((&lidar["fault"], &lidar["connections"]), (&Value::Null, &json!(1)), "{driven}");
    assert!(lidar["revolutions"].as_u64().is_some_and(|count| count > 50), "{driven}");
    let [x, y, _] = map_pose(&summary);
    let error_m = libm::hypot(x - 11.5, y - 4.5);
    assert!(error_m < 0.3, "{driven} {summary}");
    // The estimated pose is right; track odometry alone would be half a metre off.
    let error = &driven["final_error"];
    let believed = |axis: &str, goal: f64| goal + error[axis].as_f64().expect("a number");
    let estimate_error_m = libm::hypot(x - believed("x_m", 11.5), y - believed("y_m", 4.5));
    assert!(estimate_error_m < 0.05, "{estimate_error_m}: {driven} {summary}");
    let by_tracks = &driven["base"]["travelled_m"];
    let true_m = summary["travelled_m"].as_f64().expect("a number");
    let counted_m = by_tracks.as_f64().expect("a number");
    assert!(counted_m > 1.03 * true_m && true_m > 9.0, "{driven} {summary}");
}

#[test]
fn robot_with_unknown_start_needs_no_start() {
    let hall = hall();
    let robot = robot(&hall, "");
    let ended = drive_from(&hall, &robot, "--unknown-start --goal 4,2.5 --time-limit 60");
    let (driven, summary) = (ended.object(), robot.end());
    assert_eq!((ended.status.code(), &driven["reached"]), (Some(0), &json!(true)), "{driven}");
    let [x, y, _] = map_pose(&summary);
    assert!(libm::hypot(x - 4.0, y - 2.5) < 0.3, "{driven} {summary}");
}

/// More ticks than reports of the base: each report keeps its time. The poses of a time that goes back were forgotten, and the scans
/// were no longer compensated for the motion.
#[test]
fn report_keeps_its_time_for_all_ticks() {
    let hall = hall();
    let robot = robot(&hall, "");
    let recording = file(&hall, "run.mcap");
    let more = format!("--time-limit 3 --set local.control_period_s=0.01 --record {recording}");
    let ended = drive(&hall, &robot, &more);
    assert_eq!(ended.object()["recording"]["stopped"], Value::Null, "{ended:?}");
    let recording = fs::File::open(recording).expect("a recording");
    let mut reader = Reader::open(BufReader::new(recording)).expect("a recording");
    let mut times = Vec::new();
    while let Some(tick) = reader.next_tick().expect("a tick") {
        times.push(tick.observation.odometry_s);
    }
    let repeated = times.windows(2).filter(|pair| pair[0] == pair[1]).count();
    assert!(repeated > 20, "{repeated} of {}", times.len());
    assert!(times.is_sorted(), "{times:?}");
}

#[test]
fn unplugged_lidar_stops_robot_with_cause() {
    let hall = hall();
    // The lidar is unplugged soon after the drive starts.
    let robot = robot(&hall, "--lidar-until 6");
    let ended = drive(&hall, &robot, "--time-limit 120");
    assert_eq!(ended.status.code(), Some(1), "{ended:?}");
    let (driven, summary) = (ended.object(), robot.end());
    assert_eq!(driven["reached"], json!(false), "{driven}");
    let fault = driven["fault"].as_str().expect("text");
    assert!(fault.contains("there is no fresh scan"), "{fault}");
    let lidar_fault = driven["base"]["lidar"]["fault"].as_str().expect("text");
    assert!(lidar_fault.contains("the lidar is disconnected"), "{lidar_fault}");
    // The base itself has no fault, and stands.
    assert_eq!(driven["base"]["stop_cause"], Value::Null, "{driven}");
    assert_eq!(summary["linear"], json!(0.0), "{summary}");
    assert!(summary["final_zero_commands"].as_u64().is_some_and(|zeros| zeros >= 3), "{summary}");
    let [x, ..] = map_pose(&summary);
    assert!(x < 10.0, "{summary}");
}

/// The thread of the lidar waits for bytes nearly all the time, with every signal unblocked: the first of these signals ended the program.
#[test]
fn signals_stop_a_drive_with_a_lidar_and_do_not_end_it() {
    let hall = hall();
    let robot = robot(&hall, "");
    let map = file(&hall, "hall.txt");
    let lidar = robot.lidar.as_deref().expect("it has one");
    let route = "--resolution 0.1 --start 1.6,2.5,0 --goal 11.5,4.5";
    let host = format!("drive --map {map} {route} --engine cpu --threads 1 --arm --lidar {lidar}");
    let mut host = robot.host(&host);
    host.await_note("engine");
    for _ in 0..10 {
        host.signal("USR1");
        host.await_note("stopped by the operator");
    }
    host.signal("INT");
    let ended = host.wait();
    assert_eq!(ended.status.code(), Some(1), "{ended:?}");
    assert_eq!(ended.object()["base"]["interrupted"], json!(true), "{ended:?}");
    assert_eq!(robot.end()["linear"], json!(0.0));
}

#[test]
fn people_of_an_emulated_world_stop_a_robot_that_touches_none() {
    let hall = hall();
    // All across the hall.
    let people = (-3..=3).map(|index| format!("--person 2,{}@6", f64::from(index) * 0.55));
    let robot = robot(&hall, &people.collect::<Vec<_>>().join(" "));
    drive(&hall, &robot, "--time-limit 12");
    let summary = robot.end();
    assert_eq!(summary["robot_touched"], json!(false), "{summary}");
    let gap_m = summary["min_gap_m"].as_f64().expect("a number");
    assert!(gap_m > 0.0 && gap_m < 2.0, "{summary}");
}

#[test]
fn blind_or_frozen_lidar_stops_robot_with_cause() {
    for fault in ["lidar-blind", "lidar-frozen"] {
        let hall = hall();
        let robot = robot(&hall, &format!("--fault {fault}@6"));
        let ended = drive(&hall, &robot, "--time-limit 60");
        assert_eq!(ended.status.code(), Some(1), "{fault}: {ended:?}");
        let (driven, summary) = (ended.object(), robot.end());
        assert_eq!(driven["reached"], json!(false), "{fault}: {driven}");
        assert!(driven["fault"].as_str().is_some(), "{fault}: {driven}");
        assert_eq!(driven["collided"], json!(false), "{fault}: {driven}");
        assert_eq!(summary["linear"], json!(0.0), "{fault}: {summary}");
        let [x, ..] = map_pose(&summary);
        assert!(x < 10.0, "{fault}: {summary}");
    }
}

#[test]
fn robot_with_wrong_map_is_lost_and_stands() {
    let hall = hall();
    let robot = robot(&hall, "");
    fs::write(hall.path().join("hall.txt"), room::rows(60, 60, &[]).join("\n")).expect("written");
    fs::write(hall.path().join("patience.toml"), "[navigator]\nlocalization_patience_s = 2.0\n")
        .expect("written");
    let map = file(&hall, "hall.txt");
    let (lidar, settings) =
        (robot.lidar.clone().expect("it has one"), file(&hall, "patience.toml"));
    let route = "--resolution 0.1 --start 2,3,0 --goal 5,3";
    let host = format!(
        "drive --map {map} {route} --engine cpu --threads 1 --arm --lidar {lidar} --config {settings}"
    );
    let ended = robot.host(&host).wait();
    assert_eq!(ended.status.code(), Some(1), "{ended:?}");
    let driven = ended.object();
    let fault = driven["fault"].as_str().expect("text");
    assert!(fault.contains("the robot is lost: "), "{fault}");
    let travelled_m = robot.end()["travelled_m"].as_f64().expect("a number");
    assert!(travelled_m < 1.0, "{travelled_m}");
}

#[test]
fn signal_before_the_lidar_answers_ends_the_drive() {
    let hall = hall();
    let robot = robot(&hall, "--fault lidar-silent@0");
    let (map, lidar) = (file(&hall, "hall.txt"), robot.lidar.as_deref().expect("it has one"));
    let route = format!("drive --map {map} --resolution 0.1 --start 1.6,2.5 --goal 11.5,4.5");
    let host = robot.host(&format!("{route} --engine cpu --arm --lidar {lidar}"));
    thread::sleep(Duration::from_millis(1500));
    let signalled = Instant::now();
    host.signal("INT");
    let ended = host.wait();
    assert!(signalled.elapsed() < Duration::from_secs(4), "{ended:?}");
    assert_eq!(ended.status.code(), Some(1), "{ended:?}");
    assert!(ended.stderr.contains("stopped by a signal before the device answered"), "{ended:?}");
}

/// The example of the library, which `cargo test` builds next to the tests.
#[test]
fn example_drives_a_base_with_a_lidar_and_obeys_a_signal() {
    let mine = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/mine.yaml");
    let tests = env::current_exe().expect("this program");
    let example = tests.parent().and_then(Path::parent).expect("a folder");
    let example = example.join("examples/serial_drive");
    assert!(example.exists(), "{}: cargo build --examples makes it", example.display());
    for is_interrupted in [false, true] {
        let robot = Emulated::start("native", &format!("--lidar-map {mine} --start 10,5"));
        let mut command = Command::new(&example);
        command.args([&robot.port, robot.lidar.as_deref().expect("it has one"), mine]);
        let host = Process::of(command);
        if is_interrupted {
            thread::sleep(Duration::from_secs(5));
            host.signal("INT");
        }
        let ended = host.wait();
        assert!(ended.status.success(), "{ended:?}");
        assert!(ended.stdout.contains(&format!("reached: {}", !is_interrupted)), "{ended:?}");
        assert_eq!(ended.stdout.contains("the drive was interrupted"), is_interrupted, "{ended:?}");
        let summary = robot.end();
        assert!(summary["travelled_m"].as_f64().expect("a number") > 0.2, "{summary}");
        assert!(summary["final_zero_commands"].as_u64().expect("a count") >= 3, "{summary}");
    }
}

#[test]
fn unusable_lidar_arguments_fail_with_one_line() {
    let hall = hall();
    let map = file(&hall, "hall.txt");
    let robot = robot(&hall, "");
    let lidar = robot.lidar.clone().expect("it has one");
    let route = format!("drive --map {map} --resolution 0.1 --start 1.6,2.5 --goal 11.5,4.5");
    let fails = |more: &str, words: &str| {
        let ended = robot.host(&format!("{route} --arm {more}")).wait();
        assert_eq!(ended.status.code(), Some(2), "{ended:?}");
        assert!(ended.stderr.contains(words), "{words}: {ended:?}");
    };
    fails(&format!("--lidar {lidar} --obstacles 3"), "--obstacles are simulated");
    fails("--lidar /dev/no-such-lidar", "--lidar: /dev/no-such-lidar: cannot be opened");
    robot.end();
    let ended = Process::start(&format!("{route} --lidar {lidar}")).wait();
    assert_eq!(ended.status.code(), Some(2), "{ended:?}");
    let ended = Process::start(&format!("base emulate --lidar-map {map} --for 1")).wait();
    assert_eq!(ended.status.code(), Some(2), "{ended:?}");
    assert!(ended.stderr.contains("--lidar-map needs --start"), "{ended:?}");
    let world = format!("base emulate --resolution 0.1 --lidar-map {map} --for 1 --start");
    for place in ["6.7,3.4", "57.4,93.9", "1.65,2.46 --fault carried@1 --carry-to 0.2,0.2"] {
        let ended = Process::start(&format!("{world} {place}")).wait();
        assert_eq!(ended.status.code(), Some(2), "{place}: {ended:?}");
        assert!(ended.stderr.contains("the robot touches a wall"), "{ended:?}");
    }
}
